"""Tables of boxes: of one facade in metres, and of pictures."""

import pytest

from grammarlab.errors import FacadeError
from grammarlab.facade.reading.assembling import assemble
from grammarlab.facade.reading.formats import read_annotation

METRES = "label;x;y;width;height\nwindow;1,0;1,0;1,0;1,4\nwindow;3,0;1,0;1,0;1,4\n"


def read(tmp_path, content, suffix=".csv", wall=""):
    path = tmp_path / f"a{suffix}"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_annotation(path, wall)


@pytest.mark.parametrize(
    "content",
    [
        METRES,
        METRES.replace("label", "Label"),
        "sep=;\n" + METRES,
        METRES.encode("utf-16"),
        METRES.encode("utf-8-sig"),
        METRES.replace("window", "Tür").encode("cp1252"),
        METRES + ";;;;\n\n",
        METRES.replace("height", "height;").replace("1,4", "1,4;"),
        METRES.replace(";", "\t"),
        METRES.replace("x;y;width;height", "left; top ;Breite;Höhe"),
        METRES.replace(",", ".").replace(";", ","),
        METRES.replace("\n", "\r\n"),
    ],
)
def test_tables_of_spreadsheets_are_read_alike(tmp_path, content):
    found = read(tmp_path, content)
    assert found.low.tolist() == [[1.0, -2.4], [3.0, -2.4]]
    assert found.high.tolist() == [[2.0, -1.0], [4.0, -1.0]]
    assert (found.unit, found.notes) == ("metres", ())


@pytest.mark.parametrize(
    ("scale", "unit"), [(1, "metres"), (20, "metres"), (40, "pixels"), (25.5, "metres"), (60.5, "pixels")]
)
def test_a_facade_that_is_too_large_for_metres_is_read_as_pixels_with_a_note(tmp_path, scale, unit):
    boxes = [(0, 0, 1, 1), (2, 0, 1, 1), (4, 0, 1, 1)]
    lines = [f"window,{','.join(str(scale * side) for side in box)}" for box in boxes]
    found = read(tmp_path, "\n".join(["label,x,y,width,height", *lines]))
    assert found.unit == unit
    assert bool(found.notes) == (unit == "pixels")
    facade = assemble(found).facade
    assert facade.width == pytest.approx(20.0 if unit == "pixels" else 5 * scale)
    assert assemble(found, width=5 * scale).facade.width == pytest.approx(5 * scale)
    if unit == "pixels":
        assert f"give `width={5 * scale:g}`" in found.notes[0]


def test_tables_of_pictures_are_in_pixels_however_small(tmp_path):
    forms = [
        "filename,width,height,class,xmin,ymin,xmax,ymax\nf.jpg,50,40,window,1,2,11,22\n",
        "image;xmin;ymin;xmax;ymax;label\nf.jpg;1,0;2,0;11,0;22,0;window\n",
        "f.jpg,1,2,11,22,window\n",
        "f.jpg,,,,,\nf.jpg,1,2,11,22,window\n",
        "window,1,2,10,20,f.jpg,50,40\n",
        "label_name,bbox_x,bbox_y,bbox_width,bbox_height,image_name,image_width,image_height\nwindow,1,2,10,20,f.jpg,50,40\n",
    ]
    for text in forms:
        found = read(tmp_path, text)
        assert (found.unit, found.names) == ("pixels", ("window",))
        assert (found.high - found.low).tolist() == [[10, 20]]


def test_open_images_has_fractions_and_known_classes(tmp_path):
    header = "ImageID,Source,LabelName,Confidence,XMin,XMax,YMin,YMax"
    found = read(tmp_path, f"{header}\nab,x,/m/0d4v4,1,0.2,0.4,0.1,0.5\nab,x,/m/1,1,0,1,0,1\n")
    assert (found.unit, found.names, found.picture) == ("parts", ("window", "/m/1"), "ab.jpg")
    assert found.low[0].tolist() == pytest.approx([0.2, 0.5])
    assert found.high[0].tolist() == pytest.approx([0.4, 0.9])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (
            "filename,class,xmin,ymin,xmax,ymax\nf.jpg,window,1,2,x,4\n",
            "Line 2, xmax: expected a finite number, found 'x'",
        ),
        ("filename,class,xmin,ymin,xmax,ymax\nf.jpg,,1,2,3,4\n", "Line 2, label: expected the label"),
        ("filename,class,xmin,ymin,xmax,ymax\nf.jpg,window,1,2\n", "Line 2: expected 6 fields, found 4"),
        ("filename,class,xmin,ymin,xmax,ymax\nf.jpg,window,5,2,3,4\n", "Box 1 .window: .* negative width"),
        ("label,x,y,width,height\nwindow,1,2,1_0,4\n", "Line 2, width: expected a finite number, found '1_0'"),
        ("label,x,y,width,height\nwindow,1,2,3,4,5\n", "Line 2: expected 5 fields, found 6"),
        ("filename,region_shape_attributes\nf.jpg,{}\n", "table of VIA without the column region_attributes"),
        (
            'filename,region_shape_attributes,region_attributes\nf.jpg,"{""name"": 1",{}\n',
            "line 2: This is not valid JSON",
        ),
        ("a,b,c\n1,2,3\n", "expected the columns label,x,y,width,height .* Read are CityGML"),
    ],
)
def test_mistakes_are_named_with_their_line(tmp_path, content, message):
    with pytest.raises(FacadeError, match=message):
        read(tmp_path, content)
