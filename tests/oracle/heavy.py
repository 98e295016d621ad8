"""Operations whose geometry is a library's business: the oracle hands it one mesh at a time."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

import numpy as np

from grammarlab.geometry.meshes import primitives
from grammarlab.geometry.meshes.extrude import extrude as extruded
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.outlines import offset as outlines
from grammarlab.geometry.outlines import roofs
from tests.oracle.components import unit
from tests.oracle.expressions import number
from tests.oracle.operations import OPERATIONS, Call, frame_from_y, primitive
from tests.oracle.shape import Mesh, Shape, newell, replace
from tests.oracle.streets import remembering


def primitive_with(make: Callable[..., Meshes]) -> Callable[[Call], Shape]:
    """``primitiveX(counts)``, fitted to the scope."""

    def apply(call: Call) -> Shape:
        counts = [int(number(a.value)) for a in call.arguments]
        own = primitives.natural_size(make.__name__, *counts)  # ty: ignore[missing-attribute]
        return primitive(Mesh.from_columns(make(*counts)), call, own)

    return apply


def roof_with(make: Callable[..., Meshes]) -> Callable[[Call], Shape]:
    """A roof over the shape's faces; the scope stands on the first one."""

    def apply(call: Call) -> Shape:
        values = [a.value for a in call.arguments if not a.word]
        by = "height" if "byHeight" in call.words else "angle"
        roof = make(call.shape.mesh.to_columns(), values[0], by, *values[1:])
        frame = frame_from_y(unit(newell(call.shape.mesh.polygon(0))), np.array([1.0, 0.0, 0.0]))
        mesh = Mesh.from_columns(roof).moved(lambda p: frame.T @ p)
        return replace(call.shape, rotation=call.shape.rotation @ frame, mesh=mesh).fitted()

    return apply


def extrude(call: Call) -> Shape:
    """A solid over one face is the oracle's own. Several faces move along their normals, or all upwards."""
    shape, height = call.shape, number(call.arguments[-1].value)
    if len(shape.mesh.faces) < 2 or height == 0.0:
        return OPERATIONS["extrude"](call)
    up = shape.rotation.T @ np.array([0.0, 1.0, 0.0]) if "world.up" in call.words else None
    y = unit(newell(shape.mesh.polygon(0))) if up is None else up
    frame = frame_from_y(y, np.array([1.0, 0.0, 0.0]))
    directions = None if up is None else up[None, :]
    solid = Mesh.from_columns(extruded(shape.mesh.to_columns(), np.array([height]), directions))
    return replace(shape, rotation=shape.rotation @ frame, mesh=solid.moved(lambda p: frame.T @ p)).fitted()


def offset(call: Call) -> Shape:
    """Every face moved inwards or outwards; what it remembers of the lot moves with it."""
    shape, root, distance = call.shape, call.scope.model.root, number(call.arguments[0].value)
    keep = cast("outlines.Keep", call.words[0] if call.words else "all")
    faces = outlines.offset(shape.mesh.to_columns(), distance, keep)
    mesh = Mesh.from_columns(faces)
    moved = [-distance] * sum(len(face) for face in shape.mesh.faces)
    return remembering(replace(shape, mesh=mesh).fitted(), shape, root, moved, mesh.polygons())


HEAVY: dict[str, Callable[[Call], Shape]] = {
    **OPERATIONS,
    "extrude": extrude,
    "offset": offset,
    "primitiveCylinder": primitive_with(primitives.cylinder),
    "primitiveQuad": primitive_with(primitives.quad),
    "roofGable": roof_with(roofs.roof_gable),
    "roofHip": roof_with(roofs.roof_hip),
    "roofPyramid": roof_with(roofs.roof_pyramid),
}
"""All operations of the oracle."""
