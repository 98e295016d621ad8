"""Labelled shapes as LabelMe JSON: `shapes` of two or more points, in pixels from the top left.

X-AnyLabeling writes the same form, with rectangles of four corners and rotated ones of the type `rotation`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.boxes.annotation import MOST_BOXES, BoxAnnotation
from grammarlab.facade.reading.images import check_only
from grammarlab.facade.reading.left_out import box_only_notes
from grammarlab.facade.reading.numbers import coordinate, known_size
from grammarlab.facade.reading.polygons import MOST_CORNERS
from grammarlab.facade.reading.shapes import Shape, ellipse, label_of, on_picture, polygon, upright
from grammarlab.facade.reading.source import Source
from grammarlab.facade.tree import Floats
from grammarlab.facade.values import a_list, an_object, numbers, shown

_ROTATED = ("oriented_rectangle", "rotation")
_SHAPES = ("rectangle", *_ROTATED, "polygon", "circle", "mask")
_WITHOUT_AREA = ("point", "points", "line", "linestrip")
"""What may be drawn beside them and is no box."""


def is_labelme(document: Any) -> bool:
    """Whether a JSON document is one of LabelMe."""
    return isinstance(document, dict) and "shapes" in document


def read_labelme(document: dict[str, Any], source: Source) -> BoxAnnotation:
    """The boxes of a file; polygons and circles are outlines inside their boxes; points and lines are left out.

    Of masks, which are pixels in a box given by two corners, only the box is read.

    Raises:
        FacadeError: If the file does not have that form, or has shapes of other kinds.
    """
    shapes: list[Shape] = []
    left_out = num_masks = 0
    for position, entry in enumerate(a_list(document.get("shapes"), "shapes", MOST_BOXES)):
        where = f"shapes, entry {position}"
        kind = an_object(entry, where).get("shape_type") or "polygon"
        if kind in _WITHOUT_AREA:
            left_out += 1
        else:
            shapes.append(_shape(entry, kind, where))
            num_masks += kind == "mask"
    path = document.get("imagePath")
    picture = path if isinstance(path, str) else ""
    check_only(source.wall, picture)
    notes = [f"{left_out} points and lines have no area and are left out"] if left_out else []
    return on_picture(
        shapes,
        source,
        size=known_size(document.get("imageWidth"), document.get("imageHeight")),
        picture=picture,
        notes=[*notes, *box_only_notes(num_masks)],
    )


def _shape(shape: dict[str, Any], kind: Any, where: str) -> Shape:
    if kind not in _SHAPES:
        raise FacadeError(f"{where}: expected a shape_type of {', '.join(_SHAPES)}, found {shown(kind)}.")
    name = label_of(shape.get("label"), f"{where}, label")
    corners = _points(shape, where)
    if kind == "circle":
        radius = float(np.hypot(*(corners[1] - corners[0])))
        return ellipse(name, (float(corners[0, 0]), float(corners[0, 1])), (radius, radius))
    if kind == "rectangle" and len(corners) == 2:  # its two corners may be any opposite ones
        (left, top), (right, bottom) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
        return upright(name, left, top, right, bottom)
    return polygon(name, corners, rectangle=kind in _ROTATED)


def _points(shape: dict[str, Any], where: str) -> Floats:
    points = [
        [coordinate(each, f"{where}, points") for each in numbers(point, f"{where}, points", 2)]
        for point in a_list(shape.get("points"), f"{where}, points", MOST_CORNERS)
    ]
    if len(points) < 2:
        raise FacadeError(f"{where}, points: expected at least two corners, found {len(points)}.")
    return np.array(points)
