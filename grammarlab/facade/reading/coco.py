"""Labelled boxes as COCO JSON: `images`, `categories` and `annotations` with a `bbox`, in pixels from the top left.

Programs write ids as numbers or texts, even both for one image; CVAT adds an attribute `rotation`, in degrees.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.boxes.annotation import MOST_BOXES, BoxAnnotation
from grammarlab.facade.reading.images import ImageName, chosen_image
from grammarlab.facade.reading.left_out import box_only_notes
from grammarlab.facade.reading.numbers import coordinate, known_size
from grammarlab.facade.reading.polygons import MOST_CORNERS
from grammarlab.facade.reading.shapes import Shape, label_of, on_picture, polygon, rotated, upright
from grammarlab.facade.reading.source import Source
from grammarlab.facade.tree import Floats
from grammarlab.facade.values import a_list, an_object, numbers, shown

_MOST_OF_ALL = 10_000_000
"""Largest number of entries of a list for many images."""


def is_coco(document: Any) -> bool:
    """Whether a JSON document is one of COCO."""
    return isinstance(document, dict) and {"images", "annotations"} <= document.keys()


def read_coco(document: dict[str, Any], source: Source) -> BoxAnnotation:
    """The boxes of one image: with their polygons; of run lengths and several polygons, only the box.

    Raises:
        FacadeError: If the file does not have that form, or no annotation belongs to its only image.
        UsageError: If no image has the name, or the choice is ambiguous.
    """
    images = _entries(document, "images")
    names = [ImageName(str(image.get("file_name") or ""), _identity(image.get("id"))) for image in images]
    index = chosen_image(names, source.wall)
    image = names[index]
    if sum(image.identity == each.identity for each in names) > 1:
        raise FacadeError(
            f"images, entry {index}: {image.text} has the id {image.identity} of another image: its boxes are unknown."
        )
    annotations = _entries(document, "annotations")
    positions, notes = _positions(annotations, names, image)
    categories = _categories(document)
    shapes = [_shape(annotations[position], categories, f"annotations, entry {position}") for position in positions]
    return on_picture(
        shapes,
        source,
        size=known_size(images[index].get("width"), images[index].get("height")),
        picture=image.file,
        notes=[*notes, *box_only_notes(sum(_is_mask(annotations[position]) for position in positions))],
    )


def _entries(document: dict[str, Any], key: str) -> list[dict[str, Any]]:
    return [an_object(each, f"{key}, entry {k}") for k, each in enumerate(a_list(document.get(key), key, _MOST_OF_ALL))]


def _identity(value: Any) -> str:
    """An id as text: 5, 5.0 and "5" are equal."""
    whole = isinstance(value, float) and value.is_integer() and abs(value) < 2**53
    return str(int(value) if whole else value)[:1_000]


def _positions(
    annotations: Sequence[dict[str, Any]], names: Sequence[ImageName], image: ImageName
) -> tuple[list[int], list[str]]:
    """Positions of the annotations of an image, and a note on those of no image."""
    owners = [_identity(each.get("image_id")) for each in annotations]
    known = {name.identity for name in names}
    if image.identity not in owners and image.file in owners:  # some programs refer to an image by its file
        return [position for position, owner in enumerate(owners) if owner == image.file], []
    strays = [owner for owner in owners if owner not in known]
    if strays and len(names) == 1 and len(strays) == len(owners):
        raise FacadeError(
            f"annotations, entry 0: expected the image_id {shown(image.identity)} of the only image, "
            f"found {shown(strays[0])}."
        )
    notes = [f"{len(strays)} annotations belong to no image of this file and are left out"] if strays else []
    positions = [position for position, owner in enumerate(owners) if owner == image.identity]
    return a_list(positions, "annotations of the image", MOST_BOXES), notes


def _categories(document: dict[str, Any]) -> dict[str, Any]:
    """Names of categories, by id and by name."""
    entries = _entries(document, "categories") if "categories" in document else []
    by_name = {str(each.get("name")): each.get("name") for each in entries}
    return by_name | {_identity(each.get("id")): each.get("name") for each in entries}


def _shape(annotation: dict[str, Any], categories: dict[str, Any], where: str) -> Shape:
    category = _identity(annotation.get("category_id"))
    if category not in categories:
        advice = " VIA writes null for a label that is not an option of its attribute." if category == "None" else ""
        found = shown(annotation.get("category_id"))
        raise FacadeError(f"{where}: expected a category_id of the list categories, found {found}.{advice}")
    name = label_of(categories[category], f"{where}: the name of its category_id")
    polygons = _polygons(annotation.get("segmentation"), f"{where}, segmentation")
    box = annotation.get("bbox")
    if not box and polygons:  # some programs leave the box of a polygon empty
        whole = polygon(name, np.vstack(polygons))
        return polygon(name, polygons[0]) if len(polygons) == 1 else upright(name, *whole.box)
    left, top, across, down = (coordinate(each, f"{where}, bbox") for each in numbers(box, f"{where}, bbox", 4))
    sides = (left, top, left + across, top + down)
    degrees = _rotation(annotation.get("attributes"), where)
    if degrees:
        return rotated(name, sides, degrees)
    return Shape(name, sides, polygons[0] if len(polygons) == 1 else np.zeros((0, 2)))


def _rotation(attributes: Any, where: str) -> float:
    """The rotation of a box about its centre as CVAT writes it, degrees clockwise."""
    value = attributes.get("rotation") if isinstance(attributes, dict) else None
    return 0.0 if value is None else coordinate(value, f"{where}, rotation") % 360.0


def _polygons(segmentation: Any, where: str) -> list[Floats]:
    """Corners [P, 2] of the polygons of a segmentation; none for run lengths."""
    if not isinstance(segmentation, list) or not segmentation:
        return []
    parts = segmentation if isinstance(segmentation[0], list) else [segmentation]  # one polygon may be flat
    flat = [
        [coordinate(each, where) for each in a_list(part, where, 2 * MOST_CORNERS)]
        for part in a_list(parts, where, MOST_BOXES)
    ]
    return [np.array(part[: len(part) // 2 * 2]).reshape(-1, 2) for part in flat if len(part) >= 6]


def _is_mask(annotation: dict[str, Any]) -> bool:
    """Whether the segmentation is more than one polygon."""
    segmentation = annotation.get("segmentation")
    if isinstance(segmentation, dict):
        return True
    return isinstance(segmentation, list) and len(segmentation) > 1 and isinstance(segmentation[0], list)
