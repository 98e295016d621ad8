from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from grammarlab.errors import UsageError
from grammarlab.features.patterns.pattern import Draw, Formula, Threshold
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.pool import Pool, PoolDesigns
from grammarlab.learning.designs.species_space import SpeciesSpace
from grammarlab.learning.designs.tree_columns import TreeBatch, relevant_names
from grammarlab.learning.settings import POOL_SIZE, FeatureOptions
from grammarlab.randomness import root_keys
from grammarlab.runs.sample.domains import opened
from grammarlab.runs.sample.shipped import find_rules
from grammarlab.trees.growth import grow
from grammarlab.trees.measures import MEASURES, measure
from grammarlab.trees.parameters import COLUMN
from grammarlab.trees.species import drawn
from grammarlab.trees.species_file import parse

TEXT = """
[tree]
levels = 2
scale = { value = 4.0, range = [2.0, 8.0] }
ratio = { value = 0.02, range = [0.01, 0.04] }

[level_1]
branches_1 = { value = 6, range = [3, 9] }
down_angle_1 = { value = 60.0, spread = 10.0, spread_range = [0.0, 30.0], unit = "deg" }

[level_2]
branches_2 = { value = 6, range = [3, 9] }

[leaves]
leaf_bend = { value = 0.3, range = [0.1, 0.6] }

[[kinds]]
weight = 0.9
means = "slender"
[kinds.ranges]
ratio = [0.01, 0.02]

[[kinds]]
weight = 0.1
means = "stout"
[kinds.ranges]
ratio = [0.015, 0.04]
"""
SPACE = SpeciesSpace(parse(TEXT, "small"), TEXT)


def test_a_design_is_the_tree_of_its_address_measured():
    addresses = [Address(False, 5, 3), Address(True, 7, 0), Address(False, 5, 4)]
    trees = SPACE.make(addresses)
    rows, _ = drawn(SPACE.species, root_keys(5, np.array([3, 4])))
    assert np.array_equal(trees.rows[[0, 2]], rows)
    assert np.array_equal(trees.measures, measure(grow(trees.rows, trees.keys)))
    for number, address in enumerate(addresses):
        alone = SPACE.make([address])
        assert np.array_equal(alone.rows[0], trees.rows[number])
        assert np.array_equal(alone.measures[0], trees.measures[number])


def test_samples_are_the_designs_of_addresses():
    (batch,) = SPACE.sample(True, 5, 11, first=2)
    expected = SPACE.make([Address(True, 11, number) for number in range(2, 7)])
    assert np.array_equal(batch.rows, expected.rows)
    assert np.array_equal(batch.measures, expected.measures)


def test_attributes_of_labels_fix_columns_and_change_no_other():
    plain, fixed = (
        SPACE.make([Address(False, 5, 3, attributes=text)]) for text in ("{}", '{"scale": 3, "detail": "low"}')
    )
    assert fixed.rows[0, COLUMN["scale"]] == 3.0
    assert set(np.flatnonzero(plain.rows[0] != fixed.rows[0])) == {COLUMN["scale"]}


@pytest.mark.parametrize(
    ("address", "message"),
    [
        (Address(False, 1, 1, start_rule="Lot"), "start rule"),
        (Address(False, 1, 1, footprint="10x10"), "footprint"),
        (Address(False, 1, 1, attributes='{"hight": 3}'), "not a parameter"),
        (Address(False, 1, 1, attributes='{"levels": 9}'), "whole number from 1 to 4, found 9"),
        (Address(False, 1, 1, attributes='{"scale": "tall"}'), "expected a number"),
    ],
)
def test_other_addresses_have_no_tree(address: Address, message: str):
    with pytest.raises(UsageError, match=message):
        SPACE.make([address])


def test_the_proposal_draws_kinds_equally_often_and_weights_correct_for_it():
    pool = PoolDesigns.of(SPACE, Pool(3, 1500, wide=True))
    ratio = np.concatenate([batch.rows[:, COLUMN["ratio"]] for batch in pool.batches])
    num = pool.pool.sizes[0]
    assert np.mean(ratio[:num] > 0.02) == pytest.approx(0.08, abs=0.03)
    assert np.mean(ratio[num:] > 0.02) == pytest.approx(0.4, abs=0.05)
    weights = pool.weights / pool.weights.sum()
    assert weights @ (ratio > 0.02) == pytest.approx(0.08, abs=0.01)


def test_with_one_kind_the_proposal_is_the_species():
    one = replace(SPACE, species=replace(SPACE.species, kinds=SPACE.species.kinds[:1]))
    own, flat = (one.make([Address(flat, 3, 0)]) for flat in (False, True))
    assert np.array_equal(own.rows, flat.rows)
    assert one.log_ratio(flat).tolist() == [0.0]


def test_an_acceptance_rule_counts_on_both_sides():
    text = 'acceptance = "0.2 + 0.8 * ($ratio > 0.02)"\n' + TEXT
    space = SpeciesSpace(parse(text, "small"), text)
    (flat,) = space.sample(True, 500, 1)
    # The mean of the density ratio under the proposal is 1.
    assert np.exp(space.log_ratio(flat)).mean() == pytest.approx(1.0, abs=0.15)


def test_columns_are_the_parameters_that_matter_and_the_measures_on_sensible_scales():
    names = relevant_names(SPACE.species)
    assert names[: -len(MEASURES)] == ("scale", "ratio", "down_angle_1_v", "branches_1")
    (batch,) = SPACE.sample(False, 40, 1)
    table = SPACE.vocabulary([batch], FeatureOptions(1, ("draws",))).apply([batch])
    assert {"scale", "branches 1", "spread of down angle 1", "height", "slenderness"} <= set(table.names)
    assert not {"leaf bend", "num leaves"} & set(table.names)
    values = table.counts.toarray()
    scale = table.names.index("scale")
    assert np.allclose(np.exp(values[:, scale]), batch.rows[:, COLUMN["scale"]])
    assert np.allclose(np.ptp(table.rows(), axis=0), 1.0)
    # Three of four conditions of a person are expected to be about measures, and equally about each.
    assert table.priors is not None
    priors = table.priors / table.priors.sum()
    is_measure = np.array([str(feature) in MEASURES for feature in table.features])
    assert priors[is_measure].sum() == pytest.approx(0.75)
    assert np.ptp(priors[is_measure]) == pytest.approx(0.0)
    assert SPACE.vocabulary([batch], FeatureOptions(1, ("paths",))).apply([batch]).rows().shape == (40, 0)


def test_features_of_trees_are_read_by_name():
    (batch,) = SPACE.sample(False, 10, 2)
    scale, height = batch.rows[:, COLUMN["scale"]], batch.measures[:, list(MEASURES).index("height")]
    features = [
        Draw("height"),
        Threshold("scale", 4.0),
        Formula.of("/", Draw("height"), Draw("scale")),
        Formula.of("<", Draw("height"), Draw("scale")),
    ]
    values = SPACE.values([batch, batch.take(np.array([2]))], features)
    assert values.shape == (11, 4)
    expected = np.column_stack([height, scale < 4.0, height / scale, height < scale])
    assert values[:10] == pytest.approx(expected)
    assert np.array_equal(values[10], values[2])


def test_a_batch_is_taken_apart_by_index():
    (batch,) = SPACE.sample(False, 6, 2)
    some = SPACE.take(batch, np.array([1, 4]))
    assert isinstance(some, TreeBatch)
    assert len(some) == 2
    assert np.array_equal(some.rows, batch.rows[[1, 4]])


def test_designs_have_scenes():
    assert SPACE.realize([Address(False, 1, 0), Address(True, 1, 1)]).scene.num_models == 2


def test_a_usual_pool_is_smaller_where_trees_are_larger():
    palm, oak = (
        opened(".toml", source.text(), source.name, source.assets) for source in map(find_rules, ("palm", "oak"))
    )
    assert palm.pool_size == POOL_SIZE
    assert 1000 <= oak.pool_size < POOL_SIZE
    assert len(Pool.usual(oak, 7)) == oak.pool_size
