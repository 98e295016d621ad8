"""``grammarlab facade edit``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grammarlab.cli.console import friendly_errors, print_json, print_result, say
from grammarlab.cli.file_kinds import FACADE, expected_kind


def edit(
    file: Annotated[Path, typer.Argument(help="Facade file.", exists=True, dir_okay=False)],
    output: Annotated[
        Path,
        typer.Option("-o", "--output", help="Folder for 001.facade.json, 001.png, 001.svg, ...", file_okay=False),
    ],
    width: Annotated[float | None, typer.Option("--width", help="Metres.")] = None,
    height: Annotated[float | None, typer.Option("--height", help="Metres.")] = None,
    columns: Annotated[int, typer.Option("--columns", help="How many to add (+1) or remove (-1).")] = 0,
    rows: Annotated[int, typer.Option("--rows", help="How many to add (+1) or remove (-1).")] = 0,
    grid: Annotated[str, typer.Option("--grid", help="Grid to change. Default: the one with most elements.")] = "",
    number: Annotated[int, typer.Option("-n", "--number", help="Largest number of results.", min=1, max=200)] = 12,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object about the results.")] = False,
) -> None:
    """Resize a facade; add or remove columns and rows.

    What stands exactly above or beside each other stays so; grids and equal sizes are kept.
    """
    with friendly_errors():
        from grammarlab.facade.editing.edit import edit as edit_facade
        from grammarlab.facade.file import load_locked
        from grammarlab.runs.facade.gallery import save_gallery

        with expected_kind(file, FACADE):
            facade, locks = load_locked(file)
        results = edit_facade(
            facade, width=width, height=height, columns=columns, rows=rows, grid=grid, most=number, locks=locks
        )
        files = save_gallery([result.facade for result in results], output, file, [result.locks for result in results])
        if as_json:
            entries = [{"file": str(path), **variant.as_dict()} for path, variant in zip(files, results, strict=True)]
            print_json({"results": entries})
            return
        for path, variant in zip(files, results, strict=True):
            steps = "; ".join(variant.steps) or "the same columns and rows"
            say(
                f"{variant.facade.width:.2f} x {variant.facade.height:.2f} m, deformed by {variant.energy:.3g}: {steps}"
            )
            if variant.conflict:
                say(f"  in conflict: {'; '.join(variant.conflict)}")
            if variant.faults:
                say(f"  faults: {', '.join(variant.faults)}")
            for words in (*variant.relaxed, *variant.missing):
                say(f"  {words}")
            print_result(path)
