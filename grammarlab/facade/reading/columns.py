"""Columns of tables of labelled boxes, by the names and the orders that programs write."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.tree import Floats
from grammarlab.facade.values import shown
from grammarlab.tables import Table, TableRow

CORNER, SIDES = ("x", "y", "width", "height"), ("left", "bottom", "right", "top")
ENDS, LEFT_TOP = ("xmin", "ymin", "xmax", "ymax"), ("left", "top", "width", "height")
LABEL, IMAGE = "label", "image"
IMAGE_SIZE = ("imagewidth", "imageheight")
_LABELS = ("label", "labelname", "class", "classname", "category", "name", "bezeichnung", "klasse")
_IMAGES = ("filename", "image", "imagename", "imagepath", "imageid", "path", "file", "datei", "bild")
_SHORT = {"w": "width", "h": "height", "x1": "xmin", "y1": "ymin", "x2": "xmax", "y2": "ymax"}
_GERMAN = {"links": "left", "unten": "bottom", "rechts": "right", "oben": "top", "breite": "width", "höhe": "height"}
_OTHER_NAMES = _SHORT | _GERMAN | {f"bbox{name}": name for name in (*CORNER, *ENDS)}
_WITHOUT_HEADER = {
    6: (IMAGE, *ENDS, LABEL),  # RetinaNet
    8: (LABEL, *CORNER, IMAGE, *IMAGE_SIZE),  # makesense.ai
}
"""Columns of tables without a header, by their number."""


@dataclass(frozen=True, slots=True)
class Columns:
    """The columns of a table of boxes."""

    names: tuple[str, ...]
    """Standard names of all columns; those of no use here as they are."""
    sides: tuple[str, ...]
    """The four columns of a box: `CORNER`, `SIDES`, `ENDS` or `LEFT_TOP`."""
    rows: tuple[TableRow, ...]
    """The rows of boxes."""

    def cell(self, row: TableRow, name: str) -> str:
        """The text of a column; empty if the table has no such column."""
        return row.cells[self.names.index(name)] if name in self.names else ""


def columns_of(table: Table) -> Columns | None:
    """The columns of a table; None if it is not one of labelled boxes.

    Raises:
        FacadeError: If a row has another number of cells than the header.
    """
    if not table.rows:
        return None
    names, rows = _standard(table.header), table.body
    sides = next((kind for kind in (SIDES, CORNER, ENDS, LEFT_TOP) if set(kind) <= set(names)), None)
    if sides is None or LABEL not in names:
        names, rows = _WITHOUT_HEADER.get(len(table.header), ()), table.rows
        sides = CORNER if CORNER[0] in names else ENDS
        if not names or not _has_numbers(table, Columns(names, sides, rows)):
            return None
    return Columns(names, sides, tuple(_of_length(row, len(names)) for row in rows))


def box_sides(columns: Columns, table: Table, rows: Sequence[TableRow]) -> Floats:
    """[N, 4] numbers in the four columns of a box.

    Raises:
        FacadeError: If a cell is not a finite number.
    """
    places = [columns.names.index(name) for name in columns.sides]
    return np.array([[_number(row, place, columns, table) for place in places] for row in rows]).reshape(-1, 4)


def _number(row: TableRow, place: int, columns: Columns, table: Table) -> float:
    value = table.number(row.cells[place])
    if value is None:
        raise FacadeError(
            f"Line {row.line}, {columns.names[place]}: expected a finite number, found {shown(row.cells[place])}."
        )
    return value


def _standard(header: Sequence[str]) -> tuple[str, ...]:
    """Standard names of columns."""
    plain = ["".join(filter(str.isalnum, name)) for name in header]
    names = [_OTHER_NAMES.get(name, name) for name in plain]
    for standard, others in ((LABEL, _LABELS), (IMAGE, _IMAGES)):
        first = next((name for name in others if name in names), None)
        if first is not None:
            names[names.index(first)] = standard
    return tuple(names)


def _has_numbers(table: Table, columns: Columns) -> bool:
    """Whether the first row with a label has numbers where a table without header has them."""
    row = next((row for row in columns.rows if len(row.cells) == len(columns.names) and columns.cell(row, LABEL)), None)
    return row is not None and all(table.number(columns.cell(row, side)) is not None for side in columns.sides)


def _of_length(row: TableRow, length: int) -> TableRow:
    """The row without blank cells beyond the header, which spreadsheets write."""
    if len(row.cells) < length or any(row.cells[length:]):
        raise FacadeError(f"Line {row.line}: expected {length} fields, found {len(row.cells)}.")
    return TableRow(row.line, row.cells[:length])
