"""Ground of a city: parcels, pavements and streets as coloured surfaces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats
from grammarlab.city.map_squares import cut_by_squares, polygons_of
from grammarlab.city.packed_outlines import Outlines
from grammarlab.derivation.materials import CHANNELS, Materials
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.runs.city.outline_face import outline_face
from grammarlab.runs.city.survey import Survey, lot_outlines
from grammarlab.scene import Scene

_COLORS = {
    "garden": "8FA071",
    "park": "7C9A5E",
    "yard": "B9B2A4",
    "pavement": "A8A49C",
    "street": "6F7073",
    "land": "9DA284",
}
"""Kinds of ground and their colours."""
KINDS = tuple(_COLORS)
LAND = KINDS.index("land")
"""Kind of what is neither a parcel nor along a street."""
Kinds: TypeAlias = NDArray[np.int64]
_STREET, _PAVEMENT = 14.0, 2.0
"""Metres around parcels that are street, and pavement."""
_CLOSING = 1.0
"""Gaps between parcels up to twice this width in metres are not streets."""
_LIFT = {"land": 0.0, "street": 0.0, "pavement": 0.02, "yard": 0.02, "garden": 0.02, "park": 0.02}
"""Metres above the ground of each kind."""
_YARD = 0.5
"""Share of a parcel that a building fills from which on there is no garden."""
_STEP = 10.0
"""Longest edge of streets in metres, so that they follow the terrain."""
_SQUARE, _MOST_SQUARES = 5.0, 40_000
"""Side in metres of the squares that follow a terrain, and the number of squares above which they are larger."""


@dataclass(frozen=True, eq=False)
class GroundPieces:
    """K polygons of ground, in metres of the frame: x east, y north."""

    outline: Outlines
    """[K] polygons with their holes."""
    kind: Kinds
    """[K] index into `KINDS`."""

    def where(self, chosen: Flags) -> GroundPieces:
        """The pieces that are chosen [K]."""
        return GroundPieces(self.outline[chosen], self.kind[chosen])


def ground_pieces(outlines: Outlines, kind: Kinds, cell: shapely.Polygon, *, has_land: bool = False) -> GroundPieces:
    """The ground of one square: its parcels whole, and what of the streets around all parcels lies in it.

    Args:
        outlines: parcels in the square and around it.
        kind: [n] kind of the ground of each, an index into `KINDS`.
        cell: the square.
        has_land: whether there is ground beyond the streets.
    """
    inside = shapely.contains_properly(cell, shapely.point_on_surface(outlines))
    near = shapely.intersects(outlines, shapely.buffer(cell, 2 * _STREET))
    built = shapely.buffer(
        shapely.buffer(shapely.union_all(outlines[near]), _CLOSING, join_style="mitre"), -_CLOSING, join_style="mitre"
    )
    pavement = shapely.buffer(built, _PAVEMENT, join_style="mitre")
    street = shapely.buffer(built, _STREET, join_style="mitre")
    parts = [outlines[inside]], [kind[inside]]
    for name, shape in (
        ("pavement", shapely.difference(pavement, built)),
        ("street", shapely.difference(street, pavement)),
        ("land", shapely.difference(cell, street) if has_land else shapely.Polygon()),
    ):
        pieces, _ = polygons_of(np.array([shapely.intersection(shape, cell)]))
        parts[0].append(shapely.segmentize(pieces, _STEP))
        parts[1].append(np.full(len(pieces), KINDS.index(name)))
    return GroundPieces(np.concatenate(parts[0]), np.concatenate(parts[1]))


def draped(pieces: GroundPieces) -> GroundPieces:
    """The pieces cut into squares, whose corners follow a terrain."""
    side = _SQUARE
    while shapely.area(pieces.outline).sum() > _MOST_SQUARES * side * side:
        side *= 2.0
    outline, row = cut_by_squares(pieces.outline, side)
    return GroundPieces(outline, pieces.kind[row])


def ground_scene(pieces: GroundPieces, origin: Floats, heights: Callable[[Floats], Floats]) -> Scene:
    """The pieces of ground as one model.

    Args:
        pieces: at least one piece.
        origin: [3] origin of the model in metres of the frame: x east, y up, z south.
        heights: height of the ground in metres at points [n, 2], east and north.
    """
    faces = [outline_face(polygon) for polygon in pieces.outline]
    plan = np.concatenate(faces)
    counts = np.array([len(face) for face in faces])
    lift = np.array([_LIFT[kind] for kind in KINDS])[pieces.kind]
    up = heights(plan) + np.repeat(lift, counts)
    points = np.column_stack([plan[:, 0], up, -plan[:, 1]]) - origin
    order = np.argsort(pieces.kind, kind="stable")
    num = len(faces)
    return Scene(
        num_models=1,
        meshes=Meshes.from_polygons(points, counts),
        materials=_materials(),
        model=np.zeros(num, np.int32),
        mesh=order.astype(np.int32),
        material=pieces.kind[order].astype(np.int32),
        position=np.zeros((num, 3)),
        size=np.ones((num, 3)),
        frame=np.zeros(num, np.int32),
        frames=np.eye(3)[None],
        texture_map=np.full(num, -1, np.int32),
        texture_maps=np.zeros((0, 2, 4)),
        origins=np.zeros((1, 3)),
    )


def _materials() -> Materials:
    channels = np.tile(list(CHANNELS.values()), (len(KINDS), 1))
    for row, color in enumerate(_COLORS.values()):
        channels[row, :3] = [int(color[at : at + 2], 16) / 255 for at in (0, 2, 4)]
    return Materials(channels, ("",) * len(KINDS))


def square(east: float, north: float, size: float) -> shapely.Polygon:
    """The square around a middle."""
    return shapely.box(east - size / 2, north - size / 2, east + size / 2, north + size / 2)


def kinds_of_parcels(survey: Survey, is_park: Sequence[bool]) -> Kinds:
    """[N] kind of the ground of each parcel: parks, yards where buildings fill more than half of it, else gardens.

    Args:
        survey: the survey.
        is_park: whether each zone has trees instead of buildings.
    """
    sites, parcels = survey.sites, survey.parcels
    kind = np.full(len(parcels), KINDS.index("garden"))
    share = shapely.area(lot_outlines(sites)) / parcels.area[sites.parcel]
    kind[sites.parcel[share > _YARD]] = KINDS.index("yard")
    kind[sites.parcel[np.array(is_park, np.bool_)[sites.zone]]] = KINDS.index("park")
    return kind
