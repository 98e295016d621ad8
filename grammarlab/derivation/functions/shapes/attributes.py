"""Shape attributes: properties of a shape that rules can read."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.calls.pivots import PIVOT_POSITION, pivot_position
from grammarlab.derivation.functions.colors import to_hex
from grammarlab.derivation.state.shapes import Ids, Shapes, Value
from grammarlab.derivation.state.workspace import Code, Workspace
from grammarlab.derivation.values.angles import euler_angles
from grammarlab.derivation.values.materials import CHANNELS, REMEMBERED, MaterialTable

STATE_DEFAULTS: dict[str, float | str | bool] = {
    "split.index": 0.0,
    "split.total": 0.0,
    "comp.index": 0.0,
    "comp.total": 0.0,
    "comp.sel": "",
    "trim.horizontal": True,
    "trim.vertical": True,
    **dict.fromkeys(PIVOT_POSITION, 0.0),
    **{f"material.{name}": value for name, value in REMEMBERED.items()},
}
"""Entries of `Shapes.state` that operations or ``set`` change, and their values on an initial shape."""

_AXES = "xyz"

ASK_FOR_PIVOT = frozenset({*PIVOT_POSITION, *(f"{kind}{axis}" for kind in ("scope.t", "pivot.o") for axis in _AXES)})
"""Readable and settable shape attributes that depend on the pivot."""


def _size(axis: int) -> Code:
    return lambda shapes, workspace: shapes.size[:, axis]


def _translation(axis: int) -> Code:
    def evaluate(shapes: Shapes, workspace: Workspace) -> Value:
        offset = shapes.position - pivot_position(shapes, workspace)
        return workspace.frames.to_local(shapes.pivot, offset)[:, axis]

    return evaluate


def _rotation(axis: int) -> Code:
    return lambda shapes, workspace: turn_angles(shapes.pivot, shapes.frame, workspace)[:, axis]


def _orientation(axis: int) -> Code:
    return lambda shapes, workspace: turn_angles(workspace.roots.frame[shapes.model], shapes.pivot, workspace)[:, axis]


def turn_angles(reference: Ids, frames: Ids, workspace: Workspace) -> NDArray[np.float64]:
    """[N, 3] angles in degrees of frames [N] relative to other frames [N]."""
    table = workspace.frames
    return euler_angles(np.einsum("nji,njk->nik", table.rotations(reference), table.rotations(frames)))


def _state(name: str) -> Code:
    default = STATE_DEFAULTS[name]
    return lambda shapes, workspace: shapes.state.get(name, default)


def _channel(name: str) -> Code:
    return lambda shapes, workspace: workspace.materials.channel(shapes.material, name)


def _of_material(describe: Callable[[MaterialTable, int], str]) -> Code:
    """A text about each material."""

    def evaluate(shapes: Shapes, workspace: Workspace) -> Value:
        used, which = np.unique(shapes.material, return_inverse=True)
        return workspace.strings.ids(describe(workspace.materials, material) for material in used.tolist())[which]

    return evaluate


def _color(table: MaterialTable, material: int) -> str:
    return to_hex(*(float(table.channel(np.array([material]), f"color.{channel}")[0]) for channel in "rgb"))


def _origin(axis: int) -> Code:
    return lambda shapes, workspace: (workspace.roots.position + workspace.origins)[shapes.model, axis]


def _origin_turn(axis: int) -> Code:
    def evaluate(shapes: Shapes, workspace: Workspace) -> Value:
        rotations = workspace.frames.rotations(workspace.roots.frame[shapes.model])
        return euler_angles(rotations)[:, axis]

    return evaluate


SHAPE_ATTRIBUTES: dict[str, Code] = {
    **{f"scope.s{_AXES[axis]}": _size(axis) for axis in range(3)},
    **{f"scope.t{_AXES[axis]}": _translation(axis) for axis in range(3)},
    **{f"scope.r{_AXES[axis]}": _rotation(axis) for axis in range(3)},
    **{f"pivot.o{_AXES[axis]}": _orientation(axis) for axis in range(3)},
    "scope.elevation": lambda shapes, workspace: shapes.position[:, 1] + workspace.origins[shapes.model, 1],
    **{name: _state(name) for name in STATE_DEFAULTS},
    **{f"material.{name}": _channel(name) for name in CHANNELS},
    "material.color.a": _channel("opacity"),
    "material.color.rgb": _of_material(_color),
    "material.colormap": _of_material(lambda table, material: table.texture(material)),
    "initialShape.name": lambda shapes, workspace: "InitialShape",
    "initialShape.startRule": lambda shapes, workspace: workspace.start_symbol(shapes),
    "initialShape.symbol": lambda shapes, workspace: workspace.start_symbol(shapes),
    **{f"initialShape.origin.p{_AXES[axis]}": _origin(axis) for axis in range(3)},
    **{f"initialShape.origin.o{_AXES[axis]}": _origin_turn(axis) for axis in range(3)},
}
