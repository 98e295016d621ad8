"""Measures of the texture coordinates of a shape: ``geometry.du``, ``geometry.uMin`` and similar functions."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.derivation.calls.calls import Builtin, FunctionCall
from grammarlab.derivation.functions.shape_measures import alike_meshes
from grammarlab.derivation.state.corner_maps import coordinates_of, own_maps
from grammarlab.derivation.state.shapes import Ids, Shapes, Value, kind_of
from grammarlab.derivation.state.texture_maps import DELETED, NUM_SETS, WORLD, with_maps
from grammarlab.derivation.state.workspace import Workspace
from grammarlab.errors import DerivationError, Location
from grammarlab.geometry.meshes.measure import corner_edges, face_areas, face_normals
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.ragged import max_rows, next_in_row, sum_rows
from grammarlab.geometry.meshes.vectors import cross, dot, norm

SPACES = frozenset({"uvSpace", "unitSpace"})
UV_AXES = ("u", "v")

_LEVEL = 1e-9
"""Smallest change of a coordinate along a face, as a share of its change in space, that counts as a change."""


class Range(NamedTuple):
    """One coordinate on N shapes, all zeros for shapes without coordinates."""

    gradient: Floats
    """[N, 3] its change per metre along the axes of the scope."""
    start: Floats
    """[N] its value at the origin of the scope."""
    low: Floats
    """[N] its smallest value."""
    high: Floats
    """[N] its largest value."""
    metres: Floats
    """[N] length of one unit on the surface in metres, a mean over the area of the faces along which it changes; 0
    if it does not change."""

    @property
    def extent(self) -> Floats:
        """[N] from the smallest value to the largest."""
        return self.high - self.low


def range_of(shapes: Shapes, uv_set: int, axis: int, workspace: Workspace) -> Range:
    """Coordinate u (axis 0) or v (axis 1) of one uv set on shapes [N]."""
    ids = own_maps(shapes, uv_set, workspace)
    rows = np.flatnonzero(ids >= 0)
    if workspace.has_corner_maps and (workspace.texture_maps.source(ids[rows]) != WORLD).any():
        return _range_with_corners(shapes, ids, uv_set, axis, workspace)
    gradient, start = np.zeros((shapes.num, 3)), np.zeros(shapes.num)
    if len(rows):
        map_rows = workspace.texture_maps.take(ids[rows])[:, axis]
        gradient[rows] = workspace.frames.to_local(shapes.frame[rows], map_rows[:, :3])
        start[rows] = map_rows[:, 3] + dot(map_rows[:, :3], shapes.position[rows])
    meshes, first, number = alike_meshes(shapes, workspace, gradient)
    slopes = gradient[first]
    values = dot(meshes.points, slopes[meshes.mesh_of_point()])
    filled = (np.diff(meshes.mesh_points) > 0)[number]
    # The sums are rounded as the values are ordered: so the smallest value has the smallest sum.
    low = np.where(filled, start - max_rows(-values, meshes.mesh_points, -np.inf)[number], 0.0)
    high = np.where(filled, start + max_rows(values, meshes.mesh_points, -np.inf)[number], 0.0)
    return Range(gradient, start, low, high, _metres(meshes, slopes)[number])


def _range_with_corners(shapes: Shapes, ids: Ids, uv_set: int, axis: int, workspace: Workspace) -> Range:
    """Coordinate u or v on shapes [N] of which some have the coordinates of the corners of their meshes.

    The gradient is a mean over the faces: exact where the coordinate changes evenly along the whole shape.

    Args:
        shapes: the shapes.
        ids: [N] their maps.
        uv_set: the set.
        axis: 0 for u, 1 for v.
        workspace: workspace of the derivation.
    """
    source = np.full(shapes.num, WORLD, dtype=np.int8)
    source[ids >= 0] = workspace.texture_maps.source(ids[ids >= 0])
    own, others = np.flatnonzero(source != WORLD), np.flatnonzero(source == WORLD)
    columns = [np.zeros((shapes.num, 3)), *(np.zeros(shapes.num) for _ in range(4))]
    if len(others):
        without = with_maps(shapes.take(others), uv_set, np.where(ids[others] >= 0, ids[others], DELETED))
        for column, values in zip(columns, range_of(without, uv_set, axis, workspace), strict=True):
            column[others] = values
    rows = workspace.texture_maps.take(ids[own])[:, axis]
    meshes, first, number = alike_meshes(shapes.take(own), workspace, rows, source[own])
    for column, values in zip(columns, corner_range(meshes, rows[first], source[own][first]), strict=True):
        column[own] = values[number]
    return Range(*columns)


def corner_range(meshes: Meshes, rows: Floats, source: NDArray[np.int8]) -> Range:
    """A function of the coordinates of the corners of meshes [M].

    Args:
        meshes: the meshes, in metres.
        rows: [M, 4] the function ``row @ (u, v, 0, 1)``.
        source: [M] uv set that it is a function of, or `FACES`.
    """
    mesh, count = meshes.mesh_of_corner(), len(meshes)
    u, v = coordinates_of(meshes, source).T
    values = np.nan_to_num(rows[mesh, 0] * u + rows[mesh, 1] * v + rows[mesh, 3])
    normals, area = face_normals(meshes), face_areas(meshes)
    # The mean gradient over a face is the sum over its edges of value, length and direction out of the face.
    out = cross(corner_edges(meshes), normals.take(meshes.face_of_corner(), axis=0))
    middle = 0.5 * (values + values[next_in_row(meshes.face_offsets)])
    face_sums = np.stack([sum_rows(middle * out[:, k], meshes.face_offsets) for k in range(3)], axis=1)
    steepness = norm(face_sums) / np.where(area > 0.0, area, 1.0)
    offsets = meshes.face_offsets[meshes.mesh_faces]
    sums = np.stack([sum_rows(face_sums[:, k], meshes.mesh_faces) for k in range(3)], axis=1)
    whole = sum_rows(area, meshes.mesh_faces)
    gradient = sums / np.where(whole > 0.0, whole, 1.0)[:, None]
    filled = np.diff(offsets) > 0
    low = np.where(filled, -max_rows(-values, offsets, -np.inf), 0.0)
    high = np.where(filled, max_rows(values, offsets, -np.inf), 0.0)
    start = np.zeros(count)
    first = offsets[:-1][filled]
    start[filled] = values[first] - dot(gradient[filled], meshes.points[meshes.corner_points()[first]])
    climb = sum_rows(area * steepness, meshes.mesh_faces)
    changing = sum_rows(np.where(steepness > 0.0, area, 0.0), meshes.mesh_faces)
    return Range(gradient, start, low, high, np.where(climb > 0.0, changing / np.where(climb > 0.0, climb, 1.0), 0.0))


def _metres(meshes: Meshes, gradient: Floats) -> Floats:
    """[M] metres on the surface of meshes for one unit of a coordinate with these gradients [M, 3]."""
    along, normals = gradient[meshes.mesh_of_face()], face_normals(meshes)
    steepness = np.sqrt(np.maximum(dot(along, along) - dot(along, normals) ** 2, 0.0))
    changes = steepness > _LEVEL * np.sqrt(dot(along, along))
    area = np.where(changes, face_areas(meshes), 0.0)
    climb = sum_rows(area * steepness, meshes.mesh_faces)
    return np.where(climb > 0.0, sum_rows(area, meshes.mesh_faces) / np.where(climb > 0.0, climb, 1.0), 0.0)


def uv_set_of(value: Value, name: str, location: Location) -> int:
    """Uv set from an argument.

    Raises:
        DerivationError: If it is not a whole number from 0 to 9, or differs between shapes.
    """
    if kind_of(value) != "float":
        raise DerivationError(f"{name} expects a uv set from 0 to {NUM_SETS - 1}, found a {kind_of(value)}", location)
    different = np.unique(np.asarray(value, dtype=np.float64))
    if len(different) > 1:
        raise DerivationError(f"{name} expects one uv set for all shapes of a rule, found several", location)
    number = float(different[0])
    if number not in range(NUM_SETS):
        raise DerivationError(
            f"{name} expects a uv set from 0 to {NUM_SETS - 1}, found {number:g}",
            location,
            "set 0 is that of the colour map",
        )
    return int(number)


def _uv_set(call: FunctionCall) -> int:
    return uv_set_of(call.arguments[0], call.name, call.location) if call.arguments else 0


def _extent(axis: int) -> Builtin:
    """``geometry.du(set, uvSpace|unitSpace)``: the extent of u, in its own unit or in metres on the surface."""

    def evaluate(call: FunctionCall) -> Value:
        if call.arguments[1] not in SPACES:
            raise DerivationError(f"{call.name} expects uvSpace or unitSpace", call.location)
        coordinate = range_of(call.shapes, _uv_set(call), axis, call.workspace)
        return coordinate.extent * coordinate.metres if call.arguments[1] == "unitSpace" else coordinate.extent

    return Builtin(evaluate, (2, 2), keywords=SPACES)


def _bound(axis: int, is_low: bool) -> Builtin:
    """``geometry.uMin(set)``: the smallest u, by default in set 0."""

    def evaluate(call: FunctionCall) -> Value:
        coordinate = range_of(call.shapes, _uv_set(call), axis, call.workspace)
        return coordinate.low if is_low else coordinate.high

    return Builtin(evaluate, (0, 1))


def _has_coordinates(call: FunctionCall) -> Value:
    return own_maps(call.shapes, _uv_set(call), call.workspace) >= 0


BUILTINS: dict[str, Builtin] = {
    "geometry.hasUVs": Builtin(_has_coordinates, (0, 1)),
    **{f"geometry.d{name}": _extent(axis) for axis, name in enumerate(UV_AXES)},
    **{f"geometry.{name}Min": _bound(axis, is_low=True) for axis, name in enumerate(UV_AXES)},
    **{f"geometry.{name}Max": _bound(axis, is_low=False) for axis, name in enumerate(UV_AXES)},
}
