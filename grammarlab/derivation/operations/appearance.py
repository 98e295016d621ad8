"""Operations that change the material, attributes and labels of a shape, not its placement."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.calls.calls import Argument, BoundCall, Operation
from grammarlab.derivation.functions.colors import parse_color
from grammarlab.derivation.functions.text import print_value
from grammarlab.derivation.operations.placement import PLACEMENT, set_placement
from grammarlab.derivation.state.shapes import ARRAY, Shapes, kind_of, number_column
from grammarlab.derivation.values.materials import CHANNELS

_COLOR = ("color.r", "color.g", "color.b")
_ALIASES = {"color.a": "opacity"}
_WITHOUT_EFFECT = ("trim.", "seedian")
"""Settable names that have no effect."""


def color(call: BoundCall) -> Shapes:
    """``color("#rrggbb")``, ``color("#rrggbboo")``, ``color(r, g, b)`` or ``color(r, g, b, opacity)``, in 0..1."""
    if len(call.arguments) == 1:
        return _colored(call, call.arguments[0], _COLOR)
    if len(call.arguments) == 2:
        raise call.error("color expects one string, or three or four numbers, found two arguments")
    channels = (*_COLOR, "opacity")
    changes = {name: _unit(call, argument) for name, argument in zip(channels, call.arguments, strict=False)}
    return _changed(call, changes)


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
    """Red, green, blue and optional opacity in 0..1."""
    found = parse_color(text)
    if found is None:
        raise call.error(f'expected a colour like "#ff8800", found "{text}"')
    return found


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
    if name in PLACEMENT:
        return set_placement(call, name, argument)
    if name in call.shapes.state:
        return call.shapes._replace(state={**call.shapes.state, name: argument.value})
    if name.startswith("material."):
        return _set_material(call, name.removeprefix("material."), argument)
    if name.startswith(_WITHOUT_EFFECT):
        return call.shapes
    if "." in name:
        raise call.error(f"{name} cannot be set: it is not a material attribute, and no imported file defines it")
    raise call.error(
        f"set expects an attribute of this grammar or a material attribute, found {name}",
        "attributes are declared with attr; material attributes are " + ", ".join(CHANNELS),
    )


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
    """``label(name)``: a name for occlusion queries, which are not supported."""
    call.text(call.arguments[0])
    return call.shapes


OPERATIONS: dict[str, Operation] = {
    "color": Operation(color, num_arguments=(1, 4)),
    "label": Operation(label, num_arguments=(1, 1)),
    "print": Operation(show, num_arguments=(1, 1)),
    "report": Operation(report, num_arguments=(2, 2)),
    "set": Operation(set_attribute, num_arguments=(2, 2), names_target=True),
    "texture": Operation(texture, num_arguments=(1, 1)),
}
