"""Models to learn from follow the wanted density, whether an exact grammar draws them or rejection."""

import numpy as np
import pytest
from scipy.stats import chisquare

from grammarlab.density.targets.target import Target
from grammarlab.density.targets.target_samples import draw
from grammarlab.errors import GrammarlabError, InexactError
from grammarlab.features.expression import Expression
from grammarlab.features.model_score import Score, ScoreCase
from grammarlab.language.grammar import Grammar

HOUSE = Grammar.parse(
    "attr height = rand(0, 10)\nLot --> Part Part\nPart --> 20% : Glass 30% : Brick else : Stone\n"
    "Glass --> 50% : Red else : Blue"
)


def score(*cases):
    return Score.of_cases([ScoreCase(value, Expression.parse(when)) for value, when in cases])


GLASSY = Target.of_score(HOUSE, score((60, "{Glass} == 1 and {Brick} == 1"), (30, "{Glass} == 2")))


def values(target, number, seed, **options):
    """[models, features] of the models drawn."""
    found = draw(target, lambda models, rows: models.values[rows], number, seed, **options)
    return np.concatenate([kept[rows] for kept, rows in found.chunks]), found


def refuse(*_arguments, **_options):
    raise InexactError("too large")


@pytest.mark.parametrize("exact", [True, False])
def test_models_follow_the_density(exact, monkeypatch):
    if not exact:
        monkeypatch.setattr(Target, "compiled", refuse)
    drawn, found = values(GLASSY, 4_000, 3)
    mixed = (drawn == [1.0, 1.0]).all(axis=1)
    assert (mixed | (drawn == [2.0, 0.0]).all(axis=1)).all()
    # By hand: 2 x 0.2 x 0.3 x 60 and 0.2^2 x 30.
    weights = np.array([7.2, 1.2])
    assert chisquare([mixed.sum(), (~mixed).sum()], 4_000 * weights / weights.sum()).pvalue > 1e-3
    assert found.mean_preference == pytest.approx(weights.sum(), rel=1e-12 if exact else 0.05)
    assert found.finding.startswith("4,000 models drawn by the exact grammar" if exact else "accepted 4,")


def test_draws_that_the_exact_grammar_does_not_tell_are_found_by_rejection():
    low = Target.of_score(HOUSE, score((100, "$height < 2 and {Glass} >= 1")))
    drawn, found = values(low, 300, 3)
    assert (drawn[:, [feature.__class__.__name__ == "Threshold" for feature in low.features]] == 1.0).all()
    assert found.finding.startswith("accepted 3")


def test_the_same_seed_draws_the_same_models():
    one, two, other = (values(GLASSY, 200, seed)[0] for seed in (5, 5, 6))
    np.testing.assert_array_equal(one, two)
    assert (one != other).any()


def test_nothing_liked_is_told():
    with pytest.raises(GrammarlabError, match="0 for every model that the grammar makes"):
        values(Target.of_score(HOUSE, score((10, "{Glass} >= 3"))), 10, 1)
