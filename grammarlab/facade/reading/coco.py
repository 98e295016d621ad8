"""Labelled boxes as COCO JSON: `images`, `categories` and `annotations` with a `bbox`, in pixels from the top left."""

from __future__ import annotations

from typing import Any

import numpy as np

from grammarlab.errors import UsageError
from grammarlab.facade.boxes.annotation import MOST_BOXES, BoxAnnotation, annotate
from grammarlab.facade.reading.polygons import outline_of
from grammarlab.facade.tree import Floats
from grammarlab.facade.values import a_list, a_number, a_text, an_object, numbers, shown

_MOST_OF_ALL = 10_000_000
"""Largest number of entries of a list for many images."""


def read_coco(document: dict[str, Any], image: str = "") -> BoxAnnotation:
    """The boxes of one image.

    Args:
        document: the file.
        image: id or `file_name` of the image; may be left out if there is only one.

    Raises:
        FacadeError: If the file does not have that form.
        UsageError: If no image has that name, or the choice is ambiguous.
    """
    images = _entries(document, "images")
    chosen, where = _chosen(images, image)
    categories = {str(each.get("id")): each.get("name") for each in _entries(document, "categories")}
    height = a_number(chosen.get("height"), f"{where}, height")
    width = a_number(chosen.get("width"), f"{where}, width")
    boxes: list[list[float]] = []
    names: list[str] = []
    outlines: list[Floats] = []
    for place, each in enumerate(_entries(document, "annotations")):
        if each.get("image_id") != chosen.get("id"):
            continue
        at = f"annotations, entry {place}"
        left, top, across, down = numbers(each.get("bbox"), f"{at}, bbox", 4)
        boxes.append([left, height - top - down, left + across, height - top])
        names.append(a_text(categories.get(str(each.get("category_id"))), f"{at}: the name of its category_id"))
        outlines.append(_outline(each.get("segmentation"), f"{at}, segmentation", height))
        a_list(boxes, "annotations of the image", MOST_BOXES)
    bounds = np.array([[0.0, 0.0], [width, height]])
    picture = chosen.get("file_name")
    return annotate(
        np.array(boxes).reshape(-1, 4),
        names,
        "pixels",
        outlines=outlines,
        bounds=bounds,
        picture=picture if isinstance(picture, str) else "",
    )


def _entries(document: dict[str, Any], key: str) -> list[dict[str, Any]]:
    return [an_object(each, f"{key}, entry {k}") for k, each in enumerate(a_list(document.get(key), key, _MOST_OF_ALL))]


def _chosen(images: list[dict[str, Any]], image: str) -> tuple[dict[str, Any], str]:
    """The selected image, and its name in messages."""
    meant = [place for place, each in enumerate(images) if image in (str(each.get("id")), each.get("file_name"), "")]
    if len(meant) != 1:
        names = [shown(each.get("file_name") or each.get("id")) for each in images[:20]]
        more = f" and {len(images) - 20} more" if len(images) > 20 else ""
        raise UsageError(f"choose one of the {len(images)} images of this file with --wall: {', '.join(names)}{more}.")
    return images[meant[0]], f"images, entry {meant[0]}"


def _outline(segmentation: Any, where: str, height: float) -> Floats:
    """Corners, y up, of a segmentation of one polygon; none for other kinds, such as run lengths."""
    if not isinstance(segmentation, list) or len(segmentation) != 1:
        return np.zeros((0, 2))
    flat = [a_number(each, where) for each in a_list(segmentation[0], where, 20_000)]
    points = np.array(flat[: len(flat) // 2 * 2]).reshape(-1, 2)
    return outline_of(np.column_stack([points[:, 0], height - points[:, 1]]))
