"""The family of a shipped facade, and a preference over it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from grammarlab.density.targets.target import Target
from grammarlab.derivation import derive
from grammarlab.evaluation.preparation import prepare
from grammarlab.facade.file import load_facade
from grammarlab.features.patterns.counts import count
from grammarlab.learning.settings import Settings
from grammarlab.runs.facade.grammar_file import grammar_of
from grammarlab.runs.sample.sources import load_source
from tests.facade.gridded import enclosing

ROOT = Path(__file__).parents[2]
SCENARIO = ROOT / "scenarios" / "facades" / "arcade_symmetric.toml"


def truth(label: list[str], box: np.ndarray) -> float:
    """The scores, computed from the boxes of a facade."""
    portal, others = box[[name == "Portal" for name in label]], box[[name == "SquareWindow" for name in label]]
    assert len(portal) == 1
    left, right = (others[:, 0] < portal[0, 0]).sum(), (others[:, 0] > portal[0, 0]).sum()
    height = (box[:, 1] + box[:, 3]).max()
    return 0.0 if left != right else 80.0 if height < 17.0 else 30.0


def test_the_scenario_likes_what_its_title_says() -> None:
    source = load_source(SCENARIO)
    forest = derive(source.grammar_space.grammar, 200, seed=5, assets=source.grammar_space.assets)
    found = source.scenario.score.evaluate(count(forest, source.scenario.score.features))
    model = forest.nodes.model[forest.leaves.node]
    box = np.concatenate([forest.leaves.position[:, :2], forest.leaves.size[:, :2]], axis=1)
    label = np.array([forest.symbols[symbol] for symbol in forest.nodes.symbol[forest.leaves.node]])
    expected = [truth(label[model == each].tolist(), box[model == each]) for each in range(200)]
    assert found.tolist() == expected
    assert {0.0, 30.0, 80.0} == set(expected)


def test_a_learner_is_measured_on_it_like_on_any_other() -> None:
    source = load_source(SCENARIO)
    small = replace(source, scenario=replace(source.scenario, num_models=200))
    material = prepare(small, Settings())
    assert set(np.unique(material.scores)) == {0.0, 30.0, 80.0}


def test_the_liked_facades_are_a_grammar_exactly() -> None:
    source = load_source(SCENARIO)
    forest = derive(source.grammar_space.grammar, 60, seed=3, assets=source.grammar_space.assets)
    learned = Target.of_score(
        source.grammar_space.grammar, source.scenario.score, assets=source.grammar_space.assets
    ).compiled(forest)
    sampled = learned.sample(40, 1)
    assert (source.scenario.score.evaluate(count(sampled, source.scenario.score.features)) > 0.0).all()


def test_the_shipped_family_is_that_of_the_shipped_facade() -> None:
    written = grammar_of(load_facade(ROOT / "grammars" / "facades" / "arcade.json"), (10.0, 27.0), (10.0, 24.0))
    assert written.text == (ROOT / "grammars" / "facades" / "arcade_family.cga").read_text(encoding="utf-8")


def test_one_shipped_facade_has_grids_on_three_levels() -> None:
    school = load_facade(ROOT / "grammars" / "facades" / "school.json")
    above = dict(enumerate(enclosing(school).tolist())) | {-1: -1}
    names = [grid.name.rstrip(" 0123456789") for grid in school.grids]
    chains = {(names[k], names[above[k]], names[above[above[k]]]) for k in above if above[above[k]] >= 0}
    assert chains == {("panes", "sashes", "storeys")}
    assert [names.count(name) for name in ("panes", "sashes", "storeys")] == [36, 3, 1]


@pytest.mark.parametrize("path", sorted((ROOT / "grammars" / "facades").glob("*.json")), ids=lambda path: path.stem)
def test_shipped_facades_have_exact_grammars_and_their_picture(path: Path) -> None:
    facade = load_facade(path)
    written = grammar_of(facade)
    assert written.exact is not None
    assert written.exact <= 1e-9
    assert [picture.name for picture in facade.pictures] == [f"{path.stem}.png"]
    assert (facade.picture[facade.leaves] == 0).all()
    window = facade.window[facade.leaves]
    areas = (window[:, 2:] - window[:, :2]).prod(axis=1)
    assert np.isclose(areas.sum(), 1.0, atol=1e-3)
