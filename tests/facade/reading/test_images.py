"""Files of several images: each is chosen by its name, its id or the end of its path."""

import json

import numpy as np
import pytest
from PIL import Image

from grammarlab.errors import FacadeError, UsageError
from grammarlab.facade.reading.formats import read_annotation

BOXES = {"walls/front.jpg": (10, 20, 60, 90), "walls/side.jpg": (5, 8, 40, 30)}
SIZE = (100, 100)


def as_coco():
    images = [{"id": k, "file_name": name, "width": 100, "height": 100} for k, name in enumerate(BOXES)]
    annotations = [
        {"image_id": str(k), "category_id": "1", "bbox": [left, top, right - left, bottom - top]}
        for k, (left, top, right, bottom) in enumerate(BOXES.values())
    ]
    return json.dumps(
        {"images": images, "annotations": annotations, "categories": [{"id": 1, "name": "window"}]}
    ), ".json"


def as_cvat():
    images = "".join(
        f'<image id="{k}" name="{name}" width="100" height="100">'
        f'<box label="window" xtl="{box[0]}" ytl="{box[1]}" xbr="{box[2]}" ybr="{box[3]}"/><tag label="old"/></image>'
        for k, (name, box) in enumerate(BOXES.items())
    )
    return f"<annotations>{images}</annotations>", ".xml"


def _regions(box):
    left, top, right, bottom = box
    shape = {"name": "rect", "x": left, "y": top, "width": right - left, "height": bottom - top}
    return [{"shape_attributes": shape, "region_attributes": {"class": "window"}}]


def as_via():
    size = {"width": 100, "height": 100}
    return json.dumps(
        {
            str(k): {"filename": name, "size": 1, "regions": _regions(box), "file_attributes": size}
            for k, (name, box) in enumerate(BOXES.items())
        }
    ), ".json"


def as_label_studio():
    tasks = []
    for k, (name, (left, top, right, bottom)) in enumerate(BOXES.items()):
        value = {"x": left, "y": top, "width": right - left, "height": bottom - top, "rectanglelabels": ["window"]}
        region = {"value": value, "original_width": 100, "original_height": 100}
        tasks.append({"id": k, "data": {"image": f"s3://bucket/{name}?token=x"}, "annotations": [{"result": [region]}]})
    return json.dumps(tasks), ".json"


def as_table():
    lines = [f"{name},100,100,window,{','.join(map(str, box))}" for name, box in BOXES.items()]
    return "\n".join(["filename,width,height,class,xmin,ymin,xmax,ymax", *lines]), ".csv"


@pytest.mark.parametrize("writer", [as_coco, as_cvat, as_via, as_label_studio, as_table])
def test_one_image_of_several_is_chosen_by_its_names(tmp_path, writer):
    text, suffix = writer()
    path = tmp_path / f"a{suffix}"
    path.write_text(text)
    for name in ("side.jpg", *(() if writer is as_label_studio else ("walls/side.jpg",))):
        found = read_annotation(path, name)
        assert (found.low.tolist(), found.high.tolist(), found.unit) == ([[5, 70]], [[40, 92]], "pixels")
    if writer is not as_table:
        assert read_annotation(path, "0").high.tolist() == [[60, 80]]
    for name in ("", "other.jpg"):
        with pytest.raises(UsageError, match=r"choose one of the 2 images of this file with `wall=`: .*front.jpg"):
            read_annotation(path, name)


def test_two_images_with_one_name_are_not_guessed(tmp_path):
    (tmp_path / "a.csv").write_text(as_table()[0].replace("walls/side.jpg", "doors/front.jpg"))
    with pytest.raises(UsageError, match="choose one of the 2 images"):
        read_annotation(tmp_path / "a.csv", "front.jpg")
    assert read_annotation(tmp_path / "a.csv", "doors/front.jpg").high.tolist() == [[40, 92]]


def test_images_of_several_subsets_of_cvat_are_chosen_by_subset(tmp_path):
    image = '<image id="0" name="front.jpg" subset="{}" width="9" height="9">{}</image>'
    box = '<box label="window" xtl="1" ytl="1" xbr="{}" ybr="3"/>'
    images = "".join(image.format(name, box.format(right)) for name, right in (("Train", 4), ("Test", 5)))
    (tmp_path / "a.xml").write_text(f"<annotations>{images}</annotations>")
    with pytest.raises(UsageError, match=r"with `wall=`: 'Train/front.jpg', 'Test/front.jpg'"):
        read_annotation(tmp_path / "a.xml", "front.jpg")
    found = read_annotation(tmp_path / "a.xml", "Test/front.jpg")
    assert (found.high.tolist(), found.picture) == ([[5, 8]], "front.jpg")


def test_further_labels_of_a_shape_are_told(tmp_path):
    box = {"x": 10, "y": 10, "width": 20, "height": 20, "rectanglelabels": ["window", "arched"]}
    region = {"type": "rectanglelabels", "original_width": 100, "original_height": 100, "value": box}
    task = {"id": 1, "data": {"image": "front.jpg"}, "annotations": [{"result": [region]}]}
    (tmp_path / "a.json").write_text(json.dumps([task]))
    found = read_annotation(tmp_path / "a.json")
    assert (found.names, found.notes) == (
        ("window",),
        ("1 shapes have several labels, of which the first one is read",),
    )


def test_images_with_one_name_are_listed_by_their_ids(tmp_path):
    document = json.loads(as_coco()[0])
    document["images"] = [image | {"file_name": "front.jpg"} for image in document["images"]]
    (tmp_path / "a.json").write_text(json.dumps(document))
    ids = ", ".join(repr(str(image["id"])) for image in document["images"])
    with pytest.raises(UsageError, match=f"with `wall=`: {ids}"):
        read_annotation(tmp_path / "a.json", "front.jpg")


def test_the_picture_beside_the_file_gives_the_size_that_the_file_lacks(tmp_path):
    Image.new("RGB", (100, 100)).save(tmp_path / "front.jpg")
    document = json.loads(as_coco()[0])
    document["images"] = [{"id": 0, "file_name": "front.jpg"}]
    document["annotations"] = document["annotations"][:1]
    (tmp_path / "a.json").write_text(json.dumps(document))
    found = read_annotation(tmp_path / "a.json")
    assert (found.low.tolist(), found.picture_area.tolist()) == ([[10, 10]], [[0, 0], [100, 100]])
    assert (found.picture, found.notes) == ("front.jpg", ())
    (tmp_path / "front.jpg").unlink()
    without = read_annotation(tmp_path / "a.json")
    assert without.picture == ""
    np.testing.assert_array_equal(without.high - without.low, found.high - found.low)


def test_a_picture_of_another_shape_than_its_annotation_is_reported(tmp_path):
    Image.new("RGB", (60, 100)).save(tmp_path / "front.jpg")
    (tmp_path / "a.csv").write_text(as_table()[0].replace("walls/front.jpg", "front.jpg"))
    found = read_annotation(tmp_path / "a.csv", "front.jpg")
    assert any("front.jpg has 60 x 100 pixels, but its annotation 100 x 100" in note for note in found.notes)


def test_a_box_outside_of_its_picture_is_refused_by_its_label(tmp_path):
    (tmp_path / "a.csv").write_text(as_table()[0].replace("10,20,60,90", "110,20,160,90"))
    with pytest.raises(FacadeError, match=r"Box 1 \(window: .*\) is outside the picture"):
        read_annotation(tmp_path / "a.csv", "front.jpg")
