"""The reference of CGA: what each supported operation and function does, with examples that are run.

The texts are in `cga_operations.toml` and `cga_functions.toml`; `cga_pictures` draws the examples of operations.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from grammarlab.derivation import derive
from grammarlab.language.grammar import Grammar

LOT = (12.0, 8.0)
"""Width and depth in metres of the lot of all examples."""
PICTURES = "images/cga"
"""Folder of the pictures in the documentation."""
_FOLDER = Path(__file__).parent


@dataclass(frozen=True, slots=True, kw_only=True)
class Operation:
    """What the page says of an operation."""

    name: str
    forms: tuple[str, ...]
    text: str
    arguments: Mapping[str, str] = field(default_factory=dict)
    """Meaning of each argument that was not described before."""
    example: str
    """A whole rule file."""
    note: str = ""
    """Where it differs from CityEngine."""
    has_picture: bool
    group: str


def all_operations() -> Iterator[Operation]:
    """The operations, in the order of the page."""
    for group in _read("cga_operations.toml")["group"]:
        for entry in group["operation"]:
            values: dict[str, Any] = {**entry, "forms": tuple(entry["forms"]), "example": entry["example"].strip()}
            yield Operation(
                **values,
                has_picture=bool(group.get("pictures")),
                group=group["title"],
            )


def all_functions() -> dict[str, dict[str, list[str]]]:
    """Forms, meaning and perhaps an example of each function, by group."""
    return _read("cga_functions.toml")


def operations() -> str:
    """The page of operations in Markdown."""
    lines: list[str] = []
    group = ""
    for operation in all_operations():
        if operation.group != group:
            group = operation.group
            lines += [f"## {group}", ""]
        lines += [*_section(operation), ""]
    return "\n".join(lines).rstrip()


def functions() -> str:
    """The page of functions in Markdown: a table for each group, with the values of its examples."""
    groups = all_functions()
    examples = [entry[2] for group in groups.values() for entry in group.values() if len(entry) > 2]
    values = dict(zip(examples, _values(examples), strict=True))
    parts: list[str] = []
    for title, group in groups.items():
        rows = [
            f"| {_code(forms)} | {text} | {_code(example[0]) if example else ''} | "
            f"{_code(values[example[0]]) if example else ''} |"
            for forms, text, *example in group.values()
        ]
        parts.append(
            "\n".join([f"## {title}", "", "| function | value | example | gives |", "|---|---|---|---|", *rows])
        )
    return "\n\n".join(parts)


def _section(operation: Operation) -> list[str]:
    lines = [f"### {operation.name}", "", " · ".join(map(_code, operation.forms)), "", operation.text, ""]
    lines += [f"- `{name}`: {meaning}" for name, meaning in operation.arguments.items()]
    lines += [""] if operation.arguments else []
    if operation.has_picture:
        lines += [f"![{operation.name}](../{PICTURES}/{operation.name}.png)", ""]
    lines += ["```cga", *operation.example.splitlines(), "```"]
    return [*lines, "", f"Unlike CityEngine: {operation.note}"] if operation.note else lines


def _values(expressions: list[str]) -> tuple[str, ...]:
    """What expressions print on the lot, extruded to five metres."""
    prints = " ".join(f"print({expression})" for expression in expressions)
    return derive(Grammar.parse(f"Lot --> extrude(5) {prints} A."), 1, 1, footprint=LOT).prints


def _code(text: str) -> str:
    return f"`{text}`".replace("|", "\\|") if text else ""


def _read(name: str) -> dict[str, dict]:
    return tomllib.loads((_FOLDER / name).read_text(encoding="utf-8"))
