"""What annotation programs write beside plain boxes, and formats that are only recognised."""

import json

import pytest

from grammarlab.errors import FacadeError
from grammarlab.facade.reading.formats import read_annotation

SIZE = "<size><width>{}</width><height>{}</height></size>"
BOX = "<bndbox><xmin>10</xmin><ymin>20</ymin><xmax>30</xmax><ymax>60</ymax></bndbox>"


def read(tmp_path, content, suffix, wall=""):
    path = tmp_path / f"a{suffix}"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_annotation(path, wall)


def voc(*objects, size=(100, 100)):
    return f"<annotation><filename>f.jpg</filename>{SIZE.format(*size)}{''.join(objects)}</annotation>"


def test_a_file_of_pascal_voc_may_lack_the_size_and_have_polygons(tmp_path):
    window = f"<object><name> window </name>{BOX}</object>"
    found = read(tmp_path, voc(window, size=(0, 0)), ".xml", "f.jpg")
    assert (found.names, found.unit, found.picture) == (("window",), "pixels", "")
    corners = "".join(
        f"<x{k}>{x}</x{k}><y{k}>{y}</y{k}>" for k, (x, y) in enumerate([(10, 60), (20, 20), (30, 60)], start=1)
    )
    found = read(tmp_path, voc(f"<object><name>gable</name><polygon>{corners}</polygon>{BOX}</object>"), ".xml")
    assert found.outlines[0].tolist() == [[10, 40], [20, 80], [30, 40]]


@pytest.mark.parametrize(
    ("objects", "message"),
    [
        ("", "no box with a width"),
        (f"<object>{BOX}</object>", "object 1, name: expected a text"),
        (f"<object><name> </name>{BOX}</object>", "object 1, name: expected the label"),
        (
            f"<object><name>a</name>{BOX}</object><object><name>b</name></object>",
            "object 2: expected an element bndbox",
        ),
        (f"<object><name>a</name>{BOX.replace('10', 'left')}</object>", "object 1, bndbox, xmin: expected a finite"),
        (f"<object><name>a</name>{BOX.replace('10', '50')}</object>", "Box 1 .a: .* has a negative width"),
        (f"<object><name>a</name>{BOX.replace('10', '')}</object>", "object 1, bndbox, xmin: expected a finite"),
    ],
)
def test_mistakes_in_pascal_voc_are_named(tmp_path, objects, message):
    with pytest.raises(FacadeError, match=message):
        read(tmp_path, voc(objects), ".xml")


def test_xml_of_other_encodings_is_read(tmp_path):
    text = voc(f"<object><name>Tür</name>{BOX}</object>")
    for encoding in ("iso-8859-1", "utf-16", "utf-8-sig"):
        declared = f'<?xml version="1.0" encoding="{encoding.removesuffix("-sig")}"?>{text}'
        assert read(tmp_path, declared.encode(encoding), ".xml").names == ("Tür",)


def test_deleted_objects_and_points_of_labelme_are_left_out_and_masks_are_boxes(tmp_path):
    def drawn(name, corners, deleted=0):
        points = "".join(f"<pt><x>{x}</x><y>{y}</y></pt>" for x, y in corners)
        return f"<object><name>{name}</name><deleted>{deleted}</deleted><polygon>{points}</polygon></object>"

    square = [(10, 20), (30, 20), (30, 60), (10, 60)]
    box = BOX.replace("bndbox", "box")
    mask = f"<object><name>door</name><deleted>0</deleted><segm>{box}<mask>m.png</mask></segm></object>"
    text = drawn("window", square) + drawn("old", square, 1) + drawn("spot", [(1, 1)]) + mask
    found = read(tmp_path, f"<annotation><filename>f.jpg</filename>{text}</annotation>", ".xml")
    assert found.names == ("window", "door")
    assert found.notes == (
        "2 annotations are left out, since they are not areas with a label: 1 deleted, 1 point or line",
        "1 masks or shapes of several polygons are read as their boxes",
    )


def test_shapes_of_cvat_that_are_not_areas_are_counted(tmp_path):
    shapes = (
        '<polygon label="window" points="10.0,20.0;30.0,20.0;20.0,60.0"/>'
        '<mask label="door" rle="1, 2" left="50" top="40" width="20" height="30"/>'
        '<polyline label="axis" points="1,2;3,4"/><cuboid label="box"/><cuboid label="box"/><tag label="old"/>'
    )
    found = read(
        tmp_path, f'<annotations><image name="f" width="100" height="100">{shapes}</image></annotations>', ".xml"
    )
    assert found.names == ("window", "door")
    assert found.high.tolist() == [[30, 80], [70, 60]]
    assert len(found.outlines[0]) == 3
    assert "2 cuboid, 1 polyline, 1 tag" in found.notes[0]
    with pytest.raises(FacadeError, match=r"image 'f', polygon 1, points: expected 3 to 10,000 corners"):
        read(tmp_path, '<annotations><image name="f"><polygon label="a" points="1,2;3"/></image></annotations>', ".xml")


def via(*regions, **more):
    entries = [{"shape_attributes": shape, "region_attributes": attributes} for shape, attributes in regions]
    image = {"f.jpg1": {"filename": "f.jpg", "size": 1, "regions": entries, "file_attributes": {}}}
    return json.dumps({"_via_img_metadata": image} | more)


RECT = {"name": "rect", "x": 1, "y": 2, "width": 3, "height": 4}


def test_the_label_of_via_is_the_attribute_that_most_regions_have_and_others_are_named(tmp_path):
    text = via((RECT, {"note": "x", "type": "window"}), (RECT | {"x": 5}, {"type": {"door": True}}))
    found = read(tmp_path, text, ".json")
    assert found.names == ("window", "door")
    assert found.notes == ("the attribute 'type' is read as the label; others are not: 'note'",)
    text = via((RECT, {"colour": "red", "Label": "window"}), (RECT | {"x": 5}, {"colour": "red", "Label": "door"}))
    assert read(tmp_path, text, ".json").names == ("window", "door")


def test_numbered_options_of_via_are_read_by_their_names(tmp_path):
    definition = {"region": {"type": {"type": "radio", "options": {"1": "window", "2": "door"}}}, "file": {}}
    text = via((RECT, {"type": "1"}), (RECT | {"x": 5}, {"type": "2"}), _via_attributes=definition)
    assert read(tmp_path, text, ".json").names == ("window", "door")


def test_regions_of_via_without_a_label_or_an_area_are_counted(tmp_path):
    point, circle = {"name": "point", "cx": 1, "cy": 1}, {"name": "circle", "cx": 50, "cy": 50, "r": 10}
    shapes = [(circle, {"name": "oculus"}), (RECT, {}), (point, {"name": "spot"}), (RECT, {"name": ""})]
    found = read(tmp_path, via(*shapes), ".json")
    assert found.names == ("oculus",)
    assert (found.high - found.low).tolist() == [[20, 20]]
    assert found.notes[-1].endswith("1 point, 2 rect without 'name'")
    with pytest.raises(FacadeError, match=r"None of the 1 regions .* give each a region attribute such as label"):
        read(tmp_path, via((RECT, {})), ".json")
    with pytest.raises(FacadeError, match=r"region 1, width: expected a finite number, found nothing"):
        read(tmp_path, via(({"name": "rect", "x": 1, "y": 2}, {"a": "window"})), ".json")


def label_studio(*results, key="annotations", **more):
    return json.dumps([{"id": 1, "data": {"image": "/data/f.jpg"}, key: [{"result": list(results)} | more]}])


def percent(x, **labels):
    return {
        "value": {"x": x, "y": 20, "width": 10, "height": 20, "rotation": 0} | labels,
        "type": next(iter(labels), ""),
    }


SIZE_100 = {"original_width": 200, "original_height": 100}


def test_label_studio_without_sizes_gives_fractions(tmp_path):
    found = read(tmp_path, label_studio(percent(50, rectanglelabels=["window"])), ".json")
    assert (found.unit, found.low.tolist(), found.high.tolist()) == ("parts", [[0.5, 0.6]], [[0.6, 0.8]])
    found = read(tmp_path, label_studio(percent(50, rectanglelabels=["window"]) | SIZE_100), ".json")
    assert (found.unit, found.low.tolist(), found.high.tolist()) == ("pixels", [[100, 60]], [[120, 80]])


def test_a_rectangle_of_label_studio_may_have_its_label_in_another_region(tmp_path):
    bare, label = percent(50) | {"id": "r1", "type": "rectangle"}, percent(50, labels=["window"]) | {"id": "r1"}
    brush = {"value": {"rle": [1, 2], "brushlabels": ["wall"]}, "type": "brushlabels", "id": "r2"}
    unlabelled = percent(10) | {"id": "r3", "type": "rectangle"}
    found = read(tmp_path, label_studio(bare, label, brush, unlabelled), ".json")
    assert found.names == ("window",)
    assert "1 brushlabels, 1 rectangle" in found.notes[0]


def test_the_first_annotation_of_a_task_is_read_and_others_are_reported(tmp_path):
    task = json.loads(label_studio(percent(50, rectanglelabels=["window"])))
    cancelled = {"was_cancelled": True, "result": [percent(1, rectanglelabels=["no"])]}
    second = {"result": [percent(1, rectanglelabels=["door"])]}
    task[0]["annotations"] = [cancelled, {"result": []}, *task[0]["annotations"], second]
    found = read(tmp_path, json.dumps(task), ".json")
    assert found.names == ("window",)
    assert "the task has 2 annotations: the first one is read" in found.notes
    found = read(tmp_path, label_studio(percent(50, rectanglelabels=["window"]), key="predictions"), ".json")
    assert "the boxes are predictions of a model" in found.notes


def test_polygons_of_label_studio_are_percentages(tmp_path):
    points = {"points": [[10, 20], [30, 20], [20, 60]], "polygonlabels": ["gable"]}
    found = read(tmp_path, label_studio({"value": points, "type": "polygonlabels"} | SIZE_100), ".json")
    assert found.outlines[0].tolist() == [[20, 80], [60, 80], [40, 40]]


@pytest.mark.parametrize(
    ("suffix", "content", "message"),
    [
        (
            ".json",
            '{"project": {}, "file": {}, "metadata": {}, "view": {}}',
            "VIA 3 JSON, which is not read. Export VIA 2",
        ),
        (
            ".json",
            '{"images": [], "categories": [], "annotations": [{"segments_info": []}]}',
            "COCO panoptic, which is not read",
        ),
        (".json", '{"size": {}, "objects": []}', "Supervisely JSON, which is not read"),
        (".json", '{"asset": {}, "regions": []}', "VoTT JSON, which is not read. Export CSV or Pascal VOC"),
        (".json", '{"metadata": {}, "instances": []}', "SuperAnnotate JSON, which is not read"),
        (".json", '{"info": {}, "categories": {}, "items": []}', "Datumaro JSON, which is not read. Export COCO"),
        (".json", '[{"data_row": {}, "projects": {}}]', "Labelbox JSON, which is not read"),
        (".json", '[{"image_id": 1, "bbox": [1, 2, 3, 4], "score": 0.5}]', "COCO results, which is not read"),
        (".json", '{"type": "FeatureCollection", "features": []}', "GeoJSON, which is not read"),
        (".xml", "<dataset><images/></dataset>", "imglab XML, which is not read. Export Pascal VOC or COCO"),
        (".xml", "<annotations><track label='a'/></annotations>", '"CVAT for video", .* export it as "CVAT for images'),
        (".xml", "<svg xmlns='http://www.w3.org/2000/svg'/>", "SVG, which is not read"),
        (".csv", "# Exported using VGG Image Annotator\n# CSV_HEADER = a,b\n", "VIA 3 CSV, which is not read"),
    ],
)
def test_a_format_that_is_not_read_is_named_with_the_export_to_choose(tmp_path, suffix, content, message):
    with pytest.raises(FacadeError, match=message):
        read(tmp_path, content, suffix)


def test_the_content_decides_on_the_format_before_the_suffix(tmp_path):
    text = voc(f"<object><name>window</name>{BOX}</object>")
    for suffix in (".txt", ".csv", ".json", ".gml"):
        assert read(tmp_path, text, suffix).names == ("window",)
    assert read(tmp_path, label_studio(percent(50, rectanglelabels=["door"])), ".xml").names == ("door",)
    for suffix in (".tsv", ".txt"):
        assert read(tmp_path, "label\tx\ty\tw\th\nwindow\t1\t1\t1\t1\n", suffix).names == ("window",)


def test_classes_of_yolo_have_names_or_numbers_with_a_note(tmp_path):
    text = "1 0.5 0.5 0.2 0.4 0.93\n0 0.1 0.1 0.3 0.1 0.3 0.4\n"
    found = read(tmp_path, text, ".txt")
    assert (found.names, found.unit) == (("class 1", "class 0"), "parts")
    assert "put their names into classes.txt" in found.notes[0]
    (tmp_path / "classes.txt").write_text("window\ndoor\n")
    found = read(tmp_path, text, ".txt")
    assert (found.names, found.notes) == (("door", "window"), ())
    assert len(found.outlines[1]) == 3
    for line, message in (
        ("0 0.5 0.5 0.2\n", "Line 2: expected a class"),
        ("0 a 0.5 0.2 0.1\n", "Line 2: expected a fin"),
    ):
        with pytest.raises(FacadeError, match=message):
            read(tmp_path, "0 0.5 0.5 0.2 0.2\n" + line, ".txt")
