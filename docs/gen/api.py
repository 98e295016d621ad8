"""The page of the Python names: one section per public name."""

from __future__ import annotations

import inspect
from typing import Any

import grammarlab


def names() -> tuple[str, ...]:
    """The public names of the package, in the order in which it lists them."""
    return tuple(name for name in getattr(grammarlab, "__all__", ()) if not name.startswith("__"))


def sections() -> str:
    """A table of all names, and one section for each, for mkdocstrings to fill in."""
    rows = [f"| [`{name}`](#{name}) | {_first_line(getattr(grammarlab, name))} |" for name in names()]
    table = "\n".join(["| name | what it is |", "|---|---|", *rows])
    return "\n\n".join([table, *map(_section, names())])


def _first_line(value: Any) -> str:
    return " ".join((inspect.getdoc(value) or "").split("\n\n")[0].split()).replace("|", "\\|")


def _section(name: str) -> str:
    value = getattr(grammarlab, name)
    place = value.__name__ if inspect.ismodule(value) else f"{value.__module__}.{value.__qualname__}"
    return f"## `gl.{name}` {{ #{name} }}\n\n::: {place}"
