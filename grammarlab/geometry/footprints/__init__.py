"""Footprints: ground polygons of models, from a size, from WKT or from a GeoJSON file."""

from grammarlab.geometry.footprints.footprint import Footprint, FootprintMap, Georeference, Remark, RemarkKind
from grammarlab.geometry.footprints.footprint_text import read_footprint_map, read_footprints

__all__ = ["Footprint", "FootprintMap", "Georeference", "Remark", "RemarkKind", "read_footprint_map", "read_footprints"]
