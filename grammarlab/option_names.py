"""Options of the command line in messages of the library, which name arguments."""

from __future__ import annotations

import re

_ARGUMENT = re.compile(r"`([a-z_]+)=([^`\n]{0,40})`")
"""An argument in a message of the library: ``width=``, ``unit='mm'`` or ``resume=True``, each between backticks."""
_ARGUMENTS = frozenset(
    [
        "assets",
        "box",
        "boxes",
        "columns",
        "corrections",
        "height",
        "jobs",
        "library",
        "method",
        "no_models",
        "num_models",
        "port",
        "resume",
        "rows",
        "split",
        "stored_grammar",
        "templates",
        "unit",
        "up",
        "wall",
        "width",
        "workers",
    ]
)
"""Arguments that are options of the same name."""
_RENAMED = {"start_rule": "start"}
"""Arguments that are options of another name."""


def with_options(message: str) -> str:
    """A message of the library with the options of the command line instead of arguments.

    >>> with_options("give `width=` or `unit='mm'`, or leave out `stored_grammar=True`")
    'give --width or --unit mm, or leave out --stored-grammar'
    """
    return _ARGUMENT.sub(_option, message)


def _option(match: re.Match[str]) -> str:
    name, value = match[1], match[2].strip("'")
    if name not in _ARGUMENTS and name not in _RENAMED:
        return match[0]
    option = f"--{_RENAMED.get(name, name).replace('_', '-')}"
    return option if value in {"", "True"} else f"{option} {value}"
