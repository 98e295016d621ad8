"""Outlines and pictures of families."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.facade.grammar.family import WrittenFamily, write_family
from grammarlab.facade.grammar.leaf_looks import store_shapes
from grammarlab.facade.looks import look_of
from grammarlab.facade.tree import Facade, X
from grammarlab.language.checking.check import check_text
from grammarlab.language.grammar import Grammar
from grammarlab.runs.sample.checks import SUPPORTED
from tests.facade.grammar.houses import house, of_columns
from tests.facade.grammar.test_exact import coordinates, pictured
from tests.facade.grammar.test_outlines import ARCH


def family(facade: Facade, low: float = 0.7, high: float = 1.5) -> WrittenFamily:
    width, height = facade.size[0].tolist()
    written = write_family(facade, (low * width, high * width), (low * height, high * height))
    assert check_text(written.text, supported=SUPPORTED) == ()
    return written


def arched(facade: Facade, outline: np.ndarray, every: int = 1) -> Facade:
    """With one of `every` windows of each row outlined."""
    windows = [leaf for leaf in facade.leaves.tolist() if facade.name_of(leaf) == "window"]
    place = {leaf: k for row in np.flatnonzero(facade.axis == X) for k, leaf in enumerate(facade.children[row][1::2])}
    points = [outline if leaf in windows and place[leaf] % every == 0 else outline[:0] for leaf in range(len(facade))]
    offsets = np.cumsum([0, *(len(each) for each in points)])
    return replace(facade, outline_offsets=offsets, outline_points=np.concatenate(points))


def test_arches_stay_arches(tmp_path: Path) -> None:
    facade = arched(house(columns=5, rows=3), ARCH)
    written = family(facade)
    assert written.error == pytest.approx(0.0, abs=1e-9)
    assert len(written.outlined) == 1
    store_shapes(written.outlined, tmp_path)
    assert len(list(tmp_path.iterdir())) == 2  # the arch and the wall around it
    forest = derive(Grammar.parse(written.text), 24, seed=3, assets=tmp_path)
    leaves = forest.leaves
    symbols = [forest.symbols[symbol].rstrip(".") for symbol in forest.nodes.symbol[leaves.node].tolist()]
    arches = np.array([symbol == "WindowShape" for symbol in symbols])
    around = np.array([symbol == "Around" for symbol in symbols])
    assert arches.sum() == around.sum() > 24
    assert "Window" not in symbols
    assert np.allclose(leaves.size[arches, :2], [1.1, 1.5])
    assert written.text.count("i(") == 2


def test_windows_of_other_outlines_are_other_columns() -> None:
    facade = arched(of_columns(["WWWWW"] * 3), ARCH, every=2)
    written = family(facade)
    assert written.error == pytest.approx(0.0, abs=1e-9)
    plain = family(of_columns(["WWWWW"] * 3))
    assert written.facades < plain.facades  # arches and rectangles take turns
    nearly = arched(of_columns(["WWWWW"] * 3), np.array([[0, 0], [1, 0], [1, 0.99], [0.5, 1], [0, 0.99]]), every=2)
    assert family(nearly).facades == plain.facades


def test_things_of_the_own_columns_and_rows_show_what_they_do_in_the_facade() -> None:
    facade = pictured(of_columns(["WBD", "WBW"]))
    found = coordinates(family(facade, 0.999, 1.001).text)
    boxes = np.array(list(found))
    assert boxes[:, 2:].prod(axis=1).sum() == pytest.approx(facade.size[0].prod())
    things = [leaf for leaf in facade.leaves.tolist() if facade.name_of(leaf) in ("window", "door")]
    assert len(things) == 6
    for leaf in things:
        miss = np.abs(boxes - np.concatenate([facade.position[leaf], facade.size[leaf]])).max(axis=1)
        assert miss.min() < 1e-5
        assert np.allclose(found[tuple(boxes[miss.argmin()].tolist())], facade.window[leaf], atol=1e-6)


def test_all_samples_show_things_whole_and_walls_as_long_as_they_are() -> None:
    facade = pictured(house(columns=5, rows=4))
    text = family(facade).text
    windows = {
        name: {tuple(facade.window[leaf].round(6)) for leaf in facade.leaves if facade.name_of(leaf) == name}
        for name in facade.labels
    }
    forest = derive(Grammar.parse(text), 24, seed=3)
    leaves = forest.leaves
    low, size = leaves.position, leaves.size
    first, last = (
        np.einsum("kij,kj->ki", forest.texture_maps[leaves.texture_map], np.column_stack([xyz, np.ones(len(xyz))]))
        for xyz in (low, low + size)
    )
    for leaf in range(len(leaves)):
        name = forest.symbols[forest.nodes.symbol[leaves.node[leaf]]].rstrip("0123456789").lower()
        if name in ("window", "door"):
            assert tuple(np.concatenate([first[leaf], last[leaf]]).round(6)) in windows[name]
        else:
            assert look_of(name).is_flexible or name == "cornice"
    assert np.allclose((last - first) / size[:, :2], 1.0 / facade.size[0], rtol=1e-4)


def test_a_picture_with_seams_changes_neither_columns_nor_rows() -> None:
    facade = house(columns=5, rows=4)
    window = np.sort(np.random.default_rng(1).uniform(size=(len(facade), 2, 2)), axis=1).reshape(-1, 4)
    seamed, plain = family(replace(pictured(facade), window=window)), family(facade)
    assert replace(seamed, text="", rules=0) == replace(plain, text="", rules=0)
    # A picture divides walls into more rules, which moves the places that models draw from, but no probability.
    one, other = (choices(written.text) for written in (seamed, plain))
    assert one == other
    assert len(one) > 10


def choices(text: str) -> list[str]:
    """The ways of all random choices of a family, without numbers that tell bays of one name apart."""
    ways = (line.strip() for line in text.splitlines() if "% :" in line or line.strip().startswith("else :"))
    return [re.sub(r"(Bay|Pier)\d*", r"\1", way) for way in ways]


def test_a_picture_that_goes_on_is_projected_once_and_percentages_are_round() -> None:
    text = family(pictured(house(columns=5, rows=4))).text
    rules = [line.split(" -->")[0] for line in text.splitlines() if "-->" in line]
    assert {"Wall", "Window", "Door", "Cornice"} < set(rules)
    assert not [name for name in rules if re.fullmatch("(Wall|Window|Door|Cornice)[0-9]+", name)]
    assert re.findall(r"[\d.]+(?=%)", text) == re.findall(r"\d+(?=%)", text)
