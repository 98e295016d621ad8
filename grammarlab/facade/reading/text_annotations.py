"""Labelled boxes as tables and as text of YOLO, one box per line.

Tables of one facade: `label,x,y,width,height` or `label,left,bottom,right,top`.

Tables of pictures: a column names the picture. TensorFlow's object detection, RetinaNet (without header), Open Images
(fractions), VoTT, makesense.ai and Roboflow write such tables; they differ in the names and the order of their columns.

YOLO: lines are `class x y width height` with the centre of the box, and perhaps a confidence; or `class x y x y ...`
with the corners of a polygon, all as fractions of the picture. Names of classes are the lines of `classes.txt` or
`obj.names` beside the file; the picture has the name of the file.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.errors import FacadeError, TableError, shown
from grammarlab.facade.reading.annotation import BoxAnnotation, Unit, annotate, check_count
from grammarlab.facade.reading.drawn_shapes import (
    FRACTIONS,
    MOST_CORNERS,
    Shape,
    label_of,
    on_picture,
    polygon,
    sides_around,
    upright,
)
from grammarlab.facade.reading.source import (
    ImageName,
    Source,
    check_only,
    chosen_image,
    coordinate,
    known_size,
    last_part,
)
from grammarlab.facade.values import read_bounded
from grammarlab.tables import Table, TableRow, decoded

_CORNER, _SIDES = ("x", "y", "width", "height"), ("left", "bottom", "right", "top")
_ENDS, _LEFT_TOP = ("xmin", "ymin", "xmax", "ymax"), ("left", "top", "width", "height")
_LABEL, _IMAGE = "label", "image"
_IMAGE_SIZE = ("imagewidth", "imageheight")
_LABELS = ("label", "labelname", "class", "classname", "category", "name", "bezeichnung", "klasse")
_IMAGES = ("filename", "image", "imagename", "imagepath", "imageid", "path", "file", "datei", "bild")
_SHORT = {"w": "width", "h": "height", "x1": "xmin", "y1": "ymin", "x2": "xmax", "y2": "ymax"}
_GERMAN = {"links": "left", "unten": "bottom", "rechts": "right", "oben": "top", "breite": "width", "höhe": "height"}
_OTHER_NAMES = _SHORT | _GERMAN | {f"bbox{name}": name for name in (*_CORNER, *_ENDS)}
_WITHOUT_HEADER = {
    6: (_IMAGE, *_ENDS, _LABEL),  # RetinaNet
    8: (_LABEL, *_CORNER, _IMAGE, *_IMAGE_SIZE),  # makesense.ai
}
"""Columns of tables without a header, by their number."""
_MAX_METRES = 200.0
"""Largest width or height of a facade that a table gives in metres; larger ones are pixels, or a smaller unit."""
_MAX_WHOLE_METRES = 100.0
"""Largest width or height in metres if all numbers are whole: pixels are, and measurements of a building are not."""
_OPEN_IMAGES = {"/m/0d4v4": "window", "/m/02dgv": "door", "/m/03jm5": "house", "/m/0cgh4": "building"}
"""Names of the classes of Open Images that occur on facades."""
_YOLO_CLASS_FILES = ("classes.txt", "obj.names", "labels.txt")
_MOST_CLASS_BYTES = 1 << 20
"""Largest size of a file of classes."""
_PICTURE_SUFFIXES = (".jpg", ".jpeg", ".png")


def is_box_table(table: Table) -> bool:
    """Whether a table has labelled boxes of one facade."""
    columns = _columns_of(table)
    return columns is not None and _IMAGE not in columns.names


def read_box_table(table: Table, source: Source) -> BoxAnnotation:
    """The boxes of a table, in metres; in pixels if they are too large for a facade, with a note.

    With `x,y,width,height` and `left,top,width,height` the corner is the upper left one and y points down, as in
    pictures. With `left,bottom,right,top` y points up if bottom is below top, and down if it is above, the same in all
    lines. With `xmin,ymin,xmax,ymax`, y points down.

    Raises:
        FacadeError: If columns are missing or a line has another form than the others.
    """
    columns = _box_columns(table)
    check_count(len(columns.rows))
    boxes = _boxes_y_up(_box_sides(columns, table, columns.rows), columns.sides)
    unit, notes = _unit(boxes)
    names = [columns.cell(row, _LABEL) for row in columns.rows]
    check_only(source.wall)
    return annotate(boxes, names, unit, notes=notes)


def missing_columns(table: Table) -> str:
    """A message on a table without the columns of boxes."""
    expected = " or ".join(",".join((_LABEL, *kind)) for kind in (_CORNER, _SIDES, _ENDS))
    return f"Line 1: expected the columns {expected}, found {shown(','.join(table.header))}."


def is_picture_table(table: Table) -> bool:
    """Whether a table has labelled boxes and the names of their pictures."""
    columns = _columns_of(table)
    return columns is not None and _IMAGE in columns.names


def read_picture_table(table: Table, source: Source) -> BoxAnnotation:
    """The boxes of one picture, in pixels; as fractions, if no number of the table is above 1.

    Raises:
        FacadeError: If a line has another form than the others, or no label.
        UsageError: If no picture has the name, or the choice is ambiguous.
    """
    columns = _box_columns(table)
    images = list(dict.fromkeys(columns.cell(row, _IMAGE) for row in columns.rows))
    image = images[chosen_image([ImageName(name, name.rpartition(".")[0]) for name in images], source.wall)]
    filled = [row for row in columns.rows if any(columns.cell(row, side) for side in columns.sides)]
    sides = _box_sides(columns, table, filled)
    chosen = [index for index, row in enumerate(filled) if columns.cell(row, _IMAGE) == image]
    check_count(len(chosen))
    rows = [filled[index] for index in chosen]
    fractions = len(sides) > 0 and bool((np.abs(sides) <= 1.0).all())
    shapes = [
        upright(_picture_label(columns, row), *(coordinate(side, f"Line {row.line}") for side in box))
        for row, box in zip(rows, _boxes_y_down(sides[chosen], columns.sides).tolist(), strict=True)
    ]
    size = FRACTIONS if fractions else _picture_size(columns, rows, table)
    picture = image if "." in last_part(image) else f"{image}.jpg"  # Open Images has ids of pictures
    return on_picture(shapes, source, size=size, picture=picture)


def is_yolo(text: str) -> bool:
    """Whether the first line of a text has a class number and at least four numbers."""
    fields = text.lstrip().partition("\n")[0].split()
    return len(fields) >= 5 and fields[0].isdecimal() and all(_is_number(field) for field in fields)


def read_yolo(text: str, source: Source) -> BoxAnnotation:
    """The boxes and polygons of a file.

    Raises:
        FacadeError: If a line has another form.
    """
    lines = [(number, line.split()) for number, line in enumerate(text.splitlines(), start=1) if line.strip()]
    check_count(len(lines))
    classes, notes = _yolo_classes(source)
    shapes = [_yolo_shape(fields, classes, f"Line {number}") for number, fields in lines]
    stem = source.path.stem
    pictures = [stem + suffix for suffix in _PICTURE_SUFFIXES if source.picture_size(stem + suffix)]
    picture = pictures[0] if pictures else f"{stem}.jpg"
    check_only(source.wall)
    return on_picture(shapes, source, size=FRACTIONS, picture=picture, notes=notes)


@dataclass(frozen=True, slots=True)
class _Columns:
    """The columns of a table of boxes."""

    names: tuple[str, ...]
    """Standard names of all columns; those of no use here as they are."""
    sides: tuple[str, ...]
    """The four columns of a box: `_CORNER`, `_SIDES`, `_ENDS` or `_LEFT_TOP`."""
    rows: tuple[TableRow, ...]
    """The rows of boxes."""

    def cell(self, row: TableRow, name: str) -> str:
        """The text of a column; empty if the table has no such column."""
        return row.cells[self.names.index(name)] if name in self.names else ""


def _box_columns(table: Table) -> _Columns:
    """The columns of a table of labelled boxes.

    Raises:
        FacadeError: If it has other columns, or a row has another number of cells than the header.
    """
    columns = _columns_of(table)
    if columns is None:
        raise FacadeError(missing_columns(table))
    return columns


def _columns_of(table: Table) -> _Columns | None:
    """The columns of a table; None if it is not one of labelled boxes.

    Raises:
        FacadeError: If a row has another number of cells than the header.
    """
    if not table.rows:
        return None
    names, rows = _standard_names(table.header), table.body
    sides = next((kind for kind in (_SIDES, _CORNER, _ENDS, _LEFT_TOP) if set(kind) <= set(names)), None)
    if sides is None or _LABEL not in names:
        names, rows = _WITHOUT_HEADER.get(len(table.header), ()), table.rows
        sides = _CORNER if _CORNER[0] in names else _ENDS
        if not names or not _has_numbers(table, _Columns(names, sides, rows)):
            return None
    return _Columns(names, sides, tuple(_of_length(row, len(names)) for row in rows))


def _standard_names(header: Sequence[str]) -> tuple[str, ...]:
    """Standard names of columns."""
    plain = ["".join(filter(str.isalnum, name)) for name in header]
    names = [_OTHER_NAMES.get(name, name) for name in plain]
    for standard, synonyms in ((_LABEL, _LABELS), (_IMAGE, _IMAGES)):
        first = next((name for name in synonyms if name in names), None)
        if first is not None:
            names[names.index(first)] = standard
    return tuple(names)


def _has_numbers(table: Table, columns: _Columns) -> bool:
    """Whether the first row with a label has numbers where a table without header has them."""
    row = next(
        (row for row in columns.rows if len(row.cells) == len(columns.names) and columns.cell(row, _LABEL)), None
    )
    return row is not None and all(table.number(columns.cell(row, side)) is not None for side in columns.sides)


def _of_length(row: TableRow, length: int) -> TableRow:
    """The row without blank cells beyond the header, which spreadsheets write."""
    if len(row.cells) < length or any(row.cells[length:]):
        raise FacadeError(f"Line {row.line}: expected {length} fields, found {len(row.cells)}.")
    return TableRow(row.line, row.cells[:length])


def _boxes_y_up(values: Floats, sides: tuple[str, ...]) -> Floats:
    """[N, 4] left, bottom, right, top with y up."""
    if sides in (_CORNER, _LEFT_TOP):
        left, top, across, down = values.T
        return np.column_stack([left, -top - down, left + across, -top])
    if sides == _ENDS:  # y of the lower side is the larger one
        return values[:, [0, 3, 2, 1]] * [1.0, -1.0, 1.0, -1.0]
    downwards = len(values) > 0 and bool((values[:, 1] >= values[:, 3]).all())
    return values * [1.0, -1.0, 1.0, -1.0] if downwards else values


def _box_sides(columns: _Columns, table: Table, rows: Sequence[TableRow]) -> Floats:
    """[N, 4] numbers in the four columns of a box.

    Raises:
        FacadeError: If a cell is not a finite number.
    """
    column_indices = [columns.names.index(name) for name in columns.sides]
    return np.array([[_cell_number(row, column, columns, table) for column in column_indices] for row in rows]).reshape(
        -1, 4
    )


def _cell_number(row: TableRow, column: int, columns: _Columns, table: Table) -> float:
    value = table.number(row.cells[column])
    if value is None:
        raise FacadeError(
            f"Line {row.line}, {columns.names[column]}: expected a finite number, found {shown(row.cells[column])}."
        )
    return value


def _unit(boxes: Floats) -> tuple[Unit, list[str]]:
    """Metres, or pixels with a note if the facade would be too large."""
    if not len(boxes):
        return "metres", []
    width, height = (boxes[:, 2:].max(axis=0) - boxes[:, :2].min(axis=0)).tolist()
    most = _MAX_WHOLE_METRES if (boxes == np.round(boxes)).all() else _MAX_METRES
    if max(width, height) <= most:
        return "metres", []
    note = f"the boxes extend over {width:g} x {height:g}: too large for a facade in metres, so they are read as pixels"
    return "pixels", [f"{note}; if they are metres, give `width={width:g}`"]


def _picture_label(columns: _Columns, row: TableRow) -> str:
    label = label_of(columns.cell(row, _LABEL), f"Line {row.line}, {_LABEL}")
    return _OPEN_IMAGES.get(label, label)


def _boxes_y_down(values: Floats, sides: tuple[str, ...]) -> Floats:
    """[N, 4] left, top, right, bottom with y down."""
    if sides in (_CORNER, _LEFT_TOP):
        return np.hstack([values[:, :2], values[:, :2] + values[:, 2:]])
    return values if sides == _ENDS else values[:, [0, 3, 2, 1]]


def _picture_size(columns: _Columns, rows: Sequence[TableRow], table: Table) -> tuple[float, float] | None:
    """Width and height of the picture, from the first of its rows; None if the table has no columns for them."""
    if not rows:
        return None
    names = _IMAGE_SIZE if _IMAGE_SIZE[0] in columns.names else ("width", "height")
    if names[0] in columns.sides:
        return None
    return known_size(*(table.number(columns.cell(rows[0], name)) for name in names))


def _is_number(text: str) -> bool:
    try:
        float(text[:100])
    except ValueError:
        return False
    return True


def _yolo_classes(source: Source) -> tuple[list[str], list[str]]:
    """Names of the classes, and a note if they are unknown."""
    for name in _YOLO_CLASS_FILES:
        path = source.path.parent / name
        if path.is_file() and path.resolve().parent == source.path.parent.resolve():
            try:
                return [line.strip() for line in decoded(read_bounded(path, _MOST_CLASS_BYTES)).splitlines()], []
            except TableError as error:
                raise FacadeError(f"{name}: {error}") from error
    return [], [f"classes have numbers only: put their names into {_YOLO_CLASS_FILES[0]} beside the file, one per line"]


def _yolo_shape(fields: list[str], classes: list[str], where: str) -> Shape:
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
    return upright(name, *sides_around(*values[:4]))
