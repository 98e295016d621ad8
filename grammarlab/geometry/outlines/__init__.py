"""Operations on polygons: skeletons, offsets, setbacks, largest rectangles, footprints."""
