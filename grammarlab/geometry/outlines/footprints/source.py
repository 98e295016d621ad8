"""Outlines as a source has them, before they are checked and placed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import shapely

from grammarlab.geometry.outlines.footprints.crs import Crs
from grammarlab.geometry.outlines.footprints.footprint import Remark


@dataclass(frozen=True, slots=True)
class Outline:
    """One polygon in the coordinates of its source, valid or not."""

    polygon: shapely.Polygon
    name: str
    """Its place in the source: ``lots.geojson, feature 3``."""
    properties: Mapping[str, float | bool | str] = field(default_factory=dict)
    unread: tuple[str, ...] = ()
    """See `Footprint.unread`."""


@dataclass(frozen=True, slots=True)
class Source:
    """The outlines of a file or of a text."""

    name: str
    """Path of the file, for messages."""
    outlines: tuple[Outline, ...]
    remarks: tuple[Remark, ...]
    crs: Crs
    strict: bool = False
    """Whether a bad outline is an error, as for one written by hand, instead of a remark."""
