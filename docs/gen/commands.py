"""The command line as tables: every command, argument and option with its help.

Everything is read from the signatures of the commands, so the text depends neither on the width of a terminal nor on
how a version of typer words its help.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum
from functools import cache
from pathlib import Path
from typing import Any, get_args, get_type_hints

import typer
from typer.models import ArgumentInfo, OptionInfo

from grammarlab.cli import app

WORDS = {int: "int", float: "float", str: "text", bool: ""}
"""Value of an option, by its type."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """An argument or an option of a command."""

    names: tuple[str, ...]
    """`-n` and `--num-models`; of an argument its only name, without dashes."""
    value: str
    """Kind of its value, such as `int`; empty for switches."""
    help: str
    notes: tuple[str, ...]
    """Default and range, or that it is required."""
    is_option: bool

    @property
    def usage(self) -> str:
        """An argument as the line of usage writes it."""
        return self.names[0] if "required" in self.notes else f"[{self.names[0]}]"


@dataclass(frozen=True, slots=True)
class Command:
    """A command."""

    name: str
    """Such as `facade read`."""
    help: str
    parameters: tuple[Parameter, ...]


@cache
def commands() -> dict[str, Command]:
    """Every command by its name (`sample`, `facade read`), in the order of the help."""
    return {name: _command(name, function) for name, function in _named(app, "")}


def page_of(name: str) -> str:
    """The page of a command in the folder `commands`."""
    return f"{name.replace(' ', '-')}.md"


def overview() -> str:
    """A table of all commands."""
    rows = [f"| [`{name}`]({page_of(name)}) | {_first_line(command)} |" for name, command in commands().items()]
    return "\n".join(["| command | what it does |", "|---|---|", *rows])


def options(name: str) -> str:
    """Usage and options of a command.

    Args:
        name: such as `facade read`.
    """
    parameters = commands()[name].parameters
    arguments = [each.usage for each in parameters if not each.is_option]
    usage = " ".join([f"grammarlab {name} [OPTIONS]", *arguments])
    rows = [f"| {_words(each)} | {_meaning(each)} |" for each in parameters]
    return "\n".join(["```text", usage, "```", "", "| argument or option | meaning |", "|---|---|", *rows])


def _named(group: typer.Typer, before: str) -> Iterator[tuple[str, Callable[..., Any]]]:
    for command in group.registered_commands:
        if command.callback is not None:
            yield f"{before}{command.name}", command.callback
    for inner in group.registered_groups:
        if inner.typer_instance is not None:
            yield from _named(inner.typer_instance, f"{before}{inner.typer_instance.info.name} ")


def _command(name: str, function: Callable[..., Any]) -> Command:
    hints = get_type_hints(function, include_extras=True)
    parameters = [
        _parameter(parameter, *get_args(hints[parameter.name]))
        for parameter in inspect.signature(function).parameters.values()
        if hints[parameter.name] is not typer.Context and not get_args(hints[parameter.name])[1].hidden
    ]
    return Command(name, inspect.getdoc(function) or "", tuple(parameters))


def _parameter(parameter: inspect.Parameter, kind: Any, info: OptionInfo | ArgumentInfo) -> Parameter:
    if isinstance(info, OptionInfo):
        # In `Annotated`, typer takes the first declaration, such as "-o", as its argument `default`.
        declared = [name for name in (info.default, *(info.param_decls or ())) if isinstance(name, str)]
        names = declared or [f"--{parameter.name.replace('_', '-')}"]
        texts = tuple(text for name in names for text in name.split("/"))
    else:
        texts = (info.metavar or parameter.name.upper(),)
    is_option = isinstance(info, OptionInfo)
    return Parameter(texts, _value(kind, info), info.help or "", _notes(parameter, info), is_option)


def _value(kind: Any, info: OptionInfo | ArgumentInfo) -> str:
    """Kind of a value in words."""
    inner = [each for each in get_args(kind) if each is not type(None)]
    if inner:
        return _value(inner[0], info)
    if issubclass(kind, Enum):
        return " ".join(f"`{each.value}`" for each in kind)
    if kind is Path:
        return "path" if info.dir_okay and info.file_okay else "folder" if info.dir_okay else "file"
    return WORDS[kind]


def _notes(parameter: inspect.Parameter, info: OptionInfo | ArgumentInfo) -> tuple[str, ...]:
    default = parameter.default
    if default in (inspect.Parameter.empty, ...):
        notes = ["required"]
    elif default is None or default == "" or isinstance(default, bool | list | tuple):
        notes = []
    else:
        notes = [f"default: {_number(default) if isinstance(default, float) else str(default)}"]
    least, most = (None if limit is None else _number(limit) for limit in (info.min, info.max))
    if least is not None and most is not None:
        return (*notes, f"{least} to {most}")
    limits = [] if least is None else [f"at least {least}"]
    return (*notes, *limits, *([] if most is None else [f"at most {most}"]))


def _number(value: float) -> str:
    return str(int(value) if value == int(value) else value)


def _words(parameter: Parameter) -> str:
    """Names as code, followed by the kind of the value of an option: `-n`, `--num-models` int."""
    names = ", ".join(f"`{name}`" for name in parameter.names)
    return f"{names} {parameter.value}".rstrip() if parameter.is_option else names


def _meaning(parameter: Parameter) -> str:
    notes = f" [{'; '.join(parameter.notes)}]" * bool(parameter.notes)
    return f"{_escaped(parameter.help)}{notes}"


def _first_line(command: Command) -> str:
    return _escaped(command.help.split("\n\n")[0])


def _escaped(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")
