from dataclasses import replace
from xml.etree import ElementTree as ET

import numpy as np
from hypothesis import given, settings

from grammarlab.facade.drawing import svg
from grammarlab.facade.tree import Facade
from tests.facade.grammar.houses import house
from tests.facade.strategies import trees
from tests.facade.test_scene import ARCH, pictured, with_outline

NAMESPACE = "{http://www.w3.org/2000/svg}"


def drawn(facade: Facade) -> ET.Element:
    return ET.fromstring(svg(facade))  # noqa: S314 - our own drawing


@settings(max_examples=25)
@given(trees())
def test_one_element_for_each_leaf_that_tile_the_drawing(facade: Facade) -> None:
    root = drawn(facade)
    leaves = root.findall(f"{NAMESPACE}rect")
    assert len(leaves) == len(facade.leaves)
    areas = [float(each.attrib["width"]) * float(each.attrib["height"]) for each in leaves]
    assert np.isclose(sum(areas), facade.width * facade.height, rtol=1e-4)
    tops = sorted(float(each.attrib["y"]) for each in leaves)
    assert np.allclose(
        tops, sorted(facade.height - facade.position[facade.leaves, 1] - facade.size[facade.leaves, 1]), atol=1e-5
    )


def test_an_outline_is_a_path_before_wall() -> None:
    facade = house(columns=1, rows=2)
    leaf = next(leaf for leaf in facade.leaves.tolist() if facade.name_of(leaf) == "window")
    root = drawn(with_outline(facade, leaf, ARCH))
    path = root.find(f"{NAMESPACE}path")
    assert path is not None
    assert path.attrib["class"] == "window"
    assert path.attrib["d"].count("L") == len(ARCH) - 1


def test_a_picture_is_embedded_once_and_each_leaf_shows_its_part() -> None:
    facade = pictured(house(columns=2, rows=1))
    root = drawn(facade)
    assert len(root.findall(f"{NAMESPACE}defs/{NAMESPACE}image")) == 1
    views = [list(map(float, each.attrib["viewBox"].split())) for each in root.findall(f"{NAMESPACE}svg")]
    assert len(views) == len(facade.leaves)
    assert np.isclose(sum(width * height for _, _, width, height in views), 1.0, atol=1e-4)


def test_labels_of_strangers_do_not_leave_their_attribute() -> None:
    facade = replace(house(columns=1, rows=1), labels=('"><script>', "\x00&", "wall"))
    root = drawn(facade)
    assert {each.attrib["class"] for each in root.findall(f"{NAMESPACE}rect")} == {"script", "part", "wall"}
