"""Other geometry in the same scope: cleaned, reduced, of convex faces, without holes, or its footprint."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.derivation.calls.calls import BoundCall, Operation
from grammarlab.derivation.state.mesh_table import replaced, scaled
from grammarlab.derivation.state.shapes import EMPTY, FACE, FOOTPRINT, Shapes
from grammarlab.geometry.meshes.cleanup import Components, cleaned
from grammarlab.geometry.meshes.convex import MOST_CORNERS, convexified
from grammarlab.geometry.meshes.measure import has_concave_face
from grammarlab.geometry.meshes.mesh import Meshes

_COMPONENTS = frozenset({"all", "edges", "faces", "vertices"})


def cleanup_geometry(call: BoundCall) -> Shapes:
    """``cleanupGeometry(all|edges|faces|vertices, tolerance)``: near points merged, needless components removed."""
    if len(call.values) != 1 or len(call.words) != 1:
        raise call.error("cleanupGeometry expects all, edges, faces or vertices, and a tolerance between 0 and 1")
    kind = cast("Components", call.words[0])
    tolerances = np.clip(call.column(call.values[0]), 0.0, 1.0)
    return reworked(call, tolerances, lambda mesh, tolerance: _if_other(mesh, cleaned(mesh, kind, tolerance)))


def reduce_geometry(call: BoundCall) -> Shapes:
    """``reduceGeometry(share)``: this share of the points is gone, those first that the surface needs least."""
    from grammarlab.geometry.meshes.reduction import MOST_TRIANGLES, reduced  # noqa: PLC0415  # few rules reduce

    def smaller(mesh: Meshes, share: float) -> Meshes | None:
        if len(mesh.corners) - 2 * mesh.num_faces > MOST_TRIANGLES:
            call.warn(f"reduceGeometry reduces at most {MOST_TRIANGLES:,} triangles; larger meshes stay as they are")
            return None
        result = reduced(mesh, share)
        return None if result is mesh else result

    return reworked(call, np.clip(call.column(call.values[0]), 0.0, 1.0), smaller)


def convexify(call: BoundCall) -> Shapes:
    """``convexify(length)``: concave faces divided by cuts of at most a length in metres, of any without it."""
    longest = call.column(call.values[0]) if call.values else np.full(call.shapes.num, np.inf)

    def divided(mesh: Meshes, length: float) -> Meshes | None:
        if np.diff(mesh.face_offsets).max(initial=0) > MOST_CORNERS:
            call.warn(f"convexify divides faces of at most {MOST_CORNERS} corners; larger ones stay as they are")
        return _if_other(mesh, convexified(mesh, length)) if has_concave_face(mesh)[0] else None

    return reworked(call, longest, divided)


def delete_holes(call: BoundCall) -> Shapes:
    """``deleteHoles()``: every face without its holes."""
    from grammarlab.geometry.meshes.shadows import without_holes  # noqa: PLC0415  # few grammars need shapely

    return reworked(call, np.zeros(call.shapes.num), lambda mesh, _: _if_other(mesh, without_holes(mesh)))


def footprint(call: BoundCall) -> Shapes:
    """``footprint()``: the area that the geometry covers on the plane y = 0 of the scope; a wall stays as it is."""
    from grammarlab.geometry.meshes.shadows import shadow  # noqa: PLC0415

    shapes, table = call.shapes, call.workspace.meshes
    keys = np.column_stack((shapes.mesh, shapes.size))
    _, first, number = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    meshes = scaled(table.take(shapes.mesh[first]), shapes.size[first])
    each = [meshes.take(np.array([row])) for row in range(len(first))]
    areas = [area if area.num_faces else mesh for mesh, area in zip(each, map(shadow, each), strict=True)]
    return replaced(shapes, Meshes.concatenate(areas), number.ravel(), table, call.workspace.frames)


def reworked(call: BoundCall, parameter: Floats, change: Callable[[Meshes, float], Meshes | None]) -> Shapes:
    """Shapes with other surfaces in the same scopes; single rectangles stay as they are.

    Args:
        call: the operation, on shapes [N].
        parameter: [N] a number for each shape.
        change: makes a mesh in metres, of some faces, from one and the number; None if it stays as it is.
    """
    shapes, table = call.shapes, call.workspace.meshes
    rows = np.flatnonzero(~np.isin(shapes.mesh, (EMPTY, FACE, FOOTPRINT)))
    if len(rows) == 0:
        return shapes
    keys = np.column_stack((shapes.mesh[rows], parameter[rows], shapes.size[rows]))
    _, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    chosen = rows[first]
    size, ids = shapes.size[chosen], shapes.mesh[chosen].copy()
    meshes = scaled(table.take(ids), size)
    results: dict[int, Meshes] = {}
    for number, row in enumerate(chosen.tolist()):
        result = change(meshes.take(np.array([number])), float(parameter[row]))
        if result is not None:
            results[number] = result
    if results:
        changed = np.array(list(results))
        inverse_size = np.divide(1.0, size[changed], out=np.zeros_like(size[changed]), where=size[changed] != 0.0)
        ids[changed] = table.add(scaled(Meshes.concatenate(list(results.values())), inverse_size))
    mesh = shapes.mesh.copy()
    mesh[rows] = ids[inverse.ravel()]
    return shapes._replace(mesh=mesh)


def _if_other(mesh: Meshes, result: Meshes) -> Meshes | None:
    return None if _counts(result) == _counts(mesh) else result


def _counts(mesh: Meshes) -> tuple[int, int, int]:
    return mesh.num_faces, len(mesh.corners), len(mesh.points)


OPERATIONS: dict[str, Operation] = {
    "cleanupGeometry": Operation(cleanup_geometry, _COMPONENTS, (2, 2)),
    "convexify": Operation(convexify, num_arguments=(0, 1)),
    "deleteHoles": Operation(delete_holes),
    "footprint": Operation(footprint),
    "reduceGeometry": Operation(reduce_geometry, num_arguments=(1, 1)),
}
