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
    """A pixel is a centimetre."""
    lines = [
        f"{left / 100!r},{top / 100!r},{(right - left) / 100!r},{(bottom - top) / 100!r},{name}"
        for (left, top, right, bottom), name in zip(_from_the_top(drawn), drawn.names, strict=True)
    ]
    return "\n".join(["x, y,Width,height,label", *lines])


def as_sides(drawn: Drawing) -> str:
    """A pixel is a centimetre."""
    lines = [
        ",".join([name, *(repr(side / 100) for side in box)])
        for box, name in zip(drawn.boxes.tolist(), drawn.names, strict=True)
    ]
    return "\r\n".join(["label,left,bottom,right,top", *lines, ""])


def _named(drawn: Drawing) -> list[tuple[list[float], str]]:
    return list(zip(_from_the_top(drawn), drawn.names, strict=True))


def as_voc(drawn: Drawing) -> str:
    keys = ("xmin", "ymin", "xmax", "ymax")
    objects = [
        f"<object><name>{name}</name><difficult>0</difficult><bndbox>"
        + "".join(f"<{key}>{side!r}</{key}>" for key, side in zip(keys, box, strict=True))
        + "</bndbox><part><name>pane</name><bndbox><xmin>1</xmin></bndbox></part></object>"
        for box, name in _named(drawn)
    ]
    size = "<size><width>{}</width><height>{}</height><depth>3</depth></size>".format(*drawn.size)
    return f"<annotation><folder/><filename>front.png</filename>{size}{''.join(objects)}</annotation>"


def as_labelme_xml(drawn: Drawing) -> str:
    objects = []
    for (left, top, right, bottom), name in _named(drawn):
        corners = [(left, top), (right, top), (right, bottom), (left, bottom)]
        points = "".join(f"<pt><x>{x!r}</x><y>\n{y!r}\n</y></pt>" for x, y in corners)
        objects.append(f"<object><name>{name}</name><deleted>0</deleted><polygon>{points}</polygon></object>")
    size = "<imagesize><nrows>{1}</nrows><ncols>{0}</ncols></imagesize>".format(*drawn.size)
    return f"<annotation><filename>front.png</filename>{size}<objects>{''.join(objects)}</objects></annotation>"


def as_cvat(drawn: Drawing) -> str:
    boxes = [
        f'<box label="{name}" xtl="{left!r}" ytl="{top!r}" xbr="{right!r}" ybr="{bottom!r}" z_order="0" rotation="0"/>'
        for (left, top, right, bottom), name in _named(drawn)
    ]
    image = '<image id="7" name="front.png" width="{}" height="{}">'.format(*drawn.size)
    start = '<?xml version="1.0" encoding="utf-8"?>\n<annotations><version>1.1</version>'
    return f"{start}{image}{''.join(boxes)}</image></annotations>"


def _via_regions(drawn: Drawing) -> list[dict[str, dict[str, object]]]:
    return [
        {
            "shape_attributes": {"name": "rect", "x": left, "y": top, "width": right - left, "height": bottom - top},
            "region_attributes": {"type": name},
        }
        for (left, top, right, bottom), name in _named(drawn)
    ]


def as_via_annotations(drawn: Drawing) -> str:
    image = {"filename": "front.png", "size": 12, "regions": _via_regions(drawn), "file_attributes": {}}
    return json.dumps({"front.png12": image})


def as_via_project(drawn: Drawing) -> str:
    regions = {str(number): region for number, region in enumerate(_via_regions(drawn))}
    size = {"width": drawn.size[0], "height": str(drawn.size[1])}
    image = {"filename": "front.png", "size": 12, "regions": regions, "file_attributes": size}
    attributes = {"region": {"type": {"type": "dropdown", "options": {"window": "", "door": ""}}}, "file": {}}
    return json.dumps({"_via_settings": {}, "_via_img_metadata": {"a": image}, "_via_attributes": attributes})


def as_via_table(drawn: Drawing) -> str:
    lines = []
    for number, region in enumerate(_via_regions(drawn)):
        cells = [json.dumps(each).replace('"', '""') for each in region.values()]
        lines.append(f'front.png,12,"{{}}",{len(drawn.names)},{number},"{cells[0]}","{cells[1]}"')
    header = "filename,file_size,file_attributes,region_count,region_id,region_shape_attributes,region_attributes"
    return "\n".join([f"#{header}", *lines])


def _percent(drawn: Drawing, name: str, box: list[float]) -> dict[str, object]:
    left, top, right, bottom = (100.0 * side / size for side, size in zip(box, drawn.size * 2, strict=True))
    sides: dict[str, object] = {"x": left, "y": top, "width": right - left, "height": bottom - top, "rotation": 0}
    return sides | {"rectanglelabels": [name]}


def as_label_studio(drawn: Drawing) -> str:
    size = {"original_width": drawn.size[0], "original_height": drawn.size[1], "image_rotation": 0}
    result = [
        {"id": f"r{number}", "type": "rectanglelabels", "value": _percent(drawn, name, box)} | size
        for number, (box, name) in enumerate(_named(drawn))
    ]
    return json.dumps([{"id": 3, "data": {"image": "/data/upload/1/front.png"}, "annotations": [{"result": result}]}])


def as_label_studio_min(drawn: Drawing) -> str:
    size = {"original_width": drawn.size[0], "original_height": drawn.size[1]}
    regions = [_percent(drawn, name, box) | size for box, name in _named(drawn)]
    return json.dumps([{"image": "/data/upload/1/front.png", "id": 3, "label": regions, "created_at": "2024.png"}])


def as_createml(drawn: Drawing) -> str:
    annotations = []
    for (left, top, right, bottom), name in _named(drawn):
        middle = {"x": (left + right) / 2, "y": (top + bottom) / 2}
        annotations.append({"label": name, "coordinates": middle | {"width": right - left, "height": bottom - top}})
    return json.dumps([{"image": "front.png", "annotations": annotations}])


def as_tensorflow(drawn: Drawing) -> str:
    size = "{},{}".format(*drawn.size)
    lines = [f"front.png,{size},{name},{','.join(map(repr, box))}" for box, name in _named(drawn)]
    return "\n".join(["filename,width,height,class,xmin,ymin,xmax,ymax", *lines])


def as_retinanet(drawn: Drawing) -> str:
    return "\n".join(f"photos/front.png,{','.join(map(repr, box))},{name}" for box, name in _named(drawn))


def as_makesense(drawn: Drawing) -> str:
    size = "{},{}".format(*drawn.size)
    return "\n".join(
        f"{name},{left!r},{top!r},{right - left!r},{bottom - top!r},front.png,{size}"
        for (left, top, right, bottom), name in _named(drawn)
    )


def as_open_images(drawn: Drawing) -> str:
    width, height = drawn.size
    lines = [
        f"abc,xclick,{name},1,{left / width!r},{right / width!r},{top / height!r},{bottom / height!r},0"
        for (left, top, right, bottom), name in _named(drawn)
    ]
    return "\n".join(["ImageID,Source,LabelName,Confidence,XMin,XMax,YMin,YMax,IsOccluded", *lines])


def as_yolo(drawn: Drawing) -> str:
    """The class of a label is its position among all labels in order."""
    width, height = drawn.size
    names = sorted(set(drawn.names))
    return "\n".join(
        f"{names.index(name)} {(left + right) / 2 / width!r} {(top + bottom) / 2 / height!r} "
        f"{(right - left) / width!r} {(bottom - top) / height!r}"
        for (left, top, right, bottom), name in _named(drawn)
    )


WRITERS = [
    (as_cmp, ".xml"),
    (as_voc, ".xml"),
    (as_labelme_xml, ".xml"),
    (as_cvat, ".xml"),
    (as_coco, ".json"),
    (as_labelme, ".json"),
    (as_via_annotations, ".json"),
    (as_via_project, ".json"),
    (as_label_studio, ".json"),
    (as_label_studio_min, ".json"),
    (as_createml, ".json"),
    (as_corners, ".csv"),
    (as_sides, ".csv"),
    (as_via_table, ".csv"),
    (as_tensorflow, ".csv"),
    (as_retinanet, ".csv"),
    (as_makesense, ".csv"),
    (as_open_images, ".csv"),
    (as_yolo, ".txt"),
]
"""A writer of each form that is read, and its suffix."""
