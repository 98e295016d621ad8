"""Labelled boxes as Pascal VOC XML: an element `object` with a `bndbox` each, in pixels from the top left.

Programs add to it: Roboflow a `polygon`, CVAT an attribute `rotation` (degrees), roLabelImg a `robndbox` (radians).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.boxes.annotation import BoxAnnotation, check_count
from grammarlab.facade.reading.images import check_only
from grammarlab.facade.reading.markup import Node, numbers_of
from grammarlab.facade.reading.numbers import coordinate, known_size
from grammarlab.facade.reading.polygons import MOST_CORNERS
from grammarlab.facade.reading.shapes import Shape, label_of, on_picture, polygon, rotated
from grammarlab.facade.reading.source import Source

_SIDES = ("xmin", "ymin", "xmax", "ymax")
_ROTATED = ("cx", "cy", "w", "h", "angle")


def is_voc(root: Node) -> bool:
    """Whether the root is one of Pascal VOC; a file without objects may be of any program that writes this root."""
    objects = root.findall("object")
    return root.tag == "annotation" and all(
        each.find("bndbox") is not None or each.find("robndbox") is not None for each in objects[:1]
    )


def read_voc(root: Node, source: Source) -> BoxAnnotation:
    """The boxes of a file, with their polygons or rotations if it has them; parts of objects are not read.

    Raises:
        FacadeError: If an object has no label or no box.
    """
    objects = root.findall("object")
    check_count(len(objects))
    shapes = [_shape(node, f"object {number}") for number, node in enumerate(objects, start=1)]
    size = known_size(root.findtext("size/width"), root.findtext("size/height"))
    picture = (root.findtext("filename") or "").strip()
    check_only(source.wall, picture)
    return on_picture(shapes, source, size=size, picture=picture)


def _shape(node: Node, where: str) -> Shape:
    name = label_of(node.findtext("name"), f"{where}, name")
    box = node.find("bndbox")
    if box is None:
        return _rotated(node.find("robndbox"), name, where)
    sides = numbers_of(box, _SIDES, f"{where}, bndbox")
    corners = _corners(node.find("polygon"), f"{where}, polygon")
    if len(corners) >= 3:
        return polygon(name, np.array(corners))
    return rotated(name, sides, _rotation(node, where))


def _rotated(box: Node | None, name: str, where: str) -> Shape:
    if box is None:
        raise FacadeError(f"{where}: expected an element bndbox with xmin, ymin, xmax, ymax, found none.")
    across, down, width, height, angle = numbers_of(box, _ROTATED, f"{where}, robndbox")
    sides = (across - width / 2.0, down - height / 2.0, across + width / 2.0, down + height / 2.0)
    return rotated(name, sides, float(np.degrees(angle)))


def _rotation(node: Node, where: str) -> float:
    """The attribute `rotation`, degrees clockwise about the centre."""
    for attribute in node.iterfind("attributes/attribute"):
        if attribute.findtext("name") == "rotation":
            return coordinate(attribute.findtext("value"), f"{where}, rotation")
    return 0.0


def _corners(node: Node | None, where: str) -> Sequence[tuple[float, float]]:
    """Corners from elements x1, y1, x2, y2 and so on."""
    values = {} if node is None else {child.tag: child.text for child in node}
    corners: list[tuple[float, float]] = []
    while (number := len(corners) + 1) <= MOST_CORNERS and f"x{number}" in values:
        across, down = (coordinate(values.get(f"{axis}{number}"), f"{where}, {axis}{number}") for axis in "xy")
        corners.append((across, down))
    return corners
