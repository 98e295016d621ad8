"""Operations that change materials, attributes and labels of shapes; ``set`` for placements; one without effect.

``set`` changes the numbers that place a shape: ``scope.t``, ``scope.r``, ``scope.s``, ``pivot.p`` and ``pivot.o``.

``setupUV`` is accepted and has no effect; `grammarlab check` warns of each use.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.calls.calls import Argument, BoundCall, Operation
from grammarlab.derivation.calls.texture_transfer import carried, pivot_position, with_pivot
from grammarlab.derivation.frames import euler
from grammarlab.derivation.functions.color_functions import parse_color
from grammarlab.derivation.functions.shape_attributes import STATE_DEFAULTS, turn_angles
from grammarlab.derivation.functions.shape_materials import asset_materials, named_values, with_asset_materials
from grammarlab.derivation.functions.text_functions import print_value, to_number
from grammarlab.derivation.materials import CHANNELS, REMEMBERED
from grammarlab.derivation.operations.scope import s
from grammarlab.derivation.state.array_table import is_table
from grammarlab.derivation.state.shapes import ARRAY, Shapes, Value, as_column, kind_of, number_column
from grammarlab.language.syntax.keywords import KEYWORDS
from grammarlab.language.syntax.syntax_tree import TRIM_SWITCHES
from grammarlab.randomness import fold

_PLACEMENT = frozenset(
    f"{kind}{axis}" for kind in ("scope.t", "scope.r", "scope.s", "pivot.p", "pivot.o") for axis in "xyz"
)
"""The names of these numbers."""
_UNCHANGED_SIZE = Argument(1.0, relative=True)
_WORDS = frozenset[str]().union(*KEYWORDS.values())
_OF_LOOKS = ("setupUV",)
_REMEMBERED = frozenset(f"material.{name}" for name in REMEMBERED)
_COLOR = ("color.r", "color.g", "color.b")
_ALIASES = {"color.a": "opacity"}
_SEEDIANS = np.uint64(0x5EED)
"""Key below which the keys of shapes with a given seedian are folded."""


def color(call: BoundCall) -> Shapes:
    """``color("#rrggbb")``, ``color("#rrggbboo")``, ``color(r, g, b)`` or ``color(r, g, b, opacity)``, in 0..1."""
    if len(call.arguments) == 1:
        return _colored(call, call.arguments[0], _COLOR)
    if len(call.arguments) == 2:
        raise call.error("color expects one string, or three or four numbers, found two arguments")
    channels = (*_COLOR, "opacity")
    changes = {name: _unit(call, argument) for name, argument in zip(channels, call.arguments, strict=False)}
    return _changed(call, changes)


def texture(call: BoundCall) -> Shapes:
    """``texture(path)``: the image on the surface; an empty path removes it."""
    return _changed_by_text(call, call.arguments[0], lambda path: {"texture": path})


def set_attribute(call: BoundCall) -> Shapes:
    """``set(name, value)``: an attribute of the grammar, a part of the material or of the shape's placement.

    The value holds for the following operations and all descendants.
    """
    name, argument = str(call.arguments[0].value), call.arguments[1]
    if name in call.workspace.attributes:
        return call.shapes._replace(state={**call.shapes.state, name: argument.value})
    if name in _PLACEMENT:
        return _set_placement(call, name, argument)
    if name == "seedian":
        return _reseeded(call, argument)
    if name in call.shapes.state:
        return call.shapes._replace(state={**call.shapes.state, name: argument.value})
    if name.startswith("material."):
        return _set_material(call, name.removeprefix("material."), argument)
    if name in TRIM_SWITCHES:
        return call.shapes
    if "." in name:
        problem = "it is not a material attribute, and no imported file defines it"
        if not name.startswith(call.workspace.import_prefixes):
            raise call.error(f"{name} cannot be set: {problem}")
        call.warn(f"{name} is not set: {problem}")
        return call.shapes
    raise call.error(
        f"set expects an attribute of this grammar or a material attribute, found {name}",
        "attributes are declared with attr; material attributes are " + ", ".join(CHANNELS),
    )


def _reseeded(call: BoundCall, argument: Argument) -> Shapes:
    """Shapes whose draws from here on depend on the number alone: equal numbers give equal draws in all models."""
    if call.shapes.key is None:
        return call.shapes
    words = call.column(argument).view(np.uint64)
    return call.shapes._replace(key=fold(np.full(call.shapes.num, _SEEDIANS), words))


def report(call: BoundCall) -> Shapes:
    """``report(key, value)``: collect a number for the model; the key may differ between shapes."""
    key = call.text(call.arguments[0])
    value = call.arguments[1].value
    column = np.full(call.shapes.num, np.nan)
    if kind_of(value) not in ("string", ARRAY):
        column = number_column(value, call.shapes.num)
    recorder, strings = call.workspace.recorder, call.workspace.strings
    if isinstance(key, str):
        recorder.add_report(call.shapes.node, key, column)
        return call.shapes
    for code in np.unique(key).tolist():
        rows = np.flatnonzero(key == code)
        recorder.add_report(call.shapes.node[rows], strings[code], column[rows])
    return call.shapes


def show(call: BoundCall) -> Shapes:
    """``print(value)``: collect a text."""
    print_value(call.arguments[0].value, call.shapes, call.workspace)
    return call.shapes


def label(call: BoundCall) -> Shapes:
    """``label(name)``: spatial queries see the shape as it is here, under this name."""
    text, collector = call.text(call.arguments[0]), call.workspace.collector
    if collector is None:
        return call.shapes
    if isinstance(text, str):
        collector.add(call.shapes, text)
        return call.shapes
    for code in np.unique(text).tolist():
        collector.add(call.shapes.take(np.flatnonzero(text == code)), call.workspace.strings[code])
    return call.shapes


def set_material(call: BoundCall) -> Shapes:
    """``setMaterial(array)``: the attributes whose names and values are in an array in turn, as by ``set`` of each."""
    value, shapes = call.arguments[0].value, call.shapes
    if not is_table(value):
        raise call.error(f"setMaterial expected an array of names and values, found a {kind_of(value)}")
    tables = np.broadcast_to(np.asarray(value), shapes.num)
    material = shapes.material.copy()
    state = dict(shapes.state)
    for number in np.unique(tables).tolist():
        rows = np.flatnonzero(tables == number)
        table = call.workspace.tables[number]
        if len(table.cells) % 2:
            call.warn("setMaterial expects a value after each name; the last name is left out")
        for name, text in named_values(table):
            changes = _changes_by_text(call, name, text)
            material[rows] = call.workspace.materials.repainted(material[rows], changes)
            remembered = f"material.{name}"
            if remembered in state and remembered in STATE_DEFAULTS:
                state[remembered] = _with_text(call, state[remembered], remembered, text, rows)
    return shapes._replace(material=material, state=state)


def _changes_by_text(call: BoundCall, name: str, text: str) -> dict[str, float | str]:
    """Channels of a material that an attribute without ``material.`` sets to a value written as a text."""
    channel = _ALIASES.get(name, name)
    if channel in CHANNELS:
        number = to_number(text)
        if np.isfinite(number):
            return {channel: min(max(number, 0.0), 1.0)}
        call.warn(f'setMaterial expected a number for {name}, found "{text}"; it does not change')
        return {}
    if name in ("color.rgb", "color", "emissive.rgb", "emissive"):
        channels = [f"{name.partition('.')[0]}.{channel}" for channel in "rgb"]
        return dict(zip((*channels, "opacity"), _color_of(text, call), strict=False))
    return {"texture": text} if name == "colormap" else {}


def _with_text(call: BoundCall, value: Value, name: str, text: str, rows: NDArray[np.int64]) -> Value:
    """An attribute of the type of its default, set to a value written as a text at some rows."""
    default, strings = STATE_DEFAULTS[name], call.workspace.strings
    column = as_column(value, call.shapes.num, strings).copy()
    if isinstance(default, str):
        column[rows] = strings.id(text)
    elif isinstance(default, bool):
        column[rows] = text == "true"
    elif np.isfinite(to_number(text)):
        column[rows] = to_number(text)
    return column


def reset_material(call: BoundCall) -> Shapes:
    """``resetMaterial(shape|geometry|all)``: without what rules changed, without the material of the asset, or both."""
    shapes, target = call.shapes, call.words[0] if call.words else "shape"
    asset = asset_materials(shapes)
    if target == "geometry":
        material = call.workspace.materials.without(shapes.material, asset)
    else:
        material = asset if target == "shape" else np.zeros(shapes.num, np.int32)
    reset = {} if target == "geometry" else {name: STATE_DEFAULTS[name] for name in shapes.state if name in _REMEMBERED}
    result = shapes._replace(material=material, state={**shapes.state, **reset})
    return result if target == "shape" else with_asset_materials(result, np.zeros(shapes.num, np.int32))


OPERATIONS: dict[str, Operation] = {
    "color": Operation(color, num_arguments=(1, 4)),
    "label": Operation(label, num_arguments=(1, 1)),
    "print": Operation(show, num_arguments=(1, 1)),
    "report": Operation(report, num_arguments=(2, 2)),
    "resetMaterial": Operation(reset_material, KEYWORDS["material_target"], (0, 1)),
    "set": Operation(set_attribute, num_arguments=(2, 2), names_target=True),
    "setMaterial": Operation(set_material, num_arguments=(1, 1)),
    "texture": Operation(texture, num_arguments=(1, 1)),
}


def _colored(call: BoundCall, argument: Argument, channels: tuple[str, str, str]) -> Shapes:
    """Channels from a hexadecimal colour."""
    return _changed_by_text(
        call, argument, lambda text: dict(zip((*channels, "opacity"), _color_of(text, call), strict=False))
    )


def _changed_by_text(call: BoundCall, argument: Argument, changes: Callable[[str], dict[str, float | str]]) -> Shapes:
    """Materials changed by what ``changes`` makes of a string."""
    table, strings, text = call.workspace.materials, call.workspace.strings, call.text(argument)
    if isinstance(text, str):
        return call.shapes._replace(material=table.repainted(call.shapes.material, changes(text)))
    material = table.changed_by_code(call.shapes.material, text, lambda code: changes(strings[code]))
    return call.shapes._replace(material=material)


def _color_of(text: str, call: BoundCall) -> tuple[float, ...]:
    """Red, green, blue and optional opacity in 0..1; none, which changes nothing, and a warning for other texts."""
    channels = parse_color(text)
    if channels is None:
        call.warn(f'expected a colour like "#ff8800", found "{text}"; the colour does not change')
        return ()
    return channels


def _unit(call: BoundCall, argument: Argument) -> float | NDArray[np.float64]:
    """A number clamped to 0..1."""
    number = call.number(argument)
    return np.clip(number, 0.0, 1.0) if isinstance(number, np.ndarray) else min(max(number, 0.0), 1.0)


def _changed(call: BoundCall, changes: dict[str, float | NDArray[np.float64]]) -> Shapes:
    table, shapes = call.workspace.materials, call.shapes
    constants = {name: value for name, value in changes.items() if not isinstance(value, np.ndarray)}
    if len(constants) == len(changes):
        return shapes._replace(material=table.repainted(shapes.material, constants))
    return shapes._replace(material=table.changed(shapes.material, changes))


def _set_placement(call: BoundCall, name: str, argument: Argument) -> Shapes:
    """Shapes with one of the numbers changed and the others kept.

    The scope is placed relative to the pivot, so it moves and rotates with it.

    Args:
        call: the operation.
        name: one of `_PLACEMENT`.
        argument: metres or degrees.
    """
    axis = "xyz".index(name[-1])
    if name.startswith("scope.s"):
        return s(call._replace(arguments=tuple(argument if other == axis else _UNCHANGED_SIZE for other in range(3))))
    return carried(call.shapes, _placed(call, name, axis, argument), call.workspace)


def _placed(call: BoundCall, name: str, axis: int, argument: Argument) -> Shapes:
    """Shapes moved or rotated, with their pivots or relative to them."""
    shapes, frames, value = call.shapes, call.workspace.frames, call.column(argument)
    pivot = pivot_position(shapes, call.workspace)
    if name.startswith("pivot.p"):
        initial = call.workspace.roots.frame[shapes.model]
        start = call.workspace.roots.position[shapes.model]
        offset = frames.to_local(initial, pivot - start)
        offset[:, axis] = value
        moved = start + frames.to_world(initial, offset)
        return with_pivot(
            shapes._replace(position=shapes.position + moved - pivot), moved, shapes.pivot, call.workspace
        )
    translation = frames.to_local(shapes.pivot, shapes.position - pivot)
    if name.startswith("scope.t"):
        translation[:, axis] = value
        return shapes._replace(position=pivot + frames.to_world(shapes.pivot, translation))
    reference = call.workspace.roots.frame[shapes.model] if name.startswith("pivot.o") else shapes.pivot
    turned = shapes.pivot if name.startswith("pivot.o") else shapes.frame
    angles = turn_angles(reference, turned, call.workspace)
    angles[:, axis] = value
    frame = frames.rotated(reference, euler(*angles.T))
    if name.startswith("scope.r"):
        return shapes._replace(frame=frame)
    scope = frames.rotations(shapes.pivot).swapaxes(1, 2) @ frames.rotations(shapes.frame)
    placed = shapes._replace(frame=frames.rotated(frame, scope), position=pivot + frames.to_world(frame, translation))
    return with_pivot(placed, pivot, frame, call.workspace)


def _set_material(call: BoundCall, name: str, argument: Argument) -> Shapes:
    channel = _ALIASES.get(name, name)
    if channel in CHANNELS:
        return _changed(call, {channel: _unit(call, argument)})
    if name in ("color.rgb", "color"):
        return _colored(call, argument, _COLOR)
    if name in ("emissive.rgb", "emissive"):
        return _colored(call, argument, ("emissive.r", "emissive.g", "emissive.b"))
    if name == "colormap":
        return texture(call._replace(arguments=(argument,)))
    return call.shapes


def _unchanged(call: BoundCall) -> Shapes:
    """The unchanged shapes."""
    return call.shapes


NEUTRAL: dict[str, Operation] = {name: Operation(_unchanged, _WORDS, (0, 9)) for name in _OF_LOOKS}
