"""Labelled boxes as CSV, one per line: `label,x,y,width,height` or `label,left,bottom,right,top`, in metres.

Fields are separated by commas, semicolons or tabs. If they are not separated by commas, a comma is a decimal point.
"""

from __future__ import annotations

import csv
import io
from itertools import islice

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.boxes.annotation import MOST_BOXES, BoxAnnotation, annotate, check_count
from grammarlab.facade.values import shown

CORNER, SIDES = ("x", "y", "width", "height"), ("left", "bottom", "right", "top")
_ENDS = ("xmin", "ymin", "xmax", "ymax")
_OTHER_NAMES = {"w": "width", "h": "height", "x1": "xmin", "y1": "ymin", "x2": "xmax", "y2": "ymax"}
_SEPARATORS = ",;\t"


def read_table(content: bytes) -> BoxAnnotation:
    """The boxes of a file.

    With `x,y,width,height` the corner is the upper left one and y points down, as in pictures. With
    `left,bottom,right,top` y points up if bottom is below top, and down if it is above, the same in all lines. With
    `xmin,ymin,xmax,ymax`, y points down, as in pictures.

    Raises:
        FacadeError: If columns are missing or a line has another form than the others.
    """
    try:
        text = content.decode("utf-8-sig")
        separator = max(_SEPARATORS, key=text.lstrip().partition("\n")[0].count)
        reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator, strict=True)
        lines = ((reader.line_num, line) for line in reader if any(field.strip() for field in line))
        rows = list(islice(lines, MOST_BOXES + 2))
    except (UnicodeDecodeError, csv.Error) as error:
        raise FacadeError(f"This is not valid CSV: {error}.") from error
    header = [name.strip().lower() for name in rows.pop(0)[1]] if rows else []
    header = [_OTHER_NAMES.get(name, name) for name in header]
    kind = next((some for some in (SIDES, CORNER, _ENDS) if set(some) <= set(header)), None)
    if kind is None or "label" not in header:
        expected = " or ".join(",".join(("label", *some)) for some in (CORNER, SIDES))
        raise FacadeError(f"Line 1: expected the columns {expected}, found {shown(','.join(header))}.")
    check_count(len(rows))
    places = [header.index(name) for name in kind]
    point = "." if separator == "," else ","
    values = np.array([_numbers(row, number, places, header, point) for number, row in rows]).reshape(-1, 4)
    if kind is _ENDS:  # y of the lower side is the larger one
        values = values[:, [0, 3, 2, 1]] * [1.0, -1.0, 1.0, -1.0]
    names = [row[header.index("label")].strip() for _, row in rows]
    return annotate(_from_corner(values) if kind is CORNER else _upright(values), names, "metres")


def _numbers(row: list[str], line: int, places: list[int], header: list[str], point: str) -> list[float]:
    if len(row) != len(header):
        raise FacadeError(f"Line {line}: expected {len(header)} fields, found {len(row)}.")
    found = []
    for place in places:
        try:
            found.append(float(row[place].replace(point, ".")))
        except ValueError:
            message = f"Line {line}, {header[place]}: expected a number, found {shown(row[place])}."
            raise FacadeError(message) from None
    return found


def _from_corner(values: np.ndarray) -> np.ndarray:
    left, top, across, down = values.T
    return np.column_stack([left, -top - down, left + across, -top])


def _upright(values: np.ndarray) -> np.ndarray:
    if len(values) and (values[:, 1] >= values[:, 3]).all():
        return values * np.array([1.0, -1.0, 1.0, -1.0])
    return values
