"""Maps for tests."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from grammarlab.geometry.footprints.footprint import Footprint

SQUARE = [[0, 0], [10, 0], [10, 8], [0, 8], [0, 0]]
BOW_TIE = [[40, 0], [50, 8], [50, 0], [40, 8], [40, 0]]


def polygon(*rings: Any) -> dict[str, Any]:
    """A GeoJSON polygon."""
    return {"type": "Polygon", "coordinates": list(rings)}


def feature(geometry: Any, **properties: Any) -> dict[str, Any]:
    """A GeoJSON feature."""
    return {"type": "Feature", "geometry": geometry, "properties": properties}


def collection(*features: Any, **members: Any) -> dict[str, Any]:
    """A GeoJSON collection of features."""
    return {"type": "FeatureCollection", "features": list(features), **members}


def named(crs: Any) -> dict[str, Any]:
    """A member ``crs``."""
    return {"type": "name", "properties": {"name": crs}}


def moved(ring: Sequence[Sequence[float]], x: float, y: float, scale: float = 1.0) -> list[list[float]]:
    """A ring at another place."""
    return [[x + scale * u, y + scale * v] for u, v in ring]


def written(folder: Path, document: Any, name: str = "lots.geojson") -> str:
    """Path of a file with a document; a text or bytes are written as they are."""
    path = folder / name
    if isinstance(document, bytes):
        path.write_bytes(document)
    else:
        path.write_text(document if isinstance(document, str) else json.dumps(document), encoding="utf-8")
    return str(path)


def area(footprint: Footprint) -> float:
    """Square metres of a footprint seen from above, by the shoelace formula."""
    x, y = footprint.polygon[:, 0], -footprint.polygon[:, 2]
    x, y = x - x[0], y - y[0]
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) / 2)
