"""Labelled boxes as LabelMe JSON: `shapes` of two or more points, in pixels from the top left."""

from __future__ import annotations

from typing import Any

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.boxes.annotation import MOST_BOXES, BoxAnnotation, annotate
from grammarlab.facade.reading.polygons import outline_of
from grammarlab.facade.tree import Floats
from grammarlab.facade.values import a_list, a_number, a_text, an_object, numbers, shown

_SHAPES = ("rectangle", "polygon", "circle", "mask")
_WITHOUT_AREA = ("point", "points", "line", "linestrip")
"""What may be drawn beside them and is no box."""
_CIRCLE_CORNERS = 32
_MOST_POINTS = 10_000


def read_labelme(document: dict[str, Any]) -> BoxAnnotation:
    """The boxes of a file; polygons and circles are outlines inside their boxes; points and lines are left out.

    Of masks, which are pixels in a box given by two corners, only the box is read.

    Raises:
        FacadeError: If the file does not have that form, or has shapes of other kinds.
    """
    height, width = (a_number(document.get(key), key) for key in ("imageHeight", "imageWidth"))
    boxes: list[Floats] = []
    names: list[str] = []
    outlines: list[Floats] = []
    left_out = 0
    for place, each in enumerate(a_list(document.get("shapes"), "shapes", MOST_BOXES)):
        where = f"shapes, entry {place}"
        shape = an_object(each, where)
        if shape.get("shape_type") in _WITHOUT_AREA:
            left_out += 1
            continue
        points = _points(shape, where)
        points[:, 1] = height - points[:, 1]
        boxes.append(np.concatenate([points.min(axis=0), points.max(axis=0)]))
        names.append(a_text(shape.get("label"), f"{where}, label"))
        outlines.append(outline_of(points))
    picture = document.get("imagePath")
    return annotate(
        np.array(boxes).reshape(-1, 4),
        names,
        "pixels",
        outlines=outlines,
        bounds=np.array([[0.0, 0.0], [width, height]]),
        picture=picture if isinstance(picture, str) else "",
        notes=[f"{left_out} points and lines have no area and are left out"] if left_out else [],
    )


def _points(shape: dict[str, Any], where: str) -> Floats:
    kind = shape.get("shape_type", "polygon")
    if kind not in _SHAPES:
        raise FacadeError(f"{where}: expected a shape_type of {', '.join(_SHAPES)}, found {shown(kind)}.")
    points = [
        numbers(each, f"{where}, points", 2) for each in a_list(shape.get("points"), f"{where}, points", _MOST_POINTS)
    ]
    if len(points) < 2:
        raise FacadeError(f"{where}, points: expected at least two corners, found {len(points)}.")
    corners = np.array(points)
    if kind != "circle":
        return corners
    angle = np.linspace(0.0, 2.0 * np.pi, _CIRCLE_CORNERS, endpoint=False)
    around = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return corners[0] + np.hypot(*(corners[1] - corners[0])) * around
