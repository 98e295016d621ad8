"""Roofs over the faces of a shape: ``roofHip``, ``roofGable``, ``roofPyramid``, ``roofShed``, ``roofRidge``, ``taper``.

The value is an angle in degrees, or after ``byHeight`` a height in metres. The scope then has the orientation of the
first face, as after ``extrude``. The geometry is imported by the first roof, since few grammars have any.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.calls.calls import Argument, BoundCall, Operation, OperationFunction
from grammarlab.derivation.functions.shape_measures import alike_meshes
from grammarlab.derivation.operations.alignment import where
from grammarlab.derivation.operations.extrusion import first_normals, stood_up
from grammarlab.derivation.state.face_tags import inherited, with_automatic_tags
from grammarlab.derivation.state.mesh_table import turned_over
from grammarlab.derivation.state.shapes import Shapes
from grammarlab.geometry.meshes.measure import face_normals
from grammarlab.geometry.meshes.mesh import Meshes

_WORDS = frozenset({"byAngle", "byHeight"})
_LEVEL = 1e-9
"""Largest height of the unit normal of a wall: a tolerance."""

Roof: TypeAlias = "Callable[[BoundCall, Meshes], Meshes]"
"""The roofs of an operation on shapes [N] over their geometry [N]."""


def roof_hip(call: BoundCall, faces: Meshes) -> Meshes:
    """``roofHip([byAngle|byHeight,] value, overhang, even)``."""
    from grammarlab.geometry.outlines import roofs  # noqa: PLC0415

    value, *rest = call.values
    overhang = call.column(rest[0]) if rest else 0.0
    even = _flag(call, rest[1]) if len(rest) > 1 else False
    return roofs.roof_hip(faces, call.column(value), _by(call), overhang, even)


def roof_gable(call: BoundCall, faces: Meshes) -> Meshes:
    """``roofGable([byAngle|byHeight,] value, overhangX, overhangY, even, index)``."""
    from grammarlab.geometry.outlines import roofs  # noqa: PLC0415

    value, *rest = call.values
    overhangs = [call.column(argument) for argument in rest[:2]]
    # One overhang is that of eaves and gables.
    overhangs = overhangs * 2 if len(overhangs) == 1 else overhangs or [0.0, 0.0]
    even = _flag(call, rest[2]) if len(rest) > 2 else False
    index = _index(call, rest[3]) if len(rest) > 3 else None
    return roofs.roof_gable(faces, call.column(value), _by(call), *overhangs, even=even, index=index)


def roof_pyramid(call: BoundCall, faces: Meshes) -> Meshes:
    """``roofPyramid([byAngle|byHeight,] value)``."""
    from grammarlab.geometry.outlines import roofs  # noqa: PLC0415

    return roofs.roof_pyramid(faces, call.column(call.values[0]), _by(call))


def roof_shed(call: BoundCall, faces: Meshes) -> Meshes:
    """``roofShed([byAngle|byHeight,] value, index)``."""
    from grammarlab.geometry.outlines import roofs  # noqa: PLC0415

    value, *rest = call.values
    index = _index(call, rest[0]) if rest else 0
    return roofs.roof_shed(faces, call.column(value), _by(call), index)


def roof_ridge(call: BoundCall, faces: Meshes) -> Meshes:
    """``roofRidge([byAngle|byHeight,] value)``."""
    from grammarlab.geometry.outlines import roofs  # noqa: PLC0415

    return roofs.roof_ridge(faces, call.column(call.values[0]), _by(call))


def _pyramid(call: BoundCall, faces: Meshes) -> Meshes:
    from grammarlab.geometry.outlines import roofs  # noqa: PLC0415

    heights = call.column(call.values[0])
    # Over a face seen from behind, the pyramid points the opposite way.
    return roofs.taper(faces.reversed(heights[faces.mesh_of_face()] < 0.0), np.abs(heights))


def taper(call: BoundCall) -> Shapes:
    """``taper(height)``: a pyramid over the first face, its tip over the mean of the face's corners.

    A negative height makes ``scope.sy`` negative and the pyramid point the opposite way; all faces point outwards.
    """
    standing = with_roof_tags(call, _standing(call, _pyramid), "taper", "side")
    below, workspace = call.column(call.values[0]) < 0.0, call.workspace
    return turned_over(standing, below, workspace.meshes, workspace.frames) if below.any() else standing


def _standing(call: BoundCall, roof: Roof) -> Shapes:
    """Shapes with roofs over their faces, one for all shapes that are alike."""
    columns = [argument.value for argument in call.arguments if isinstance(argument.value, np.ndarray)]
    faces, first, number = alike_meshes(call.shapes, call.workspace, *columns)
    return stood_up(call, roof(call.rows(first), faces), first_normals(faces), number)


def _roofed(roof: Roof) -> OperationFunction:
    """The operation that makes roofs over the faces of shapes."""

    def apply(call: BoundCall) -> Shapes:
        walls = "side.outer" if call.name in ("roofRidge", "roofShed") else "side"
        roofs = _standing(call, lambda part, faces: _in_sheets(roof(part, faces)))
        return with_roof_tags(call, roofs, "roof", "top", walls)

    return apply


def _by(call: BoundCall) -> Literal["angle", "height"]:
    return "height" if "byHeight" in call.words else "angle"


def _by_flag(apply: OperationFunction, position: int) -> OperationFunction:
    """An operation whose value number ``position`` is a truth value, carried out for each of its values."""

    def carried_out(call: BoundCall) -> Shapes:
        argument = call.values[position] if len(call.values) > position else None
        if argument is None or not isinstance(argument.value, np.ndarray) or argument.value.dtype.kind != "b":
            return apply(call)
        flags = argument.value
        if (flags == flags[0]).all():
            same = argument._replace(value=bool(flags[0]))
            return apply(call._replace(arguments=tuple([same if a is argument else a for a in call.arguments])))
        for flag in (False, True):
            call = call._replace(shapes=where(call, flags == flag, carried_out))  # ty: ignore[invalid-argument-type]
        return call.shapes

    return carried_out


def _flag(call: BoundCall, argument: Argument) -> bool:
    if isinstance(argument.value, bool):
        return argument.value
    raise call.error(f"{call.name} expects true or false for even, the same for all shapes")


def _index(call: BoundCall, argument: Argument) -> NDArray[np.int64]:
    return np.rint(call.column(argument)).astype(np.int64)


def with_roof_tags(call: BoundCall, roofs: Shapes, base: str, slope: str, wall: str = "") -> Shapes:
    """Roofs that keep the tags of what they stand on, with tags for their undersides, slopes and walls.

    Args:
        call: the operation.
        roofs: its results, in scopes that stand on them.
        base: first subtag of all.
        slope: tag of faces that look up.
        wall: tag of faces that look sideways, as those of gables; that of slopes by default.
    """
    kept = inherited(roofs, call.shapes, np.arange(roofs.num), call.workspace)
    names = {-1: "bottom", 0: wall or slope, 1: slope}
    return with_automatic_tags(kept, call.workspace, base, _slopes, names)


def _slopes(meshes: Meshes) -> NDArray[np.int64]:
    """[F] the direction of each face: 1 up, 0 sideways, -1 down."""
    height = face_normals(meshes)[:, 1]
    return np.where(np.abs(height) < _LEVEL, 0, np.sign(height)).astype(np.int64)


def _in_sheets(roofs: Meshes) -> Meshes:
    """Roofs whose slopes, walls and undersides are sheets with points of their own, as CityEngine makes them."""
    up = first_normals(roofs)[roofs.mesh_of_face()]
    height = -np.einsum("fi,fi->f", face_normals(roofs), up)
    kind = np.where(np.abs(height) < _LEVEL, 0, np.sign(height)).astype(np.int64) + 1
    corner = kind[roofs.face_of_corner()] + 3 * roofs.corner_points()
    used, row = np.unique(corner, return_inverse=True)
    points, mesh = used // 3, roofs.mesh_of_point()[used // 3]
    starts = np.searchsorted(mesh, np.arange(len(roofs) + 1))
    return replace(
        roofs,
        points=roofs.points[points],
        corners=row.ravel() - starts[roofs.mesh_of_corner()],
        mesh_points=starts,
    )


OPERATIONS: dict[str, Operation] = {
    "roofGable": Operation(_by_flag(_roofed(roof_gable), 3), _WORDS, (1, 6)),
    "roofHip": Operation(_by_flag(_roofed(roof_hip), 2), _WORDS, (1, 4)),
    "roofPyramid": Operation(_roofed(roof_pyramid), _WORDS, (1, 2)),
    "roofRidge": Operation(_roofed(roof_ridge), _WORDS, (1, 2)),
    "roofShed": Operation(_roofed(roof_shed), _WORDS, (1, 3)),
    "taper": Operation(taper, num_arguments=(1, 1)),
}
