"""Formulas in grammars: compiled exactly where they have finitely many values, else written as acceptance rules."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.density.exact.compile import Exactness
from grammarlab.density.targets.accepted import with_rule
from grammarlab.density.targets.target import Target
from grammarlab.derivation.derive import derive
from grammarlab.features.acceptance import Acceptance
from grammarlab.features.expression import Expression
from grammarlab.features.model_score import Score
from grammarlab.features.patterns.conditions import at_least
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern import Formula
from grammarlab.language.grammar import Grammar

GRAMMAR = Grammar.parse(
    """
    attr h = rand(1, 5)
    attr w = rand(1, 5)
    Lot --> 50% : Two Part Part else : Three Part Part Part
    Part --> 50% : Red 30% : Blue else : Green
    """
)
PLACES = [f"which({{Lot > Part@{i}:0}}, {{Lot > Part@{i}:1}}, {{Lot > Part@{i}:2}})" for i in (1, 2, 3)]
FINITE = [
    f"equal({', '.join(PLACES)})",
    f"mirrored({', '.join(PLACES)})",
    f"unequal_neighbours({', '.join(PLACES)})",
    f"longest_run({', '.join(PLACES)})",
    "max({Part:0}, {Part:1})",
    "{Part:0} == {Part}",
]
CONTINUOUS = ["$h + $w", "{Part} * $h / $w", "$h > $w"]


def _formula(text: str) -> Formula:
    return Expression.parse(text).formula


@pytest.mark.parametrize("text", FINITE)
def test_formulas_of_finitely_many_values_compile_to_their_exact_density(text):
    formula, forest = _formula(text), derive(GRAMMAR, 2_000, seed=1)
    assert Exactness(GRAMMAR, forest).reason_against(formula) == ""
    score = Score.of_text(f"100 * choose({at_least(formula, 1.0)}, 1, 0.2)")
    learned = Target.of_score(GRAMMAR, score).compiled(forest)
    liked = np.where(count(forest, [formula])[:, 0] >= 1.0, 100.0, 20.0)
    ratio = learned.ratio(forest)
    np.testing.assert_allclose(ratio / ratio.max(), liked / liked.max(), rtol=1e-9)


@pytest.mark.parametrize("text", CONTINUOUS)
def test_formulas_of_drawn_numbers_have_no_exact_grammar(text):
    assert Exactness(GRAMMAR, derive(GRAMMAR, 100, seed=1)).reason_against(_formula(text))


@pytest.mark.parametrize("text", [*FINITE, *CONTINUOUS])
def test_an_acceptance_rule_over_a_formula_is_written_and_read_back(text):
    formula, forest = _formula(text), derive(GRAMMAR, 200, seed=2)
    rule = Expression.parse(f"choose({at_least(formula, 1.0)}, 1, 0.25)")
    written = Grammar.parse(with_rule(GRAMMAR, Acceptance(rule, {}), 0.5))
    acceptance = Acceptance.of(written.tree)
    assert acceptance is not None
    expected = np.where(count(forest, [formula])[:, 0] >= 1.0, 1.0, 0.25)
    np.testing.assert_array_equal(acceptance.probabilities(derive(written, 200, seed=2)), expected)
