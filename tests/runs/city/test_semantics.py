"""Surfaces are called what the names of their symbols say."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.export.surface_labels import DOOR, ROOF, SURFACE_TYPES, UNLABELLED, WALL, WINDOW
from grammarlab.language.grammar import Grammar
from grammarlab.runs.city.semantics import surface_labels
from grammarlab.scene.instances import leaf_order

FACADE = """
    Lot --> extrude(9) comp(f) { front : Facade | side : Plain. | top : FlatRoof. }
    Facade --> split(y) { 3 : GroundFloor | { 3 : WindowRow }* }
    GroundFloor --> split(x) { 2 : HouseDoor | ~1 : Wall. }
    HouseDoor --> split(y) { 2 : Leaf. | ~1 : Glass. }
    WindowRow --> split(x) { { ~1 : Pier. | 1 : OldWindow }* | ~1 : Pier. }
    OldWindow --> split(y) { 0.2 : Sill. | ~1 : Sash | 0.2 : WallAbove. }
    Sash --> split(x) { { 0.5 : Pane. }* }
"""


@pytest.fixture(scope="module")
def forest():
    return derive(Grammar.parse(FACADE), 2, seed=3)


def kinds_by_symbol(forest, labels):
    symbols = np.array(forest.symbols)[forest.nodes.symbol[forest.leaves.node]]
    order = leaf_order(forest)
    return {(str(symbol).rstrip("."), int(kind)) for symbol, kind in zip(symbols[order], labels.kind, strict=True)}


def test_leaves_have_the_kind_of_the_topmost_opening_or_of_their_own_name(forest):
    assert kinds_by_symbol(forest, surface_labels(forest)) == {
        ("Plain", UNLABELLED),
        ("FlatRoof", ROOF),
        ("Wall", WALL),
        ("Leaf", DOOR),
        ("Glass", DOOR),
        ("Pier", UNLABELLED),
        ("Sill", WINDOW),
        ("Pane", WINDOW),
        ("WallAbove", WALL),
    }


def test_parts_of_one_window_have_one_number(forest):
    labels = surface_labels(forest)
    sizes = Counter(labels.opening[labels.kind == WINDOW].tolist())
    windows = [node for node, symbol in enumerate(forest.nodes.symbol) if forest.symbols[symbol] == "OldWindow"]
    assert set(sizes) == set(windows)
    assert set(sizes.values()) == {3}  # a sill and two panes


def test_labels_are_the_same_alone_and_in_a_batch(forest):
    grammar = Grammar.parse(FACADE)
    alone = [surface_labels(derive(grammar, 1, seed=3, first_model=model)) for model in range(2)]
    assert np.concatenate([labels.kind for labels in alone]).tolist() == surface_labels(forest).kind.tolist()


@pytest.mark.parametrize(
    ("symbol", "kind"),
    [
        ("SHOP_WINDOW", "Window"),
        ("doors2", "Door"),
        ("RoofWindow", "Window"),
        ("GlassDoor", "Door"),
        ("Wall3", "WallSurface"),
        ("Roofing", "RoofSurface"),
        ("WindowRow", ""),
        ("Sill", ""),
        ("Outdoors", ""),
    ],
)
def test_words_of_names(symbol, kind):
    forest = derive(Grammar.parse(f"Lot --> {symbol}."), 1, seed=1)
    assert SURFACE_TYPES[surface_labels(forest).kind[0]] == kind
