"""Labelled polygons as XML of LabelMe's web tool: elements `object` with a `polygon`, in pixels from the top left.

Its objects may lie in an element `objects`; what was deleted in the tool stays in the file and is marked.
"""

from __future__ import annotations

from collections import Counter

import numpy as np

from grammarlab.facade.boxes.annotation import BoxAnnotation, check_count
from grammarlab.facade.reading.images import check_only
from grammarlab.facade.reading.left_out import box_only_notes, left_out_notes
from grammarlab.facade.reading.markup import Node, numbers_of
from grammarlab.facade.reading.numbers import known_size
from grammarlab.facade.reading.shapes import Shape, label_of, on_picture, polygon, upright
from grammarlab.facade.reading.source import Source

_NO = {"", "0", "false", "no"}
_SIDES = ("xmin", "ymin", "xmax", "ymax")


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
        if (node.findtext("deleted") or "").strip().lower() not in _NO:
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
