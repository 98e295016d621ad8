"""Outlines of parcels in the coordinates of a tileset, for the ground of the page."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.city.ground_heights import HeightField
from grammarlab.city.plan import Plan
from grammarlab.errors import AssetError, GrammarlabError
from grammarlab.extras import named_extras
from grammarlab.files import read_bounded
from grammarlab.geometry.footprints.frame import Frame
from grammarlab.pages.city.parcel_facts import ParcelFacts
from grammarlab.pages.city.street_surface import (
    NO_STREETS,
    NO_SURFACES,
    land_triangles,
    parcel_triangles,
    street_triangles,
)
from grammarlab.runs.city.survey import PlacedTerrain

MOST_OUTLINES = 100_000
"""Largest number of parcels that are drawn; cities with more are shown without their ground."""
MOST_STREETS = 20_000
"""Largest number of parcels between which streets are drawn."""
MAX_TILESET_BYTES = 64 << 20
"""Largest size of a tileset in bytes."""
NO_ZONE = 255
_EARTH_CENTRED = "EPSG:4978"
_SIMPLIFY = 0.1
"""Metres by which drawn outlines may differ."""
_STEP = 10.0
"""Longest edge of outlines in metres on a terrain."""


@dataclass(frozen=True, eq=False, kw_only=True)
class GroundPlan:
    """N parcels and T triangles of streets in metres: x to the east, y up, z to the south of the tileset's origin."""

    offsets: NDArray[np.uint32]
    """[N + 1] into the corners."""
    corners: NDArray[np.float32]
    """[C, 3] corners of the outer rings of parcels."""
    zones: NDArray[np.uint8]
    """[N] numbers of zones; `NO_ZONE` for none."""
    built: NDArray[np.uint8]
    """[N] 1 for parcels with a building."""
    streets: NDArray[np.float32]
    """[T, 3, 3] corners of triangles of streets and pavements, and of the land around them on a terrain."""
    kinds: NDArray[np.uint8]
    """[T] index into `grammarlab.pages.city.street_surface.SURFACES`."""
    surfaces: NDArray[np.float32]
    """[S, 3, 3] corners of triangles of parcels on a terrain; none where the ground is level, or parcels are many."""
    owners: NDArray[np.uint32]
    """[S] row of the parcel of each triangle."""

    @property
    def buffers(self) -> tuple[bytes, ...]:
        """All columns as bytes, little-endian."""
        columns = (self.offsets, self.corners, self.zones, self.built, self.streets, self.kinds)
        columns = (*columns, self.surfaces, self.owners)
        return tuple(column.tobytes() for column in columns)


@dataclass(frozen=True)
class GroundPlacement:
    """Place of the ground of a city among its tiles."""

    frame: Frame
    transform: NDArray[np.float64]
    """[4, 4] matrix from metres east, north and up of the origin of the tileset to earth-centred coordinates."""
    base: float
    """Height in metres of the zero of the terrain, or of level ground, in the coordinates of the tiles."""
    terrain: HeightField | None
    """None for level ground."""

    def local(self, points: NDArray[np.float64]) -> NDArray[np.float32]:
        """[n, 3] x, y and z in metres among the tiles of points [n, 2] in metres from the origin of the frame.

        Raises:
            AssetError: If the coordinate system cannot be used.
        """
        heights = np.zeros(len(points)) if self.terrain is None else np.nan_to_num(self.terrain.heights(points))
        east_north_up = np.column_stack([points, heights + self.base])
        if self.frame.has_place and len(points):
            east_north_up = _from_earth(east_north_up, self.frame, self.transform)
        return (east_north_up[:, [0, 2, 1]] * (1.0, 1.0, -1.0)).astype("<f4")


def ground_placement(facts: ParcelFacts, folder: Path, plan: Plan | None) -> GroundPlacement:
    """Place of the ground of a city among its tiles.

    Args:
        facts: its parcels.
        folder: folder of its tileset.
        plan: its plan, which names its terrain; None if it is unknown.

    Raises:
        AssetError: If its tileset cannot be read.
    """
    base = 0.0 if plan is None else plan.geoid_height or 0.0
    return GroundPlacement(facts.frame, _transform(folder), base, _terrain(facts.frame, plan))


def ground_plan(facts: ParcelFacts, placement: GroundPlacement) -> GroundPlan | None:
    """The ground of a city; None if it has too many parcels. Streets among 10,000 parcels take 2 seconds.

    Raises:
        AssetError: If the coordinate system of the city cannot be used.
    """
    if len(facts) > MOST_OUTLINES:
        return None
    is_level, are_few = placement.terrain is None, len(facts) <= MOST_STREETS
    outlines = facts.rows.outline
    points, offsets = _corners(outlines, np.inf if is_level else _STEP)
    streets, kinds = street_triangles(outlines, is_level=is_level) if are_few else NO_STREETS
    surfaces, owners = NO_SURFACES
    if placement.terrain is not None and are_few:
        land, land_kinds = land_triangles(outlines)
        is_known = ~np.isnan(placement.terrain.heights(land.mean(axis=1)))
        streets, kinds = np.concatenate([streets, land[is_known]]), np.concatenate([kinds, land_kinds[is_known]])
        surfaces, owners = parcel_triangles(outlines)
    numbers = {zone: min(number, NO_ZONE - 1) for number, zone in enumerate(facts.zones)}
    return GroundPlan(
        offsets=offsets.astype("<u4"),
        corners=placement.local(points),
        zones=np.array([numbers.get(zone, NO_ZONE) for zone in facts.rows.zone], np.uint8),
        built=facts.is_built.astype(np.uint8),
        streets=placement.local(streets.reshape(-1, 2)).reshape(-1, 3, 3),
        kinds=kinds,
        surfaces=placement.local(surfaces.reshape(-1, 2)).reshape(-1, 3, 3),
        owners=owners.astype("<u4"),
    )


def _corners(outlines: NDArray[np.object_], step: float) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Corners [C, 2] of the outer rings of first parts, without the repeated last ones, and their offsets [N + 1].

    Edges that are longer than a step have corners between their ends.
    """
    rings = shapely.simplify(shapely.get_exterior_ring(shapely.get_geometry(outlines, 0)), _SIMPLIFY)
    if np.isfinite(step):
        rings = shapely.segmentize(rings, step)
    points, ring = shapely.get_coordinates(rings, return_index=True)
    is_last = np.append(ring[1:] != ring[:-1], True)[: len(ring)]
    counts = np.bincount(ring[~is_last], minlength=len(outlines))
    return points[~is_last], np.concatenate([[0], np.cumsum(counts)])


def _from_earth(points: NDArray[np.float64], frame: Frame, transform: NDArray[np.float64]) -> NDArray[np.float64]:
    """[n, 3] metres east, north and up of the origin of the tileset, of points in metres of a frame."""
    with named_extras():
        from pyproj import CRS, Transformer  # noqa: PLC0415  # an extra
        from pyproj.exceptions import ProjError  # noqa: PLC0415
    try:
        system = CRS.from_user_input(frame.crs).to_3d()
        east, north, up = (points + np.array([*frame.origin, 0.0])).T
        places = Transformer.from_crs(system, _EARTH_CENTRED, always_xy=True).transform(east, north, up)
    except ProjError as error:
        raise AssetError(f"the coordinate system of the parcels cannot be used: {error}") from error
    return (np.column_stack([*places, np.ones(len(points))]) @ np.linalg.inv(transform).T)[:, :3]


def _terrain(frame: Frame, plan: Plan | None) -> PlacedTerrain | None:
    if plan is None or plan.terrain is None:
        return None
    try:
        return PlacedTerrain.read(plan.terrain, frame)
    except GrammarlabError:  # it was there when the city was built
        return None


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
