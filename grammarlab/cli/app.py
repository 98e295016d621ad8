"""The commands, by name.

``grammarlab list``.

``grammarlab check``.

``grammarlab format``.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grammarlab.about import __version__
from grammarlab.cli.compare import compare
from grammarlab.cli.console import FAILURE, friendly_errors, print_content, print_json, print_result, say
from grammarlab.cli.evaluate import evaluate
from grammarlab.cli.facade_app import facade
from grammarlab.cli.facade_app import show as show_facade
from grammarlab.cli.facade_edit import edit
from grammarlab.cli.facade_grammar import grammar
from grammarlab.cli.facade_infer import infer
from grammarlab.cli.facade_layers import layers
from grammarlab.cli.facade_match import match, scene
from grammarlab.cli.facade_open import open_facade
from grammarlab.cli.facade_synthesize import synthesize
from grammarlab.cli.label import label
from grammarlab.cli.learn import learn
from grammarlab.cli.numbers import PlainNumbers
from grammarlab.cli.sample import sample
from grammarlab.cli.score import score
from grammarlab.cli.show import show
from grammarlab.errors import UsageError


def list_examples(
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead.")] = False,
) -> None:
    """List the grammars that come with grammarlab."""
    from grammarlab.runs.sample.shipped import shipped_examples

    with friendly_errors():
        examples = shipped_examples()
        if as_json:
            print_json({"examples": [{"name": e.name, "description": e.description()} for e in examples]})
            return
        width = max((len(e.name) for e in examples), default=0)
        for example in examples:
            print_result(f"{example.name:<{width}}  {example.description()}")


def check(
    grammar: Annotated[str, typer.Argument(metavar="FILE", help="A .cga file, or the name of a shipped grammar.")],
    assets: Annotated[
        Path | None, typer.Option("--assets", help="Folder of assets. Default: the asset folder of the rules.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead.")] = False,
) -> None:
    """List all findings about a rule file.

    Findings are errors, unsupported features and warnings. Imported files are included.

    The exit code is 1 if there is an error.
    """
    with friendly_errors():
        from grammarlab.runs.sample.checks import check_source
        from grammarlab.runs.sample.shipped import find_rules

        source = find_rules(grammar, assets)
        file, checked = source.path, check_source(source)
        findings = [finding for checked_file in checked for finding in checked_file.findings]
        counts = {kind: sum(f.severity == kind for f in findings) for kind in ("error", "unsupported", "warning")}
        if as_json:
            print_json({"file": str(file), **counts, "findings": [finding.as_dict() for finding in findings]})
        else:
            for checked_file in checked:
                lines = checked_file.text.splitlines()
                for finding in checked_file.findings:
                    print_result(finding.render(lines) + "\n")
            print_result(_summary(file, counts))
        if counts["error"]:
            raise typer.Exit(FAILURE)


def _summary(file: Path, counts: dict[str, int]) -> str:
    nouns = {"error": "error", "unsupported": "unsupported feature", "warning": "warning"}
    parts = [f"{count} {nouns[kind]}{'s' * (count != 1)}" for kind, count in counts.items() if count]
    return f"{file}: {', '.join(parts) or 'nothing to complain about'}"


def format_file(
    file: Annotated[Path, typer.Argument(help="A .cga file.")],
    check: Annotated[
        bool, typer.Option("--check", help="Exit with 1 if the file would change; write nothing.")
    ] = False,
    in_place: Annotated[bool, typer.Option("--in-place", "-i", help="Write the file instead of printing it.")] = False,
) -> None:
    """Print a rule file in the canonical style, comments included."""
    with friendly_errors():
        from grammarlab.files import rewrite_text
        from grammarlab.language.formatting import format_grammar
        from grammarlab.language.grammar import Grammar, read_text

        if check and in_place:
            raise UsageError("--check and --in-place exclude each other.")
        text = read_text(file)
        formatted = format_grammar(Grammar.parse(text, str(file)))
        changed = formatted != text
        if check:
            say(f"{file}: {'would change' if changed else 'is formatted'}")
            raise typer.Exit(FAILURE if changed else 0)
        if not in_place:
            print_content(formatted)
        elif changed:
            rewrite_text(file, formatted)
            say(f"{file}: formatted")


app = typer.Typer(
    name="grammarlab",
    help="Sample real models from stochastic CGA shape grammars.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # plain help takes half the time
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _print_version(value: bool) -> None:
    if value:
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
