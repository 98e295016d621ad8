"""Labelled shapes as JSON of COCO, LabelMe and Create ML, in pixels from the top left.

COCO: `images`, `categories` and `annotations` with a `bbox`. Programs write ids as numbers or texts, even both for one
image; CVAT adds an attribute `rotation`, in degrees.

LabelMe: `shapes` of two or more points. X-AnyLabeling writes the same form, with rectangles of four corners and rotated
ones of the type `rotation`.

Create ML: images with `annotations` of a label, a centre and a size.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.errors import FacadeError, shown
from grammarlab.facade.reading.annotation import MOST_BOXES, BoxAnnotation
from grammarlab.facade.reading.drawn_shapes import (
    MOST_CORNERS,
    Shape,
    ellipse,
    label_of,
    on_picture,
    polygon,
    rotated,
    sides_around,
    upright,
)
from grammarlab.facade.reading.source import (
    ImageName,
    Source,
    box_only_notes,
    check_only,
    chosen_image,
    coordinate,
    known_size,
)
from grammarlab.facade.values import a_list, an_object, numbers

_LABELME_ROTATED = ("oriented_rectangle", "rotation")
_LABELME_SHAPES = ("rectangle", *_LABELME_ROTATED, "polygon", "circle", "mask")
_LABELME_WITHOUT_AREA = ("point", "points", "line", "linestrip")
"""Shapes that are not boxes."""
_MOST_IMAGES = 1_000_000
"""Largest number of images of a file of Create ML."""
_MOST_ENTRIES = 10_000_000
"""Largest number of entries of a list of COCO, which may be for many images."""


def is_coco(document: Any) -> bool:
    """Whether a JSON document is one of COCO."""
    return isinstance(document, dict) and {"images", "annotations"} <= document.keys()


def read_coco(document: dict[str, Any], source: Source) -> BoxAnnotation:
    """The boxes of one image: with their polygons; of run lengths and several polygons, only the box.

    Raises:
        FacadeError: If the file does not have that form, or no annotation belongs to its only image.
        UsageError: If no image has the name, or the choice is ambiguous.
    """
    images = _coco_entries(document, "images")
    names = [ImageName(str(image.get("file_name") or ""), _coco_identity(image.get("id"))) for image in images]
    index = chosen_image(names, source.wall)
    image = names[index]
    if sum(image.identity == other.identity for other in names) > 1:
        raise FacadeError(
            f"images, entry {index}: {image.text} has the id {image.identity} of another image: its boxes are unknown."
        )
    annotations = _coco_entries(document, "annotations")
    positions, notes = _coco_positions(annotations, names, image)
    categories = _coco_categories(document)
    shapes = [
        _coco_shape(annotations[position], categories, f"annotations, entry {position}") for position in positions
    ]
    return on_picture(
        shapes,
        source,
        size=known_size(images[index].get("width"), images[index].get("height")),
        picture=image.file,
        notes=[*notes, *box_only_notes(sum(_is_coco_mask(annotations[position]) for position in positions))],
    )


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
        if kind in _LABELME_WITHOUT_AREA:
            left_out += 1
        else:
            shapes.append(_labelme_shape(entry, kind, where))
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
    shapes = [
        _createml_shape(an_object(annotation, f"{where} {k}"), f"{where} {k}")
        for k, annotation in enumerate(annotations, start=1)
    ]
    return on_picture(shapes, source, size=None, picture=names[index].file)


def _coco_entries(document: dict[str, Any], key: str) -> list[dict[str, Any]]:
    return [
        an_object(entry, f"{key}, entry {k}") for k, entry in enumerate(a_list(document.get(key), key, _MOST_ENTRIES))
    ]


def _coco_identity(value: Any) -> str:
    """An id as text: 5, 5.0 and "5" are equal."""
    whole = isinstance(value, float) and value.is_integer() and abs(value) < 2**53
    return str(int(value) if whole else value)[:1_000]


def _coco_positions(
    annotations: Sequence[dict[str, Any]], names: Sequence[ImageName], image: ImageName
) -> tuple[list[int], list[str]]:
    """Positions of the annotations of an image, and a note on those of no image."""
    owners = [_coco_identity(annotation.get("image_id")) for annotation in annotations]
    identities = {name.identity for name in names}
    if image.identity not in owners and image.file in owners:  # some programs refer to an image by its file
        return [position for position, owner in enumerate(owners) if owner == image.file], []
    strays = [owner for owner in owners if owner not in identities]
    if strays and len(names) == 1 and len(strays) == len(owners):
        raise FacadeError(
            f"annotations, entry 0: expected the image_id {shown(image.identity)} of the only image, "
            f"found {shown(strays[0])}."
        )
    notes = [f"{len(strays)} annotations belong to no image of this file and are left out"] if strays else []
    positions = [position for position, owner in enumerate(owners) if owner == image.identity]
    return a_list(positions, "annotations of the image", MOST_BOXES), notes


def _coco_categories(document: dict[str, Any]) -> dict[str, Any]:
    """Names of categories, by id and by name."""
    entries = _coco_entries(document, "categories") if "categories" in document else []
    by_name = {str(entry.get("name")): entry.get("name") for entry in entries}
    return by_name | {_coco_identity(entry.get("id")): entry.get("name") for entry in entries}


def _coco_shape(annotation: dict[str, Any], categories: dict[str, Any], where: str) -> Shape:
    category = _coco_identity(annotation.get("category_id"))
    if category not in categories:
        advice = " VIA writes null for a label that is not an option of its attribute." if category == "None" else ""
        identity = shown(annotation.get("category_id"))
        raise FacadeError(f"{where}: expected a category_id of the list categories, found {identity}.{advice}")
    name = label_of(categories[category], f"{where}: the name of its category_id")
    polygons = _coco_polygons(annotation.get("segmentation"), f"{where}, segmentation")
    box = annotation.get("bbox")
    if not box and polygons:  # some programs leave the box of a polygon empty
        whole = polygon(name, np.vstack(polygons))
        return polygon(name, polygons[0]) if len(polygons) == 1 else upright(name, *whole.box)
    left, top, across, down = (coordinate(number, f"{where}, bbox") for number in numbers(box, f"{where}, bbox", 4))
    sides = (left, top, left + across, top + down)
    degrees = _coco_rotation(annotation.get("attributes"), where)
    if degrees:
        return rotated(name, sides, degrees)
    return Shape(name, sides, polygons[0] if len(polygons) == 1 else np.zeros((0, 2)))


def _coco_polygons(segmentation: Any, where: str) -> list[Floats]:
    """Corners [P, 2] of the polygons of a segmentation; none for run lengths."""
    if not isinstance(segmentation, list) or not segmentation:
        return []
    parts = segmentation if isinstance(segmentation[0], list) else [segmentation]  # one polygon may be flat
    flat = [
        [coordinate(number, where) for number in a_list(part, where, 2 * MOST_CORNERS)]
        for part in a_list(parts, where, MOST_BOXES)
    ]
    return [np.array(part[: len(part) // 2 * 2]).reshape(-1, 2) for part in flat if len(part) >= 6]


def _coco_rotation(attributes: Any, where: str) -> float:
    """The rotation of a box about its centre as CVAT writes it, degrees clockwise."""
    value = attributes.get("rotation") if isinstance(attributes, dict) else None
    return 0.0 if value is None else coordinate(value, f"{where}, rotation") % 360.0


def _is_coco_mask(annotation: dict[str, Any]) -> bool:
    """Whether the segmentation is more than one polygon."""
    segmentation = annotation.get("segmentation")
    if isinstance(segmentation, dict):
        return True
    return isinstance(segmentation, list) and len(segmentation) > 1 and isinstance(segmentation[0], list)


def _labelme_shape(shape: dict[str, Any], kind: Any, where: str) -> Shape:
    if kind not in _LABELME_SHAPES:
        raise FacadeError(f"{where}: expected a shape_type of {', '.join(_LABELME_SHAPES)}, found {shown(kind)}.")
    name = label_of(shape.get("label"), f"{where}, label")
    corners = _labelme_points(shape, where)
    if kind == "circle":
        radius = float(np.hypot(*(corners[1] - corners[0])))
        return ellipse(name, (float(corners[0, 0]), float(corners[0, 1])), (radius, radius))
    if kind == "rectangle" and len(corners) == 2:  # its two corners may be any opposite ones
        (left, top), (right, bottom) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
        return upright(name, left, top, right, bottom)
    return polygon(name, corners, rectangle=kind in _LABELME_ROTATED)


def _labelme_points(shape: dict[str, Any], where: str) -> Floats:
    points = [
        [coordinate(number, f"{where}, points") for number in numbers(point, f"{where}, points", 2)]
        for point in a_list(shape.get("points"), f"{where}, points", MOST_CORNERS)
    ]
    if len(points) < 2:
        raise FacadeError(f"{where}, points: expected at least two corners, found {len(points)}.")
    return np.array(points)


def _createml_shape(annotation: dict[str, Any], where: str) -> Shape:
    box = an_object(annotation.get("coordinates"), f"{where}, coordinates")
    keys = ("x", "y", "width", "height")
    across, down, width, height = (coordinate(box.get(key), f"{where}, {key}") for key in keys)
    name = label_of(annotation.get("label"), f"{where}, label")
    return upright(name, *sides_around(across, down, width, height))
