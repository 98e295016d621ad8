"""Labelled boxes of many programs: one drawing has equal results in all of their formats."""

import copy
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import FacadeError, UsageError
from grammarlab.facade.reading.annotation import MOST_BOXES
from grammarlab.facade.reading.formats import read_annotation
from tests.facade.drawings import Drawing, drawing
from tests.facade.reading.formats import WRITERS, as_cmp, as_coco, as_labelme, as_sides


def read(tmp_path, content, suffix, wall=""):
    path = tmp_path / f"a{suffix}"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_annotation(path, wall)


@pytest.mark.parametrize(("writer", "suffix"), WRITERS, ids=lambda value: getattr(value, "__name__", ""))
@pytest.mark.parametrize("seed", [1, 2])
def test_one_drawing_reads_alike_from_every_format(tmp_path, writer, suffix, seed):
    drawn = drawing(seed)
    (tmp_path / "classes.txt").write_text("\n".join(sorted(set(drawn.names))))
    found = read(tmp_path, writer(drawn), suffix)
    scale = {"parts": np.array(drawn.size), "pixels": np.ones(2), "metres": np.full(2, 100.0)}[found.unit]
    low, high = found.low * scale, found.high * scale
    shift = drawn.boxes[:, :2].min(axis=0) - low.min(axis=0)  # without the size of the picture there is no origin
    np.testing.assert_allclose(np.hstack([low + shift, high + shift]), drawn.boxes, atol=1e-9)
    assert list(found.names) == drawn.names
    assert found.notes == ()
    assert all(len(outline) == 0 for outline in found.outlines)


def test_the_x_of_cmp_runs_down_the_picture(tmp_path):
    text = "<object><points><x>0.1</x><x>0.4</x><y>0.5</y><y>0.6</y></points><labelname>\nwindow\n</labelname></object>"
    found = read(tmp_path, text, ".xml")
    assert np.allclose([*found.low[0], *found.high[0]], [0.5, 0.6, 0.6, 0.9])
    assert (found.names, found.unit, found.picture) == (("window",), "parts", "a.jpg")
    for around in (
        f"<root>{text}</root>",
        f'<?xml version="1.0"?>\n<annotation>{text}</annotation>',
        f"{text}\n{text}",
    ):
        assert np.array_equal(read(tmp_path, around, ".xml").low[0], found.low[0])


def test_circles_of_labelme_are_outlines_and_lines_are_left_out(tmp_path):
    shapes = [
        {"label": "window", "shape_type": "circle", "points": [[40, 50], [40, 70]]},
        {"label": "door", "shape_type": "rectangle", "points": [[70, 60], [80, 100]]},
        {"label": "axis", "shape_type": "line", "points": [[40, 0], [40, 100]]},
        {"label": "corner", "shape_type": "point", "points": [[1, 1]]},
    ]
    (tmp_path / "a.json").write_text(json.dumps({"imageHeight": 100, "imageWidth": 100, "shapes": shapes}))
    annotation = read_annotation(tmp_path / "a.json")
    assert annotation.names == ("window", "door")
    assert annotation.notes == ("2 points and lines have no area and are left out",)
    assert annotation.low[0] == pytest.approx([20, 30])
    assert annotation.high[0] == pytest.approx([60, 70])
    assert np.hypot(*(annotation.outlines[0] - [40, 50]).T) == pytest.approx(20)


def test_polygons_are_outlines_and_rectangles_are_none(tmp_path):
    arch = [[10, 90], [10, 40], [30, 10], [50, 40], [50, 90]]
    square = [[60, 10], [90, 10], [90, 30], [60, 30]]
    shapes = [{"label": "window", "points": points, "shape_type": "polygon"} for points in (arch, square)]
    labelme = {"imageHeight": 100, "imageWidth": 100, "imagePath": "../a.png", "shapes": shapes}
    flat = [[each for point in points for each in point] for points in (arch, square)]
    boxes = [[10, 10, 40, 80], [60, 10, 30, 20]]
    coco = {
        "images": [{"id": 1, "file_name": "a.png", "width": 100, "height": 100}],
        "categories": [{"id": 7, "name": "window"}],
        "annotations": [
            {"image_id": 1, "category_id": 7, "bbox": box, "segmentation": [points]}
            for box, points in zip(boxes, flat, strict=True)
        ],
    }
    for document in (labelme, coco):
        found = read(tmp_path, json.dumps(document), ".json")
        assert found.outlines[0].tolist() == [[x, 100 - y] for x, y in arch]
        assert len(found.outlines[1]) == 0
        assert found.low.tolist() == [[10, 10], [60, 70]]


def test_a_coco_file_of_several_images_lists_them(tmp_path):
    document = json.loads(as_coco(drawing(3)))
    document["images"].append({"id": 2, "file_name": "other.png", "width": 50, "height": 60})
    document["annotations"].append({"image_id": 2, "category_id": 0, "bbox": [0, 0, 10, 20]})
    with pytest.raises(UsageError, match=r"choose one of the 2 images.*'front.png', 'other.png'"):
        read(tmp_path, json.dumps(document), ".json")
    for name in ("other.png", "2"):
        found = read(tmp_path, json.dumps(document), ".json", name)
        assert (found.low.tolist(), found.high.tolist(), found.picture) == ([[0, 40]], [[10, 60]], "other.png")
    with pytest.raises(UsageError, match="choose one of"):
        read(tmp_path, json.dumps(document), ".json", "third.png")


def test_the_sides_of_a_table_may_run_down_as_in_pictures(tmp_path):
    table = "label,left,top,right,bottom\nwindow,1,2,3,5\ndoor,0,0,9,9\n"
    found = read(tmp_path, table, ".csv")
    assert found.low.tolist() == [[1, -5], [0, -9]]
    with pytest.raises(FacadeError, match="negative width or height"):
        read(tmp_path, table + "door,0,9,9,0\n", ".csv")


@pytest.mark.parametrize(
    "table",
    [
        "label;x;y;width;height\nwindow;1,5;2;2,25;3\ndoor;0;0;9;9,5\n",
        "label;x;y;width;height\nwindow;1.5;2;2.25;3\ndoor;0;0;9;9.5\n",
        "\ufefflabel\tx\ty\tw\th\nwindow\t1,5\t2\t2,25\t3\ndoor\t0\t0\t9\t9,5\n",
        "label,xmin,ymin,xmax,ymax\nwindow,1.5,2,3.75,5\ndoor,0,0,9,9.5\n",
        "x1;y1;x2;y2;label\n1,5;2;3,75;5;window\n0;0;9;9,5;door\n",
    ],
)
def test_tables_of_other_programs_are_read_alike(tmp_path, table):
    found = read(tmp_path, table, ".csv")
    assert found.names == ("window", "door")
    assert found.low.tolist() == [[1.5, -5], [0, -9.5]]
    assert found.high.tolist() == [[3.75, -2], [9, 0]]


def test_of_a_mask_of_labelme_the_box_is_read(tmp_path):
    mask = {"label": "window", "shape_type": "mask", "points": [[10, 20], [30, 50]], "mask": "iVBORw0KGgo="}
    document = {"shapes": [mask], "imageHeight": 100, "imageWidth": 90}
    found = read(tmp_path, json.dumps(document), ".json")
    assert (found.low.tolist(), found.high.tolist()) == ([[10, 50]], [[30, 80]])
    assert len(found.outlines[0]) == 0


def test_a_wall_is_not_chosen_where_there_is_but_one(tmp_path):
    for writer, suffix in ((as_cmp, ".xml"), (as_labelme, ".json"), (as_sides, ".csv")):
        with pytest.raises(UsageError, match="only one facade"):
            read(tmp_path, writer(drawing(1)), suffix, "front")


MANY = "label,x,y,width,height\n" + "w,0,0,1,1\n" * (MOST_BOXES + 1)
NESTED = b"<a>" * 200 + b"</a>" * 200
LAUGHS = b'<!DOCTYPE a [<!ENTITY b "ha"><!ENTITY c "&b;&b;&b;">]><a>&c;</a>'
OUTSIDE = b'<!DOCTYPE a [<!ENTITY b SYSTEM "file:///etc/passwd">]><a>&b;</a>'


@pytest.mark.parametrize(
    ("suffix", "content", "says"),
    [
        (".xml", b"", "This XML has the root 'root'. Read are CityGML, .*CMP, Pascal VOC"),
        (".xml", b"no xml", "not valid XML"),
        (".xml", b"<object>", "not valid XML"),
        (".xml", NESTED, "more than 100 levels"),
        (".xml", LAUGHS, "entities or a document type|not valid XML"),
        (".gml", LAUGHS, "declares entities or a document type"),
        (".gml", OUTSIDE, "declares entities or a document type"),
        (
            ".xml",
            b"<object><points><x>1</x><x>nan</x><y>0</y><y>1</y></points></object>",
            "x: expected a finite number",
        ),
        (".xml", b"<object><points><x>1</x><y>0</y><y>1</y></points></object>", "Object 1: expected two numbers <x>"),
        (
            ".xml",
            b"<object><points><x>1</x><x>a</x><y>0</y><y>1</y></points></object>",
            "x: expected a finite number, found 'a'",
        ),
        (".xml", b"<object><points><x>2</x><x>3</x><y>0</y><y>1</y></points></object>", "is outside the picture"),
        (".json", b"[]", "This is JSON without keys. Read are .*COCO, LabelMe"),
        (".json", b"{", "not valid JSON"),
        (".json", b"[" * 100_000, "too deep"),
        (".json", b'{"shapes": 3, "imageHeight": 1, "imageWidth": 1}', "shapes: expected a list"),
        (".json", b'{"shapes": [3], "imageHeight": 1, "imageWidth": 1}', "shapes, entry 0: expected an object"),
        (".json", b'{"shapes": [], "imageWidth": 1}', "no box with a width and a height"),
        (".json", b'{"shapes": [{"shape_type": "cube"}], "imageHeight": 1, "imageWidth": 1}', "found 'cube'"),
        (".json", b'{"images": [], "annotations": [], "categories": []}', "choose one of the 0 images"),
        (".json", b'{"images": [{}], "annotations": [], "categories": []}', "no box with a width and a height"),
        (".csv", b"", "expected the columns label,x,y,width,height or label,left,bottom,right,top"),
        (".csv", b"label,x,y\n", "found 'label,x,y'"),
        (".csv", b"\xff\xff", "Line 1: expected the columns"),
        (".csv", b"label,x,y,width,height\nw,1,2,3\n", "Line 2: expected 5 fields, found 4"),
        (".csv", b"label,x,y,width,height\n\nw,1,2,3,high\n", "Line 3, height: expected a finite number, found 'high'"),
        (".csv", b"label,x,y,width,height\nw,1,2,-3,1\n", "Box 1 .*negative width"),
        (".csv", b"label,x,y,width,height\nw,1,2,nan,1\n", "width: expected a finite number, found 'nan'"),
        (".csv", b"label,x,y,width,height\n" + b"w" * 201 + b",1,2,3,4\n", "at most 200 characters"),
        (".csv", MANY.encode(), "There are 100,001 boxes; a facade has at most 100,000"),
        (".jpg", b"", "expected a file that ends in .xml, .gml, .json, .csv, .tsv, .txt: CityGML"),
    ],
    ids=lambda value: value[:30] if isinstance(value, str) else "",
)
def test_what_is_no_such_file_is_explained(tmp_path, suffix, content, says):
    with pytest.raises((FacadeError, UsageError), match=says) as told:
        read(tmp_path, content, suffix)
    assert str(told.value).startswith(f"a{suffix}: ")


FILES = [
    (suffix, writer(Drawing(drawing(0).boxes[:6], drawing(0).names[:6], (400, 300), 1, 1)))
    for writer, suffix in WRITERS
]


SPLINTERS = [
    *(
        b"1e999",
        b"-",
        b"null",
        b"{}",
        b"[]",
        b"<x>",
        b"NaN",
        b"1_0",
        b"-1e308",
        b"9" * 5_000,
        b"1,5",
        b";",
        b'"',
        b"\0",
    ),
    *("\u202e\U0001f3e0".encode(), b"</object>", b"rotation", b'"width": -1', b"\r", b"sep=;\n"),
]


@given(st.sampled_from(FILES), st.data())
def test_damaged_files_are_read_or_refused_in_words(tmp_path_factory, file, data):
    suffix, text = file
    content = text.encode()
    for _ in range(data.draw(st.integers(1, 3))):
        start = data.draw(st.integers(0, len(content)))
        other = data.draw(st.binary(max_size=6) | st.sampled_from(SPLINTERS))
        content = content[:start] + other + content[start + data.draw(st.integers(0, 12)) :]
    path = tmp_path_factory.getbasetemp() / f"fuzz{suffix}"
    path.write_bytes(content)
    try:
        found = read_annotation(path)
    except (FacadeError, UsageError):
        return
    assert (found.low < found.high).all()
    assert np.isfinite(found.high).all()


OTHER_VALUES = [None, True, -1, 0, 1e300, "", "x", "7", [], [1], [[1, 2]], {}, {"a": 1}]


def places(value, path=()):
    """The paths of all values in a document."""
    yield path
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, part in items:
        yield from places(part, (*path, key))


@given(st.sampled_from([text for suffix, text in FILES if suffix == ".json"]), st.data())
def test_json_with_values_of_other_types_is_read_or_refused_in_words(tmp_path_factory, text, data):
    document = json.loads(text)
    for _ in range(data.draw(st.integers(1, 3))):
        path = data.draw(st.sampled_from(list(places(document))[1:] or [()]))
        holder = document
        for key in path[:-1]:
            holder = holder[key]
        if path and data.draw(st.booleans()):
            holder[path[-1]] = copy.deepcopy(data.draw(st.sampled_from(OTHER_VALUES)))
        elif path:
            del holder[path[-1]]
    path = tmp_path_factory.getbasetemp() / "types.json"
    path.write_text(json.dumps(document))
    try:
        found = read_annotation(path)
    except (FacadeError, UsageError):
        return
    assert (found.low < found.high).all()


@pytest.mark.parametrize("number", ["9" * 5_000, "1e999", "1e308", "-1e30"])
@pytest.mark.parametrize(("writer", "suffix"), WRITERS, ids=lambda value: getattr(value, "__name__", ""))
def test_an_enormous_number_in_any_format_is_refused_in_words(tmp_path, writer, suffix, number):
    text = writer(Drawing(np.array([[123.456, 20.0, 200.0, 90.0]]), ["window"], (400, 300), 1, 1))
    places = [value for value in ("123.456", "1.23456", "0.30864", "30.864", "161.728", "0.40432") if value in text]
    with pytest.raises((FacadeError, UsageError)) as refusal:
        read(tmp_path, text.replace(places[0], number, 1), suffix)
    assert len(str(refusal.value)) < 1_000


def test_labels_of_all_scripts_are_kept_and_none_reaches_the_terminal_as_a_command(tmp_path):
    name = "окно 窓 fenêtre"
    for writer, suffix in WRITERS:
        (tmp_path / "classes.txt").write_text(name)
        found = read(tmp_path, writer(Drawing(np.array([[10.0, 20.0, 60.0, 90.0]]), [name], (100, 100), 1, 1)), suffix)
        assert found.names == (name,)
    with pytest.raises(FacadeError, match="negative width") as refusal:
        read(tmp_path, "label,x,y,width,height\n\x1b[31mred,1,1,-1,1\n", ".csv")
    assert "\x1b" not in str(refusal.value)


@given(st.sampled_from([".xml", ".gml", ".json", ".csv", ".tsv", ".txt"]), st.binary(max_size=200))
def test_noise_is_refused_in_words(tmp_path_factory, suffix, content):
    path = tmp_path_factory.getbasetemp() / f"noise{suffix}"
    path.write_bytes(content)
    with pytest.raises((FacadeError, UsageError)):
        read_annotation(path)
