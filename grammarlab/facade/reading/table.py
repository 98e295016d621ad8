"""Labelled boxes of one facade as a table, one per line: `label,x,y,width,height` or `label,left,bottom,right,top`."""

from __future__ import annotations

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.boxes.annotation import BoxAnnotation, Unit, annotate, check_count
from grammarlab.facade.reading.columns import CORNER, ENDS, IMAGE, LABEL, LEFT_TOP, SIDES, box_sides, columns_of
from grammarlab.facade.reading.images import check_only
from grammarlab.facade.reading.source import Source
from grammarlab.facade.tree import Floats
from grammarlab.facade.values import shown
from grammarlab.tables import Table

_LARGEST = 200.0
"""Largest width or height of a facade that a table gives in metres; larger ones are pixels, or a smaller unit."""
_LARGEST_WHOLE = 100.0
"""The same, if all numbers are whole: pixels are, and measurements of a building are not."""


def is_box_table(table: Table) -> bool:
    """Whether a table has labelled boxes of one facade."""
    columns = columns_of(table)
    return columns is not None and IMAGE not in columns.names


def read_box_table(table: Table, source: Source) -> BoxAnnotation:
    """The boxes of a table, in metres; in pixels if they are too large for a facade, with a note.

    With `x,y,width,height` and `left,top,width,height` the corner is the upper left one and y points down, as in
    pictures. With `left,bottom,right,top` y points up if bottom is below top, and down if it is above, the same in all
    lines. With `xmin,ymin,xmax,ymax`, y points down.

    Raises:
        FacadeError: If columns are missing or a line has another form than the others.
    """
    columns = columns_of(table)
    if columns is None:
        raise FacadeError(missing_columns(table))
    check_count(len(columns.rows))
    boxes = _upright(box_sides(columns, table, columns.rows), columns.sides)
    unit, notes = _unit(boxes)
    names = [columns.cell(row, LABEL) for row in columns.rows]
    check_only(source.wall)
    return annotate(boxes, names, unit, notes=notes)


def missing_columns(table: Table) -> str:
    """A message on a table without the columns of boxes."""
    expected = " or ".join(",".join((LABEL, *kind)) for kind in (CORNER, SIDES, ENDS))
    return f"Line 1: expected the columns {expected}, found {shown(','.join(table.header))}."


def _upright(values: Floats, sides: tuple[str, ...]) -> Floats:
    """[N, 4] left, bottom, right, top with y up."""
    if sides in (CORNER, LEFT_TOP):
        left, top, across, down = values.T
        return np.column_stack([left, -top - down, left + across, -top])
    if sides == ENDS:  # y of the lower side is the larger one
        return values[:, [0, 3, 2, 1]] * [1.0, -1.0, 1.0, -1.0]
    downwards = len(values) > 0 and bool((values[:, 1] >= values[:, 3]).all())
    return values * [1.0, -1.0, 1.0, -1.0] if downwards else values


def _unit(boxes: Floats) -> tuple[Unit, list[str]]:
    """Metres, or pixels with a note if the facade would be too large."""
    if not len(boxes):
        return "metres", []
    width, height = (boxes[:, 2:].max(axis=0) - boxes[:, :2].min(axis=0)).tolist()
    most = _LARGEST_WHOLE if (boxes == np.round(boxes)).all() else _LARGEST
    if max(width, height) <= most:
        return "metres", []
    note = f"the boxes extend over {width:g} x {height:g}: too large for a facade in metres, so they are read as pixels"
    return "pixels", [f"{note}; if they are metres, give --width {width:g}"]
