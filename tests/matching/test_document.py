"""Files of elements: round trips and error messages."""

import io
import json
import zipfile
from typing import Any

import numpy as np
import pytest

from grammarlab.errors import FacadeError, UsageError
from grammarlab.matching.elements import too_poor
from grammarlab.matching.scans.element_files import load_arrays, loads, save_elements
from grammarlab.matching.scans.scan_boxes import cut_out, read_boxes
from grammarlab.matching.scans.scan_files import load_elements
from grammarlab.matching.scenes import SceneOptions, house, rectangles

SCENE = rectangles(SceneOptions(elements=8, kinds=4, rows=2), 3)


@pytest.mark.parametrize("ending", ["json", "npz"])
def test_a_scene_is_read_as_it_was_written(tmp_path, ending):
    path = tmp_path / f"scene.{ending}"
    save_elements(SCENE, path)
    read = load_elements(path)
    for name in ("offsets", "points", "low", "high", "row", "column"):
        assert np.array_equal(getattr(read, name), getattr(SCENE, name)), name
    assert read.truth is not None
    assert SCENE.truth is not None
    assert np.array_equal(read.truth.kind, SCENE.truth.kind)


def test_scenes_are_the_same_for_the_same_seed_and_count_as_the_figure():
    assert np.array_equal(rectangles(SceneOptions(), 1).points, rectangles(SceneOptions(), 1).points)
    assert not np.array_equal(rectangles(SceneOptions(), 1).points, rectangles(SceneOptions(), 2).points)
    truth = house().truth
    assert truth is not None
    assert np.bincount(truth.kind).tolist() == [38, 4, 23, 23]


@pytest.mark.parametrize(
    ("elements", "message"),
    [
        ([], "no elements"),
        ([{"points": [[0, 0], [1, None]]}], "Element 0, point 1"),
        ([{"points": [[0, 0], [1, 1, 1]]}], "Element 0, point 1"),
        ([{"points": [[0, 0]], "box": [1, 1, 0, 0]}], "width and a height"),
        ([{"points": [[0, 0]], "box": [1, 1]}], "4 numbers"),
        ([{"points": [], "box": [0, 0, 1, 1]}], "boxes are empty"),
        ([{"points": [[1e300, 0]]}], "not a finite number"),
        ([{"points": [[0, 0]], "kind": 0}, {"points": [[0, 0]]}], "Element 1"),
    ],
)
def test_what_is_wrong_is_said_with_its_place(elements, message):
    with pytest.raises(FacadeError, match=message):
        loads(json.dumps({"elements": elements}).encode())


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"points": np.zeros((4, 2), dtype=complex)}, "points: expected rows of real numbers"),
        ({"offsets": np.array([0.0, np.nan])}, "offsets: expected a list of whole numbers"),
        ({"boxes": np.array(3.0)}, "boxes: expected rows"),
        ({"kind": np.array([10**15])}, r"boxes \[N, 4\]"),
        ({"points": np.array([[None, 1]] * 4)}, "allow_pickle"),
    ],
)
def test_arrays_of_other_numbers_are_refused(columns, message):
    buffer = io.BytesIO()
    fine: dict[str, Any] = {"offsets": np.array([0, 4]), "points": np.zeros((4, 2)), "boxes": np.array([[0, 0, 1, 1]])}
    np.savez(buffer, **{**fine, **columns})
    with pytest.raises(FacadeError, match=message):
        load_arrays(buffer.getvalue())


def test_an_archive_that_unfolds_to_too_much_is_not_unfolded():
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("points.npy", b"")
    packed = bytearray(buffer.getvalue())
    place = packed.index(b"PK\x01\x02") + 24
    packed[place : place + 4] = (2**32 - 2).to_bytes(4, "little")
    with pytest.raises(FacadeError, match="unfolds to 4,294,967,294 bytes"):
        load_arrays(bytes(packed))


def test_poor_elements_are_told_apart():
    clouds = [[], [[0, 0]] * 20, [[x, x] for x in range(20)], [[0, 0], [1, 0]], np.eye(2).tolist() * 10]
    elements = [{"points": each, "box": [0, 0, 30, 30]} for each in clouds]
    reasons = too_poor(loads(json.dumps({"elements": elements}).encode()))
    assert [word in reasons[each] for each, word in enumerate(("empty", "the same", "one line", "2 points"))] == [
        True
    ] * 4


def test_boxes_of_a_scan_take_their_points_and_find_their_rows():
    points = np.array([[0.5, 0.5, 0], [3.5, 0.4, 0], [0.4, 5.5, 0], [9, 9, 0]], dtype=float)
    found = cut_out(points, read_boxes(b"left,bottom,right,top\n0,0,1,1\n3,0,4,1\n0,5,1,6\n"))
    assert (found.counts.tolist(), found.row.tolist(), found.column.tolist()) == ([1, 1, 1], [1, 1, 0], [0, 1, 0])
    with pytest.raises(FacadeError, match="line 2"):
        read_boxes(b"0,0,1,1\n0,0,x,1\n")


BOXES = [[0.5, 0.0, 1.25, 1.0], [3.0, 0.0, 4.0, 1.5]]


@pytest.mark.parametrize(
    "text",
    [
        "0.5,0,1.25,1\n3,0,4,1.5\n",
        "left,bottom,right,top\r\n0.5,0,1.25,1\r\n\r\n3,0,4,1.5\r\n,,,\r\n",
        "0,5;0,0;1,25;1,0\n3,0;0,0;4,0;1,5\n",
        "Left ; Bottom;Right;Top;\n0,5;0; 1,25;1;\n3;0;4;1,5;\n;;;;\n",
        "0.5\t0\t1.25\t1\n3\t0\t4\t1.5\n",
        "name,top,left,right,bottom\na,1,0.5,1.25,0\nb,1.5,3,4,0\n",
        "sep=;\n0,5;0;1,25;1\n3;0;4;1,5\n",
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_boxes_are_read_as_spreadsheets_write_them(text, encoding):
    assert read_boxes(text.encode(encoding)).tolist() == BOXES


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x,y,width,height\n0,0,1,1\n", "line 1: expected the columns left, bottom, right, top once each"),
        ("left,bottom,right,top\n", "none below the header"),
        ("0,0,1\n", "line 1: expected left, bottom, right, top"),
        ("0,0,1,1,7\n", "line 1: "),
        ("0,0,1_0,1\n", "line 1: "),
        ('0,0,"1,1\n', "line 1: this is not valid CSV"),
    ],
)
def test_tables_that_are_not_of_boxes_are_refused_by_line(text, message):
    with pytest.raises(FacadeError, match=f"Boxes.*{message}"):
        read_boxes(text.encode())


def test_other_endings_are_refused(tmp_path):
    (tmp_path / "a.txt").write_text("")
    with pytest.raises(UsageError, match=r"\.json"):
        load_elements(tmp_path / "a.txt")
