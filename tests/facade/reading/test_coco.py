"""COCO JSON as programs write it."""

import json

import pytest

from grammarlab.errors import FacadeError
from grammarlab.facade.reading.formats import read_annotation

SQUARE = [10, 10, 30, 10, 30, 50, 10, 50]


def document(**changes):
    annotation = {"image_id": 7, "category_id": 1, "bbox": [10, 10, 20, 40], "segmentation": [SQUARE]}
    return {
        "images": [{"id": 7, "file_name": "a.jpg", "width": 100, "height": 100}],
        "categories": [{"id": 1, "name": "window"}],
        "annotations": [annotation | changes],
    }


def read(tmp_path, value):
    (tmp_path / "a.json").write_text(json.dumps(value))
    return read_annotation(tmp_path / "a.json")


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"image_id": "7"},
        {"image_id": 7.0},
        {"image_id": "a.jpg"},
        {"category_id": "1"},
        {"category_id": "window"},
        {"segmentation": SQUARE},
        {"segmentation": []},
        {"bbox": []},
        {"bbox": [], "segmentation": SQUARE},
    ],
)
def test_ids_and_polygons_have_several_forms(tmp_path, changes):
    found = read(tmp_path, document(**changes))
    assert (found.low.tolist(), found.high.tolist(), found.names) == ([[10, 50]], [[30, 90]], ("window",))
    assert found.notes == ()


@pytest.mark.parametrize("identity", [None, "front", 3])
def test_ids_of_images_may_be_texts_or_missing(tmp_path, identity):
    value = document(image_id=identity)
    value["images"][0]["id"] = identity
    assert read(tmp_path, value).names == ("window",)


@pytest.mark.parametrize("size", [{}, {"width": 0, "height": 0}, {"width": None, "height": None}, {"width": "100"}])
def test_boxes_keep_their_sizes_and_order_without_the_size_of_the_image(tmp_path, size):
    value = document()
    value["images"] = [{"id": 7, "file_name": "a.jpg"} | size]
    value["annotations"].append({"image_id": 7, "category_id": 1, "bbox": [10, 60, 20, 30]})
    found = read(tmp_path, value)
    assert found.low.tolist() == [[10, 40], [10, 0]]
    assert found.high.tolist() == [[30, 80], [30, 30]]


@pytest.mark.parametrize("segmentation", [{"counts": [1, 2], "size": [100, 100]}, [SQUARE, SQUARE]])
def test_masks_are_read_as_their_boxes_with_a_note(tmp_path, segmentation):
    found = read(tmp_path, document(segmentation=segmentation))
    assert found.high.tolist() == [[30, 90]]
    assert found.notes == ("1 masks or shapes of several polygons are read as their boxes",)


def test_annotations_of_no_image_are_counted(tmp_path):
    value = document()
    value["annotations"].append({"image_id": 8, "category_id": 1, "bbox": [1, 1, 2, 2]})
    found = read(tmp_path, value)
    assert (len(found.names), found.notes) == (1, ("1 annotations belong to no image of this file and are left out",))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"image_id": 8}, "expected the image_id '7' of the only image, found '8'"),
        (
            {"category_id": None},
            "entry 0: expected a category_id of the list categories, found nothing. VIA writes null",
        ),
        ({"category_id": 5}, "entry 0: expected a category_id of the list categories, found 5"),
        ({"bbox": [1, 2, 3]}, "entry 0, bbox: expected 4 numbers"),
        ({"bbox": [1, 2, -3, 4]}, "negative width"),
        ({"bbox": [1, 2, 1e300, 4]}, "bbox: expected at most 1e[+]09"),
        (
            {"bbox": [1, 2, 3, 4], "attributes": {"rotation": "left"}},
            "rotation: expected a finite number, found 'left'",
        ),
        ({"bbox": [1, 2, 3, 4], "segmentation": [["a"] * 6]}, "segmentation: expected a finite number"),
    ],
)
def test_what_is_wrong_is_named(tmp_path, change, message):
    with pytest.raises(FacadeError, match=message):
        read(tmp_path, document(**change))


def test_two_images_with_one_id_are_not_guessed(tmp_path):
    value = document()
    value["images"] += [{"id": 7, "file_name": "b.jpg"}]
    (tmp_path / "a.json").write_text(json.dumps(value))
    with pytest.raises(FacadeError, match=r"'b.jpg' has the id 7 of another image"):
        read_annotation(tmp_path / "a.json", "b.jpg")
