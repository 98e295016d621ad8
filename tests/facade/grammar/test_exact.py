import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.derivation import derive
from grammarlab.errors import FacadeError
from grammarlab.facade.grammar.exact_grammar import EXACT, write_exact
from grammarlab.facade.tree import LEAF, Facade, Picture, X, Y, laid_out, plain
from grammarlab.language.checking.check import check_text
from grammarlab.language.grammar import Grammar
from grammarlab.runs.sample.checks import SUPPORTED
from tests.facade.grammar.houses import house
from tests.facade.strategies import trees


def derived(text: str) -> list[tuple[float, ...]]:
    leaves = derive(Grammar.parse(text), 1, seed=0).leaves
    return sorted(map(tuple, np.concatenate([leaves.position[:, :2], leaves.size[:, :2]], axis=1).tolist()))


@settings(max_examples=20)
@given(trees(), st.sampled_from([1e-3, 1.0, 37.0, 1e4]))
def test_the_derivation_gives_back_every_leaf(facade: Facade, scale: float) -> None:
    facade = replace(facade, position=facade.position * scale, size=facade.size * scale)
    written = write_exact(facade)
    expected = np.concatenate([facade.position, facade.size], axis=1)[facade.leaves]
    found = np.array(derived(written.text))
    assert len(found) == len(expected)
    misses = np.abs(found[:, None] - expected[None]).max(axis=2)
    assert misses.min(axis=0).max() <= 2 * EXACT
    assert misses.min(axis=1).max() <= 2 * EXACT
    assert written.error <= EXACT


@settings(max_examples=20)
@given(trees())
def test_the_grammar_is_supported_whole(facade: Facade) -> None:
    assert check_text(write_exact(facade).text, supported=SUPPORTED) == ()


def test_equal_parts_share_a_rule_and_runs_are_repeats() -> None:
    text = write_exact(house(columns=5, rows=4)).text
    assert "{ ~0.9 : Wall | 1.1 : Window }*" in text
    assert "{ ~1.2 : Wall | 1.5 : WindowRow }*" in text
    assert text.count("-->") == len(("Lot", "Facade", "Wall", "Row", "Window", "Door", "WindowRow", "Cornice"))


def test_as_many_windows_on_both_sides_of_a_door_are_two_repeats() -> None:
    assert write_exact(house(columns=5, rows=2)).text.count("{ ~0.9 : Wall | 1.1 : Window }*") == 3


def test_without_walls_everything_gives() -> None:
    axis = np.array([X, LEAF, LEAF], dtype=np.int8)
    position, size = laid_out(np.array([-1, 0, 0]), axis, np.array([[0, 0], [1.0, 2], [2.0, 2]]))
    assert (
        "~1 : Window | ~2 : Window"
        in write_exact(plain(np.array([-1, 0, 0]), axis, position, size, ["", *["window"] * 2])).text
    )


def test_a_facade_that_begins_elsewhere_begins_at_the_lot() -> None:
    facade = house(columns=3, rows=2)
    assert (
        write_exact(replace(facade, position=facade.position + np.array([1e5, -40.0]))).text == write_exact(facade).text
    )


def test_labels_of_strangers_are_names_of_rules() -> None:
    names = ["", 'a"b\n} Lot -->', "Lot", "NIL", "lot", "é"]
    parent = np.array([-1, *[0] * 5])
    axis = np.array([Y, *[LEAF] * 5], dtype=np.int8)
    position, size = laid_out(parent, axis, np.ones((6, 2)))
    assert len(derived(write_exact(plain(parent, axis, position, size, names)).text)) == 5


def test_what_is_too_thin_for_rules_is_explained() -> None:
    facade = house(columns=3, rows=2)
    with pytest.raises(FacadeError, match=r"miss a leaf by .* m, expected at most 1e-09"):
        write_exact(replace(facade, position=facade.position * 1e-9, size=facade.size * 1e-9))


def pictured(facade: Facade) -> Facade:
    low, high = facade.position / facade.size[0], (facade.position + facade.size) / facade.size[0]
    return replace(
        facade,
        pictures=(Picture("front view.png", b""),),
        picture=np.zeros(len(facade), dtype=np.int64),
        window=np.concatenate([low, high], axis=1),
    )


def coordinates(text: str) -> dict[tuple[float, ...], tuple[float, ...]]:
    """For the box of each leaf, its window."""
    forest = derive(Grammar.parse(text), 1, seed=0)
    leaves, found = forest.leaves, {}
    for row in range(len(leaves)):
        low, size = leaves.position[row], leaves.size[row]
        corners = np.stack([np.append(low, 1.0), np.append(low + size, 1.0)])
        window = corners @ forest.texture_maps[leaves.texture_map[row]].T
        found[tuple(np.concatenate([low[:2], size[:2]]).round(9).tolist())] = tuple(window.ravel().tolist())
    return found


def test_one_picture_of_the_whole_is_laid_once() -> None:
    facade = pictured(house(columns=4, rows=3))
    text = write_exact(facade).text
    assert text.count("setupProjection") == 1
    assert 'texture("front_view.png")' in text
    found = coordinates(text)
    for leaf in facade.leaves:
        box = np.concatenate([facade.position[leaf], facade.size[leaf]]).round(9).tolist()
        assert np.allclose(found[tuple(box)], facade.window[leaf], atol=1e-9)


def test_leaves_with_windows_of_their_own_show_them() -> None:
    facade = pictured(house(columns=2, rows=1))
    window = np.sort(np.random.default_rng(1).uniform(size=(len(facade), 2, 2)), axis=1).reshape(-1, 4)
    facade = replace(facade, window=window)
    found = coordinates(write_exact(facade).text)
    for leaf in facade.leaves:
        box = np.concatenate([facade.position[leaf], facade.size[leaf]]).round(9).tolist()
        assert np.allclose(found[tuple(box)], window[leaf], atol=1e-9)


def test_no_rule_is_left_over() -> None:
    names = re.findall(r"^(\w+) -->", write_exact(house(columns=6, rows=5)).text, re.MULTILINE)
    assert len(names) == len(set(names))
