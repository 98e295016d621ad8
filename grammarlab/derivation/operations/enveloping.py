"""``envelope``: the largest building that height limits and sloping planes over the edges of a lot allow."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.derivation.calls.calls import BoundCall, Operation
from grammarlab.derivation.functions.shape_measures import local_meshes
from grammarlab.derivation.operations.alignment import reframed
from grammarlab.derivation.operations.extrusion import first_normals, stood_up
from grammarlab.derivation.operations.outlines import Rows, edge_values, edges_towards
from grammarlab.derivation.state.array_table import is_table
from grammarlab.derivation.state.face_tags import inherited, with_automatic_tags
from grammarlab.derivation.state.shapes import Shapes
from grammarlab.geometry.meshes.measure import face_normals
from grammarlab.geometry.meshes.mesh import Meshes

_SIDES = {
    3: ("front",),
    5: ("front", "back"),
    7: ("front", "back", "side"),
    9: ("front", "back", "right", "left"),
}
"""Sides of the lot with a height and an angle each, by the number of arguments."""
_TAGS = {0: "bottom", 1: "side.base", 2: "side.slope", 3: "top"}
_LEVEL = 1e-9
"""Tolerance of the height of a unit normal."""
_SELECTORS = {"side": ("left", "right")}


def envelope(call: BoundCall) -> Shapes:
    """``envelope(normal|world.up, height, frontBase, frontAngle, …)``, ``envelope(direction, height, bases, angles)``.

    Each edge has the base height and the angle of its side of the lot (``street.front`` and so on), or those of its
    place in two arrays, in the order of ``comp(fe)``. Edges without them are walls up to the height.
    """
    values, shapes = call.values, call.shapes
    meshes = local_meshes(shapes, call.workspace)
    mesh = meshes.mesh_of_face()[meshes.face_of_corner()]
    bases, angles = _limits(call, meshes, mesh)
    heights = call.column(values[0])
    along = first_normals(meshes)
    if "world.up" in call.words:
        along = call.workspace.frames.to_local(shapes.frame, np.broadcast_to([0.0, 1.0, 0.0], (shapes.num, 3)))
    standing = stood_up(call, _envelopes(meshes, along, heights, bases, angles), along, np.arange(shapes.num))
    kept = inherited(standing, shapes, np.arange(shapes.num), call.workspace)
    tagged = with_automatic_tags(kept, call.workspace, "envelope", _kinds, _TAGS)
    # Other than after ``extrude``, the scope keeps its axes, as in the runtime.
    frames = call.workspace.frames
    turn = np.swapaxes(frames.rotations(tagged.frame), 1, 2) @ frames.rotations(shapes.frame)
    return reframed(call._replace(shapes=tagged), turn)


def _kinds(meshes: Meshes) -> NDArray[np.int64]:
    """[F] which of `_TAGS` a face has: level ones look up or down, walls sideways."""
    height = face_normals(meshes)[:, 1]
    return np.select([height > 1.0 - _LEVEL, height < _LEVEL - 1.0, np.abs(height) < _LEVEL], [3, 0, 1], 2)


def _limits(call: BoundCall, meshes: Meshes, mesh: Rows) -> tuple[Floats, Floats]:
    """Base heights and angles [C] of the edges that leave corners."""
    values = call.values
    if len(values) == 3 and is_table(values[1].value):
        return edge_values(call, values[1], meshes, mesh), edge_values(call, values[2], meshes, mesh, 90.0)
    if len(values) not in _SIDES:
        raise call.error("envelope expects a height, then a base height and an angle for one to four sides")
    bases, angles = np.zeros(len(mesh)), np.full(len(mesh), 90.0)
    for number, side in enumerate(_SIDES[len(values)]):
        chosen = edges_towards(call, [f"street.{name}" for name in _SELECTORS.get(side, (side,))], meshes)
        bases[chosen] = call.column(values[1 + 2 * number])[mesh[chosen]]
        angles[chosen] = call.column(values[2 + 2 * number])[mesh[chosen]]
    return bases, angles


def _envelopes(meshes: Meshes, along: Floats, heights: Floats, bases: Floats, angles: Floats) -> Meshes:
    """[M] envelopes over the faces of meshes; a face that has none stays as it is."""
    from grammarlab.geometry.components import extract_faces  # noqa: PLC0415
    from grammarlab.geometry.meshes.envelopes import envelope as over_face  # noqa: PLC0415  # few grammars need it

    faces = extract_faces(meshes, np.arange(meshes.num_faces), np.ones(meshes.num_faces, dtype=np.int64))
    owner, offsets = meshes.mesh_of_face(), meshes.face_offsets
    parts = []
    for number in range(meshes.num_faces):
        face, row = faces.take(np.array([number])), owner[number]
        corners = slice(offsets[number], offsets[number + 1])
        solid = None
        if heights[row] > 0.0:
            solid = over_face(face, along[row], float(heights[row]), bases[corners], angles[corners])
        parts.append(face if solid is None else solid)
    return _grouped(parts, np.bincount(owner, minlength=len(meshes)))


def _grouped(parts: list[Meshes], counts: Rows) -> Meshes:
    """Meshes of consecutive parts."""
    groups, start = [], 0
    for count in counts.tolist():
        group, start = parts[start : start + count], start + count
        groups.append(Meshes.united(group))
    return Meshes.concatenate(groups)


OPERATIONS: dict[str, Operation] = {"envelope": Operation(envelope, frozenset({"normal", "world.up"}), (4, 10))}
