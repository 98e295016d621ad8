"""Labelled boxes as CSV, one per line: `label,x,y,width,height` or `label,left,bottom,right,top`, in metres."""

from __future__ import annotations

import csv
import io
from itertools import islice

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.boxes.annotation import MOST_BOXES, BoxAnnotation, annotate, check_count
from grammarlab.facade.values import shown

CORNER, SIDES = ("x", "y", "width", "height"), ("left", "bottom", "right", "top")


def read_table(content: bytes) -> BoxAnnotation:
    """The boxes of a file.

    With `x,y,width,height` the corner is the upper left one and y points down, as in pictures. With
    `left,bottom,right,top` y points up if bottom is below top, and down if it is above, the same in all lines.

    Raises:
        FacadeError: If columns are missing or a line has another form than the others.
    """
    try:
        reader = csv.reader(io.StringIO(content.decode("utf-8-sig"), newline=""), strict=True)
        lines = ((reader.line_num, line) for line in reader if any(field.strip() for field in line))
        rows = list(islice(lines, MOST_BOXES + 2))
    except (UnicodeDecodeError, csv.Error) as error:
        raise FacadeError(f"This is not valid CSV: {error}.") from error
    header = [name.strip().lower() for name in rows.pop(0)[1]] if rows else []
    kind = next((some for some in (SIDES, CORNER) if set(some) <= set(header)), None)
    if kind is None or "label" not in header:
        expected = " or ".join(",".join(("label", *some)) for some in (CORNER, SIDES))
        raise FacadeError(f"Line 1: expected the columns {expected}, found {shown(','.join(header))}.")
    check_count(len(rows))
    places = [header.index(name) for name in kind]
    values = np.array([_numbers(row, number, places, header) for number, row in rows]).reshape(-1, 4)
    names = [row[header.index("label")].strip() for _, row in rows]
    return annotate(_upright(values) if kind is SIDES else _from_corner(values), names, "metres")


def _numbers(row: list[str], line: int, places: list[int], header: list[str]) -> list[float]:
    if len(row) != len(header):
        raise FacadeError(f"Line {line}: expected {len(header)} fields, found {len(row)}.")
    found = []
    for place in places:
        try:
            found.append(float(row[place]))
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
