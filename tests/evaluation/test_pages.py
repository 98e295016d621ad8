"""Models to show for each score."""

from dataclasses import replace
from pathlib import Path

import pytest

from grammarlab.evaluation.preparation import Source
from grammarlab.evaluation.scenario import load, parse
from grammarlab.features.patterns.counts import count
from grammarlab.language.grammar import Grammar
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.runs.evaluate.pictures import BANDS, OTHERS, models_for_scores

ROOT = Path(__file__).parents[2]


def source_of(scenario) -> Source:
    grammar = Grammar.parse((ROOT / "grammars" / f"{scenario.grammar}.cga").read_text())
    return Source(scenario, GrammarSpace(grammar, ROOT / "grammars" / "assets"))


def scores(source, models):
    score = source.scenario.score
    forest = source.space.make([source.labelled_address._replace(model=model) for model in sorted(models)])
    values = dict(zip(sorted(models), score.evaluate(count(forest, score.features)).tolist(), strict=True))
    return [values[model] for model in models]


@pytest.mark.parametrize("name", ["F1", "F3xF4", "S2", "L1", "L5"])
def test_every_model_has_the_score_of_its_group(name):
    source = source_of(load(ROOT / "scenarios" / f"{name}.toml"))
    groups = models_for_scores(source, 3)
    for group in groups:
        assert len(group.models) == 3
        assert list(group.models) == sorted(set(group.models))
        assert scores(source, group.models) == pytest.approx([group.score] * 3)


def test_there_is_a_group_for_each_case_and_one_for_the_others():
    source = source_of(load(ROOT / "scenarios" / "F1.toml"))
    groups = models_for_scores(source, 2)
    assert [(group.score, group.means) for group in groups] == [
        (70, "stands on one leg"),
        (20, "stands on two legs"),
        (10, "stands on four legs"),
        (0, OTHERS),
    ]


def test_a_product_has_a_group_for_each_score():
    source = source_of(load(ROOT / "scenarios" / "F3xF4.toml"))
    assert [group.score for group in models_for_scores(source, 1)] == [49, 21, 9, 0]


def test_an_expression_has_bands():
    text = 'name = "a"\ntitle = "a"\ngrammar = "toy"\npreference = "25 * ($h1 - 1)"'
    source = source_of(parse(text))
    groups = models_for_scores(source, 4)
    assert [group.score for group in groups] == list(BANDS)
    for group in groups:
        assert all(group.score <= score <= group.score + 20 for score in scores(source, group.models))
        assert len(group.models) == 4


def test_a_group_may_be_empty_or_short():
    scenario = replace(load(ROOT / "scenarios" / "S1.toml"), num_models=5)
    groups = models_for_scores(source_of(scenario), 9)
    together = [model for group in groups for model in group.models]
    assert sorted(together) == [0, 1, 2, 3, 4]
