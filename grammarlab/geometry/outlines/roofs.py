"""CGA's roofs over the faces of meshes: ``roofHip``, ``roofGable``, ``roofPyramid``, ``roofShed``, ``roofRidge``.

Every face becomes a roof, closed if it has no overhang: the face itself turned over from its first edge on, then its
slopes and vertical sides in the order of its edges, each beginning with its edge (for sheds and ridges first the
slopes, then the sides). Slopes over edges on one line that meet above a wing between them are one. Overhangs have
neither thickness nor underside, as in CityEngine. All faces look outwards. A roof of height 0 is a closed sheet. A
face without area, or with crossing edges, does not change.

Angles are in degrees between slope and face, limited to 0..89.9 (sheds: -89.9..89.9); heights are those of
the highest point over the face, in metres, negative ones count as 0 (except for sheds).
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from grammarlab.arrays import Floats, take_rows
from grammarlab.errors import DerivationError
from grammarlab.geometry.meshes.mesh import Indices, Meshes
from grammarlab.geometry.meshes.planar import RELATIVE_TOLERANCE, Polygons, lay_flat, rectangle_sizes, regroup
from grammarlab.geometry.outlines import plain_roofs
from grammarlab.geometry.outlines.patches import Patch, alike, in_order, stamp, stamp_patch
from grammarlab.geometry.outlines.roof_faces import Sheet, build, free_overhang
from grammarlab.geometry.outlines.roof_plan import AUTOMATIC, Plan, gable_plan, hip_plan

By = Literal["angle", "height"]

STEEPEST = 89.9
"""Largest angle of a slope, in degrees."""


def roof_hip(
    meshes: Meshes,
    value: Floats | float,
    by: By = "angle",
    overhang: Floats | float = 0.0,
    even: bool = False,
) -> Meshes:
    """A slope over every edge, all equally steep: the straight skeleton of each face.

    Args:
        meshes: M meshes.
        value: [M] or one for all: angle or height, see above.
        by: whether values are angles or heights.
        overhang: [M] or one for all: length of overhangs in metres on the slope, less where slopes would intersect;
            slopes of a negative one begin above the face.
        even: whether ridges are made level; slopes may then be not planar.

    Raises:
        DerivationError: If a value is not finite.
    """
    polygons = lay_flat(meshes)
    amount, eaves = _per_face(meshes, value, overhang)
    rectangular, sizes = rectangle_sizes(polygons)
    square = np.abs(sizes[:, 0] - sizes[:, 1]) <= RELATIVE_TOLERANCE * sizes.max(axis=1, initial=0.0)
    kind = np.where(square, 2, np.where(sizes[:, 0] > sizes[:, 1], 0, 1))
    roofs = _Roofs(polygons, amount, by, eaves, np.zeros_like(eaves))
    for i in range(3):
        roofs.add_rectangles(np.flatnonzero(rectangular & (kind == i)), sizes, i, gables=())
    for members, xy, _ in alike(polygons, np.flatnonzero(~rectangular), [None] * int((~rectangular).sum())):
        roofs.add(members, hip_plan(xy, even))
    return roofs.collected(meshes)


def roof_gable(
    meshes: Meshes,
    value: Floats | float,
    by: By = "angle",
    overhang_x: Floats | float = 0.0,
    overhang_y: Floats | float = 0.0,
    even: bool = False,
    index: Indices | int | None = None,
) -> Meshes:
    """A hip roof whose triangular slopes at the ends of wings are vertical gables instead; rectangles: the short ends.

    Args:
        meshes: M meshes.
        value: [M] or one for all: angle or height, see above.
        by: whether values are angles or heights.
        overhang_x: [M] or one for all: overhang at eaves, in metres on the slope, see `roof_hip`.
        overhang_y: [M] or one for all: overhang at gables, in metres along the ridge; slopes of a negative one
            end before the gables.
        even: whether ridges are made level; slopes may then be not planar.
        index: [M] or one for all: the edge that is a gable together with the opposite one; any integer, counted
            cyclically. Convex faces only: others ignore it. By default the shape decides.

    Raises:
        DerivationError: If a value is not finite.
    """
    polygons = lay_flat(meshes)
    amount, eaves, verges = _per_face(meshes, value, overhang_x, overhang_y)
    rectangular, sizes = rectangle_sizes(polygons)
    if index is None:
        gable_edge = np.full(len(polygons), AUTOMATIC)
        near = sizes[:, 0] >= sizes[:, 1] - RELATIVE_TOLERANCE * sizes[:, 1]
        first_gable = np.where(near, 1, 0)
    else:
        index_of_face = np.broadcast_to(np.asarray(index, np.int64), len(meshes))[meshes.mesh_of_face()]
        gable_edge = index_of_face % np.maximum(polygons.counts, 1)
        first_gable = gable_edge % 2
    roofs = _Roofs(polygons, amount, by, eaves, verges)
    for i in range(2):
        members = np.flatnonzero(rectangular & (first_gable == i))
        roofs.add_rectangles(members, sizes, 1 - i, gables=(i, i + 2))
    slow = np.flatnonzero(~rectangular)
    for members, xy, edge in alike(polygons, slow, gable_edge[slow].tolist()):
        roofs.add(members, gable_plan(xy, edge, even))
    return roofs.collected(meshes)


def roof_pyramid(meshes: Meshes, value: Floats | float, by: By = "angle") -> Meshes:
    """A triangle over every edge, up to one tip over the mean of the corners.

    Args:
        meshes: M meshes.
        value: [M] or one for all: height, or angle between the face and the line from the middle of its first edge to
            the tip, see above.
        by: whether values are angles or heights.

    Raises:
        DerivationError: If a value is not finite.
    """
    (amount,) = _per_face(meshes, value)
    # Imported here: it loads shapely.
    from grammarlab.geometry.meshes.shadows import without_holes  # noqa: PLC0415

    return plain_roofs.pyramids(without_holes(meshes), _limited(amount, by, 0.0), by == "height")


def taper(meshes: Meshes, heights: Floats) -> Meshes:
    """A pyramid over the first face of each mesh, its tip over the mean of the corners; the other faces are dropped.

    Args:
        meshes: M meshes.
        heights: [M] metres, at least 0.
    """
    first = np.unique(meshes.mesh_of_face(), return_index=True)[1]
    filled = np.diff(meshes.mesh_faces) > 0
    corners, offsets = take_rows(meshes.face_offsets, first)
    points = meshes.points[meshes.corner_points()[corners]]
    alone = Meshes.from_polygons(points, np.diff(offsets), filled.astype(np.int64))
    return plain_roofs.pyramids(alone, heights[filled], is_height=True)


def roof_shed(meshes: Meshes, value: Floats | float, by: By = "angle", index: Indices | int = 0) -> Meshes:
    """One slope that rises from an edge, on vertical sides. The lowest point of the slope lies on the face.

    Args:
        meshes: M meshes.
        value: [M] or one for all: angle or height, see above; negative ones fall from the edge.
        by: whether values are angles or heights.
        index: [M] or one for all: the edge; any integer, counted cyclically.

    Raises:
        DerivationError: If a value is not finite.
    """
    (amount,) = _per_face(meshes, value)
    edge = np.broadcast_to(np.asarray(index, np.int64), len(meshes))[meshes.mesh_of_face()]
    return plain_roofs.sheds(meshes, _limited(amount, by, -np.inf), by == "height", edge)


def roof_ridge(meshes: Meshes, value: Floats | float, by: By = "angle") -> Meshes:
    """Two slopes up to one ridge along the x axis, midway across the face, on vertical sides.

    Args:
        meshes: M meshes, in the axes of their scopes.
        value: [M] or one for all: angle or height, see above.
        by: whether values are angles or heights.

    Raises:
        DerivationError: If a value is not finite.
    """
    (amount,) = _per_face(meshes, value)
    return plain_roofs.ridges(meshes, _limited(amount, by, 0.0), by == "height")


def _per_face(meshes: Meshes, *values: Floats | float) -> list[Floats]:
    """[F] each value for every face."""
    mesh = meshes.mesh_of_face()
    columns = [np.broadcast_to(np.asarray(value, np.float64), len(meshes))[mesh] for value in values]
    if not all(np.isfinite(column).all() for column in columns):
        raise DerivationError("a roof needs finite angles, heights and overhangs, but one is infinite or not a number")
    return columns


def _limited(amount: Floats, by: By, least: float) -> Floats:
    """Slopes (rise over run) from angles, or the given heights, at least ``least``."""
    if by == "height":
        return np.maximum(amount, least)
    return np.tan(np.radians(np.clip(amount, max(least, -STEEPEST), STEEPEST)))


class _Roofs:
    """Hip and gable roofs, collected batch by batch."""

    def __init__(self, polygons: Polygons, amount: Floats, by: By, eaves: Floats, verges: Floats) -> None:
        self._polygons = polygons
        self._amount = _limited(amount, by, 0.0)
        self._by = by
        self._eaves = eaves
        self._verges = verges
        self._batches: list[Meshes] = []
        self._rows: list[Indices] = []

    def add_rectangles(self, rows: Indices, sizes: Floats, kind: int, gables: tuple[int, ...]) -> None:
        """Roofs on rectangles, by formula: ridge along the first edge (kind 0), the second (1), or just a tip (2)."""
        if not len(rows):
            return
        width, depth = sizes[rows].T
        half = 0.5 * np.minimum(width, depth) if not gables else 0.5 * (depth if kind == 0 else width)
        inset = 0.0 * half if gables else half
        zero = 0.0 * half
        if kind == 0:
            tips = [(inset, half), (width - inset, half)]
        elif kind == 1:
            tips = [(half, inset), (half, depth - inset)]
        else:
            tips = [(half, half)]
        nodes = [(zero, zero), (width, zero), (width, depth), (zero, depth), *tips]
        xy = np.stack([np.stack(node, axis=1) for node in nodes], axis=1)
        time = np.stack([zero] * 4 + [half] * len(tips), axis=1)
        for members, has_eaves, has_verges in self._by_overhang(rows, bool(gables)):
            chosen = np.isin(rows, members)
            plan = Plan(
                xy=xy[chosen][0],
                time=time[chosen][0],
                corner=(0, 1, 2, 3),
                edges=((0, 1), (1, 2), (2, 3), (3, 0)),
                faces=tuple((loop,) for loop in _RECTANGLE_LOOPS[kind]),
                gables=frozenset(gables),
                bottom=(0, 1, 2, 3),
            )
            self._raise(members, xy[chosen], time[chosen], plan, build(plan, has_eaves, has_verges))

    def add(self, rows: Indices, plan: Plan | None) -> None:
        """Roofs on equal polygons."""
        if plan is None:
            whole = self._polygons.xy[self._polygons.offsets[rows[0]] : self._polygons.offsets[rows[0] + 1]]
            loop = tuple(range(len(whole)))
            self._batches.append(
                stamp_patch(self._polygons, rows, Patch(whole, np.zeros(len(whole)), loop, (loop,), (0,)))
            )
            self._rows.append(rows)
            return
        for members, has_eaves, has_verges in self._by_overhang(rows, bool(plan.gables)):
            xy = np.broadcast_to(plan.xy, (len(members), *plan.xy.shape))
            time = np.broadcast_to(plan.time, (len(members), len(plan.time)))
            self._raise(members, xy, time, plan, build(plan, has_eaves, has_verges))

    def _by_overhang(self, rows: Indices, has_gables: bool) -> list[tuple[Indices, bool, bool]]:
        """Rows grouped by the presence of overhangs at eaves and at gables."""
        verges = (self._verges[rows] != 0.0) & has_gables
        # A slope that ends before a gable does so down to the eaves.
        eaves = (self._eaves[rows] != 0.0) | (verges & (self._verges[rows] < 0.0))
        cases = [(eave, verge) for eave in (False, True) for verge in (False, True)]
        parts = [(rows[(eaves == eave) & (verges == verge)], eave, verge) for eave, verge in cases]
        return [part for part in parts if len(part[0])]

    def _raise(self, rows: Indices, xy: Floats, time: Floats, plan: Plan, sheet: Sheet) -> None:
        """Lift a sheet over its plan [K, N, 2] by the slopes of the rows [K]."""
        highest = time.max(axis=1)
        amount = self._amount[rows]
        slope = amount if self._by == "angle" else amount / highest
        eaves = self._eaves[rows] / np.sqrt(1.0 + slope * slope)
        verges = self._verges[rows] * bool(plan.gables)
        if not plan.is_convex:
            distinct, inverse = np.unique(np.stack([eaves, verges], axis=1), axis=0, return_inverse=True)
            free = np.array([_free(plan, eave, verge) for eave, verge in distinct.tolist()])[inverse.ravel()]
            eaves, verges = eaves * free, verges * free
        push, rise = sheet.push, sheet.rise
        out = xy[:, sheet.source] + eaves[:, None, None] * push[:, 0] + verges[:, None, None] * push[:, 1]
        up = time[:, sheet.source] + eaves[:, None] * rise[:, 0] + verges[:, None] * rise[:, 1]
        tags = [0] * len(sheet.faces)
        self._batches.append(stamp(self._polygons, rows, out, up * slope[:, None], plan.corner, sheet.faces, tags))
        self._rows.append(rows)

    def collected(self, meshes: Meshes) -> Meshes:
        """All roofs, in the order of their faces."""
        if not self._batches:
            return meshes
        return regroup(in_order(self._batches, self._rows), meshes.mesh_faces)


def _free(plan: Plan, eave: float, verge: float) -> float:
    """The largest share of overhangs at which slopes do not meet; what ends before the gables does not count."""
    return free_overhang(plan, eave, verge if eave <= 0.0 else max(verge, 0.0))


_RECTANGLE_LOOPS = (
    ((0, 1, 5, 4), (1, 2, 5), (2, 3, 4, 5), (3, 0, 4)),
    ((0, 1, 4), (1, 2, 5, 4), (2, 3, 5), (3, 0, 4, 5)),
    ((0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
)
"""Slopes over the edges of a rectangle, for a ridge along the first edge, along the second, and for a tip."""
