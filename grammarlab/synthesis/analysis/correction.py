"""The analysis of an example as a JSON file for correction: lines between units, and their labels.

Walls that are missing in the file are stretched with the rest; docs/synthesis/file.md describes the format.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.errors import FacadeError
from grammarlab.facade.lattice import Lattice
from grammarlab.facade.values import a_list, a_text, an_object, numbers, parse_json, read_bounded
from grammarlab.synthesis.analysis.example import MOST_LINES, Example, Region
from grammarlab.synthesis.label_grid import LabelGrid

FORMAT, VERSION = "grammarlab example", 1
_MIN_DISTANCE_M = 0.05
"""Least distance of lines, metres."""


def dumps(example: Example) -> str:
    """The text of a file: one line per row of labels, the lowest row first."""
    walls = [_wall_text(region) for region in example.regions]
    return f'{{"format": "{FORMAT}", "version": {VERSION}, "walls": [\n' + ",\n".join(walls) + "\n]}\n"


def corrected(example: Example, path: Path) -> Example:
    """The example with the lines and labels of a file.

    Raises:
        FacadeError: If the file is not an example file, or does not fit the example; with the position of the mistake.
    """
    try:
        return with_corrections(example, an_object(parse_json(read_bounded(path)), "file"))
    except FacadeError as error:
        raise FacadeError(f"{path.name}: {error}") from error


def with_corrections(example: Example, document: dict[str, Any]) -> Example:
    """The example with the content of such a file.

    Raises:
        FacadeError: See `corrected`.
    """
    return replace(example, regions=_regions(example, document))


def _regions(example: Example, document: dict[str, Any]) -> tuple[Region, ...]:
    """The walls of a file, in the order of the example."""
    if document.get("format") != FORMAT or document.get("version") != VERSION:
        raise FacadeError(f'expected "format": "{FORMAT}" and "version": {VERSION}.')
    walls = [an_object(wall, "walls") for wall in a_list(document.get("walls"), "walls", 1_000)]
    names = [a_text(wall.get("name"), "walls, name") for wall in walls]
    wall_names = [region.name for region in example.regions]
    for name in names:
        if name not in wall_names:
            raise FacadeError(f"unknown wall {name!r}; expected one of {', '.join(wall_names)}.")
    if len(set(names)) < len(names) or example.main.name not in names:
        raise FacadeError(f"expected each wall once, and the main wall {example.main.name!r} among them.")
    return tuple(_region(region, walls[names.index(region.name)]) for region in example.regions if region.name in names)


def _wall_text(region: Region) -> str:
    names = [[region.grid.names[label] for label in row] for row in region.grid.labels.tolist()]
    rows = ",\n   ".join(json.dumps(row_names) for row_names in names)
    lines = {
        key: json.dumps([round(float(position), 4) for position in lattice.line])
        for key, lattice in (("columns", region.columns), ("rows", region.rows))
    }
    return (
        f' {{"name": {json.dumps(region.name)},\n  "columns": {lines["columns"]},\n  "rows": {lines["rows"]},\n'
        f'  "labels": [\n   {rows}]}}'
    )


def _region(region: Region, wall: dict[str, Any]) -> Region:
    middle = (region.elements[:, :2] + region.elements[:, 2:]) / 2.0
    columns = _lattice(wall.get("columns"), f"{region.name}, columns", middle[:, 0], region.columns)
    rows = _lattice(wall.get("rows"), f"{region.name}, rows", middle[:, 1], region.rows)
    label_names = [
        [a_text(name, f"{region.name}, labels") for name in a_list(row, f"{region.name}, labels", MOST_LINES)]
        for row in a_list(wall.get("labels"), f"{region.name}, labels", MOST_LINES)
    ]
    if len(label_names) != len(rows) or any(len(row) != len(columns) for row in label_names):
        raise FacadeError(
            f"{region.name}, labels: expected {len(rows)} rows of {len(columns)} names: one between any two lines."
        )
    names = tuple(dict.fromkeys(name for row in label_names for name in row))
    labels = np.array([[names.index(name) for name in row] for row in label_names], dtype=np.int64)
    inside = (columns.member >= 0) & (rows.member >= 0)
    return replace(
        region,
        columns=replace(columns, member=columns.member[inside]),
        rows=replace(rows, member=rows.member[inside]),
        elements=region.elements[inside],
        whole=region.whole[inside],
        grid=LabelGrid.from_labels(labels, names),
    )


def _lattice(value: Any, where: str, middle: Floats, previous: Lattice) -> Lattice:
    """Lines of a file; elements outside of them belong to no cell."""
    count = len(a_list(value, where, MOST_LINES + 1))
    line = np.array(numbers(value, where, count), dtype=np.float64)
    if count < 2 or not np.isfinite(line).all() or (np.diff(line) < _MIN_DISTANCE_M).any():
        raise FacadeError(
            f"{where}: expected 2 or more positions in metres, at least {_MIN_DISTANCE_M:g} m apart, ascending."
        )
    same = count == len(previous.line) and np.abs(line - previous.line).max() < 1e-3
    # Unchanged positions keep their exact values, since the file has them rounded to a tenth of a millimetre.
    line = previous.line if same else line
    member = np.searchsorted(line, middle) - 1
    member[(middle < line[0]) | (middle > line[-1])] = -1
    if same:
        return replace(previous, member=member)
    pitch = np.diff(line)
    regular = bool(np.ptp(pitch) <= 0.06 * pitch.mean())
    return Lattice(line, float(pitch.mean()) if count > 2 else 0.0, regular, member)
