"""The command line as tables: every command, argument and option with its help."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any

import typer

from grammarlab.cli import app


@cache
def commands() -> dict[str, Any]:
    """Every command by its name (`sample`, `facade read`), in the order of the help."""
    return dict(_named(typer.main.get_command(app), ()))


def page_of(name: str) -> str:
    """The page of a command in the folder `commands`."""
    return f"{name.replace(' ', '-')}.md"


def overview() -> str:
    """A table of all commands."""
    rows = [f"| [`{name}`]({page_of(name)}) | {_first_line(command)} |" for name, command in commands().items()]
    return "\n".join(["| command | what it does |", "|---|---|", *rows])


def page(name: str) -> str:
    """The page of a command that has no page of its own: its help."""
    return f"# grammarlab {name}\n\n{commands()[name].help}\n\n{options(name)}\n"


def options(name: str) -> str:
    """Usage and options of a command.

    Args:
        name: such as `facade read`.
    """
    command = commands()[name]
    context = typer.Context(command, info_name=f"grammarlab {name}")
    usage = command.get_usage(context).removeprefix("Usage: ")
    records = [(parameter, *parameter.get_help_record(context)) for parameter in command.params]
    rows = [f"| {_words(parameter, first)} | {_escaped(text)} |" for parameter, first, text in records]
    return "\n".join(["```text", usage, "```", "", "| argument or option | meaning |", "|---|---|", *rows])


def _named(command: Any, before: tuple[str, ...]) -> Iterator[tuple[str, Any]]:
    if not hasattr(command, "commands"):
        yield " ".join(before), command
        return
    for name, inner in command.commands.items():
        yield from _named(inner, (*before, name))


def _first_line(command: Any) -> str:
    return _escaped(command.help.split("\n\n")[0])


def _words(parameter: Any, first: str) -> str:
    """Names of an option as code, followed by the type of its value: `-n`, `--num-models` int."""
    if not parameter.opts[0].startswith("-"):
        return f"`{first.split(maxsplit=1)[0]}`"
    names = ", ".join(f"`{name}`" for name in (*parameter.opts, *parameter.secondary_opts))
    value = " ".join(word for word in first.split() if not word.startswith(("-", "/")))
    return f"{names} {_escaped(value).strip('<>').replace(' range', '')}".rstrip()


def _escaped(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")
