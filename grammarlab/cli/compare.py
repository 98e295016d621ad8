"""``grammarlab compare``."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from grammarlab.cli.console import friendly_errors, print_json, say
from grammarlab.cli.sample import complete_grammar
from grammarlab.learning.targets.distance_words import divergence_share

if TYPE_CHECKING:
    from grammarlab.runs.sample.comparison import Comparison

_MAX_LISTED = 8
"""Largest number of listed branches of a choice, and of listed symbols that only one grammar makes."""


def compare(
    first: Annotated[
        str, typer.Argument(help="A .cga, .toml or .xml file, or a shipped name.", autocompletion=complete_grammar)
    ],
    second: Annotated[
        str, typer.Argument(help="The file to compare with, or a shipped name.", autocompletion=complete_grammar)
    ],
    number: Annotated[
        int, typer.Option("-n", "--number", help="Number of models to sample from each.", min=1, max=100_000)
    ] = (2_500),
    seed: Annotated[int, typer.Option("--seed", help="Seed of the models.", min=0)] = 0,
    picture: Annotated[
        Path | None, typer.Option("--picture", help="PNG file with samples of both, side by side.", dir_okay=False)
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object about the result.")] = False,
) -> None:
    """Measure how far two grammars, or two species, are apart.

    Lists the choices and numbers that differ most.
    """
    with friendly_errors():
        from grammarlab.runs.sample.comparison import compare_files

        result = compare_files(first, second, num_models=number, seed=seed)
        if as_json:
            print_json(_as_json(result))
        else:
            _print_summary(result)
        if picture is not None:
            from grammarlab.runs.learn.report import draw_side_by_side
            from grammarlab.runs.sample.domains import opened
            from grammarlab.runs.work.executor_choice import executor_of

            spaces = [opened(s.suffix, s.text(), s.name, s.assets) for s in result.sources]
            named_spaces = list(zip((first, second), spaces, strict=True))
            draw_side_by_side(named_spaces, picture, side=4, seed=seed, executor=executor_of(0))


def _as_json(result: Comparison) -> dict[str, Any]:
    return {
        "js": result.js,
        "js_at_least": result.at_least,
        "origin": result.origin,
        "choices": [asdict(difference) for difference in result.choices],
        "numbers": [asdict(difference) for difference in result.numbers],
        "differences": [asdict(difference) for difference in result.differences],
        "only_first": list(result.only_first),
        "only_second": list(result.only_second),
    }


def _print_summary(result: Comparison) -> None:
    if result.js is not None:
        origin = f", as trees of {result.origin}" * bool(result.origin)
        say(f"distance: {divergence_share(result.js)}{origin} (100%: no model in common)")
    elif result.are_strangers:
        say("these grammars share nothing: no symbol of one occurs in the models of the other")
    else:
        say(
            f"distance: about {divergence_share(result.at_least)} or more, from the counts of one shared symbol. The "
            "exact value needs a grammar made from the other, or two made from a grammar that grammarlab can find"
        )
    if not result.are_strangers and not (result.choices or result.numbers or result.differences):
        say("no choice or number differs significantly")
    for choice in result.choices:
        say(f"  {divergence_share(choice.js):>6}  {choice.symbol} (line {choice.line})")
        for branch in sorted(choice.branches, key=lambda branch: -abs(branch.second - branch.first))[:_MAX_LISTED]:
            say(f"      {branch.first:6.1%} -> {branch.second:6.1%}  {branch.makes}")
    for number in result.numbers:
        means = f"{number.first:.4g} on average -> {number.second:.4g}"
        say(f"  {divergence_share(number.js):>6}  {number.attribute}: {means}")
    for symbol in () if result.choices or result.numbers else result.differences:
        shares = f"{symbol.first:.1%} of the first, {symbol.second:.1%} of the second"
        say(f"  {divergence_share(symbol.js):>6}  {symbol.symbol}: in {shares}")
    for ordinal, symbols in (("first", result.only_first), ("second", result.only_second)):
        if symbols:
            more = f" and {len(symbols) - _MAX_LISTED} more" if len(symbols) > _MAX_LISTED else ""
            say(f"only the {ordinal} makes: {', '.join(symbols[:_MAX_LISTED])}{more}")
