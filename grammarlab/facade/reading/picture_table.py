"""Labelled boxes on pictures as a table: a column names the picture.

TensorFlow's object detection, RetinaNet (without header), Open Images (fractions), VoTT, makesense.ai and Roboflow
write such tables; they differ in the names and the order of their columns.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.boxes.annotation import BoxAnnotation, check_count
from grammarlab.facade.reading.columns import (
    CORNER,
    ENDS,
    IMAGE,
    IMAGE_SIZE,
    LABEL,
    LEFT_TOP,
    Columns,
    box_sides,
    columns_of,
)
from grammarlab.facade.reading.images import ImageName, chosen_image, last_part
from grammarlab.facade.reading.numbers import coordinate, known_size
from grammarlab.facade.reading.shapes import FRACTIONS, label_of, on_picture, upright
from grammarlab.facade.reading.source import Source
from grammarlab.facade.reading.table import missing_columns
from grammarlab.facade.tree import Floats
from grammarlab.tables import Table, TableRow

_OPEN_IMAGES = {"/m/0d4v4": "window", "/m/02dgv": "door", "/m/03jm5": "house", "/m/0cgh4": "building"}
"""Names of the classes of Open Images that occur on facades."""


def is_picture_table(table: Table) -> bool:
    """Whether a table has labelled boxes and the names of their pictures."""
    columns = columns_of(table)
    return columns is not None and IMAGE in columns.names


def read_picture_table(table: Table, source: Source) -> BoxAnnotation:
    """The boxes of one picture, in pixels; as fractions, if no number of the table is above 1.

    Raises:
        FacadeError: If a line has another form than the others, or no label.
        UsageError: If no picture has the name, or the choice is ambiguous.
    """
    columns = columns_of(table)
    if columns is None:
        raise FacadeError(missing_columns(table))
    images = list(dict.fromkeys(columns.cell(row, IMAGE) for row in columns.rows))
    image = images[chosen_image([ImageName(name, name.rpartition(".")[0]) for name in images], source.wall)]
    filled = [row for row in columns.rows if any(columns.cell(row, side) for side in columns.sides)]
    sides = box_sides(columns, table, filled)
    chosen = [index for index, row in enumerate(filled) if columns.cell(row, IMAGE) == image]
    check_count(len(chosen))
    rows = [filled[index] for index in chosen]
    fractions = len(sides) > 0 and bool((np.abs(sides) <= 1.0).all())
    shapes = [
        upright(_label(columns, row), *(coordinate(side, f"Line {row.line}") for side in box))
        for row, box in zip(rows, _from_the_top(sides[chosen], columns.sides).tolist(), strict=True)
    ]
    size = FRACTIONS if fractions else _size(columns, rows, table)
    picture = image if "." in last_part(image) else f"{image}.jpg"  # Open Images has ids of pictures
    return on_picture(shapes, source, size=size, picture=picture)


def _label(columns: Columns, row: TableRow) -> str:
    label = label_of(columns.cell(row, LABEL), f"Line {row.line}, {LABEL}")
    return _OPEN_IMAGES.get(label, label)


def _from_the_top(values: Floats, sides: tuple[str, ...]) -> Floats:
    """[N, 4] left, top, right, bottom with y down."""
    if sides in (CORNER, LEFT_TOP):
        return np.hstack([values[:, :2], values[:, :2] + values[:, 2:]])
    return values if sides == ENDS else values[:, [0, 3, 2, 1]]


def _size(columns: Columns, rows: Sequence[TableRow], table: Table) -> tuple[float, float] | None:
    """Width and height of the picture, from the first of its rows; None if the table has no columns for them."""
    if not rows:
        return None
    names = IMAGE_SIZE if IMAGE_SIZE[0] in columns.names else ("width", "height")
    if names[0] in columns.sides:
        return None
    return known_size(*(table.number(columns.cell(rows[0], name)) for name in names))
