"""Species from example trees: likelier examples, a density, and nothing learned from nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from grammarlab.arrays import Flags, Floats
from grammarlab.density.samples.sampled import NUM_SAMPLES
from grammarlab.density.samples.tree_kinds import species_of_examples
from grammarlab.errors import UsageError
from grammarlab.randomness import root_keys
from grammarlab.trees.accepted_trees import log_density
from grammarlab.trees.parameters import COLUMN
from grammarlab.trees.species import Species, drawn
from grammarlab.trees.species_file import parse, write

SPECIES = parse(
    """
    [tree]
    scale = { value = 5.0, range = [3.0, 8.0] }
    ratio = { value = 0.02, range = [0.01, 0.03] }
    [level_1]
    branches_1 = { value = 6, range = [4, 19] }
    curve_1 = { value = 0.0, range = [-50.0, 50.0], spread_range = [0.0, 90.0] }
    [leaves]
    leaves = { value = 0, range = [-3, 12] }
    """,
    "small",
)
SCALE, BRANCHES, CURVE, LEAVES = (COLUMN[name] for name in ("scale", "branches_1", "curve_1", "leaves"))


def rows_of(species: Species, num: int, seed: int = 1) -> Floats:
    return drawn(species, root_keys(seed, np.arange(num)))[0]


def log_ratio(learned: Species, rows: Floats, species: Species = SPECIES) -> Floats:
    return log_density(learned, rows) - log_density(species, rows)


def either(rows: Floats) -> Flags:
    """Bent trees with many branches, or tall ones without leaves."""
    bent = (rows[:, CURVE] > 10.0) & (rows[:, BRANCHES] > 12)
    return bent | ((rows[:, SCALE] > 6.5) & (rows[:, LEAVES] < 3))


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("num", [1, 7, 60, 500])
def test_trees_of_the_species_itself_teach_nothing(num: int, seed: int):
    assert write(species_of_examples(SPECIES, rows_of(SPECIES, num, seed))) == write(SPECIES)


@pytest.mark.parametrize("num", [12, 60, 400, 2_000])
def test_examples_get_likelier_and_the_result_is_a_density(num: int):
    pool = rows_of(SPECIES, 20_000)
    examples = pool[either(pool)][:num]
    learned = species_of_examples(SPECIES, examples)
    gains = log_ratio(learned, examples)
    assert np.isfinite(gains).all()
    assert gains.mean() >= 0.0
    ratio = np.exp(log_ratio(learned, rows_of(SPECIES, 40_000, seed=2)))
    assert ratio.mean() == pytest.approx(1.0, abs=0.06)
    assert sum(kind.weight for kind in learned.kinds) == pytest.approx(1.0)
    assert write(parse(write(learned), "small")) == write(learned)


def test_many_examples_give_back_what_they_are():
    pool = rows_of(SPECIES, 20_000)
    liked = either(pool)
    learned = species_of_examples(SPECIES, pool[liked][:3_000])
    held_out = rows_of(SPECIES, 20_000, seed=3)
    held_out = held_out[either(held_out)]
    ideal = -np.log(liked.mean())
    gains = log_ratio(learned, held_out)
    assert np.isfinite(gains).mean() > 0.995
    assert gains[np.isfinite(gains)].mean() > 0.9 * ideal
    # What is drawn from the new species is liked.
    assert either(rows_of(learned, 4_000, seed=4)).mean() > 0.9


def test_counts_have_the_ends_of_the_examples():
    pool = rows_of(SPECIES, 4_000)
    examples = pool[(pool[:, BRANCHES] >= 8) & (pool[:, BRANCHES] <= 11)][:300]
    (kind,) = species_of_examples(SPECIES, examples).kinds
    assert (kind.low[BRANCHES], kind.high[BRANCHES]) == (8.0, 11.0)
    assert kind.means == "branches_1 8 to 11"


def test_equal_examples_do_not_make_a_parameter_constant():
    examples = rows_of(SPECIES, 50)
    examples[:, SCALE] = 5.0
    (kind,) = species_of_examples(SPECIES, examples).kinds
    assert kind.low[SCALE] < 5.0 < kind.high[SCALE]
    assert kind.high[SCALE] - kind.low[SCALE] < 0.15


def test_each_kind_learns_from_its_own_examples():
    (only,) = SPECIES.kinds
    low, high = only.low.copy(), only.high.copy()
    low[SCALE], high[SCALE] = 20.0, 30.0
    two = replace(SPECIES, kinds=(replace(only, weight=0.5), replace(only, weight=0.5, low=low, high=high)))
    pool = rows_of(two, 4_000)
    examples = pool[pool[:, SCALE] > 25.0][:200]
    learned = species_of_examples(two, examples)
    (kind,) = learned.kinds
    assert kind.low[SCALE] == pytest.approx(25.0, abs=0.1)
    assert kind.high[SCALE] == 30.0
    assert learned.typical[SCALE] == kind.low[SCALE]


def test_of_very_many_examples_some_are_looked_at():
    rows = rows_of(SPECIES, NUM_SAMPLES + 3)
    assert write(species_of_examples(SPECIES, rows)) == write(SPECIES)


def test_trees_that_the_species_cannot_draw_are_refused():
    rows = rows_of(SPECIES, 9)
    rows[4, BRANCHES] = 99.0
    with pytest.raises(UsageError, match=r"1 of 9 examples .*: branches_1 is 99, and not within 4 to 19"):
        species_of_examples(SPECIES, rows)
    with pytest.raises(UsageError, match="no example trees"):
        species_of_examples(SPECIES, rows[:0])
