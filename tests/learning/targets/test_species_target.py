from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from grammarlab.arrays import Floats
from grammarlab.errors import UsageError
from grammarlab.learning.answers import Answers
from grammarlab.learning.designs.pool import Pool
from grammarlab.learning.designs.species_space import SpeciesSpace
from grammarlab.learning.designs.tree_columns import TreeBatch
from grammarlab.learning.round import State, Study, init, step
from grammarlab.learning.targets import species_target
from grammarlab.learning.targets.simplification import predict
from grammarlab.learning.targets.species_target import SpeciesWriter
from grammarlab.learning.targets.writers import LearnedDensity, Making
from grammarlab.preference.blended import BlendedPreference
from grammarlab.preference.regression_tree import leaves_of
from grammarlab.trees.species import Species
from grammarlab.trees.species_file import parse
from tests.cases import takes_turns

TEXT = """
about = "A seedling."

[tree]
levels = 2
scale = { value = 0.5, range = [0.25, 1.0], unit = "m", why = "small" }
ratio = { value = 0.02, range = [0.01, 0.04] }

[trunk]
curve_0 = { value = 0.0, spread = 90.0, unit = "deg", why = "each bends in its own way" }

[level_1]
branches_1 = { value = 6, range = [3, 9] }
down_angle_1 = { value = 60.0, range = [20.0, 100.0], unit = "deg" }
"""
SPACE = SpeciesSpace(parse(TEXT, "seedling"), TEXT)


@cache
def learned_from(
    score: Callable[[dict[str, Floats]], Floats], making: Making | None = None, space: SpeciesSpace = SPACE
) -> LearnedDensity[TreeBatch]:
    """What is learned from the scores of every third tree of a pool, without errors."""
    study, state = studied(score, space)
    return SpeciesWriter(space).learn(study, state, making or Making(), ["Labels by\n[tree]", "second line"])


@cache
def studied(score: Callable[[dict[str, Floats]], Floats], space: SpeciesSpace) -> tuple[Study[TreeBatch], State]:
    study = Study(space, Pool(1, 480))
    addresses = tuple(study.pool)[::3]
    scores = score(space.make(addresses).columns())
    return study, step(study, init(study), (Answers("f", addresses, scores.astype(np.float64)),), widens=False)


def species_of(density: LearnedDensity[TreeBatch]) -> Species:
    return parse(density.learned.text, "learned")


def slender_or_stout(columns: dict[str, Floats]) -> Floats:
    ratio = columns["ratio"]
    return np.array(100.0 * (ratio < 0.015) + 50.0 * (ratio > 0.03), dtype=np.float64)


def wide_and_upright(columns: dict[str, Floats]) -> Floats:
    return np.array(100.0 * ((columns["crown_ratio"] > 0.7) & (columns["lean"] < 0.05)), dtype=np.float64)


@takes_turns
def test_a_taste_in_parameters_becomes_kinds_with_words():
    density = learned_from(slender_or_stout)
    text, species = density.learned.text, species_of(density)
    assert text.startswith("# Labels by [tree]\n# second line\n#\n# Likes (with the mean score, 0 to 100):\n")
    assert "\n#\n# Method kinds, base grammar\n\n" in text
    assert not species.acceptance
    assert density.learned.accept_rate is None
    assert [kind.means.split(":")[0] for kind in species.kinds] == ["slender", "stout"]
    # Ratios are drawn by logarithm: log(1.5) of slender trees with 100, log(4/3) of stout ones with 50 points.
    weight = np.log(1.5) / (np.log(1.5) + 0.5 * np.log(4.0 / 3.0))
    assert species.kinds[0].weight == pytest.approx(weight, abs=0.03)
    assert (density.learned.rules_before, density.learned.rules_after) == (1, 2)
    assert density.measured.after.js < 0.02 < density.measured.before.js
    assert 'why = "small"' in text


@takes_turns
def test_what_depends_on_measures_becomes_a_rule():
    density = learned_from(wide_and_upright)
    learned = density.learned
    space = SpeciesSpace(parse(learned.text, "again"), learned.text)
    assert "$lean < 0.0" in space.species.acceptance
    (batch,) = space.sample(False, 60, 3)
    assert wide_and_upright(batch.columns()).mean() > 85.0
    assert learned.accept_rate is not None
    assert 0.0 < learned.accept_rate <= 1.0
    assert any("acceptance rule" in finding for finding in learned.findings)
    assert density.measured.after.js < 0.05 < density.measured.before.js
    # The ranges in which such trees grow keep more of them than those of the original.
    only = learned_from(wide_and_upright, Making(method="acceptance")).learned
    assert only.accept_rate is not None
    assert learned.accept_rate >= only.accept_rate
    assert only.rules_after == 1


@takes_turns
def test_learned_files_can_be_learned_from_again():
    first = learned_from(wide_and_upright).learned
    space = replace(SPACE, species=parse(first.text, "first"), text=first.text)
    second = learned_from(slender_or_stout, space=space)
    again = SpeciesSpace(parse(second.learned.text, "second"), second.learned.text)
    (batch,) = again.sample(False, 60, 5)
    columns = batch.columns()
    assert wide_and_upright(columns).mean() > 80.0
    assert (slender_or_stout(columns) > 0.0).mean() > 0.9
    assert second.measured.after.js < 0.03


@takes_turns
def test_cells_divide_the_pool_in_the_units_of_its_columns_as_they_divide_rows():
    study, state = studied(wide_and_upright, SPACE)
    pool = species_target._pool_of(SPACE, study, state, predict(study, state))
    preference = state.preferences["f"]
    assert isinstance(preference, BlendedPreference)
    number, cells = preference.partition.trees[0].cell_of(study.table(state).rows)
    leaf = leaves_of(pool.cells, pool.rows)
    assert len(pool.cells) >= 2
    assert len(np.unique(number)) == len(cells) == len(np.unique(leaf)) == len(np.unique([number, leaf], axis=1).T)


@takes_turns
def test_samples_of_a_learned_file_have_scenes():
    assert learned_from(slender_or_stout).learned.scene(2, 1).num_models == 2


def test_species_have_no_uniform_density():
    with pytest.raises(UsageError, match="trees of a species cannot all be equally likely"):
        learned_from(slender_or_stout, Making(base="uniform"))


def test_methods_are_checked():
    with pytest.raises(UsageError, match="unknown method 'mixture'"):
        learned_from(slender_or_stout, Making(method="mixture"))
