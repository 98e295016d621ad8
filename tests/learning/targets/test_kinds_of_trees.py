from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from grammarlab.learning.targets.kinds_of_trees import divisible, parts_of, with_parts, words_of
from grammarlab.preference.regression_tree import Split
from grammarlab.preference.simplified import SimplifiedPreference
from grammarlab.randomness import root_keys
from grammarlab.trees.accepted_trees import log_density
from grammarlab.trees.parameters import COLUMN, DEFAULTS
from grammarlab.trees.species import Kind, Species, drawn
from grammarlab.trees.species_file import parse, write

NAMES = ("scale", "ratio", "branches_1", "shape", "curve_1", "down_angle_1_v", "taper_1")
RANGES = {
    "scale": (2.0, 30.0),
    "ratio": (0.005, 0.05),
    "branches_1": (3, 60),
    "shape": (0, 7),
    "curve_1": (-90.0, 90.0),
    "down_angle_1_v": (-40.0, 40.0),
    "taper_1": (0.5, 1.2),
}


def kind(weight: float, **changes: tuple[float, float]) -> Kind:
    low, high = DEFAULTS.copy(), DEFAULTS.copy()
    for name, ends in (RANGES | changes).items():
        low[COLUMN[name]], high[COLUMN[name]] = ends
    return Kind(weight, low, high)


ONE = Species("one", (kind(1.0),), DEFAULTS)
TWO = Species(
    "two", (kind(0.3, ratio=(0.005, 0.02), shape=(2, 5)), kind(0.7, scale=(9.0, 9.0), taper_1=(0.8, 1.6))), DEFAULTS
)


def random_preference(random: np.random.Generator, num_splits: int) -> SimplifiedPreference:
    splits = []
    for number in range(num_splits):
        column = int(random.integers(len(NAMES)))
        low, high = RANGES[NAMES[column]]
        splits.append(Split(int(random.integers(number + 1)), column, round(float(random.uniform(low, high)), 2)))
    scores = np.where(random.random(num_splits + 1) < 0.4, 0.0, np.round(random.uniform(1.0, 100.0, num_splits + 1)))
    return SimplifiedPreference(tuple(splits), np.append(scores[:-1], 50.0))


def table(rows: np.ndarray) -> np.ndarray:
    return rows[:, [COLUMN[name] for name in NAMES]]


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("species", [ONE, TWO], ids=["one", "two"])
def test_the_density_of_the_parts_is_that_of_the_species_times_the_score(species: Species, seed: int):
    random = np.random.default_rng(seed)
    preference = random_preference(random, 7)
    learned = with_parts(species, parts_of(species, preference, NAMES))
    rows, _ = drawn(species, root_keys(seed, np.arange(2000)))
    scores = preference(table(rows))
    ratio = log_density(learned, rows) - log_density(species, rows)
    assert np.array_equal(scores > 0.0, np.isfinite(ratio))
    constants = ratio[scores > 0.0] - np.log(scores[scores > 0.0])
    assert np.ptp(constants) < 1e-9
    # What the learned species draws is liked, as often as the constant says.
    drawn_rows, _ = drawn(learned, root_keys(seed + 100, np.arange(500)))
    assert (preference(table(drawn_rows)) > 0.0).all()
    assert np.exp(-constants.mean()) == pytest.approx(scores.mean(), rel=0.25)


def test_species_of_few_trees_are_learned_exactly():
    small = {"scale": (5.0, 5.0), "ratio": (0.01, 0.01), "curve_1": (0.0, 0.0), "down_angle_1_v": (0.0, 0.0)}
    species = Species("few", (kind(1.0, **small, taper_1=(1.0, 1.0), branches_1=(2, 7), shape=(0, 3)),), DEFAULTS)
    preference = SimplifiedPreference((Split(0, 2, 4.0), Split(1, 3, 2.0)), np.array([10.0, 0.0, 70.0]))
    learned = with_parts(species, parts_of(species, preference, NAMES))
    cells = np.array(list(itertools.product(range(2, 8), range(4))), dtype=float)
    rows = np.tile(species.kinds[0].low, (len(cells), 1))
    rows[:, [COLUMN["branches_1"], COLUMN["shape"]]] = cells
    own = np.exp(log_density(species, rows))
    expected = own * preference(table(rows))
    assert own.sum() == pytest.approx(1.0, abs=1e-12)
    assert np.exp(log_density(learned, rows)) == pytest.approx(expected / expected.sum(), abs=1e-12)
    means = ["dense: shape at least 2, branches 1 at least 4", "open: branches 1 at most 3"]
    assert [part.means for part in learned.kinds] == means
    # Half of the trees have fewer than 4 branches, and half of the others the shape: 70 / 4 to 10 / 2.
    assert [part.weight for part in learned.kinds] == pytest.approx([7 / 9, 2 / 9])


def test_neighbouring_parts_of_equal_scores_are_one():
    preference = SimplifiedPreference(
        (Split(0, 0, 8.0), Split(1, 3, 3.0), Split(0, 3, 3.0)), np.array([9.0, 9.0, 9.0, 9.0])
    )
    (part,) = parts_of(ONE, preference, NAMES)
    assert np.array_equal(part.low, ONE.kinds[0].low)
    assert np.array_equal(part.high, ONE.kinds[0].high)
    assert words_of(ONE, part) == ""


def test_learned_species_can_be_learned_from_again():
    random = np.random.default_rng(3)
    first, second = random_preference(random, 5), random_preference(random, 5)
    once = with_parts(ONE, parts_of(ONE, first, NAMES))
    again = with_parts(once, parts_of(once, second, NAMES))
    rows, _ = drawn(ONE, root_keys(1, np.arange(2000)))
    both = first(table(rows)) * second(table(rows))
    ratio = log_density(again, rows) - log_density(ONE, rows)
    assert np.array_equal(both > 0.0, np.isfinite(ratio))
    assert np.ptp(ratio[both > 0.0] - np.log(both[both > 0.0])) < 1e-9


def test_files_keep_the_density():
    learned = with_parts(TWO, parts_of(TWO, random_preference(np.random.default_rng(5), 6), NAMES))
    back = parse(write(learned), "two.toml")
    rows, _ = drawn(learned, root_keys(1, np.arange(300)))
    assert np.allclose(log_density(back, rows), log_density(learned, rows), rtol=0.0, atol=1e-12)


def test_ranges_of_sizes_from_zero_are_not_divided():
    species = replace(ONE, kinds=(kind(1.0, branches_1=(0, 9), leaf_scale=(0.0, 0.3), scale=(0.5, 4.0)),))
    assert not divisible(species)[[COLUMN["branches_1"], COLUMN["leaf_scale"]]].any()
    assert divisible(species)[[COLUMN["scale"], COLUMN["shape"], COLUMN["curve_1"]]].all()
