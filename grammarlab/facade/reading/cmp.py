"""Annotations of the CMP facade database: XML whose `x` points down the picture and whose `y` points across it."""

from __future__ import annotations

from pathlib import PurePath

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.boxes.annotation import BoxAnnotation, annotate, check_count
from grammarlab.facade.reading.markup import Node, parse_xml

UNIT_SQUARE = np.array([[0.0, 0.0], [1.0, 1.0]])


def read_cmp(content: bytes, name: str) -> BoxAnnotation:
    """Boxes as fractions of the picture, whose file has the same name and the suffix `.jpg`.

    Args:
        content: the file: elements `object`, with or without an element around them.
        name: name of the file.

    Raises:
        FacadeError: If it is not such a file.
    """
    objects = list(parse_xml(content, fragments=True).iter("object"))
    if not objects:
        raise FacadeError(
            'This is XML with no elements "object", or no XML; the CMP facade database has one box in each.'
        )
    check_count(len(objects))
    boxes = np.array([_box(each, number) for number, each in enumerate(objects, start=1)])
    names = [(each.findtext("labelname") or "").strip() for each in objects]
    return annotate(boxes, names, "parts", bounds=UNIT_SQUARE, picture=f"{PurePath(name).stem}.jpg")


def _box(node: Node, number: int) -> list[float]:
    """Left, bottom, right, top; the two values of an axis may be in either order."""
    down, across = _interval(node, "x", number), _interval(node, "y", number)
    return [across[0], 1.0 - down[1], across[1], 1.0 - down[0]]


def _interval(node: Node, axis: str, number: int) -> list[float]:
    texts = [(each.text or "").strip() for each in node.findall(f"points/{axis}")]
    try:
        values = sorted(float(text) for text in texts)
    except ValueError:
        values = []
    if len(values) != 2:
        raise FacadeError(f"Object {number}: expected two numbers <{axis}> in <points>, found {texts[:4]}.")
    return values
