"""The commands, by name."""

from __future__ import annotations

from typing import Annotated

import typer

from grammarlab.about import __version__
from grammarlab.cli.check import check
from grammarlab.cli.compare import compare
from grammarlab.cli.console.numbers import PlainNumbers
from grammarlab.cli.evaluate import evaluate
from grammarlab.cli.examples import list_examples
from grammarlab.cli.facade.app import facade
from grammarlab.cli.facade.edit import edit
from grammarlab.cli.facade.grammar import grammar
from grammarlab.cli.facade.infer import infer
from grammarlab.cli.facade.layers import layers
from grammarlab.cli.facade.match import match
from grammarlab.cli.facade.open import open_facade
from grammarlab.cli.facade.scene import scene
from grammarlab.cli.facade.show import show as show_facade
from grammarlab.cli.facade.synthesize import synthesize
from grammarlab.cli.format import format_file
from grammarlab.cli.label import label
from grammarlab.cli.learn import learn
from grammarlab.cli.sample import sample
from grammarlab.cli.score import score
from grammarlab.cli.show import show

app = typer.Typer(
    name="grammarlab",
    help="Sample real models from stochastic CGA shape grammars.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # plain help takes half the time
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"grammarlab {__version__}")
        raise typer.Exit


@app.callback()
def grammarlab(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Sample real models from stochastic CGA shape grammars."""


app.command("sample", cls=PlainNumbers)(sample)
app.command("check", cls=PlainNumbers)(check)
app.command("list", cls=PlainNumbers)(list_examples)
app.command("show", cls=PlainNumbers)(show)
app.command("format", cls=PlainNumbers)(format_file)
app.command("label", cls=PlainNumbers)(label)
app.command("score", cls=PlainNumbers)(score)
app.command("learn", cls=PlainNumbers)(learn)
app.command("compare", cls=PlainNumbers)(compare)
app.command("evaluate", cls=PlainNumbers)(evaluate)
facade.command("edit", cls=PlainNumbers)(edit)
facade.command("grammar", cls=PlainNumbers)(grammar)
facade.command("open", cls=PlainNumbers)(open_facade)
facade.command("infer", cls=PlainNumbers)(infer)
facade.command("layers", cls=PlainNumbers)(layers)
facade.command("match", cls=PlainNumbers)(match)
facade.command("scene", cls=PlainNumbers)(scene)
facade.command("show", cls=PlainNumbers)(show_facade)
facade.command("synthesize", cls=PlainNumbers)(synthesize)
app.add_typer(facade)
