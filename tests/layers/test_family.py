"""Layouts of many canvases as one grammar."""

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.facade.tree import Facade
from grammarlab.language.grammar import Grammar
from grammarlab.runs.facade.layer_files import family_of, solve_design
from tests.layers.samples import residential

WIDTHS, COUNT = (6.0, 9.0, 12.0), 2


def boxes(facade: Facade) -> np.ndarray:
    """Sorted boxes [L, 4] of leaves, to a micrometre."""
    found = np.concatenate([facade.position[facade.leaves], facade.size[facade.leaves]], axis=1).round(6) + 0.0
    return found[np.lexsort(found.T[::-1])]


@pytest.fixture(scope="module")
def layouts() -> list[Facade]:
    return [each.facade for width in WIDTHS for each in solve_design(residential(), width, None, COUNT)]


def test_each_sample_is_a_layout(layouts: list[Facade]) -> None:
    forest = derive(Grammar.parse(family_of(residential(), WIDTHS, [4.5], COUNT).text), 150, seed=3)
    model = forest.nodes.model[forest.leaves.node]
    seen = set()
    for number in range(150):
        rows = model == number
        found = np.concatenate([forest.leaves.position[rows][:, :2], forest.leaves.size[rows][:, :2]], axis=1)
        found = found.round(6) + 0.0
        found = found[np.lexsort(found.T[::-1])]
        same = [
            place
            for place, each in enumerate(layouts)
            if len(each.leaves) == len(found) and np.abs(boxes(each) - found).max() < 1e-5
        ]
        assert len(same) == 1, number
        seen.add(same[0])
    assert seen == set(range(len(layouts)))


def test_equal_parts_share_rules_and_labels_stay_apart() -> None:
    written = family_of(residential(), WIDTHS, [4.5], COUNT)
    assert written.rules < written.alone
    names = [rule.split(" -->")[0] for rule in written.text.split("\n") if " -->" in rule]
    assert len(names) == len(set(names)) == written.rules
    assert {"Window", "ShopWindow", "Column", "Door", "Roof", "Wall"} <= set(names)


def test_alternatives_are_layouts_of_one_canvas() -> None:
    either = residential({'"A(BA)^k"': '"A(BA)^k|AAAAAA"'})
    text = family_of(either, [6.0], [4.5], 3).text
    assert text.count("Front") >= 3
    assert "else :" in text
