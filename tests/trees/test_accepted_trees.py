from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from grammarlab.errors import GrammarlabError, UsageError
from grammarlab.randomness import root_keys
from grammarlab.trees.accepted_trees import accepted_rows, log_density, rule_of
from grammarlab.trees.parameters import COLUMN, DEFAULTS, HIGH, IS_INTEGER, LOW
from grammarlab.trees.species import Kind, Species, drawn


def kind(weight: float, **ranges: tuple[float, float]) -> Kind:
    low, high = DEFAULTS.copy(), DEFAULTS.copy()
    for name, (start, end) in ranges.items():
        low[COLUMN[name]], high[COLUMN[name]] = start, end
    return Kind(weight, low, high)


def species(*kinds: Kind, acceptance: str = "") -> Species:
    return Species("tree", kinds, DEFAULTS, acceptance=acceptance)


def rows_with(**columns: np.ndarray) -> np.ndarray:
    rows = np.tile(DEFAULTS, (len(next(iter(columns.values()))), 1))
    for name, values in columns.items():
        rows[:, COLUMN[name]] = values
    return rows


MIXED = species(
    kind(0.25, branches_1=(3, 9), shape=(0, 4), lobes=(0, 2)),
    kind(0.75, branches_1=(5, 40), shape=(4, 4), lobes=(1, 2)),
)
"""Whole numbers only: of the logarithm, even ones, and a constant."""


def test_densities_of_whole_numbers_sum_to_one_and_are_the_shares_of_draws():
    table = np.array(list(itertools.product(range(3, 41), range(9), range(3))), dtype=float)
    density = np.exp(log_density(MIXED, rows_with(branches_1=table[:, 0], shape=table[:, 1], lobes=table[:, 2])))
    assert density.sum() == pytest.approx(1.0, abs=1e-12)
    rows, _ = drawn(MIXED, root_keys(1, np.arange(40_000)))
    drawn_table = rows[:, [COLUMN["branches_1"], COLUMN["shape"], COLUMN["lobes"]]]
    number = (table[:, None, 0] == np.unique(drawn_table[:, 0])).any(axis=1)
    assert number[density > 1e-3].all()
    counts = np.array([np.all(drawn_table == row, axis=1).sum() for row in table[density > 1e-3]])
    expected = 40_000 * density[density > 1e-3]
    assert (((counts - expected) / np.sqrt(expected)) ** 2).mean() == pytest.approx(1.0, abs=0.25)


def test_densities_of_ranges_have_the_total_one():
    mixture = species(kind(0.5, scale=(2.0, 8.0), taper_1=(0.0, 1.0)), kind(0.5, scale=(4.0, 16.0), taper_1=(0.5, 2.0)))
    scale = 2.0 + (np.arange(700) + 0.5) * 14.0 / 700
    taper = (np.arange(200) + 0.5) * 0.01
    rows = rows_with(scale=np.repeat(scale, 200), taper_1=np.tile(taper, 700))
    assert np.exp(log_density(mixture, rows)).sum() * 0.02 * 0.01 == pytest.approx(1.0, abs=1e-4)


def test_densities_by_hand():
    mixture = species(kind(0.25, ratio=(0.01, 0.04)), kind(0.75, base_size=(0.2, 0.6)))
    rows = rows_with(ratio=np.array([0.02, 0.015, 0.02]), base_size=np.array([0.3, 0.4, 0.4]))
    expected = [np.log(0.25 / (0.02 * np.log(4.0))), np.log(0.75 / 0.4), -np.inf]
    assert log_density(mixture, rows).tolist() == pytest.approx(expected)


def test_where_a_range_holds_a_constant_of_another_kind_the_constant_counts():
    mixture = species(kind(0.5, taper_1=(0.0, 1.0)), kind(0.5, taper_1=(0.5, 0.5)))
    rows = rows_with(taper_1=np.array([0.5, 0.25]))
    assert np.exp(log_density(mixture, rows)).tolist() == [0.5, 0.5]


def test_all_draws_have_a_density():
    low, high = np.where(IS_INTEGER, np.maximum(LOW, -3), LOW), np.where(IS_INTEGER, np.minimum(HIGH, 30), HIGH)
    everything = Species("all", (Kind(1.0, low, high),), DEFAULTS)
    rows, _ = drawn(everything, root_keys(2, np.arange(500)))
    assert np.isfinite(log_density(everything, rows)).all()


def test_accepted_trees_have_the_density_of_the_rule():
    tree = species(kind(1.0, branches_1=(1, 4)), acceptance="$branches_1 / 4")
    accepted = accepted_rows(tree, root_keys(3, np.arange(20_000)))
    assert accepted.is_accepted.all()
    values = np.arange(1, 5)
    weights = np.log1p(1.0 / values) * values
    shares = np.bincount(accepted.rows[:, COLUMN["branches_1"]].astype(int))[1:] / 20_000
    assert shares == pytest.approx(weights / weights.sum(), abs=0.012)
    keep = float((np.log1p(1.0 / values) * values / 4).sum() / np.log(5.0))
    assert accepted.tries.mean() == pytest.approx(1.0 / keep, rel=0.02)


def test_an_accepted_tree_is_the_same_alone_and_in_any_batch():
    tree = species(kind(1.0, branches_1=(1, 400), scale=(3.0, 30.0)), acceptance="$branches_1 > 300 and $scale < 20")
    keys = root_keys(4, np.arange(60))
    every = accepted_rows(tree, keys)
    for number in (0, 17, 59):
        alone = accepted_rows(tree, keys[[number]])
        assert [column[0].tolist() for column in alone] == [column[number].tolist() for column in every]
    # Its stems follow from the key of the candidate, as do its parameters.
    assert np.array_equal(drawn(tree, every.keys)[0], every.rows)
    first = every.tries == 1
    assert first.any()
    assert np.array_equal(every.keys[first], keys[first])


def test_without_a_rule_every_tree_is_kept():
    keys = root_keys(5, np.arange(50))
    accepted, (rows, kinds) = accepted_rows(MIXED, keys), drawn(MIXED, keys)
    assert np.array_equal(accepted.rows, rows)
    assert np.array_equal(accepted.kind, kinds)
    assert (accepted.tries == 1).all()
    assert accepted.is_accepted.all()


def test_a_rule_that_is_nearly_zero_keeps_the_nearest_tree():
    tree = species(kind(1.0, scale=(3.0, 30.0)), acceptance="0.000000001 * $scale")
    accepted = accepted_rows(tree, root_keys(6, np.arange(3)), enough_tries=50)
    assert not accepted.is_accepted.any()
    assert (accepted.tries == 50).all()


def test_a_rule_that_keeps_nothing_is_an_error():
    with pytest.raises(GrammarlabError, match="keeps none of 20,000 candidates"):
        accepted_rows(replace(MIXED, acceptance="$branches_1 > 500"), root_keys(7, np.arange(1)))


@pytest.mark.parametrize("text", ["{Block} > 1", "$scale:1 > 0", "branches"])
def test_a_rule_reads_parameters_and_measures(text: str):
    with pytest.raises(UsageError):
        rule_of(text)
