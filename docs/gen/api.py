"""The page of the Python names: one section per public name."""

from __future__ import annotations

import inspect

import grammarlab


def names() -> tuple[str, ...]:
    """The public names of the package, in the order in which it lists them."""
    return tuple(name for name in getattr(grammarlab, "__all__", ()) if not name.startswith("__"))


def sections() -> str:
    """One section per public name, for mkdocstrings to fill in."""
    return "\n\n".join(_section(name) for name in names())


def _section(name: str) -> str:
    value = getattr(grammarlab, name)
    place = value.__name__ if inspect.ismodule(value) else f"{value.__module__}.{value.__qualname__}"
    return f"## `grammarlab.{name}`\n\n::: {place}"
