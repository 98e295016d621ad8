"""Scenarios about trees: their prior, the rule for plausible trees, and the whole loop on a small species."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from grammarlab.errors import UsageError
from grammarlab.evaluation import protocol
from grammarlab.evaluation.methods import METHODS
from grammarlab.evaluation.preparation import prepare, true_scores
from grammarlab.evaluation.scenario import load
from grammarlab.runs.learn.from_scenario import learn_from_scenario
from grammarlab.runs.sample.domains import opened
from grammarlab.runs.sample.shipped import examples_folder, find_rules
from grammarlab.runs.sample.sources import load_source
from grammarlab.trees.parameters import COLUMN, COLUMNS
from grammarlab.trees.species import Species
from grammarlab.trees.species_file import parse
from tests.cases import takes_turns

SCENARIOS = Path(__file__).parents[3] / "scenarios"
SPECIES = sorted(path.stem for path in (examples_folder() / "species").glob("*.toml") if path.stem != "any")
SAPLING = """
levels = 2
scale = { value = 4.0, range = [2.0, 8.0], unit = "m" }
branches_1 = { value = 6, range = [3, 9] }
leaves = 3
"""


def species(name: str) -> Species:
    return parse(find_rules(name).text(), name)


@pytest.mark.parametrize("name", SPECIES)
def test_any_tree_may_be_a_tree_of_each_species(name: str) -> None:
    prior = species("any")
    low = np.min([kind.low for kind in prior.kinds], axis=0)
    high = np.max([kind.high for kind in prior.kinds], axis=0)
    for kind in species(name).kinds:
        outside = (kind.low < low) | (kind.high > high)
        assert [column for column in COLUMNS if outside[COLUMN[column]]] == []


@takes_turns
def test_a_few_trees_of_a_hundred_are_plausible() -> None:
    source = load_source(SCENARIOS / "T1.toml")
    (trees,) = source.space.sample(False, 300, 0)
    share = np.mean(true_scores(source, trees) == 100.0)
    # 4.6 % of 10,000 (docs/evaluation/plausible_trees.md); the standard deviation is here 1.2 %.
    assert 0.002 <= share <= 0.05 + 2 * 0.012


@pytest.fixture
def low(tmp_path: Path) -> Path:
    """A scenario beside a species: the lower half of some saplings."""
    (tmp_path / "sapling.toml").write_text(SAPLING)
    text = 'name = "low"\ntitle = "Low saplings"\ngrammar = "sapling.toml"\nnum_models = 150\n'
    (tmp_path / "low.toml").write_text(text + 'preference = "100 * ($height < 4)"\n')
    return tmp_path / "low.toml"


@takes_turns
def test_what_is_liked_of_saplings_is_learned(low: Path) -> None:
    source = load_source(low)
    method = METHODS["default"]
    material = prepare(source, method.settings(source.scenario.features))
    _, curve = protocol.run(material, 8, 1, 40)
    assert material.js_original > 0.05
    assert curve.points[-1].js < 0.01


def test_a_known_preference_becomes_a_species_that_samples_it_exactly(low: Path) -> None:
    file = low.with_name("learned.toml")
    result = learn_from_scenario(str(low.with_name("sapling.toml")), low, "", file)
    assert (result.js, result.learned.accept_rate) == (pytest.approx(0.0, abs=1e-12), pytest.approx(0.49, abs=0.02))
    rules = find_rules(str(file))
    space = opened(rules.suffix, rules.text(), rules.name, rules.assets)
    score = result.source.scenario.score
    (trees,) = space.sample(False, 50, 3)
    assert set(score.evaluate(space.values([trees], score.features))) == {100.0}
    with pytest.raises(UsageError, match="unknown method 'compile'; expected one of acceptance"):
        learn_from_scenario(str(low.with_name("sapling.toml")), low, "compile", file)


def test_a_measure_that_does_not_exist_is_named_with_the_nearest(tmp_path: Path) -> None:
    text = (SCENARIOS / "T1.toml").read_text().replace("$slenderness", "$slendernes")
    (tmp_path / "T1.toml").write_text(text)
    space = load_source(SCENARIOS / "T1.toml").space
    with pytest.raises(UsageError) as caught:
        load(tmp_path / "T1.toml").check(space)
    assert "T1 does not fit any:\ntrees have no parameter or measure 'slendernes'; did you mean slenderness" in str(
        caught.value
    )
