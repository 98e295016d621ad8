"""Labelled shapes as XML of CVAT, Pascal VOC, LabelMe's web tool and the CMP facade database.

CVAT, "CVAT for images 1.1": an element `image` with its shapes each, in pixels.

Pascal VOC: an element `object` with a `bndbox` each, in pixels from the top left. Programs add to it: Roboflow a
`polygon`, CVAT an attribute `rotation` (degrees), roLabelImg a `robndbox` (radians).

LabelMe: elements `object` with a `polygon`, in pixels from the top left. Its objects may lie in an element `objects`;
what was deleted in the tool stays in the file and is marked.

CMP: `x` points down the picture and `y` points across it, as fractions of the picture.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.errors import FacadeError, shown
from grammarlab.facade.reading.annotation import BoxAnnotation, check_count
from grammarlab.facade.reading.drawn_shapes import (
    FRACTIONS,
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
from grammarlab.facade.reading.markup import numbers_of
from grammarlab.facade.reading.source import (
    ImageName,
    Source,
    box_only_notes,
    check_only,
    chosen_image,
    coordinate,
    known_size,
    left_out_notes,
)
from grammarlab.xml_text import Node

_SIDES = ("xmin", "ymin", "xmax", "ymax")
_VOC_ROTATED = ("cx", "cy", "w", "h", "angle")
_FALSE_TEXTS = {"", "0", "false", "no"}
_CVAT_AREAS = ("box", "polygon", "ellipse", "mask")
_CVAT_EXPORT = 'export it as "CVAT for images 1.1", which has all boxes of each frame'


def is_cvat(root: Node) -> bool:
    """Whether the root is one of CVAT."""
    return root.tag == "annotations"


def read_cvat(root: Node, source: Source) -> BoxAnnotation:
    """The boxes, polygons and ellipses of one image, and the boxes of its masks; other shapes are left out.

    Raises:
        FacadeError: If the file has tracks of a video, or a shape has no label or not its numbers.
        UsageError: If no image has the name, or the choice is ambiguous.
    """
    images = root.findall("image")
    if not images and root.find("track") is not None:
        raise FacadeError(f'This is "CVAT for video", with boxes at key frames only: {_CVAT_EXPORT}.')
    names = _cvat_names(images)
    index = chosen_image(names, source.wall)
    image = images[index]
    check_count(len(image))
    shapes = [
        _cvat_shape(node, f"image {names[index].text}, {node.tag} {number}")
        for number, node in enumerate(image, start=1)
        if node.tag in _CVAT_AREAS
    ]
    left_out = Counter(node.tag for node in image if node.tag not in _CVAT_AREAS)
    return on_picture(
        shapes,
        source,
        size=known_size(image.get("width"), image.get("height")),
        picture=image.get("name", ""),
        notes=[*left_out_notes(left_out), *box_only_notes(len(image.findall("mask")))],
    )


def is_voc(root: Node) -> bool:
    """Whether the root is one of Pascal VOC; a file without objects may be of any program that writes this root."""
    objects = root.findall("object")
    return root.tag == "annotation" and all(
        node.find("bndbox") is not None or node.find("robndbox") is not None for node in objects[:1]
    )


def read_voc(root: Node, source: Source) -> BoxAnnotation:
    """The boxes of a file, with their polygons or rotations if it has them; parts of objects are not read.

    Raises:
        FacadeError: If an object has no label or no box.
    """
    objects = root.findall("object")
    check_count(len(objects))
    shapes = [_voc_shape(node, f"object {number}") for number, node in enumerate(objects, start=1)]
    size = known_size(root.findtext("size/width"), root.findtext("size/height"))
    picture = (root.findtext("filename") or "").strip()
    check_only(source.wall, picture)
    return on_picture(shapes, source, size=size, picture=picture)


def is_labelme_xml(root: Node) -> bool:
    """Whether the root is one of LabelMe."""
    return root.tag == "annotation" and any(
        node.find("polygon/pt") is not None or node.find("segm") is not None for node in root.iter("object")
    )


def read_labelme_xml(root: Node, source: Source) -> BoxAnnotation:
    """The polygons of a file, and the boxes of its masks; deleted objects, points and lines are left out.

    Raises:
        FacadeError: If an object has no label, or a corner is not two numbers.
    """
    objects = list(root.iter("object"))
    check_count(len(objects))
    shapes: list[Shape] = []
    left_out: Counter[str] = Counter()
    num_masks = 0
    for number, node in enumerate(objects, start=1):
        where = f"object {number}"
        corners = [
            numbers_of(point, ("x", "y"), f"{where}, corner {corner}")
            for corner, point in enumerate(node.iterfind("polygon/pt"), start=1)
        ]
        mask = node.find("segm/box")
        if (node.findtext("deleted") or "").strip().lower() not in _FALSE_TEXTS:
            left_out["deleted"] += 1
        elif len(corners) >= 3 or (len(corners) == 2 and node.findtext("type") == "bounding_box"):
            shapes.append(polygon(label_of(node.findtext("name"), f"{where}, name"), np.array(corners)))
        elif mask is not None:
            num_masks += 1
            sides = numbers_of(mask, _SIDES, f"{where}, segm")
            shapes.append(upright(label_of(node.findtext("name"), f"{where}, name"), *sides))
        else:
            left_out["point or line"] += 1
    size = known_size(root.findtext("imagesize/ncols"), root.findtext("imagesize/nrows"))
    picture = (root.findtext("filename") or "").strip()
    notes = [*left_out_notes(left_out), *box_only_notes(num_masks)]
    check_only(source.wall, picture)
    return on_picture(shapes, source, size=size, picture=picture, notes=notes)


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
    shapes = [_cmp_shape(node, number) for number, node in enumerate(objects, start=1)]
    check_only(source.wall)
    return on_picture(shapes, source, size=FRACTIONS, picture=f"{source.path.stem}.jpg")


def _cvat_names(images: Sequence[Node]) -> list[ImageName]:
    """Names of images; in an export of several subsets, each of which counts its images, the subset is in front."""
    subsets = {node.get("subset", "") for node in images}
    several = len(subsets) > 1
    return [
        ImageName(file, f"{node.get('subset', '')}/{file}" if several else node.get("id", ""))
        for node in images
        for file in [node.get("name", "")]
    ]


def _cvat_shape(node: Node, where: str) -> Shape:
    name = label_of(node.get("label"), f"{where}, label")
    if node.tag == "polygon":
        return polygon(name, _cvat_points(node.get("points", ""), f"{where}, points"))
    if node.tag == "mask":
        left, top, width, height = _cvat_numbers(node, ("left", "top", "width", "height"), where)
        return upright(name, left, top, left + width, top + height)
    degrees = coordinate(node.get("rotation", "0"), f"{where}, rotation")
    if node.tag == "ellipse":
        across, down, wide, high = _cvat_numbers(node, ("cx", "cy", "rx", "ry"), where)
        return ellipse(name, (across, down), (wide, high), degrees)
    return rotated(name, _cvat_numbers(node, ("xtl", "ytl", "xbr", "ybr"), where), degrees)


def _cvat_points(text: str, where: str) -> Floats:
    """[P, 2] corners, from text such as `1.5,2;3,4;5,6`."""
    pairs = [pair.split(",") for pair in text.split(";") if pair.strip()]
    if not 3 <= len(pairs) <= MOST_CORNERS or any(len(pair) != 2 for pair in pairs):
        raise FacadeError(
            f"{where}: expected 3 to {MOST_CORNERS:,} corners such as 1.5,2;3,4;5,6, found {shown(text)}."
        )
    return np.array([[coordinate(value, where) for value in pair] for pair in pairs])


def _cvat_numbers(node: Node, keys: tuple[str, ...], where: str) -> list[float]:
    return [coordinate(node.get(key), f"{where}, {key}") for key in keys]


def _voc_shape(node: Node, where: str) -> Shape:
    name = label_of(node.findtext("name"), f"{where}, name")
    box = node.find("bndbox")
    if box is None:
        return _voc_rotated_shape(node.find("robndbox"), name, where)
    sides = numbers_of(box, _SIDES, f"{where}, bndbox")
    corners = _voc_corners(node.find("polygon"), f"{where}, polygon")
    if len(corners) >= 3:
        return polygon(name, np.array(corners))
    return rotated(name, sides, _voc_rotation(node, where))


def _voc_rotated_shape(box: Node | None, name: str, where: str) -> Shape:
    if box is None:
        raise FacadeError(f"{where}: expected an element bndbox with xmin, ymin, xmax, ymax, found none.")
    across, down, width, height, angle = numbers_of(box, _VOC_ROTATED, f"{where}, robndbox")
    return rotated(name, sides_around(across, down, width, height), float(np.degrees(angle)))


def _voc_corners(node: Node | None, where: str) -> Sequence[tuple[float, float]]:
    """Corners from elements x1, y1, x2, y2 and so on."""
    values = {} if node is None else {child.tag: child.text for child in node}
    corners: list[tuple[float, float]] = []
    while (number := len(corners) + 1) <= MOST_CORNERS and f"x{number}" in values:
        across, down = (coordinate(values.get(f"{axis}{number}"), f"{where}, {axis}{number}") for axis in "xy")
        corners.append((across, down))
    return corners


def _voc_rotation(node: Node, where: str) -> float:
    """The attribute `rotation`, degrees clockwise about the centre."""
    for attribute in node.iterfind("attributes/attribute"):
        if attribute.findtext("name") == "rotation":
            return coordinate(attribute.findtext("value"), f"{where}, rotation")
    return 0.0


def _cmp_shape(node: Node, number: int) -> Shape:
    """A box; the two values of an axis may be in either order."""
    (top, bottom), (left, right) = _cmp_interval(node, "x", number), _cmp_interval(node, "y", number)
    return upright((node.findtext("labelname") or "").strip(), left, top, right, bottom)


def _cmp_interval(node: Node, axis: str, number: int) -> tuple[float, float]:
    texts = [(value.text or "").strip() for value in node.findall(f"points/{axis}")]
    if len(texts) != 2:
        raise FacadeError(f"Object {number}: expected two numbers <{axis}> in <points>, found {texts[:4]}.")
    first, second = sorted(coordinate(text, f"Object {number}, {axis}") for text in texts)
    return first, second
