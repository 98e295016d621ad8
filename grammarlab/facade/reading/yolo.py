"""Labelled boxes as text of YOLO, one per line: a class number, then fractions of the width and height of the picture.

Lines are `class x y width height` with the centre of the box, and perhaps a confidence; or `class x y x y x y ...` with
the corners of a polygon. Names of classes are the lines of `classes.txt` or `obj.names` beside the file; the picture
has the name of the file.
"""

from __future__ import annotations

import numpy as np

from grammarlab.errors import FacadeError, TableError
from grammarlab.facade.boxes.annotation import BoxAnnotation, check_count
from grammarlab.facade.reading.images import check_only
from grammarlab.facade.reading.numbers import coordinate
from grammarlab.facade.reading.polygons import MOST_CORNERS
from grammarlab.facade.reading.shapes import FRACTIONS, Shape, on_picture, polygon, upright
from grammarlab.facade.reading.source import Source
from grammarlab.facade.values import read_bounded, shown
from grammarlab.tables import decoded

_CLASSES = ("classes.txt", "obj.names", "labels.txt")
_MOST_BYTES = 1 << 20
"""Largest size of a file of classes."""
_PICTURES = (".jpg", ".jpeg", ".png")


def is_yolo(text: str) -> bool:
    """Whether the first line of a text has a class number and at least four numbers."""
    fields = text.lstrip().partition("\n")[0].split()
    return len(fields) >= 5 and fields[0].isdecimal() and all(_is_number(field) for field in fields)


def _is_number(text: str) -> bool:
    try:
        float(text[:100])
    except ValueError:
        return False
    return True


def read_yolo(text: str, source: Source) -> BoxAnnotation:
    """The boxes and polygons of a file.

    Raises:
        FacadeError: If a line has another form.
    """
    lines = [(number, line.split()) for number, line in enumerate(text.splitlines(), start=1) if line.strip()]
    check_count(len(lines))
    classes, notes = _classes(source)
    shapes = [_shape(fields, classes, f"Line {number}") for number, fields in lines]
    stem = source.path.stem
    pictures = [stem + suffix for suffix in _PICTURES if source.picture_size(stem + suffix)]
    picture = pictures[0] if pictures else f"{stem}.jpg"
    check_only(source.wall)
    return on_picture(shapes, source, size=FRACTIONS, picture=picture, notes=notes)


def _shape(fields: list[str], classes: list[str], where: str) -> Shape:
    if not fields[0].isdecimal() or len(fields) < 5 or (len(fields) > 6 and len(fields) % 2 == 0):
        raise FacadeError(
            f"{where}: expected a class number and four numbers, or corners, found {shown(' '.join(fields[:9]))}."
        )
    number = int(fields[0]) if len(fields[0]) < 10 else len(classes)
    name = classes[number] if number < len(classes) else f"class {fields[0][:9]}"
    values = [coordinate(field, where) for field in fields[1 : 2 * MOST_CORNERS + 1]]
    if len(values) > 5:
        corners = np.array(values).reshape(-1, 2)
        return polygon(name, corners)
    across, down, width, height = values[:4]
    return upright(name, across - width / 2.0, down - height / 2.0, across + width / 2.0, down + height / 2.0)


def _classes(source: Source) -> tuple[list[str], list[str]]:
    """Names of the classes, and a note if they are unknown."""
    for name in _CLASSES:
        path = source.path.parent / name
        if path.is_file() and path.resolve().parent == source.path.parent.resolve():
            try:
                return [line.strip() for line in decoded(read_bounded(path, _MOST_BYTES)).splitlines()], []
            except TableError as error:
                raise FacadeError(f"{name}: {error}") from error
    return [], [f"classes have numbers only: put their names into {_CLASSES[0]} beside the file, one per line"]
