"""Labelled boxes as JSON of Create ML: images with `annotations` of a label, a centre and a size, in pixels."""

from __future__ import annotations

from typing import Any

from grammarlab.facade.boxes.annotation import MOST_BOXES, BoxAnnotation
from grammarlab.facade.reading.images import ImageName, chosen_image
from grammarlab.facade.reading.numbers import coordinate
from grammarlab.facade.reading.shapes import Shape, label_of, on_picture, upright
from grammarlab.facade.reading.source import Source
from grammarlab.facade.values import a_list, an_object

_MOST_IMAGES = 1_000_000


def is_createml(document: Any) -> bool:
    """Whether a JSON document is one of Create ML."""
    return (
        isinstance(document, list)
        and bool(document)
        and all(isinstance(image, dict) and {"image", "annotations"} <= image.keys() for image in document[:100])
    )


def read_createml(document: list[Any], source: Source) -> BoxAnnotation:
    """The boxes of one image.

    Raises:
        FacadeError: If an annotation has no label, or not the four numbers.
        UsageError: If no image has the name, or the choice is ambiguous.
    """
    entries = a_list(document, "images", _MOST_IMAGES)
    images = [an_object(image, f"image {number}") for number, image in enumerate(entries, start=1)]
    names = [ImageName(str(image.get("image"))) for image in images]
    index = chosen_image(names, source.wall)
    where = f"image {names[index].text}, annotation"
    annotations = a_list(images[index].get("annotations"), f"{where}s", MOST_BOXES)
    shapes = [_shape(an_object(each, f"{where} {k}"), f"{where} {k}") for k, each in enumerate(annotations, start=1)]
    return on_picture(shapes, source, size=None, picture=names[index].file)


def _shape(annotation: dict[str, Any], where: str) -> Shape:
    box = an_object(annotation.get("coordinates"), f"{where}, coordinates")
    keys = ("x", "y", "width", "height")
    across, down, width, height = (coordinate(box.get(key), f"{where}, {key}") for key in keys)
    name = label_of(annotation.get("label"), f"{where}, label")
    return upright(name, across - width / 2.0, down - height / 2.0, across + width / 2.0, down + height / 2.0)
