"""Footprints: ground polygons of models, from a size, from WKT or from a map in any coordinate system."""
