"""glTF 2.0 files: the triangles of their scene, with instances, sparse and quantised values."""
