"""Polygons grown, shrunk and looked into: skeletons, offsets, setbacks, largest rectangles, footprints."""
