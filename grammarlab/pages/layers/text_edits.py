"""Changes of a design as changes of its text; comments, order and spaces are preserved."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import tomlkit
from tomlkit.items import Item

from grammarlab.layers.design import Design
from grammarlab.layers.file import parse_design

FLAGS = ("opaque", "attached", "unoccludable", "transparent")
_AXES = "xy"


def with_canvas(text: str, width: float, height: float) -> str:
    """The text of a design with another canvas, metres."""

    def change(table: Any) -> None:
        for name, value in (("width", width), ("height", height)):
            if table["canvas"][name] != value:
                _set(table["canvas"], name, float(f"{value:.9g}"))

    return _changed(text, change)


def with_switch(text: str, layer: int, *, on: bool) -> str:
    """The text with a layer switched on or off."""
    return _changed(text, lambda table: _set(table["layers"][layer], "on", on))


def with_flag(text: str, symbol: str, flag: str, *, value: bool) -> str:
    """The text with a flag of a symbol set."""

    def change(table: Any) -> None:
        entry = table["symbols"][symbol]
        if isinstance(entry, dict):
            _set(entry, flag, value)
        else:
            _set(table["symbols"], symbol, _inline({"size": entry.unwrap(), flag: value}))

    return _changed(text, change)


def with_mask(text: str, layer: int, axis: int, symbols: Sequence[str] | None) -> str:
    """The text with a mask of visible symbols of a layer along an axis; None for all."""

    def change(table: Any) -> None:
        entry = table["layers"][layer]
        mask = {key: list(value) for key, value in entry.get("mask", {}).items() if key != _AXES[axis]}
        if symbols is not None:
            mask[_AXES[axis]] = list(symbols)
        if mask:
            _set(entry, "mask", _inline(mask))
        elif "mask" in entry:
            del entry["mask"]

    return _changed(text, change)


def same_but_canvas(design: Design, other: Design) -> bool:
    """Whether designs differ only in the size of their canvas."""
    return replace(design, width=other.width, height=other.height) == other


def _changed(text: str, change: Callable[[Any], None]) -> str:
    """A text after a change of its tables.

    Raises:
        LanguageError: If the result is not a design.
    """
    table = tomlkit.parse(text)
    change(table)
    changed = tomlkit.dumps(table)
    parse_design(changed)
    return changed


def _inline(values: dict[str, Any]) -> Item:
    table = tomlkit.inline_table()
    table.update(values)
    return table


def _set(table: Any, name: str, value: Any) -> None:
    """Replaces or appends a value; the comment of its line is preserved."""
    old = table.get(name)
    item = value if isinstance(value, Item) else tomlkit.item(value)
    if isinstance(old, Item):
        item.trivia.comment_ws, item.trivia.comment = old.trivia.comment_ws, old.trivia.comment
    table[name] = item
