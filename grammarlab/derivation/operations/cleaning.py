"""``cleanupGeometry``: surfaces with fewer points and faces."""

from __future__ import annotations

from typing import cast

import numpy as np

from grammarlab.derivation.calls.calls import BoundCall, Operation
from grammarlab.derivation.state.mesh_table import scaled
from grammarlab.derivation.state.shapes import EMPTY, FACE, FOOTPRINT, Shapes
from grammarlab.geometry.meshes.cleanup import Components, cleaned
from grammarlab.geometry.meshes.mesh import Meshes

_COMPONENTS = frozenset({"all", "edges", "faces", "vertices"})


def cleanup_geometry(call: BoundCall) -> Shapes:
    """``cleanupGeometry(all|edges|faces|vertices, tolerance)``: near points merged, needless components removed."""
    if len(call.values) != 1 or len(call.words) != 1:
        raise call.error("cleanupGeometry expects all, edges, faces or vertices, and a tolerance between 0 and 1")
    shapes, table = call.shapes, call.workspace.meshes
    tolerances = np.clip(call.column(call.values[0]), 0.0, 1.0)
    kind = cast("Components", call.words[0])
    rows = np.flatnonzero(~np.isin(shapes.mesh, (EMPTY, FACE, FOOTPRINT)))
    if len(rows) == 0:
        return shapes
    keys = np.column_stack((shapes.mesh[rows], tolerances[rows], shapes.size[rows]))
    _, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    chosen = rows[first]
    unit, size = table.take(shapes.mesh[chosen]), shapes.size[chosen]
    meshes = scaled(unit, size)
    results = [
        cleaned(meshes.take(np.array([number])), kind, float(tolerances[row])) for number, row in enumerate(chosen)
    ]
    is_new = [result.num_faces != faces for result, faces in zip(results, np.diff(unit.mesh_faces), strict=True)]
    corners = np.diff(unit.face_offsets[unit.mesh_faces])
    is_new = np.array(is_new) | (np.array([len(result.corners) for result in results]) != corners)
    ids = shapes.mesh[chosen].copy()
    changed = np.flatnonzero(is_new)
    if len(changed):
        inverse_size = np.divide(1.0, size[changed], out=np.zeros_like(size[changed]), where=size[changed] > 0.0)
        ids[changed] = table.add(scaled(Meshes.concatenate([results[number] for number in changed]), inverse_size))
    mesh = shapes.mesh.copy()
    mesh[rows] = ids[inverse.ravel()]
    return shapes._replace(mesh=mesh)


OPERATIONS: dict[str, Operation] = {"cleanupGeometry": Operation(cleanup_geometry, _COMPONENTS, (2, 2))}
