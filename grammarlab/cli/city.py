"""``grammarlab city``: build, learn and open cities."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from grammarlab.cli.console import Unfinished, friendly_errors, print_json, print_result, progress, say

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
    implicit: Annotated[
        bool, typer.Option("--implicit", help="Write an implicit tileset, whose tree needs no lists of tiles.")
    ] = False,
    workers: Workers = 0,
    as_json: AsJson = False,
) -> None:
    """Build a city from a plan: 3D Tiles, a table of its parcels, and CityJSON.

    What stands on a parcel depends on its id, outline, terrain, attributes and streets, and on nothing else. A stopped
    build goes on where it stopped, and a change costs the squares that it concerns.
    """
    unfinished = Unfinished()
    with friendly_errors(unfinished.advice), progress(unfinished.note) as show:
        from grammarlab.runs.city.build import build_city
        from grammarlab.runs.work.executors import executor_of

        result = build_city(
            plan, output, executor=executor_of(workers), cityjson=cityjson, implicit=implicit, on_progress=show
        )
    _say_remarks(result)
    if as_json:
        print_json(_as_json(result))
    else:
        say(f"{result.num_built:,} of {result.num_parcels:,} parcels built, {result.num_tiles:,} tiles")
        for reason, number in result.empty.items():
            say(f"empty: {number:,} {reason}")
        print_result(result.tileset)


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
