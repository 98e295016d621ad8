"""Operations on polygons in a plane, and roofs over them."""
