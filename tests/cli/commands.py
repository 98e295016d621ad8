"""All commands of the command line."""

from collections.abc import Callable, Iterator
from typing import Any

import typer

from grammarlab.cli import app


def named(group: typer.Typer, before: str = "") -> Iterator[tuple[str, Callable[..., Any]]]:
    """What each command is called, with the groups that it belongs to, and its function."""
    for command in group.registered_commands:
        assert command.callback is not None
        yield f"{before}{command.name}", command.callback
    for inner in group.registered_groups:
        assert inner.typer_instance is not None
        yield from named(inner.typer_instance, f"{before}{inner.typer_instance.info.name} ")


COMMANDS = dict(sorted(named(app)))
"""Function of each command, by its name: `check`, …, `facade read`."""
