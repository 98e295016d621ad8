"""Labelled shapes as XML of CVAT, "CVAT for images 1.1": an element `image` with its shapes each, in pixels."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.boxes.annotation import BoxAnnotation, check_count
from grammarlab.facade.reading.images import ImageName, chosen_image
from grammarlab.facade.reading.left_out import box_only_notes, left_out_notes
from grammarlab.facade.reading.markup import Node
from grammarlab.facade.reading.numbers import coordinate, known_size
from grammarlab.facade.reading.polygons import MOST_CORNERS
from grammarlab.facade.reading.shapes import Shape, ellipse, label_of, on_picture, polygon, rotated, upright
from grammarlab.facade.reading.source import Source
from grammarlab.facade.tree import Floats
from grammarlab.facade.values import shown

_AREAS = ("box", "polygon", "ellipse", "mask")
_EXPORT = 'export it as "CVAT for images 1.1", which has all boxes of each frame'


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
        raise FacadeError(f'This is "CVAT for video", with boxes at key frames only: {_EXPORT}.')
    names = _names(images)
    index = chosen_image(names, source.wall)
    image = images[index]
    check_count(len(image))
    shapes = [
        _shape(node, f"image {names[index].text}, {node.tag} {number}")
        for number, node in enumerate(image, start=1)
        if node.tag in _AREAS
    ]
    left_out = Counter(node.tag for node in image if node.tag not in _AREAS)
    return on_picture(
        shapes,
        source,
        size=known_size(image.get("width"), image.get("height")),
        picture=image.get("name", ""),
        notes=[*left_out_notes(left_out), *box_only_notes(len(image.findall("mask")))],
    )


def _names(images: Sequence[Node]) -> list[ImageName]:
    """Names of images; in an export of several subsets, each of which counts its images, the subset is in front."""
    subsets = {node.get("subset", "") for node in images}
    several = len(subsets) > 1
    return [
        ImageName(file, f"{node.get('subset', '')}/{file}" if several else node.get("id", ""))
        for node in images
        for file in [node.get("name", "")]
    ]


def _shape(node: Node, where: str) -> Shape:
    name = label_of(node.get("label"), f"{where}, label")
    if node.tag == "polygon":
        return polygon(name, _points(node.get("points", ""), f"{where}, points"))
    if node.tag == "mask":
        left, top, width, height = _numbers(node, ("left", "top", "width", "height"), where)
        return upright(name, left, top, left + width, top + height)
    degrees = coordinate(node.get("rotation", "0"), f"{where}, rotation")
    if node.tag == "ellipse":
        across, down, wide, high = _numbers(node, ("cx", "cy", "rx", "ry"), where)
        return ellipse(name, (across, down), (wide, high), degrees)
    return rotated(name, _numbers(node, ("xtl", "ytl", "xbr", "ybr"), where), degrees)


def _numbers(node: Node, keys: tuple[str, ...], where: str) -> list[float]:
    return [coordinate(node.get(key), f"{where}, {key}") for key in keys]


def _points(text: str, where: str) -> Floats:
    """[P, 2] corners, from text such as `1.5,2;3,4;5,6`."""
    pairs = [pair.split(",") for pair in text.split(";") if pair.strip()]
    if not 3 <= len(pairs) <= MOST_CORNERS or any(len(pair) != 2 for pair in pairs):
        raise FacadeError(
            f"{where}: expected 3 to {MOST_CORNERS:,} corners such as 1.5,2;3,4;5,6, found {shown(text)}."
        )
    return np.array([[coordinate(value, where) for value in pair] for pair in pairs])
