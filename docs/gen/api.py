"""The page of the Python names: one section per public name."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from typing import Any, get_args, get_origin, get_type_hints

import grammarlab
from grammarlab.learning.targets.explanation import Words
from grammarlab.learning.targets.simplification import Predicted

_RECORDS = """## Records

These are values that the functions above return. Their fields are public; their constructors are not."""


def names() -> tuple[str, ...]:
    """The public names of the package, in the order in which it lists them."""
    return tuple(name for name in getattr(grammarlab, "__all__", ()) if not name.startswith("__"))


def sections() -> str:
    """A table of all names, and one section for each name and each record, for mkdocstrings to fill in."""
    rows = [f"| [`{name}`](#{name}) | {_first_line(getattr(grammarlab, name))} |" for name in names()]
    table = "\n".join(["| name | what it is |", "|---|---|", *rows])
    shown = [_section(f"gl.{name}", name, getattr(grammarlab, name)) for name in names()]
    records = [_section(each.__name__, each.__name__, each) for each in returned()]
    return "\n\n".join([table, *shown, _RECORDS, *records])


def returned() -> tuple[type, ...]:
    """Records that public functions return and that have no public name, by name, and those inside them."""
    public = [getattr(grammarlab, name) for name in names()]
    functions = [each for each in public if inspect.isfunction(each)]
    found = {part for each in functions for part in _parts(get_type_hints(each)["return"])} | {Predicted, Words}
    ours = [each for each in found if each.__module__.startswith("grammarlab.") and each not in public]
    return tuple(sorted(ours, key=lambda each: each.__name__))


def _parts(hint: Any) -> Iterator[type]:
    """Classes in a type, such as `Edited` in ``tuple[Edited, ...]``."""
    own = get_origin(hint) or hint
    if inspect.isclass(own):
        yield own
    for argument in get_args(hint):
        yield from _parts(argument)


def _first_line(value: Any) -> str:
    return " ".join((inspect.getdoc(value) or "").split("\n\n")[0].split()).replace("|", "\\|")


def _section(title: str, anchor: str, value: Any) -> str:
    place = value.__name__ if inspect.ismodule(value) else f"{value.__module__}.{value.__qualname__}"
    return f"## `{title}` {{ #{anchor} }}\n\n::: {place}"
