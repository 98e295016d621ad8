"""``grammarlab city build``, ``layout``, ``learn`` and ``draw``."""

from __future__ import annotations

from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from grammarlab.cli.console import Scheduler, Unfinished, friendly_errors, print_json, print_result, say
from grammarlab.cli.progress import progress

if TYPE_CHECKING:
    from grammarlab.runs.city.build import CityResult

_MOST_SHOWN = 8
"""Largest number of remarks and messages that are printed."""
PlanFile = Annotated[
    Path, typer.Argument(help="Plan of the city (.toml): parcels and zones.", exists=True, dir_okay=False)
]
Workers = Annotated[int, typer.Option("--workers", help="Number of processes; 0 for one per core.", min=0)]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object about the result.")]


def build(
    plan: PlanFile,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder of the city.", file_okay=False)],
    cityjson: Annotated[
        bool, typer.Option("--cityjson", help="Write city.city.jsonl (CityJSONSeq 2.0) as well.")
    ] = False,
    cityjson_lods: Annotated[
        str,
        typer.Option(
            "--cityjson-lods", help="Write city.city.jsonl with some levels of detail only: a list of 1, 2 and 3 (1,2)."
        ),
    ] = "",
    implicit: Annotated[
        bool, typer.Option("--implicit", help="Write an implicit tileset, whose tree needs no lists of tiles.")
    ] = False,
    workers: Workers = 0,
    scheduler: Scheduler = "",
    as_json: AsJson = False,
) -> None:
    """Build a city from a plan: 3D Tiles, a table of its parcels, and CityJSON.

    What stands on a parcel depends on its id, outline, terrain, attributes and streets, and on nothing else. A stopped
    build goes on where it stopped, and a change costs the squares that it concerns.
    """
    unfinished = Unfinished()
    with friendly_errors(unfinished.advice), progress(unfinished.note, as_json=as_json) as show:
        from grammarlab.export.cityjson import LEVELS, levels_of
        from grammarlab.runs.city.build import build_city
        from grammarlab.runs.work.executor_choice import executor_of

        levels = levels_of(cityjson_lods) if cityjson_lods else LEVELS if cityjson else ()
        executor = executor_of(workers, scheduler, say)
        result = build_city(plan, output, executor=executor, cityjson=levels, implicit=implicit, on_progress=show)
    _say_remarks(result)
    if as_json:
        print_json(_as_json(result))
    else:
        say(f"{result.num_built:,} of {result.num_parcels:,} parcels built, {result.num_tiles:,} tiles")
        for reason, number in result.empty.items():
            say(f"empty: {number:,} {reason}")
        print_result(result.tileset if result.num_tiles else result.table)


def layout(
    plan: PlanFile,
    output: Annotated[Path, typer.Option("-o", "--output", help="Map of the parcels (.geojson).", dir_okay=False)],
    streets: Annotated[
        Path | None, typer.Option("--streets", help="Map of the streets (.geojson) as well.", dir_okay=False)
    ] = None,
    picture: Annotated[
        Path | None, typer.Option("--picture", help="Picture of the layout (.png) as well.", dir_okay=False)
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Write the parcels of a plan without a map, to be edited and read as a map."""
    with friendly_errors():
        from grammarlab.city.layout_file import write_parcels, write_streets
        from grammarlab.city.plan import read_plan
        from grammarlab.errors import UsageError
        from grammarlab.runs.city.survey import layout_of

        read = read_plan(plan)
        if read.layout is None:
            raise UsageError(f"{plan}: expected [layout], found a map of parcels, which is there already.")
        made = layout_of(read.layout, read.crs)
        write_parcels(made, output)
        if streets is not None:
            write_streets(made, streets)
        if picture is not None:
            from grammarlab.runs.city.layout_picture import write_layout_picture

            write_layout_picture(made, picture)
        if as_json:
            print_json({"file": str(output), "parcels": len(made.parcels), "streets": len(made.streets)})
        else:
            say(f"{len(made.parcels):,} parcels along {len(made.streets):,} streets")
            print_result(output)


def learn(
    plan: PlanFile,
    answers: Annotated[
        Path | None,
        typer.Option(
            "--answers",
            help="Table of answers: id,zone or id,zone,score. Default: name the parcels to ask about first.",
            exists=True,
            dir_okay=False,
        ),
    ] = None,
    trees: Annotated[
        bool, typer.Option("--trees", help="Learn species of trees from the map of trees of the plan instead.")
    ] = False,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", help="File of the zones or trees. Default: the one that the plan names.", dir_okay=False
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Learn where the zones of a plan are from right zones, or scores of zones, of a few parcels.

    With --trees: learn which species of trees stand where, and how densely, from a map of trees.
    """
    if trees:
        _learn_trees(plan, answers, output, as_json=as_json)
        return
    with friendly_errors():
        from grammarlab.runs.city.learn import learn_zones, questions

        if answers is None:
            first = questions(plan)
            if as_json:
                print_json({"questions": list(first)})
            else:
                say("parcels to ask about first:")
                for name in first:
                    print_result(name)
            return
        result = learn_zones(plan, answers, output)
        if result.unknown:
            say(f"left out: {len(result.unknown):,} answers about unknown parcels, such as {result.unknown[0]}")
        if as_json:
            print_json(result.as_json())
            return
        decides = ", ".join(f"{name} {share:.0%}" for name, share in result.decides.items()) or "nothing yet"
        say(f"{result.num_answers:,} answers; what decides: {decides}")
        if result.questions:
            say(f"most is learned from answers about: {', '.join(result.questions[:_MOST_SHOWN])}")
        print_result(result.file)


def _learn_trees(plan: Path, answers: Path | None, output: Path | None, *, as_json: bool) -> None:
    with friendly_errors():
        from grammarlab.errors import UsageError
        from grammarlab.runs.city.learn_trees import learn_trees, listed

        if answers is not None:
            raise UsageError("expected either --answers or --trees, found both: species are learned from a map.")
        result = learn_trees(plan, output)
        if as_json:
            print_json(result.as_json())
            return
        counts = ", ".join(f"{number:,} {Path(name).stem}" for name, number in result.trees.items())
        say(f"{sum(result.trees.values()):,} trees on {result.hectares:,.0f} hectares: {counts}")
        if result.unknown:
            say(f"left out, {sum(result.unknown.values()):,} trees of no species: {listed(result.unknown.items())}")
        print_result(result.file)


def draw(
    plan: PlanFile,
    output: Annotated[Path, typer.Option("-o", "--output", help="Picture (.png or .jpg).", dir_okay=False)],
    at: Annotated[
        str,
        typer.Option(
            "--at", help="Look from the street: EAST,NORTH,BEARING in metres and degrees. Default: from above."
        ),
    ] = "",
    size: Annotated[str, typer.Option("--size", help="Width and height in pixels.")] = "1600x900",
) -> None:
    """Draw the city of a plan, from above or from the street."""
    with friendly_errors():
        from grammarlab.runs.city.picture import ABOVE, StreetView, draw_city

        view = StreetView(*_numbers(at, ",", 3, "--at", "120,80,45")) if at else ABOVE
        width, height = (int(number) for number in _numbers(size, "x", 2, "--size", "1600x900"))
        draw_city(plan, output, view=view, size=(width, height))
        print_result(output)


def _numbers(text: str, separator: str, count: int, option: str, example: str) -> list[float]:
    """Numbers of an option.

    Raises:
        UsageError: If it has others.
    """
    from grammarlab.errors import UsageError

    parts = text.split(separator)
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        numbers = []
    if len(numbers) != count or not all(map(isfinite, numbers)):
        raise UsageError(f"{option}: expected {count} numbers such as {example}, found {text!r:.60}.")
    return numbers


def _as_json(result: CityResult) -> dict[str, Any]:
    return {
        "parcels": result.num_parcels,
        "built": result.num_built,
        "empty": dict(result.empty),
        "tiles": result.num_tiles,
        "seconds": round(result.seconds, 3),
        "reused_shards": result.num_reused,
        "most_draws": result.most_draws,
        "failures": dict(result.failures),
        "missing_assets": list(result.missing_assets),
        "remarks": [str(remark) for remark in result.remarks],
    }


def _say_remarks(result: CityResult) -> None:
    lines = [str(remark) for remark in result.remarks]
    lines += [f"parcel {name}: {message}" for name, message in result.failures.items()]
    lines += [f"missing mesh: {path}" for path in result.missing_assets]
    for line in lines[:_MOST_SHOWN]:
        say(line)
    if len(lines) > _MOST_SHOWN:
        say(f"… and {len(lines) - _MOST_SHOWN:,} more")
