"""``grammarlab facade``."""

import json

import pytest
from PIL import Image

from grammarlab.facade.editing.grid_proposals import with_proposals
from grammarlab.facade.file import dumps, load_facade
from tests.facade.drawings import drawing
from tests.facade.reading.city import usual
from tests.facade.reading.formats import as_cmp, as_coco

WINDMILL = "label,left,bottom,right,top\na,0,0,2,1\nb,2,0,3,2\nc,1,2,3,3\nd,0,1,1,3\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder to work in, with a drawing and its picture."""
    monkeypatch.chdir(tmp_path)
    drawn = drawing(4)
    (tmp_path / "house.xml").write_text(as_cmp(drawn))
    Image.new("RGB", drawn.size, "grey").save(tmp_path / "house.jpg")
    return tmp_path


def test_an_annotation_becomes_a_facade_with_its_picture(run, folder):
    result = run("facade", "read", "house.xml", "--width", "12", "-o", "new/f.json", "--json")
    values = json.loads(result.stdout)
    facade = load_facade(folder / "new" / "f.json")
    assert set(values) == {"file", "width", "height", "leaves", "inner_nodes", "grids", "snapped", "notes", "seconds"}
    assert values["leaves"] == len(facade.leaves)
    assert values["inner_nodes"] == len(facade) - len(facade.leaves)
    assert facade.width == pytest.approx(12.0)
    width, height = drawing(4).size
    assert facade.height == pytest.approx(12.0 * height / width)
    assert [picture.name for picture in facade.pictures] == ["house.jpg"]
    assert dumps(facade) == dumps(with_proposals(facade))
    assert values["grids"] == [
        {"name": grid.name, "rows": grid.num_rows, "columns": grid.num_columns} for grid in facade.grids
    ]
    assert values["grids"]
    assert 0.0 < values["snapped"] <= 0.01 * min(facade.width, facade.height)


def test_without_an_option_the_file_is_named_and_what_is_not_known_is_told(run, folder):
    result = run("facade", "read", "house.xml")
    assert result.stdout == "house.facade.json\n"
    assert "assuming a width of 20 m" in result.stderr
    assert load_facade(folder / "house.facade.json").width == pytest.approx(20.0)


def test_a_table_in_pixels_is_named_and_asks_for_a_width(run, folder):
    rows = [f"window,{x},{y},100,140" for y in (100, 320) for x in (100, 300, 500)]
    (folder / "front.csv").write_text("\n".join(["label,x,y,width,height", *rows]))
    result = run("facade", "read", "front.csv")
    assert (
        "the boxes extend over 500 x 360: too large for a facade in metres, so they are read as pixels" in result.stderr
    )
    assert "assuming a width of 20 m" in result.stderr
    assert "grid window: 3 columns x 2 rows" in result.stderr
    assert load_facade(folder / "front.facade.json").width == pytest.approx(20.0)
    assert "assuming" not in run("facade", "read", "front.csv", "--width", "500").stderr
    assert load_facade(folder / "front.facade.json").width == pytest.approx(500.0)


def test_an_image_of_several_is_chosen_by_its_name(run, folder):
    header, rows = (
        "filename,width,height,class,xmin,ymin,xmax,ymax",
        ["a.jpg,90,90,window,1,2,11,22", "b.jpg,9,9,door,1,2,3,4"],
    )
    (folder / "images.csv").write_text("\n".join([header, *rows]))
    assert "--wall: 'a.jpg', 'b.jpg'" in run("facade", "read", "images.csv", code=2).stderr
    run("facade", "read", "images.csv", "--wall", "b.jpg")
    assert load_facade(folder / "images.facade.json").labels == ("door",)


def test_reading_again_into_the_same_folder_gives_the_same_file(run, folder):
    run("facade", "read", "house.xml", "-o", "f.json")
    before = (folder / "f.json").read_bytes()
    run("facade", "read", "house.xml", "-o", "f.json")
    assert (folder / "f.json").read_bytes() == before


def test_one_wall_of_a_model_is_chosen_by_name(run, folder):
    city = usual()
    city.wall(city.surface(city.polygon(drawing(0).boxes[0, 2:] * [[0, 0], [1, 0], [1, 1]] / 100)), name="side")
    (folder / "city.gml").write_bytes(city.content())
    listed = run("facade", "read", "city.gml", code=2).stderr
    assert "choose one with --wall" in listed
    assert "front  (9.0 x 6.0 m, 2 openings)" in listed
    values = json.loads(run("facade", "read", "city.gml", "--wall", "front", "--json").stdout)
    assert values["width"] == pytest.approx(9.0)


def test_a_pinwheel_is_named_and_split_when_asked(run, folder):
    (folder / "mill.csv").write_text(WINDMILL)
    result = run("facade", "read", "mill.csv", code=1)
    assert "form a pinwheel: a 1 at (0, 0) to (2, 1); b 2" in result.stderr
    assert not (folder / "mill.facade.json").exists()
    assert "are cut into parts" in run("facade", "read", "mill.csv", "--split").stderr


@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        (["missing.xml"], 2, "does not exist"),
        (["house.jpg"], 2, "expected a file that ends in"),
        (["broken.json"], 1, "broken.json: This is not valid JSON"),
        (["house.xml", "--width", "0"], 2, "above 0"),
        (["house.xml", "--width", "1e9"], 2, "at most 10,000"),
        (["house.xml", "--width", "nan"], 2, "above 0"),
        (["house.xml", "--tolerance", "2"], 2, "--tolerance"),
        (["house.xml", "-o", "house.xml"], 2, "is the input file"),
        (["house.xml", "-o", "other/f.json"], 1, "exists and differs"),
    ],
)
def test_what_cannot_be_read_is_explained_and_nothing_is_lost(run, folder, arguments, code, says):
    (folder / "broken.json").write_text("{")
    (folder / "other").mkdir()
    (folder / "other" / "house.jpg").write_bytes(b"mine")
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    assert says in run("facade", "read", *arguments, code=code).stderr
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before


def test_a_broken_picture_is_told(run, folder):
    (folder / "house.jpg").write_bytes(b"no picture")
    assert "not a PNG or JPEG" in run("facade", "read", "house.xml", code=1).stderr


def test_a_picture_elsewhere_is_left_where_it_is(run, folder):
    document = json.loads(as_coco(drawing(4)))
    document["images"][0]["file_name"] = "../../etc/house.jpg"
    (folder / "coco.json").write_text(json.dumps(document))
    run("facade", "read", "coco.json", "-o", "f.json")
    assert load_facade(folder / "f.json").pictures == ()
