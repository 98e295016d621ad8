"""The grammar of the quarter: sound on lots of any shape, and the same alone and in a batch."""

from __future__ import annotations

import numpy as np

import grammarlab as gl
from grammarlab.derivation.lots import Footprints, Lots
from grammarlab.runs.sample.shipped import find_rules

LOTS = [
    (18.0, 14.0),
    np.array([[0, 0, 0], [22, 0, 0], [22, 0, -12], [12, 0, -12], [12, 0, -22], [0, 0, -22.0]]),
    np.array([[0, 0, 0], [25, 0, 0], [32, 0, -20], [15, 0, -33], [-2, 0, -20.0]]),
    np.array([[0, 0, 0], [9, 0, 1], [4, 0, -7.0]]),
]


def sample(models: list[int]):
    source = find_rules("quarter")
    grammar = gl.Grammar.parse(source.text(), "quarter.cga")
    lots = Lots.at(5, models).on(Footprints.of(LOTS), np.array(models) % len(LOTS))
    return gl.derive(grammar, lots, assets=source.assets)


def test_buildings_on_any_lot_are_sound():
    forest = sample(list(range(48)))
    leaves = forest.leaves
    assert forest.missing_assets == ()
    assert np.isfinite(leaves.position).all()
    assert (leaves.size >= 0).all()
    low = np.full(forest.num_models, np.inf)
    np.minimum.at(low, forest.nodes.model[leaves.node], leaves.position[:, 1])
    assert (low > -1.0).all()


def test_a_building_is_the_same_alone_and_in_a_batch():
    alone, batch = sample([7]), sample([3, 7])
    rows = batch.nodes.model[batch.leaves.node] == 1
    assert np.array_equal(np.sort(alone.leaves.position, axis=0), np.sort(batch.leaves.position[rows], axis=0))
    assert alone.log_probability()[0] == batch.log_probability()[1]
