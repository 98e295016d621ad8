"""Outlines of parcels in the coordinates of a tileset, for the ground of the page."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.errors import AssetError
from grammarlab.extras import named_extras
from grammarlab.files import read_bounded
from grammarlab.pages.city.parcel_facts import ParcelFacts

MOST_OUTLINES = 100_000
"""Largest number of parcels that are drawn; cities with more are shown without their ground."""
MAX_TILESET_BYTES = 64 << 20
"""Largest size of a tileset in bytes."""
NO_ZONE = 255
_EARTH_CENTRED = "EPSG:4978"
_SIMPLIFY = 0.1
"""Metres by which drawn outlines may differ."""


@dataclass(frozen=True, eq=False, kw_only=True)
class GroundPlan:
    """N outlines with C corners in metres: x to the east, y up, z to the south of the origin of the tileset."""

    offsets: NDArray[np.uint32]
    """[N + 1] into the corners."""
    points: NDArray[np.float32]
    """[C, 2] x and z of the corners of outer rings."""
    heights: NDArray[np.float32]
    """[N] mean height of the corners."""
    zones: NDArray[np.uint8]
    """[N] numbers of zones; `NO_ZONE` for none."""
    built: NDArray[np.uint8]
    """[N] 1 for parcels with a building."""

    @property
    def buffers(self) -> tuple[bytes, ...]:
        """All columns as bytes, little-endian."""
        return tuple(column.tobytes() for column in (self.offsets, self.points, self.heights, self.zones, self.built))


def ground_plan(facts: ParcelFacts, folder: Path) -> GroundPlan | None:
    """The ground of a city; None if it has too many parcels.

    Args:
        facts: its parcels.
        folder: folder of its tileset.

    Raises:
        AssetError: If its tileset cannot be read.
    """
    if len(facts) > MOST_OUTLINES:
        return None
    points, offsets = _corners(facts.outlines)
    local = _local(np.column_stack([points, np.zeros(len(points))]), facts.crs, _transform(folder))
    numbers = {zone: min(number, NO_ZONE - 1) for number, zone in enumerate(facts.zones)}
    return GroundPlan(
        offsets=offsets.astype("<u4"),
        points=np.column_stack([local[:, 0], -local[:, 1]]).astype("<f4"),
        heights=_means(local[:, 2], offsets).astype("<f4"),
        zones=np.array([numbers.get(zone, NO_ZONE) for zone in facts.zone], np.uint8),
        built=facts.is_built.astype(np.uint8),
    )


def _corners(outlines: NDArray[np.object_]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Corners [C, 2] of the outer rings of first parts, without the repeated last ones, and their offsets [N + 1]."""
    rings = shapely.simplify(shapely.get_exterior_ring(shapely.get_geometry(outlines, 0)), _SIMPLIFY)
    points, ring = shapely.get_coordinates(rings, return_index=True)
    is_last = np.append(ring[1:] != ring[:-1], True)[: len(ring)]
    counts = np.bincount(ring[~is_last], minlength=len(outlines))
    return points[~is_last], np.concatenate([[0], np.cumsum(counts)])


def _local(points: NDArray[np.float64], crs: dict[str, Any] | None, transform: NDArray[np.float64]) -> NDArray[Any]:
    """[C, 3] metres east, north and up of the origin of the tileset."""
    if crs is None or not len(points):
        return points
    with named_extras():
        from pyproj import CRS, Transformer  # noqa: PLC0415  # an extra
        from pyproj.exceptions import ProjError  # noqa: PLC0415
    try:
        system = CRS.from_json_dict(crs).to_3d()
        places = Transformer.from_crs(system, _EARTH_CENTRED, always_xy=True).transform(*points.T)
    except ProjError as error:
        raise AssetError(f"the coordinate system of the parcels cannot be used: {error}") from error
    return (np.column_stack([*places, np.ones(len(points))]) @ np.linalg.inv(transform).T)[:, :3]


def _transform(folder: Path) -> NDArray[np.float64]:
    """[4, 4] matrix from metres east, north and up of the origin of a tileset to earth-centred coordinates."""
    path = folder / "tileset.json"
    try:
        values = json.loads(read_bounded(path, MAX_TILESET_BYTES))["root"].get("transform", np.eye(4).ravel().tolist())
        matrix = np.array(values, np.float64).reshape(4, 4).T
    except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError) as error:
        raise AssetError(f"{path}: expected a tileset ({error}).") from error
    if not np.isfinite(matrix).all() or abs(np.linalg.det(matrix)) < 1e-6:
        raise AssetError(f"{path}: expected a transform of the root that can be inverted.")
    return matrix


def _means(values: NDArray[np.float64], offsets: NDArray[np.int64]) -> NDArray[np.float64]:
    """[N] means of consecutive values; 0 for none."""
    sums = np.concatenate([[0.0], np.cumsum(values)])
    counts = np.diff(offsets)
    return np.diff(sums[offsets]) / np.maximum(counts, 1)
