"""Footprints from the text of an option: a size, WKT, or the name of a GeoJSON file."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import shapely

from grammarlab.errors import AssetError, UsageError
from grammarlab.files import existing
from grammarlab.geometry.outlines.footprints.crs import LOCAL
from grammarlab.geometry.outlines.footprints.footprint import Footprint, FootprintMap
from grammarlab.geometry.outlines.footprints.geojson import read_geojson
from grammarlab.geometry.outlines.footprints.placing import MOST_REASONS, placed
from grammarlab.geometry.outlines.footprints.source import Outline, Source
from grammarlab.geometry.outlines.footprints.wkt import is_wkt, read_wkt

_SIZE = re.compile(r"\s*(\d{1,30}(?:\.\d{1,30})?)\s*[xX×]\s*(\d{1,30}(?:\.\d{1,30})?)\s*")
_SUFFIXES = (".geojson", ".json", ".geojsonl", ".geojsons", ".geojsonseq", ".ndjson", ".jsonl")
_EXPECTED = "expected WIDTHxDEPTH in metres (20x12), WKT (POLYGON ((0 0, 20 0, 20 12, 0 12, 0 0))) or a .geojson file"


def read_footprints(text: str) -> tuple[Footprint, ...]:
    """Footprints from the text of an option: at least one.

    A Python warning lists what is left out of a file: lines, points, and polygons that cannot be used.

    Args:
        text: ``20x12``; WKT in metres, or with ``SRID=…;`` before it; or the path of a file of GeoJSON, of GeoJSON
            lines or of a GeoJSON text sequence (RFC 8142).

    Raises:
        UsageError: If the text is none of these.
        AssetError: If a file or a polygon cannot be used.

    >>> import grammarlab as gl
    >>> gl.read_footprints("20x12")[0].polygon[:, [0, 2]].tolist()
    [[0.0, 12.0], [20.0, 12.0], [20.0, 0.0], [0.0, 0.0]]
    """
    plan = read_footprint_map(text)
    if plan.remarks:
        shown = "".join(f"\n  {remark}" for remark in plan.remarks[:MOST_REASONS])
        more = f"\n  … and {len(plan.remarks) - MOST_REASONS:,} more" if len(plan.remarks) > MOST_REASONS else ""
        warnings.warn(f"{len(plan.remarks):,} remarks about the footprints:{shown}{more}", stacklevel=2)
    return plan.footprints


def read_footprint_map(text: str) -> FootprintMap:
    """Footprints from the text of an option, with their place and with remarks about what is left out.

    Args:
        text: see `read_footprints`.

    Raises:
        UsageError: If the text is none of these.
        AssetError: If a file is broken, its coordinates are neither true metres nor degrees, or no polygon in it can be
            used; for WKT, if any polygon cannot.
    """
    if size := _SIZE.fullmatch(text):
        width, depth = float(size[1]), float(size[2])
        plan = shapely.Polygon([(0, -depth), (width, -depth), (width, 0), (0, 0)])  # along +x and +z, as in `derive`
        return placed(Source(text, (Outline(plan, text),), (), LOCAL, strict=True))
    file = existing(text)
    if file is None and is_wkt(text):
        return placed(read_wkt(text, _EXPECTED))
    if file is not None and not file.is_dir():
        return placed(read_geojson(file))
    if text.lower().endswith(_SUFFIXES):
        raise AssetError(f"{Path(text)}: no such footprint file; {_EXPECTED}.")
    raise UsageError(f"footprint {text!r}: {_EXPECTED}.")
