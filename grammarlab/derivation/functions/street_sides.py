"""Sides of faces, edges and vertices of shapes by the streets around their lot: ``street.front`` and its kin.

A face is on the edge of the lot that lies behind one of its edges (`edges_behind`), and has the side of that edge.
Faces inside the lot, such as those where a split cuts, are at the back, left or right by their normals. Geometry that
is not of the lot, such as an asset, has the side of the edge that looks in the most similar direction.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple, cast

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints, offsets_from_counts
from grammarlab.derivation.state.shapes import Shapes
from grammarlab.derivation.state.street_outlines import StreetOutlines, outline_ids, plan_ids, with_outlines
from grammarlab.derivation.state.workspace import Workspace
from grammarlab.geometry.edges_behind import (
    EdgesBehind,
    EdgeSets,
    OutwardSegments,
    across_edges,
    best_of_groups,
    edges_ahead,
    edges_behind,
    edges_that_look_alike,
)
from grammarlab.geometry.lot_sides import BACK, FRONT, LEFT, NO_SIDE, RIGHT, Sides, sides_of_normals
from grammarlab.geometry.meshes.measure import corner_edges, face_normals
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.vectors import cross, unit
from grammarlab.geometry.selectors import nearest_axis

OLDER_SELECTORS = {
    "streetSide": ("street.front",),
    "noStreetSide": ("street.back", "street.left", "street.right"),
}
"""Selectors of older rule files, with equivalent selectors where streets are known.

They ask whether there is a street: if nothing is known, both pick nothing. ``street.front`` asks for a direction.
"""
_TOLERANCE = 1e-6
"""Tolerance of points that lie on an edge, as a share of the longer side of the lot."""
_QUADRANT = np.cos(np.radians(45.0))
"""Smallest cosine between the normals of a side of an inner rectangle and of the edge that it stands for."""
_SELECTED: dict[str, tuple[int, ...]] = {
    "front": (FRONT,),
    "back": (BACK,),
    "left": (LEFT,),
    "right": (RIGHT,),
    "side": (LEFT, RIGHT),
}


class OutwardLines(NamedTuple):
    """K edges of shapes [N], or points where ``along`` is zero, in the axes of their scopes."""

    start: Floats
    """[K, 3] metres from the scope's origin."""
    along: Floats
    """[K, 3] vector to the other end."""
    outward: Floats
    """[K, 3] unit vector towards the outer side."""
    owner: Ints
    """[K] the shape of each."""

    def take(self, rows: Ints) -> OutwardLines:
        """The lines at these rows, repeats allowed."""
        return OutwardLines(self.start[rows], self.along[rows], self.outward[rows], self.owner[rows])


def by_streets(
    selector: str, sides: Callable[[], Sides], flags: Flags, owner: Ints, shapes: Shapes, workspace: Workspace
) -> Flags:
    """[K] what a selector names: sides of lots, if it is a ``street`` selector and their streets are known.

    Args:
        selector: the selector.
        sides: makes the sides [K]; called only if they are needed.
        flags: [K] what it names elsewhere.
        owner: [K] the shape of each face, edge or vertex.
        shapes: [N].
        workspace: workspace of the derivation.
    """
    if workspace.streets is None or not selector.startswith("street."):
        return flags
    return np.where(workspace.streets.known(shapes)[owner], _has_side(selector, sides()), flags)


def picked_by(
    selector: str, picked: Callable[[str], Flags], owner: Ints, shapes: Shapes, workspace: Workspace
) -> Flags:
    """[K] what a selector, or one of older rule files, picks.

    Args:
        selector: the selector.
        picked: what a selector that is not of older rule files picks [K].
        owner: [K] the shape of each face, edge or vertex.
        shapes: [N].
        workspace: workspace of the derivation.
    """
    if selector not in OLDER_SELECTORS:
        return picked(selector)
    if workspace.streets is None:
        return np.zeros(len(owner), bool)
    return workspace.streets.known(shapes)[owner] & np.logical_or.reduce([*map(picked, OLDER_SELECTORS[selector])])


def _has_side(selector: str, sides: Sides) -> Flags:
    """[K] whether a ``street`` selector names sides."""
    return np.isin(sides, _SELECTED[selector.removeprefix("street.")])


def face_sides(meshes: Meshes, shapes: Shapes, workspace: Workspace) -> Sides:
    """[F] sides of all faces of shapes; `NO_SIDE` for faces that look up or down more than sideways.

    Args:
        meshes: [N] geometry of the shapes in metres along the axes of their scopes.
        shapes: [N].
        workspace: workspace of the derivation.
    """
    streets = _streets(workspace)
    owner, face = meshes.mesh_of_face(), meshes.face_of_corner()
    normals = face_normals(meshes)
    lateral = _lateral_directions(normals, owner, shapes, workspace)
    corners = np.flatnonzero(lateral[face].any(axis=1))
    lines = _around_faces(meshes, normals, corners)
    on_edge = best_of_groups(_edges_of(lines, shapes, workspace, streets), face[corners], len(owner))
    return np.where(on_edge > 0, on_edge, _sides_by_direction(lateral, owner, shapes, streets))


def line_sides(lines: OutwardLines, shapes: Shapes, workspace: Workspace) -> Sides:
    """[K] sides of edges or points of shapes: of the edge of the lot that they are on, or by their outward vectors."""
    streets = _streets(workspace)
    on_edge = _edges_of(lines, shapes, workspace, streets).label
    lateral = _lateral_directions(lines.outward, lines.owner, shapes, workspace)
    return np.where(on_edge > 0, on_edge, _sides_by_direction(lateral, lines.owner, shapes, streets))


def outline_lines(meshes: Meshes) -> OutwardLines:
    """[C] the edge that leaves each corner of faces, with the vector that points out of the face within its plane."""
    lines = _around_faces(meshes, face_normals(meshes), np.arange(len(meshes.corners)))
    return lines._replace(outward=unit(cross(lines.along, lines.outward)))


class EdgeMoves(NamedTuple):
    """How an operation moved the edges of the faces of shapes [N]."""

    meshes: Meshes
    """[N] the shapes before, in metres along their axes."""
    distance: Floats
    """[C] metres by which the edge that leaves each corner moved inwards, below 0 outwards."""
    by_direction: bool = False
    """Whether an edge that is on none of them stands for the one that looks in the most similar direction."""
    has_wings: bool = False
    """Whether parts are wings, whose inner edges may look at a street past the other wings."""


def with_moved_edges(
    parts: Shapes, pieces: Meshes, row: Ints, before: Shapes, moved: EdgeMoves, workspace: Workspace
) -> Shapes:
    """Parts of shapes that remember the edges of the lot of which they have something, and no others.

    Walls stay on the edges of the lot, whatever part of them is cut off.

    Args:
        parts: [K] the parts.
        pieces: [K] their geometry in metres, along the axes of the shapes they come from and from their origins.
        row: [K] the shape that each comes from, ascending.
        before: [N] these shapes.
        moved: how their edges moved.
        workspace: workspace of the derivation.
    """
    streets = workspace.streets
    if streets is None or parts.num == 0 or not (plan_ids(before) >= 0).any():
        return parts
    old = _old_and_new_edges(moved, before, workspace, streets)
    lines = outline_lines(pieces)
    piece = lines.owner
    in_lots = _segments(lines._replace(owner=row[piece]), before, workspace, streets)
    segments = replace(in_lots, outline=row[piece])
    behind = edges_behind(segments, old)
    label = np.where(behind.distance == 0.0, behind.label, NO_SIDE)
    if moved.by_direction:
        alike = edges_that_look_alike(segments.normals(), segments.outline, old, _QUADRANT)
        label = np.where(label == NO_SIDE, alike, label)
    if moved.has_wings:
        looks_at_street = _look_at_streets(in_lots, row[piece], streets)
        label = np.where((label == NO_SIDE) & looks_at_street, np.int8(FRONT), label)
    rows = np.flatnonzero(label > 0)
    ids = streets.add(_outlines(segments, rows, label[rows], piece[rows], parts.num))
    lies_flat = (plan_ids(before) >= 0) & ~_stand(moved.meshes, before, workspace)
    return with_outlines(parts, np.where(lies_flat[row], ids, outline_ids(parts)))


def _look_at_streets(segments: OutwardSegments, row: Ints, streets: StreetOutlines) -> Flags:
    """[K] whether an edge of a wing looks at an edge along a street, past all edges of the wings of its shape.

    Args:
        segments: edges of wings, ordered by shape, with the sets of edges of their lots.
        row: [K] the shape of each.
        streets: the sets.
    """
    outlines, normals = streets.outlines, segments.normals()
    rows = np.flatnonzero((segments.outline >= 0) & normals.any(axis=1))
    wings = EdgeSets(
        segments.start, segments.end, np.ones(len(row), np.int8), offsets_from_counts(np.bincount(row, minlength=1))
    )
    points, directions = (segments.start[rows] + segments.end[rows]) / 2.0, normals[rows]
    slack = segments.tolerance[rows]
    edge, distance = edges_ahead(points, directions, segments.outline[rows], outlines, -slack)
    _, obstacle = edges_ahead(points, directions, row[rows], wings, slack)
    ahead = np.flatnonzero((edge >= 0) & (obstacle >= distance - slack))
    seen = edge[ahead]
    across = across_edges(outlines.end[seen] - outlines.start[seen])
    cosine = across[:, 0] * directions[ahead, 0] + across[:, 1] * directions[ahead, 1]
    result = np.zeros(len(row), dtype=bool)
    result[rows[ahead[(outlines.label[seen] == FRONT) & (cosine > _QUADRANT)]]] = True
    return result


def _stand(meshes: Meshes, shapes: Shapes, workspace: Workspace) -> Flags:
    """[N] whether the first face of a shape looks sideways."""
    result = np.zeros(shapes.num, dtype=bool)
    filled = np.flatnonzero(np.diff(meshes.mesh_faces) > 0)
    normals = face_normals(meshes)[meshes.mesh_faces[:-1][filled]]
    result[filled] = _lateral_directions(normals, filled, shapes, workspace).any(axis=1)
    return result


def _streets(workspace: Workspace) -> StreetOutlines:
    return cast("StreetOutlines", workspace.streets)


def _old_and_new_edges(moved: EdgeMoves, shapes: Shapes, workspace: Workspace, streets: StreetOutlines) -> EdgeSets:
    """For each shape [N] its edges on the edges of the lot, where they were and where they are."""
    lines = outline_lines(moved.meshes)
    label = _edges_of(lines, shapes, workspace, streets).label
    rows = np.repeat(np.flatnonzero(label > 0), 2)
    chosen = lines.take(rows)
    chosen.start[1::2] -= chosen.outward[1::2] * moved.distance[rows[1::2], None]
    segments = _segments(chosen, shapes, workspace, streets)
    return _outlines(segments, np.arange(len(rows)), label[rows], chosen.owner, shapes.num)


def _outlines(segments: OutwardSegments, rows: Ints, label: Sides, group: Ints, num_groups: int) -> EdgeSets:
    """Sets of edges [G] from segments at rows [S], ordered by group, which run so that their outer sides are right."""
    start, end = segments.start[rows], segments.end[rows]
    normals = segments.normals()[rows]
    turn = (end - start)[:, 0] * normals[:, 1] - (end - start)[:, 1] * normals[:, 0] < 0.0
    counts = np.bincount(group, minlength=num_groups)
    return EdgeSets(
        np.where(turn[:, None], end, start),
        np.where(turn[:, None], start, end),
        label.astype(np.int8),
        offsets_from_counts(counts),
    )


def _around_faces(meshes: Meshes, normals: Floats, corners: Ints) -> OutwardLines:
    """The edges that leave corners [K] of faces with normals [F, 3], outward in the direction of their face."""
    face = meshes.face_of_corner()[corners]
    return OutwardLines(
        meshes.points[meshes.corner_points()[corners]],
        corner_edges(meshes)[corners],
        normals[face],
        meshes.mesh_of_face()[face],
    )


def _edges_of(lines: OutwardLines, shapes: Shapes, workspace: Workspace, streets: StreetOutlines) -> EdgesBehind:
    """Edges of the lot behind lines [K]; none for shapes that are not of the lot."""
    rows = np.flatnonzero(plan_ids(shapes)[lines.owner] >= 0)
    chosen = lines.take(rows)
    behind = edges_behind(_segments(chosen, shapes, workspace, streets), streets.outlines)
    count = len(lines.owner)
    result = EdgesBehind(np.zeros(count, np.int8), np.full(count, np.inf), np.zeros(count))
    result.label[rows], result.distance[rows], result.overlap[rows] = behind.label, behind.distance, behind.overlap
    return result


def _segments(lines: OutwardLines, shapes: Shapes, workspace: Workspace, streets: StreetOutlines) -> OutwardSegments:
    """OutwardLines [K] in the plans of their lots; without a meaning for shapes that are not of the lot."""
    used, owner = np.unique(lines.owner, return_inverse=True)
    maps = workspace.texture_maps.take(np.maximum(plan_ids(shapes)[used], 0))
    linear = np.einsum("nai,nij->naj", maps[:, :, :3], workspace.frames.rotations(shapes.frame[used]))
    origin = maps[:, :, 3] + np.einsum("nai,ni->na", maps[:, :, :3], shapes.position[used])
    lot = streets.model_lot[shapes.model[lines.owner]]
    start = origin[owner] + _times(linear[owner], lines.start)
    return OutwardSegments(
        start=start,
        end=start + _times(linear[owner], lines.along),
        outward=_times(linear[owner], lines.outward),
        outline=outline_ids(shapes)[lines.owner].astype(np.int64),
        tolerance=_TOLERANCE * streets.extent[lot],
    )


def _times(linear: Floats, vectors: Floats) -> Floats:
    """[K, 2] matrices [K, 2, 3] times vectors [K, 3]."""
    return linear[:, :, 0] * vectors[:, :1] + linear[:, :, 1] * vectors[:, 1:2] + linear[:, :, 2] * vectors[:, 2:]


def _lateral_directions(vectors: Floats, owner: Ints, shapes: Shapes, workspace: Workspace) -> Floats:
    """[K, 2] unit directions, in the plan of the lot, in which vectors look; zero for those that look up or down.

    Args:
        vectors: [K, 3] unit vectors or zero, in the axes of the scopes.
        owner: [K] the shape that each belongs to.
        shapes: [N].
        workspace: workspace of the derivation.
    """
    frames, roots = workspace.frames, workspace.roots
    world = frames.to_world(shapes.frame[owner], vectors)
    local = frames.to_local(roots.frame[shapes.model[owner]], world)
    is_lateral = local.any(axis=1) & (nearest_axis(local) != 1)
    flat = unit(local * [1.0, 0.0, 1.0])[:, [0, 2]]
    return np.where(is_lateral[:, None], flat, 0.0)


def _sides_by_direction(lateral: Floats, owner: Ints, shapes: Shapes, streets: StreetOutlines) -> Sides:
    """[K] sides of what is on no edge of the lot, by the directions [K, 2] in which it looks."""
    lot = streets.model_lot[shapes.model[owner]].astype(np.int64)
    inside = sides_of_normals(lateral, streets.front[lot])
    rows = np.flatnonzero(plan_ids(shapes)[owner] < 0)
    inside[rows] = edges_that_look_alike(lateral[rows], lot[rows], streets.outlines)
    return inside
