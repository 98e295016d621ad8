"""Normals that pictures and files shade a surface with: ``setNormals`` and ``softenNormals``."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from grammarlab.derivation.calls.calls import BoundCall, Operation
from grammarlab.derivation.operations.cleaning import reworked
from grammarlab.derivation.state.shapes import Shapes
from grammarlab.geometry.meshes.corner_data import CornerData
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.normals import corner_normals, turned_faces

_ANGLES = {"hard": 0.0, "conform": 0.0, "auto": 30.0, "soft": 180.0}
"""Degrees at which faces meet at a hard edge."""


def set_normals(call: BoundCall) -> Shapes:
    """``setNormals(hard|conform|soft|auto)``: ``conform`` also turns faces so that neighbours look to the same side."""
    if len(call.words) != 1:
        raise call.error("setNormals expects hard, conform, soft or auto")
    angles = np.full(call.shapes.num, _ANGLES[call.words[0]])

    def shaded(mesh: Meshes, angle: float) -> Meshes:
        return with_normals(mesh.reversed(turned_faces(mesh)) if "conform" in call.words else mesh, angle)

    return reworked(call, angles, shaded)


def soften_normals(call: BoundCall) -> Shapes:
    """``softenNormals(angle)``: edges at which faces meet at an angle in degrees or more are hard."""
    return reworked(call, np.clip(call.column(call.values[0]), 0.0, 180.0), with_normals)


def with_normals(mesh: Meshes, angle: float) -> Meshes:
    """A mesh in metres whose corners have the mean normal of the faces that meet at less than an angle in degrees."""
    normals = corner_normals(mesh, angle)
    data = CornerData(normals, np.zeros(mesh.num_faces, np.int32)) if mesh.data is None else mesh.data
    return replace(mesh, data=data.with_normals(normals))


OPERATIONS: dict[str, Operation] = {
    "setNormals": Operation(set_normals, frozenset(_ANGLES), (1, 1)),
    "softenNormals": Operation(soften_normals, num_arguments=(1, 1)),
}
