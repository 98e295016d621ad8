"""Annotations of the CMP facade database: XML whose `x` points down the picture and whose `y` points across it."""

from __future__ import annotations

from grammarlab.errors import FacadeError
from grammarlab.facade.boxes.annotation import BoxAnnotation, check_count
from grammarlab.facade.reading.images import check_only
from grammarlab.facade.reading.markup import Node
from grammarlab.facade.reading.numbers import coordinate
from grammarlab.facade.reading.shapes import FRACTIONS, Shape, on_picture, upright
from grammarlab.facade.reading.source import Source


def is_cmp(root: Node) -> bool:
    """Whether an element has objects of the CMP facade database, with or without an element around them."""
    return any(node.find("points") is not None for node in root.iter("object"))


def read_cmp(root: Node, source: Source) -> BoxAnnotation:
    """Boxes as fractions of the picture, whose file has the same name and the suffix `.jpg`.

    Raises:
        FacadeError: If an object has not two numbers for each axis.
    """
    objects = list(root.iter("object"))
    check_count(len(objects))
    shapes = [_shape(node, number) for number, node in enumerate(objects, start=1)]
    check_only(source.wall)
    return on_picture(shapes, source, size=FRACTIONS, picture=f"{source.path.stem}.jpg")


def _shape(node: Node, number: int) -> Shape:
    """A box; the two values of an axis may be in either order."""
    (top, bottom), (left, right) = _interval(node, "x", number), _interval(node, "y", number)
    return upright((node.findtext("labelname") or "").strip(), left, top, right, bottom)


def _interval(node: Node, axis: str, number: int) -> tuple[float, float]:
    texts = [(value.text or "").strip() for value in node.findall(f"points/{axis}")]
    if len(texts) != 2:
        raise FacadeError(f"Object {number}: expected two numbers <{axis}> in <points>, found {texts[:4]}.")
    first, second = sorted(coordinate(text, f"Object {number}, {axis}") for text in texts)
    return first, second
