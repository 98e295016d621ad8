"""The commands by name, imported when they are called, so that a command does not wait for all others."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Annotated, Any

import typer

from grammarlab.about import __version__
from grammarlab.cli.numbers import PlainNumbers

_FACADE, _CITY = "facade", "city"
_COMMANDS = {
    "sample": "sample:sample",
    "check": "rule_files:check",
    "list": "rule_files:list_examples",
    "show": "show:show",
    "format": "rule_files:format_file",
    "label": "label:label",
    "score": "score:score",
    "watch": "watch:watch",
    "view": "view:view",
    "learn": "learn:learn",
    "compare": "compare:compare",
    "evaluate": "evaluate:evaluate",
}
"""Module and function of each command, below this package."""
_FACADE_COMMANDS = {
    "read": "facade_read:read",
    "edit": "facade_edit:edit",
    "grammar": "facade_grammar:grammar",
    "open": "facade_open:open_facade",
    "infer": "facade_infer:infer",
    "layers": "facade_layers:layers",
    "match": "facade_match:match",
    "scene": "facade_match:scene",
    "show": "facade_read:show",
    "synthesize": "facade_synthesize:synthesize",
}
_CITY_COMMANDS = {
    "build": "city:build",
    "draw": "city:draw",
    "layout": "city:layout",
    "learn": "city:learn",
    "open": "city_open:open_city",
}
_GROUPS = {
    _FACADE: ("Read, edit and write facades.", _FACADE_COMMANDS),
    _CITY: ("Build cities on maps, and learn their zones.", _CITY_COMMANDS),
}


def app_for(arguments: Sequence[str]) -> typer.Typer:
    """The application with the command that arguments call; with all of them for help, completion and mistakes.

    Args:
        arguments: arguments of the program, without its name.
    """
    app = _group("grammarlab", "Sample real models from stochastic CGA shape grammars.", pretty_exceptions_enable=False)
    app.callback()(grammarlab)
    called = arguments[0] if arguments else ""
    if called not in _GROUPS:
        _add(app, {called: _COMMANDS[called]} if called in _COMMANDS else _COMMANDS)
    if called not in _COMMANDS:
        for name in (called,) if called in _GROUPS else _GROUPS:
            text, commands = _GROUPS[name]
            group = _group(name, text)
            _add(group, commands)
            app.add_typer(group)
    return app


def _group(name: str, text: str, **options: Any) -> typer.Typer:
    return typer.Typer(
        name=name,
        help=text,
        no_args_is_help=True,
        rich_markup_mode=None,  # plain help takes half the time
        context_settings={"help_option_names": ["-h", "--help"]},
        **options,
    )


def _add(app: typer.Typer, commands: Mapping[str, str]) -> None:
    for name, home in commands.items():
        module, function = home.split(":")
        command: Callable[..., Any] = getattr(import_module(f"{__package__}.{module}"), function)
        app.command(name, cls=PlainNumbers)(command)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"grammarlab {__version__}")
        raise typer.Exit


def grammarlab(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Sample real models from stochastic CGA shape grammars."""
