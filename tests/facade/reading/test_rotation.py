"""Rotated rectangles and ellipses of all formats: the outline that shapely rotates, with y up."""

import json
from typing import Any

import numpy as np
import pytest
import shapely
from PIL import Image
from shapely import affinity

from grammarlab.errors import FacadeError
from grammarlab.facade.reading.assembling import assemble
from grammarlab.facade.reading.formats import read_annotation

SIZE = (400, 300)
SIDES = (100.0, 60.0, 180.0, 200.0)
"""Left, top, right, bottom of a rectangle."""
DOOR = (250.0, 100.0, 300.0, 300.0)


def rotated(degrees, origin="center", shape=None):
    """The shape, rotated clockwise on the picture, with y up."""
    left, top, right, bottom = SIDES
    pivot = origin if origin == "center" else (left, SIZE[1] - top)
    return affinity.rotate(shape or shapely.box(left, SIZE[1] - bottom, right, SIZE[1] - top), -degrees, pivot)


def as_cvat(degrees):
    boxes = "".join(
        f'<box label="{name}" xtl="{sides[0]}" ytl="{sides[1]}" xbr="{sides[2]}" ybr="{sides[3]}" rotation="{angle}"/>'
        for name, sides, angle in (("window", SIDES, degrees), ("door", DOOR, 0))
    )
    image = f'<image name="a.jpg" width="{SIZE[0]}" height="{SIZE[1]}">{boxes}</image>'
    return f"<annotations>{image}</annotations>", ".xml"


def as_coco(degrees):
    annotations = [
        {"image_id": 1, "category_id": name, "bbox": [*sides[:2], sides[2] - sides[0], sides[3] - sides[1]]}
        | {"attributes": {"occluded": False, "rotation": angle}, "segmentation": []}
        for name, sides, angle in (("window", SIDES, degrees), ("door", DOOR, 0.0))
    ]
    categories = [{"id": name, "name": name} for name in ("window", "door")]
    images = [{"id": 1, "width": SIZE[0], "height": SIZE[1]}]
    return json.dumps({"images": images, "categories": categories, "annotations": annotations}), ".json"


def as_voc(degrees):
    keys = ("xmin", "ymin", "xmax", "ymax")
    attribute = "<attributes><attribute><name>rotation</name><value>{}</value></attribute></attributes>"
    objects = "".join(
        f"<object><name>{name}</name><bndbox>"
        + "".join(f"<{key}>{side}</{key}>" for key, side in zip(keys, sides, strict=True))
        + f"</bndbox>{attribute.format(angle)}</object>"
        for name, sides, angle in (("window", SIDES, degrees), ("door", DOOR, 0))
    )
    size = f"<size><width>{SIZE[0]}</width><height>{SIZE[1]}</height></size>"
    return f"<annotation><filename>a.jpg</filename>{size}{objects}</annotation>", ".xml"


def as_rolabelimg(degrees):
    left, top, right, bottom = SIDES
    values = {"cx": (left + right) / 2, "cy": (top + bottom) / 2, "w": right - left, "h": bottom - top}
    box = "".join(f"<{key}>{value}</{key}>" for key, value in (values | {"angle": np.radians(degrees)}).items())
    size = f"<size><width>{SIZE[0]}</width><height>{SIZE[1]}</height></size>"
    return f"<annotation>{size}<object><name>window</name><robndbox>{box}</robndbox></object></annotation>", ".xml"


def as_labelme(degrees, kind="rotation"):
    corners = shapely.get_coordinates(rotated(degrees))[:4]
    points = [[x, SIZE[1] - y] for x, y in corners.tolist()]
    shapes = [{"label": "window", "shape_type": kind, "points": points, "direction": 0.3}]
    return json.dumps({"shapes": shapes, "imageWidth": SIZE[0], "imageHeight": SIZE[1]}), ".json"


def as_oriented(degrees):
    return as_labelme(degrees, "oriented_rectangle")


def as_label_studio(degrees):
    percent = [100.0 * side / size for side, size in zip(SIDES, SIZE * 2, strict=True)]
    value = {"x": percent[0], "y": percent[1], "width": percent[2] - percent[0], "height": percent[3] - percent[1]}
    region: dict[str, Any] = {
        "value": value | {"rotation": degrees, "rectanglelabels": ["window"]},
        "type": "rectanglelabels",
    }
    region |= {"original_width": SIZE[0], "original_height": SIZE[1]}
    return json.dumps([{"id": 1, "data": {"image": "a.jpg"}, "annotations": [{"result": [region]}]}]), ".json"


WRITERS = [as_cvat, as_coco, as_voc, as_rolabelimg, as_labelme, as_oriented, as_label_studio]


def read(tmp_path, written):
    text, suffix = written
    (tmp_path / f"a{suffix}").write_text(text)
    return read_annotation(tmp_path / f"a{suffix}")


@pytest.mark.parametrize("degrees", [12.0, -30.0, 45.0, 350.0])
@pytest.mark.parametrize("writer", WRITERS)
def test_a_rotated_rectangle_is_an_outline_in_the_box_around_it(tmp_path, writer, degrees):
    expected = rotated(degrees, "corner" if writer is as_label_studio else "center")
    found = read(tmp_path, writer(degrees))
    assert [*found.low[0], *found.high[0]] == pytest.approx(list(expected.bounds))
    assert shapely.Polygon(found.outlines[0]).symmetric_difference(expected).area < 1e-6
    angle = {12.0: "12.0", -30.0: "30.0", 45.0: "45.0", 350.0: "10.0"}[degrees]
    assert any(f"1 rectangles are rotated, by up to {angle} degrees" in note for note in found.notes)
    facade = assemble(found, width=10.0).facade
    assert np.diff(facade.outline_offsets).max() >= 4


@pytest.mark.parametrize("degrees", [0.0, 90.0, 180.0, -270.0, 360.0])
@pytest.mark.parametrize("writer", WRITERS)
def test_a_quarter_turn_is_an_upright_rectangle_without_a_note(tmp_path, writer, degrees):
    found = read(tmp_path, writer(degrees))
    expected = rotated(degrees, "corner" if writer is as_label_studio else "center").bounds
    assert [*found.low[0], *found.high[0]] == pytest.approx(np.clip(expected, 0, SIZE * 2).tolist())
    assert len(found.outlines[0]) == 0
    assert not any("rotated" in note for note in found.notes)


def test_a_rotation_of_half_a_degree_is_not_worth_a_note_but_is_kept(tmp_path):
    found = read(tmp_path, as_cvat(0.5))
    assert found.notes == ()
    assert shapely.Polygon(found.outlines[0]).symmetric_difference(rotated(0.5)).area < 1e-6


def test_ellipses_of_via_cvat_and_label_studio_are_rotated(tmp_path):
    ring = affinity.scale(shapely.Point(140, 170).buffer(1.0, quad_segs=8), 40.0, 70.0)
    expected = rotated(25.0, shape=ring)
    label_studio = {"x": 35.0, "y": 100 * 130 / 300, "radiusX": 10.0, "radiusY": 70 / 3, "rotation": 25.0}
    region = {"value": label_studio | {"ellipselabels": ["window"]}, "original_width": 400, "original_height": 300}
    via = {"name": "ellipse", "cx": 140, "cy": 130, "rx": 40, "ry": 70, "theta": float(np.radians(25.0))}
    regions = [{"shape_attributes": via, "region_attributes": {"label": "window"}}]
    attributes = {"width": "400", "height": 300}
    ellipse = '<ellipse label="window" cx="140" cy="130" rx="40" ry="70" rotation="25"/>'
    files = [
        (json.dumps([{"data": {"image": "a.jpg"}, "annotations": [{"result": [region]}]}]), ".json"),
        (json.dumps({"a": {"filename": "a.jpg", "regions": regions, "file_attributes": attributes}}), ".json"),
        (f'<annotations><image name="a.jpg" width="400" height="300">{ellipse}</image></annotations>', ".xml"),
    ]
    for written in files:
        found = read(tmp_path, written)
        assert shapely.Polygon(found.outlines[0]).symmetric_difference(expected).area < 0.01 * expected.area


def test_a_rotated_rectangle_across_the_border_is_cut_there(tmp_path):
    text, suffix = as_cvat(20.0)
    found = read(tmp_path, (text.replace('xtl="100.0"', 'xtl="10.0"').replace('xbr="180.0"', 'xbr="90.0"'), suffix))
    whole = affinity.translate(rotated(20.0), -90.0)
    cut = whole.intersection(shapely.box(0, 0, *SIZE))
    assert cut.area < whole.area - 1.0
    assert shapely.Polygon(found.outlines[0]).symmetric_difference(cut).area < 1e-6
    assert any("clipped" in note for note in found.notes)


def test_percentages_are_rotated_only_if_the_size_of_the_image_is_known(tmp_path):
    document = json.loads(as_label_studio(30.0)[0])
    region = document[0]["annotations"][0]["result"][0]
    del region["original_width"]
    with pytest.raises(FacadeError, match="a rotated shape needs the size of its image"):
        read(tmp_path, (json.dumps(document), ".json"))
    Image.new("RGB", SIZE).save(tmp_path / "a.jpg")
    found = read(tmp_path, (json.dumps(document), ".json"))
    assert shapely.Polygon(found.outlines[0]).symmetric_difference(rotated(30.0, "corner")).area < 1e-6
