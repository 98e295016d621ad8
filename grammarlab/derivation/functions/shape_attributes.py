"""Shape attributes, which are properties of a shape that rules can read, and ``convert`` between coordinate systems."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.derivation.calls.calls import Builtin, FunctionCall
from grammarlab.derivation.calls.texture_transfer import PIVOT_POSITION, pivot_position
from grammarlab.derivation.frames import euler, euler_angles
from grammarlab.derivation.functions.color_functions import to_hex
from grammarlab.derivation.materials import CHANNELS, REMEMBERED, MaterialTable
from grammarlab.derivation.state.shapes import Ids, Shapes, Value, kind_of, number_column
from grammarlab.derivation.state.workspace import Code, Workspace
from grammarlab.errors import DerivationError
from grammarlab.language.syntax.keywords import KEYWORDS

ASSET_MATERIAL = "material of the asset"
"""Entry of `Shapes.state` with the material that the geometry had when it was inserted, if the grammar asks for it."""
_WORDS = frozenset().union(*(KEYWORDS[name] for name in ("axis", "system", "position_type")))
_READABLE_STATE: dict[str, float | str | bool] = {
    "split.index": 0.0,
    "split.total": 0.0,
    "comp.index": 0.0,
    "comp.total": 0.0,
    "comp.sel": "",
    "trim.horizontal": False,
    "trim.vertical": True,
    **dict.fromkeys(PIVOT_POSITION, 0.0),
    **{f"material.{name}": value for name, value in REMEMBERED.items()},
}
"""Entries of `Shapes.state` that operations or ``set`` change and rules read, and their values on an initial shape."""
STATE_DEFAULTS: dict[str, float | str | bool] = {**_READABLE_STATE, ASSET_MATERIAL: 0.0}
"""The same with entries that rules do not read."""
_AXES = "xyz"
ASK_FOR_PIVOT = frozenset({*PIVOT_POSITION, *(f"{kind}{axis}" for kind in ("scope.t", "pivot.o") for axis in _AXES)})
"""Readable and settable shape attributes that depend on the pivot."""


KEY_ATTRIBUTES = frozenset({"seedian", "uid"})
"""Readable shape attributes that depend on the random key."""


def turn_angles(reference: Ids, frames: Ids, workspace: Workspace) -> NDArray[np.float64]:
    """[N, 3] angles in degrees of frames [N] relative to other frames [N]."""
    table = workspace.frames
    return euler_angles(np.einsum("nji,njk->nik", table.rotations(reference), table.rotations(frames)))


def _convert(call: FunctionCall) -> Value:
    """``convert(axis, from, to, pos|orient, x, y, z)``: one coordinate in metres, or one angle in degrees."""
    axis, source, target, kind = (str(word) for word in call.arguments[:4])
    columns = [_number(call, value) for value in call.arguments[4:]]
    frames = call.workspace.frames
    origin, frame = _system(call, source)
    other_origin, other_frame = _system(call, target)
    if kind == "orient":
        turned = frames.rotations(frame) @ euler(*columns)
        angles = euler_angles(np.swapaxes(frames.rotations(other_frame), 1, 2) @ turned)
        return angles[:, "xyz".index(axis)]
    world = origin + frames.to_world(frame, np.stack(columns, axis=1))
    return frames.to_local(other_frame, world - other_origin)[:, "xyz".index(axis)]


def _number(call: FunctionCall, value: Value) -> Floats:
    if kind_of(value) == "string":
        raise DerivationError("convert expected a number, found a string", call.location)
    return number_column(value, call.shapes.num)


def _system(call: FunctionCall, name: str) -> tuple[Floats, Ids]:
    """Origin [N, 3], relative to the origin of positions, and frames [N] of a coordinate system of each shape."""
    shapes, workspace = call.shapes, call.workspace
    if name == "scope":
        return shapes.position, shapes.frame
    if name == "pivot":
        return pivot_position(shapes, workspace), shapes.pivot
    if name == "object":
        return workspace.roots.position[shapes.model], workspace.roots.frame[shapes.model]
    return -workspace.origins[shapes.model], np.zeros(shapes.num, dtype=np.int32)


def _geo_coordinate(call: FunctionCall) -> Value:
    """``getGeoCoord(X|Y|lat|lon)``: metres east and north of the world's origin; 0 for degrees, which need a map."""
    word = str(call.arguments[0])
    if word in ("lat", "lon"):
        message = f"getGeoCoord({word}) needs a place on the earth, which models do not have; 0 is used"
        call.workspace.recorder.add_warning(message, call.location)
        return 0.0
    world = call.shapes.position + call.workspace.origins[call.shapes.model]
    return world[:, 0] if word == "X" else -world[:, 2]


def _tree_key(call: FunctionCall) -> Value:
    """``getTreeKey()``: the numbers of a shape's node and of those above it among their siblings."""
    siblings = call.workspace.recorder.siblings
    return "0;" if siblings is None else call.workspace.strings.ids(siblings.keys(call.shapes.node))


BUILTINS: dict[str, Builtin] = {
    "convert": Builtin(_convert, (7, 7), keywords=_WORDS),
    "getGeoCoord": Builtin(_geo_coordinate, (1, 1), keywords=KEYWORDS["coordinate"]),
    "getTreeKey": Builtin(_tree_key, (0, 0)),
}


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


def _state(name: str) -> Code:
    default = STATE_DEFAULTS[name]
    return lambda shapes, workspace: shapes.state.get(name, default)


def _channel(name: str) -> Code:
    return lambda shapes, workspace: workspace.materials.channel(shapes.material, name)


def _of_material(describe: Callable[[MaterialTable, int], str]) -> Code:
    """A text about each material."""

    def evaluate(shapes: Shapes, workspace: Workspace) -> Value:
        used, inverse = np.unique(shapes.material, return_inverse=True)
        return workspace.strings.ids(describe(workspace.materials, material) for material in used.tolist())[inverse]

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


def seedian(shapes: Shapes, workspace: Workspace) -> Value:
    """``seedian``: a whole number below 2**31 from the random key of each shape."""
    return (shapes.random_key() >> np.uint64(33)).astype(np.float64)


SHAPE_ATTRIBUTES: dict[str, Code] = {
    "seedian": seedian,
    "uid": seedian,
    **{f"scope.s{_AXES[axis]}": _size(axis) for axis in range(3)},
    **{f"scope.t{_AXES[axis]}": _translation(axis) for axis in range(3)},
    **{f"scope.r{_AXES[axis]}": _rotation(axis) for axis in range(3)},
    **{f"pivot.o{_AXES[axis]}": _orientation(axis) for axis in range(3)},
    "scope.elevation": lambda shapes, workspace: shapes.position[:, 1] + workspace.origins[shapes.model, 1],
    **{name: _state(name) for name in _READABLE_STATE},
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
