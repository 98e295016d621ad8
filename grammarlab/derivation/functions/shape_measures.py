"""Functions that measure a shape's geometry: areas, volume, numbers of faces, angles.

Boxes and rectangles are measured by their scopes; other geometry by `grammarlab.geometry.meshes.measure`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints, distinct_rows
from grammarlab.derivation.calls.calls import Builtin, FunctionCall
from grammarlab.derivation.functions.street_sides import by_streets, face_sides
from grammarlab.derivation.state.box_orders import is_box, kinds
from grammarlab.derivation.state.mesh_table import scaled
from grammarlab.derivation.state.shapes import BOX, EMPTY, FACE, FOOTPRINT, Shapes, Value
from grammarlab.derivation.state.workspace import Workspace
from grammarlab.errors import DerivationError
from grammarlab.geometry.meshes import measure
from grammarlab.geometry.meshes.edges import boundary_lengths, is_closed_surface, num_edges, num_holes
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.ragged import any_rows, sum_rows
from grammarlab.geometry.selectors import ORIENTATIONS, STEEP, classify

Measure = Callable[[Meshes], NDArray]

_ANGLES = ("maxSlope", "zenith", "azimuth")


def local_meshes(shapes: Shapes, workspace: Workspace) -> Meshes:
    """The geometry of shapes [N] in metres along their scopes' axes, from their scopes' origins."""
    return scaled(workspace.meshes.take(shapes.mesh), shapes.size)


class AlikeMeshes(NamedTuple):
    """The different geometries of N shapes: all that depends on them alone is measured once for each."""

    meshes: Meshes
    """[K] in metres along the scopes' axes."""
    first: Ints
    """[K] the first shape of each, ascending."""
    number: Ints
    """[N] the geometry of each shape."""


def alike_meshes(shapes: Shapes, workspace: Workspace, *columns: NDArray) -> AlikeMeshes:
    """The different geometries of shapes [N]; shapes that differ in other columns [N, ...] count as different."""
    first, number = distinct_rows(shapes.mesh, shapes.size, *columns)
    meshes = scaled(workspace.meshes.take(shapes.mesh[first]), shapes.size.take(first, axis=0))
    return AlikeMeshes(meshes, first, number)


def oriented(
    selector: str, normals: Floats, owner: NDArray[np.integer], shapes: Shapes, workspace: Workspace
) -> NDArray[np.bool_]:
    """[K] whether normals point in the direction of a selector, in the axes that its prefix names.

    Args:
        selector: a selector such as ``top``, ``world.south`` or ``object.front``.
        normals: [K, 3] unit normals in scope axes.
        owner: [K] the shape that each one belongs to.
        shapes: [N].
        workspace: workspace of the derivation.
    """
    system = selector.partition(".")[0]
    if system in ("world", "object", "street"):
        normals = workspace.frames.to_world(shapes.frame[owner], normals)
    if system in ("object", "street"):
        normals = workspace.frames.to_local(workspace.roots.frame[shapes.model[owner]], normals)
    return classify(normals, selector)


def _measured(apply: Measure, shapes: Shapes, workspace: Workspace) -> NDArray:
    meshes, _, number = alike_meshes(shapes, workspace)
    return apply(meshes)[number]


def _by_scope(simple: Callable[[Shapes], Floats], general: Measure) -> Builtin:
    """A measure with a formula for boxes and rectangles."""

    def evaluate(call: FunctionCall) -> Value:
        shapes = call.shapes
        other = np.flatnonzero(shapes.mesh > FACE)
        if len(other) == shapes.num:
            return _measured(general, shapes, call.workspace).astype(np.float64)
        result = simple(shapes)
        if len(other):
            result[other] = _measured(general, shapes.take(other), call.workspace)
        return result

    return Builtin(evaluate, (0, 0))


def _by_kind(box: float, rectangle: float, general: Measure) -> Builtin:
    """A measure that is one constant for boxes and another one for rectangles."""
    table = np.array([0.0, box, rectangle, rectangle])
    return _by_scope(lambda shapes: table[np.minimum(kinds(shapes.mesh), FACE)], general)


def _area(shapes: Shapes) -> Floats:
    x, y, z = shapes.size.T
    kind = kinds(shapes.mesh)
    return np.select(
        [kind == BOX, kind == FOOTPRINT, kind == FACE], [2.0 * (x * y + y * z + z * x), x * z, x * y], default=0.0
    )


def _boundary(shapes: Shapes) -> Floats:
    x, y, z = shapes.size.T
    return np.select([shapes.mesh == FOOTPRINT, shapes.mesh == FACE], [2.0 * (x + z), 2.0 * (x + y)], default=0.0)


def _volume(shapes: Shapes) -> Floats:
    return np.where(is_box(shapes.mesh), shapes.size.prod(axis=1), 0.0)


def _heights(call: FunctionCall) -> tuple[Meshes, Floats]:
    """The geometry of shapes [N] in scope axes, and the height [P] of each of its points in the world."""
    meshes = local_meshes(call.shapes, call.workspace)
    rotations = call.workspace.frames.rotations(call.shapes.frame)
    return meshes, np.einsum("pj,pj->p", rotations[meshes.mesh_of_point(), 1, :], meshes.points)


def _extent(meshes: Meshes, heights: Floats) -> tuple[Floats, Floats]:
    """[N] the smallest and the largest of the heights [P] of the points of meshes."""
    low, high = meshes.with_points(np.repeat(heights[:, None], 3, axis=1)).bounds()
    return low[:, 0], high[:, 0]


def _height(call: FunctionCall) -> Value:
    """World height of the geometry above its lowest point."""
    low, high = _extent(*_heights(call))
    return high - low


def _lower_height(call: FunctionCall) -> Value:
    """World height of the lowest corner of the faces that look up; of all of the geometry without such a face."""
    meshes, heights = _heights(call)
    low, high = _extent(meshes, heights)
    frames = call.shapes.frame[meshes.mesh_of_face()]
    looks_up = call.workspace.frames.to_world(frames, measure.face_normals(meshes))[:, 1] > STEEP
    corners = looks_up[meshes.face_of_corner()]
    lowest = high.copy()
    np.minimum.at(lowest, meshes.mesh_of_corner()[corners], heights[meshes.corner_points()[corners]])
    return lowest - low


def _tolerance(call: FunctionCall) -> float:
    tolerance = call.arguments[0] if call.arguments else 0.0
    if isinstance(tolerance, np.ndarray | str):
        raise DerivationError(f"{call.name} expects one number of degrees for all shapes", call.location)
    return float(tolerance)


def _within_degrees(general: Callable[[Meshes, float], NDArray[np.bool_]], least: int) -> Builtin:
    """A test that boxes and rectangles pass; for other geometry it has a tolerance in degrees, by default 0."""

    def evaluate(call: FunctionCall) -> Value:
        tolerance, shapes = _tolerance(call), call.shapes
        result = shapes.mesh != EMPTY
        other = np.flatnonzero(shapes.mesh > FACE)
        if len(other):
            meshes, _, number = alike_meshes(shapes.take(other), call.workspace)
            result[other] = general(meshes, tolerance)[number]
        return result

    return Builtin(evaluate, (least, 1))


def _flag(box: bool, rectangle: bool, general: Measure) -> Builtin:
    inner = _by_kind(float(box), float(rectangle), general)
    return Builtin(lambda call: np.asarray(inner.evaluate(call)) > 0.5, (0, 0))


def _oriented_faces(call: FunctionCall, meshes: Meshes) -> NDArray[np.bool_]:
    """[F] whether faces point in the direction of the selector in the first argument."""
    normals, owner = measure.face_normals(meshes), meshes.mesh_of_face()
    selector, shapes, workspace = str(call.arguments[0]), call.shapes, call.workspace
    flags = oriented(selector, normals, owner, shapes, workspace)
    return by_streets(selector, lambda: face_sides(meshes, shapes, workspace), flags, owner, shapes, workspace)


def _area_of(call: FunctionCall) -> Value:
    if not call.arguments or call.arguments[0] in ("all", "surface"):
        return _WHOLE_AREA.evaluate(call)
    _require_selector(call)
    meshes = local_meshes(call.shapes, call.workspace)
    return sum_rows(measure.face_areas(meshes) * _oriented_faces(call, meshes), meshes.mesh_faces)


def _is_oriented(call: FunctionCall) -> Value:
    _require_selector(call)
    meshes = local_meshes(call.shapes, call.workspace)
    return any_rows(_oriented_faces(call, meshes), meshes.mesh_faces)


def _require_selector(call: FunctionCall) -> None:
    if call.arguments[0] not in ORIENTATIONS:
        raise DerivationError(f"{call.name} expects a selector such as top or world.south", call.location)


def _angle(call: FunctionCall) -> Value:
    kind = call.arguments[0]
    if kind not in _ANGLES:
        raise DerivationError("geometry.angle expects maxSlope, zenith or azimuth", call.location)
    meshes = local_meshes(call.shapes, call.workspace)
    rotations = call.workspace.frames.rotations(call.shapes.frame)
    turned = np.einsum("pij,pj->pi", rotations[meshes.mesh_of_point()], meshes.points)
    slope, azimuth = measure.steepest_slope(meshes.with_points(turned))
    return {"maxSlope": slope, "zenith": 90.0 - slope, "azimuth": azimuth}[str(kind)]


_WHOLE_AREA = _by_scope(_area, measure.areas)

BUILTINS: dict[str, Builtin] = {
    "geometry.angle": Builtin(_angle, (1, 1), keywords=frozenset(_ANGLES)),
    "geometry.area": Builtin(_area_of, (0, 1), keywords=frozenset({"all", "surface", *ORIENTATIONS})),
    "geometry.boundaryLength": _by_scope(_boundary, boundary_lengths),
    "geometry.height": Builtin(_height, (0, 0)),
    "geometry.isClosedSurface": _flag(True, False, is_closed_surface),
    "geometry.isConcave": _flag(False, False, measure.has_concave_face),
    "geometry.isOriented": Builtin(_is_oriented, (1, 1), keywords=frozenset(ORIENTATIONS)),
    "geometry.isPlanar": _within_degrees(measure.is_planar, 1),
    "geometry.isRectangular": _within_degrees(measure.is_rectangular, 0),
    "geometry.lowerheight": Builtin(_lower_height, (0, 0)),
    "geometry.nEdges": _by_kind(12.0, 4.0, num_edges),
    "geometry.nFaces": _by_kind(6.0, 1.0, measure.num_faces),
    "geometry.nHoles": _by_kind(0.0, 0.0, num_holes),
    "geometry.nVertices": _by_kind(8.0, 4.0, measure.num_vertices),
    "geometry.volume": _by_scope(_volume, measure.volumes),
}
