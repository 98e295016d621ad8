"""Operations over the faces, edges and vertices of a shape."""
