"""Tastes about several parts, against walks over the derivation trees in plain Python."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
import pytest

from grammarlab.derivation.derive import derive
from grammarlab.derivation.forest import Forest
from grammarlab.features.patterns.counts import count
from grammarlab.language.grammar import Grammar
from grammarlab.tastes.aggregates import aggregates
from grammarlab.tastes.basic_quantities import Elements
from grammarlab.tastes.language import candidates
from grammarlab.tastes.relations import contexts
from tests.tastes.grammars import elements_of, forests_of


class Node:
    """A node of a tree: its symbol, the first successor of its rule, and its children."""

    def __init__(self, symbol: str, children: Sequence[Node]) -> None:
        self.symbol, self.children = symbol, children

    @property
    def choice(self) -> str:
        return self.children[0].symbol

    def all(self, symbol: str) -> list[Node]:
        """Nodes of a symbol from the left to the right."""
        return [self] * (self.symbol == symbol) + [node for child in self.children for node in child.all(symbol)]


def trees_of(forest: Forest) -> list[Node]:
    below: dict[int, list[int]] = {}
    for row, parent in enumerate(forest.nodes.parent.tolist()):
        below.setdefault(parent, []).append(row)

    def node(row: int) -> Node:
        order = sorted(below.get(row, []), key=lambda child: (forest.nodes.child[child], forest.nodes.repeat[child]))
        return Node(forest.symbols[forest.nodes.symbol[row]], [node(child) for child in order])

    return [node(root) for root in below[-1]]


def towers(tree: Node) -> list[str]:
    return [tower.choice for tower in tree.all("Tower")]


def parts(tree: Node) -> list[str]:
    return [part.choice for part in tree.all("Part")]


def roofs(tree: Node) -> list[str]:
    return [roof.choice for roof in tree.all("Roof")]


def styles(tree: Node) -> list[str]:
    """Of the walls, the floor and the roof."""
    parts = ("Walls", "Floor", "Roof")
    return [style for part in parts for style in ("Office", "House") if tree.all(part + style)]


def both_sides(tree: Node) -> list[bool]:
    """Of sections with two sides, whether they are alike."""
    sides = [section.children for section in tree.all("Section") if len(section.children) == 2]
    return [left.choice == right.choice for left, right in sides]


def unlike_most(elements: list[str]) -> int:
    return len(elements) - max(Counter(elements).values())


def position(wanted: str, elements: list[str]) -> int:
    return elements.index(wanted) + 1 if wanted in elements else 0


def alternate(elements: list[str]) -> bool:
    """Of three elements or more."""
    return len(elements) > 2 and elements[0] != elements[1] and elements[2:] == elements[:-2]


def after(first: str, second: str, elements: list[str]) -> bool:
    """Whether the second one is somewhere after the first one."""
    return first in elements and second in elements[elements.index(first) :]


def more_before(wanted: str, elements: list[str]) -> int:
    """How many more there are before the middle of a sequence than after it."""
    half = len(elements) // 2
    return elements[:half].count(wanted) - elements[-half:].count(wanted)


TASTES: dict[str, tuple[str, Callable[[Node], float]]] = {
    "all towers alike": ("towers", lambda tree: len(set(towers(tree))) == 1),
    "no two neighbouring towers alike": ("towers", lambda tree: all(a != b for a, b in pairwise(towers(tree)))),
    "towers by turns": ("towers", lambda tree: alternate(towers(tree))),
    "mirrored towers": ("towers", lambda tree: towers(tree) == towers(tree)[::-1]),
    "kinds of towers": ("towers", lambda tree: len(set(towers(tree)))),
    "changes along the towers": ("towers", lambda tree: sum(a != b for a, b in pairwise(towers(tree)))),
    "odd towers": ("towers", lambda tree: unlike_most(towers(tree))),
    "the first and the second tower alike": ("towers", lambda tree: towers(tree)[0] == towers(tree)[1]),
    "the end towers alike": ("towers", lambda tree: towers(tree)[0] == towers(tree)[-1]),
    "towers like the second one": ("towers", lambda tree: towers(tree).count(towers(tree)[1]) - 1),
    "glass before the middle and after it": ("towers", lambda tree: more_before("Glass", towers(tree))),
    "brick somewhere before glass": ("towers", lambda tree: after("Brick", "Glass", towers(tree))),
    "share of glass": ("towers", lambda tree: towers(tree).count("Glass") / len(towers(tree))),
    "position of the first tower of steel": (
        "towers",
        lambda tree: [*towers(tree), "Steel"].index("Steel") + 1 if "Steel" in towers(tree) else 0,
    ),
    "neighbouring parts alike": ("recursive", lambda tree: sum(a == b for a, b in pairwise(parts(tree)))),
    "mirrored parts": ("recursive", lambda tree: len(parts(tree)) > 1 and parts(tree) == parts(tree)[::-1]),
    "kinds of parts": ("recursive", lambda tree: len(set(parts(tree)))),
    "floors of glass in any building": ("roles", lambda tree: len([*tree.all("OfficeGlass"), *tree.all("HouseGlass")])),
    "a flat roof": ("roles", lambda tree: len([*tree.all("OfficeFlat"), *tree.all("HouseFlat")])),
    "styles of floors and roofs": ("styles", lambda tree: len(set(styles(tree)))),
    "both floors of a house alike": (
        "roles",
        lambda tree: len(tree.all("HouseFloor")) == 2 and len({floor.choice for floor in tree.all("HouseFloor")}) == 1,
    ),
    "both sides of all sections alike": ("sections", lambda tree: bool(both_sides(tree)) and all(both_sides(tree))),
    "sections with unlike sides": ("sections", lambda tree: both_sides(tree).count(False)),
    "flat roofs and gables": ("towers", lambda tree: len(roofs(tree))),
}


@pytest.mark.parametrize("taste", TASTES)
def test_a_taste_of_several_parts_is_a_candidate(taste: str):
    grammar, value = TASTES[taste]
    expected = np.array([value(tree) for forest in forests_of(grammar) for tree in trees_of(forest)], dtype=np.float64)
    assert expected.std() > 0.0
    found = candidates(elements_of(grammar))
    same = (found.values == expected[:, None]).all(axis=0)
    centred = expected - expected.mean()
    others = found.values - found.values.mean(axis=0)
    similar = np.abs(centred @ others) / (np.linalg.norm(centred) * np.linalg.norm(others, axis=0))
    assert same.any() or similar.max() > 1.0 - 1e-9


@pytest.mark.parametrize("grammar", ["blocks", "shifts"])
def test_aggregates_are_of_the_draws_that_a_model_uses(grammar):
    elements = elements_of(grammar)
    rows = [[value for value in row if value != 0.0] for row in elements.used.values.tolist()]
    made = np.concatenate([block.values() for block in aggregates(elements)], axis=1).T
    for expected in (sum, max, min, lambda row: sum(row) / len(row), lambda row: max(row) - min(row)):
        assert any(np.allclose(column, [expected(row) for row in rows]) for column in made)


def test_a_choice_is_counted_however_far_below_another_one_it_is():
    grammar = Grammar.parse("""
        Lot --> Tower
        Tower --> 95% : Floor Tower else : Roof
        Floor --> 50% : Red else : Blue
        Roof --> 50% : Flat else : Gable
    """)
    forest = derive(grammar, 30, seed=1)
    blocks = list(contexts(Elements.of([forest])))
    counted = count(forest, [block.formula(index) for block in blocks for index in range(block.size)])
    # A choice below a tower of 40 floors is counted below each of them.
    assert counted.max() > 32 * 33 // 2
    np.testing.assert_array_equal(np.concatenate([block.values() for block in blocks], axis=1), counted)
