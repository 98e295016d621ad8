"""A drawing in each supported format."""

import json

import numpy as np

from tests.facade.drawings import Drawing


def _from_the_top(drawn: Drawing) -> list[list[float]]:
    """Left, top, right, bottom, with y down."""
    height = drawn.size[1]
    return [[left, height - top, right, height - bottom] for left, bottom, right, top in drawn.boxes.tolist()]


def as_cmp(drawn: Drawing) -> str:
    width, height = drawn.size
    objects = []
    for (left, top, right, bottom), name in zip(_from_the_top(drawn), drawn.names, strict=True):
        down, across = (top / height, bottom / height), (left / width, right / width)
        points = "".join(f"<x>{each!r}</x>" for each in down) + "".join(f"<y>{each!r}</y>" for each in across)
        objects.append(f"<object><points>{points}</points><label>1</label><labelname>{name}</labelname></object>")
    return "".join(objects)


def as_coco(drawn: Drawing) -> str:
    names = sorted(set(drawn.names))
    boxes = np.array(_from_the_top(drawn))
    sizes = boxes[:, 2:] - boxes[:, :2]
    return json.dumps(
        {
            "images": [{"id": 5, "file_name": "front.png", "width": drawn.size[0], "height": drawn.size[1]}],
            "categories": [{"id": place, "name": name} for place, name in enumerate(names)],
            "annotations": [
                {"image_id": 5, "category_id": names.index(name), "bbox": [*box[:2], *size]}
                for box, size, name in zip(boxes.tolist(), sizes.tolist(), drawn.names, strict=True)
            ],
        }
    )


def as_labelme(drawn: Drawing) -> str:
    shapes = [
        {"label": name, "shape_type": "rectangle", "points": [[right, bottom], [left, top]]}
        for (left, top, right, bottom), name in zip(_from_the_top(drawn), drawn.names, strict=True)
    ]
    size = {"imageWidth": drawn.size[0], "imageHeight": drawn.size[1]}
    return json.dumps({"version": "5.0", "imagePath": "front.png", **size, "shapes": shapes})


def as_corners(drawn: Drawing) -> str:
    lines = [
        f"{left!r},{top!r},{right - left!r},{bottom - top!r},{name}"
        for (left, top, right, bottom), name in zip(_from_the_top(drawn), drawn.names, strict=True)
    ]
    return "\n".join(["x, y,Width,height,label", *lines])


def as_sides(drawn: Drawing) -> str:
    lines = [
        ",".join([name, *(repr(side) for side in box)])
        for box, name in zip(drawn.boxes.tolist(), drawn.names, strict=True)
    ]
    return "\r\n".join(["label,left,bottom,right,top", *lines, ""])
