"""New buildings from examples: read, analysed, labelled anew, built, stitched, measured and written."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from grammarlab.errors import FacadeError, UsageError
from grammarlab.facade.file import save_facade
from grammarlab.facade.grammar.family import Range
from grammarlab.facade.values import UNITS, a_list, parse_json, read_bounded
from grammarlab.files import check_overwrites, write_bytes, write_text
from grammarlab.runs.facade.gallery import png_of, sheet
from grammarlab.runs.work.run_folder import only_run_in, replace_written
from grammarlab.synthesis.analysis.correction import corrected, dumps
from grammarlab.synthesis.analysis.example import MOST_LINES, Example, analyse
from grammarlab.synthesis.assembly import facade_of, facade_of_tiling
from grammarlab.synthesis.building_grammar import BuildingRules, building_rules
from grammarlab.synthesis.built import Box, Built, NewBuildings, Stopwatch, check_size, family_of, new_buildings
from grammarlab.synthesis.example_pictures import building_picture, label_picture
from grammarlab.synthesis.label_grid import LabelGrid, Labels, Wishes, single_units
from grammarlab.synthesis.label_synthesis import NO_WISHES, Method
from grammarlab.synthesis.mesh.building_files import read_mesh, write_glb
from grammarlab.synthesis.mesh.surface import edge_numbers
from grammarlab.synthesis.units import UnitStock

_ASSETS = "assets"
"""Folder of the meshes of rules."""


@dataclass(frozen=True, kw_only=True, slots=True)
class SynthesisRequest:
    """A request for new buildings."""

    rows: int
    """Rows and columns of the main wall; those of other walls follow from their room."""
    columns: int
    box: Box = (None, None, None)
    """Width, height and depth in metres; None for those that follow from the units."""
    method: Method = "exact"
    wishes: Wishes = NO_WISHES
    """Wishes for the main wall."""
    regions: Path | None = None
    """File of a map from parts of the main wall to examples."""
    seed: int = 0
    """Seed of all random choices."""
    count: int = 1
    """Largest number of buildings."""
    up: str = ""
    """`y` or `z`; detected if empty."""
    unit: str = "m"
    """Unit of files: a key of `UNITS`."""
    corrections: tuple[Path, ...] = ()
    """Corrected files of earlier runs, for the first example and those after it, with lines and labels."""
    widths: Range | None = None
    """Widths of the main walls of the family, metres; about those of the example and the first result if None."""
    heights: Range | None = None


def synthesize_buildings(files: Sequence[Path], folder: Path, task: SynthesisRequest) -> dict[str, Any]:
    """Write new buildings similar to those in some files, best first, and report on them.

    Args:
        files: meshes: the example, and others whose main walls also provide units.
        folder: where to write.
        task: the request.

    Raises:
        UsageError: If rows, columns, a box or a map are out of range, or a file would be overwritten.
        FacadeError: If a file cannot be read, no units are found, or wishes contradict each other.
    """
    check_size(task.rows, task.columns, task.box)
    if len(task.corrections) > len(files):
        raise UsageError(f"`corrections=`: expected at most {len(files)} files, one for each building; found more.")
    check_overwrites(folder.glob("[0-9][0-9][0-9].glb"), files)
    regions = _read_regions(task.regions, task.rows, task.columns, len(files)) if task.regions else None
    watch = Stopwatch()
    with watch("read"):
        meshes = [read_mesh(file, UNITS[task.unit]) for file in files]
    with watch("analysis"):
        examples = [analyse(mesh, task.up) for mesh in meshes]
        for index, corrections in enumerate(task.corrections):
            examples[index] = corrected(examples[index], corrections)
    new = new_buildings(
        examples,
        task.rows,
        task.columns,
        box=task.box,
        method=task.method,
        wishes=task.wishes,
        regions=regions,
        seed=task.seed,
        count=task.count,
        before=edge_numbers(meshes[0].surface),
        seconds=watch.seconds,
    )
    example = examples[0]
    with watch("pictures"):
        picture = building_picture(example.surface.moved(example.bent(example.surface.points)), example.mesh.colors)
    with only_run_in(folder, (_ASSETS,)):
        written: list[Path] = []
        results = _write_all(new, folder, picture, written)
        family, family_notes = _write_family(new, folder, task, written)
        replace_written(folder, "synthesize", written, [*files, *task.corrections])
    notes = []
    for file, analysed in zip(files, examples, strict=True):
        about_it = (*analysed.notes, *_repetition_notes(analysed.main.grid))
        notes += [f"{file.name}: {note}" if len(files) > 1 else note for note in about_it]
    if task.method == "em" and task.wishes != NO_WISHES:
        notes.append("method em ignores wishes; energies include the violations")
    return {
        "example": _example_dict(example, folder),
        "results": results,
        "family": family,
        "notes": notes + family_notes,
    }


def _repetition_notes(grid: LabelGrid) -> tuple[str, ...]:
    """A statement in words where most units occur once, so that nothing in the example says what may be repeated."""
    num_single, num_units = single_units(grid)
    if 2 * num_single <= num_units:
        return ()
    note = (
        f"{num_single} of {num_units} units of the main wall occur once, so little in it can be repeated; if units "
        "that look equal have different labels in example.json, correct its lines and labels, in the file or by "
        "`grammarlab facade open`, and give the file by `--example`"
    )
    return (note,)


def _read_regions(path: Path, rows: int, columns: int, examples: int) -> Labels:
    """[rows, columns] index of the example of each cell, from 0.

    The file is a JSON array of rows, the lowest first, each an array of numbers from 1. It is stretched over the wall
    if it has other numbers of rows and columns.

    Raises:
        FacadeError: If it is not such a map.
    """
    try:
        cells = [a_list(row, "row", MOST_LINES) for row in a_list(parse_json(read_bounded(path)), "map", MOST_LINES)]
    except FacadeError as error:
        raise FacadeError(f"{path.name}: {error}") from error
    if not cells or not cells[0] or len({len(row) for row in cells}) > 1:
        raise FacadeError(f"{path.name}: expected rows of one length, such as [[1, 1, 2], [1, 1, 2]].")
    for row in cells:
        for number in row:
            if isinstance(number, bool) or not isinstance(number, int) or not 1 <= number <= examples:
                raise FacadeError(f"{path.name}: expected examples 1 to {examples}, found {number!r:.40}.")
    regions = np.array(cells, dtype=np.int64) - 1
    indices = [
        (2 * np.arange(new) + 1) * old // (2 * new) for new, old in ((rows, len(cells)), (columns, len(cells[0])))
    ]
    return regions[np.ix_(*indices)]


def _write_all(new: NewBuildings, folder: Path, picture: Image.Image, written: list[Path]) -> list[dict[str, Any]]:
    """Write the examples and all buildings; adds the files to `written`, and returns values for `--json`."""
    written.append(save_facade(facade_of(new.examples[0].main), folder / "example.facade.json"))
    for number, example in enumerate(new.examples, start=1):
        path = folder / f"example{f'-{number}' if number > 1 else ''}.json"
        write_text(path, dumps(example))
        written.append(path)
    return [
        {**building.as_dict(), "files": _write(building, new.stock, folder, f"{number:03}", picture, written)}
        for number, building in enumerate(new.built, start=1)
    ]


def _write(
    built: Built, stock: UnitStock, folder: Path, name: str, picture: Image.Image, written: list[Path]
) -> dict[str, Any]:
    """Write the files of one building; adds them to `written`."""
    watch = Stopwatch()
    files = {
        "glb": folder / f"{name}.glb",
        "labels": folder / f"{name}.labels.png",
        "facade": folder / f"{name}.facade.json",
        "cga": folder / f"{name}.cga",
        "picture": folder / f"{name}.png",
    }
    with watch("files"):
        write_glb(built.surface, stock.colors, files["glb"])
        save_facade(facade_of_tiling(built.tilings[0], built.stretch), files["facade"])
        rules = building_rules(
            stock.cut,
            built.tilings,
            built.stretch,
            stock.colors,
            f"A building of {built.main.grid.rows} rows and {built.main.grid.columns} columns of units",
        )
        written += [*files.values(), *_write_rules(rules, stock, files["cga"])]
    with watch("pictures"):
        grids = [label_picture(grid) for grid in (stock.walls[0].grid, built.main.grid)]
        write_bytes(files["labels"], png_of(grids[1]))
        result_picture = building_picture(built.surface, stock.colors)
        write_bytes(files["picture"], png_of(sheet([picture, grids[0], grids[1], result_picture])))
    built.seconds.update(watch.seconds)
    return {key: str(path) for key, path in files.items()}


def _write_rules(rules: BuildingRules, stock: UnitStock, file: Path) -> list[Path]:
    """Write rules, and their meshes into the folder beside them; returns the meshes."""
    write_text(file, rules.text)
    assets = file.parent / _ASSETS
    assets.mkdir(exist_ok=True)
    for terminal in rules.terminals:
        write_glb(terminal.surface, stock.colors, assets / terminal.name)
    return [assets / terminal.name for terminal in rules.terminals]


def _write_family(
    new: NewBuildings, folder: Path, task: SynthesisRequest, written: list[Path]
) -> tuple[dict[str, Any] | None, list[str]]:
    """Write rules of the best building in other sizes, and report on them; None and the reason if there are none."""
    file = folder / "family.cga"
    try:
        family, rules = family_of(new, task.widths, task.heights)
    except FacadeError as error:
        return None, [f"no family: {error}"]
    written += [file, *_write_rules(rules, new.stock, file)]
    sizes = [size for ends in family.columns.values() for size in ends]
    return {
        "file": str(file),
        "facades": family.facades,
        "columns": [min(family.columns), max(family.columns)],
        "widths": [min(sizes), max(sizes)],
        "rows": {name: list(ends) for name, ends in family.rows.items()},
    }, []


def _example_dict(example: Example, folder: Path) -> dict[str, Any]:
    """Values for `--json`: the analysis of the example."""
    return {
        "triangles": len(example.surface),
        "rows": example.main.grid.rows,
        "columns": example.main.grid.columns,
        "labels": example.main.grid.labels.tolist(),
        "names": list(example.main.grid.names),
        "facade": str(folder / "example.facade.json"),
        "corrections": str(folder / "example.json"),
        "walls": [
            {
                "name": region.name,
                "rows": region.grid.rows,
                "columns": region.grid.columns,
                "labels": region.grid.labels.tolist(),
                "names": list(region.grid.names),
                "pitch": [region.columns.pitch, region.rows.pitch],
                "regular": [region.columns.is_regular, region.rows.is_regular],
            }
            for region in example.regions
        ],
    }
