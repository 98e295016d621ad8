"""Candidates that scores choose are their formulas."""

import numpy as np
import pytest

from grammarlab.features.expression import Expression
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern import Formula
from grammarlab.learning.chosen_candidates import chosen_candidates
from tests.tastes.grammars import GRAMMARS, elements_of, forests_of


@pytest.mark.parametrize("grammar", GRAMMARS)
def test_the_columns_of_chosen_candidates_are_the_values_of_their_formulas(grammar):
    elements, forests = elements_of(grammar), forests_of(grammar)
    scores = np.random.default_rng(0).uniform(0.0, 100.0, elements.num)
    for candidate in chosen_candidates(elements, scores):
        formula = candidate.formula()
        values = np.concatenate([count(forest, [formula])[:, 0] for forest in forests])
        np.testing.assert_allclose(values, candidate.values, atol=1e-12)
        if isinstance(formula, Formula):
            assert Expression.parse(str(formula)).formula == formula


def test_choices_of_which_a_model_uses_one_are_one_choice():
    elements = elements_of("blocks")
    chosen = [candidate.formula() for candidate in chosen_candidates(elements, colors_liked(elements))]
    assert any("$brickColor:0" in str(one) and "$woodColor:1" in str(one) and "$trim:1" in str(one) for one in chosen)


def colors_liked(elements):
    """Scores of models whose trim goes with the colour of their wall."""
    values = {
        str(formula): column for formula, column in zip(elements.counts.formulas, elements.counts.values.T, strict=True)
    }
    brick, trim = values["brickColor:0"] * values["Lot:0"], values["trim:1"]
    wood = values["woodColor:1"] * (1.0 - values["Lot:0"])
    return 90.0 * ((brick + wood > 0.0) == (trim > 0.0))


def test_parts_that_must_not_be_mixed_are_a_formula():
    elements = elements_of("towers")
    counts = zip(elements.counts.formulas, elements.counts.values.T, strict=True)
    has = {str(part): column > 0.0 for part, column in counts}
    mixed = (has["Roof:0"] | has["color:1"]) & has["Tower:1"]
    chosen = list(chosen_candidates(elements, 90.0 * ~mixed))
    assert any(one.values.tolist() == mixed.tolist() for one in chosen if "{Tower:1} and" in str(one.formula()))
