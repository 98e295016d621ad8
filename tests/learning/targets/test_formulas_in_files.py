"""A liked formula becomes a grammar: exactly where that is possible, else with an acceptance rule that reads back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.density.exact.learned import LearnedGrammar
from grammarlab.density.targets.accepted import AcceptedGrammar
from grammarlab.features.acceptance import Acceptance
from grammarlab.features.expression import Expression
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern import Formula
from grammarlab.language.grammar import Grammar
from grammarlab.learning.answers import Answers
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.learning.designs.pool import Pool
from grammarlab.learning.round import Study, init, step
from grammarlab.learning.targets.grammar_target import GrammarWriter
from grammarlab.learning.targets.simplification import TOLERANCE
from grammarlab.learning.targets.writers import LearnedDensity, Making
from grammarlab.preference.base import AbstractPreference, Prediction, Relevance, Rows
from tests.cases import takes_turns

GRAMMAR = Grammar.parse(
    """
    attr storey = rand(2.5, 4)
    attr plinth = rand(0, 2)
    attr front = rand(8, 12)
    @StartRule
    Lot --> s(front, 0, 8) Floors
    Floors --> 30% : Floor 40% : Floor Floor else : Floor Floor Floor
    Floor --> 40% : Brick. 40% : Glass. else : Steel.
    """
)
PLACES = ", ".join(f"which({', '.join(f'{{Floors > Floor@{i}:{b}}}' for b in range(3))})" for i in range(3))
ALIKE = Expression.parse(f"equal({PLACES})").formula
PROPORTION = Expression.parse("({Floor} * $storey + $plinth) / $front").formula


class Known(AbstractPreference):
    """Scores of the models of a pool."""

    num_columns = 0

    def __init__(self, scores: Floats) -> None:
        self.scores = scores

    def predict(self, rows: Rows) -> Prediction:
        return Prediction(self.scores, np.zeros(len(self.scores)))

    def explain(self, group_names: Sequence[str]) -> list[Relevance]:
        return [Relevance(name, 0.0, "none") for name in group_names]


def learned(formula: Formula, low: float, high: float) -> LearnedDensity:
    """The file of a person who likes models in which a formula is in a range."""
    space = GrammarSpace(GRAMMAR)
    study = Study(space, Pool(0, 4_000))
    answers = Answers("overall", tuple(study.pool)[:3], np.array([0.0, 50.0, 100.0]))
    state = step(study, init(study), (answers,))
    values = space.values(study.tables(state.wide).pool_designs.batches, (formula,))[:, 0]
    known = Known(np.where((values >= low) & (values < high), 100.0, 0.0))
    columns = replace(state.columns, extra=(formula,))
    state = replace(state, preferences={"overall": known}, columns=columns)
    return GrammarWriter(space).learn(study, state, Making())


@takes_turns
def test_floors_alike_are_a_grammar_without_a_rule():
    found = learned(ALIKE, 0.5, 1.5)
    assert isinstance(found.learned, LearnedGrammar)
    assert sum(each.js for each in found.steps) <= TOLERANCE
    assert found.names == ("Floors › Floor 1, Floors › Floor 2 and Floors › Floor 3 alike",)
    assert (count(found.learned.as_original(found.learned.sample(300, 1)), [ALIKE]) == 1.0).all()


@takes_turns
def test_a_proportion_is_an_acceptance_rule_that_reads_back():
    found = learned(PROPORTION, 0.5, 0.8)
    assert isinstance(found.learned, AcceptedGrammar)
    assert PROPORTION in found.features
    assert "(number of Floor · storey + plinth) over front" in found.names
    acceptance = Acceptance.of(Grammar.parse(found.learned.text).tree)
    assert acceptance is not None
    # What the percentages say of its parts is not said again.
    assert set(acceptance.expression.features) == set(PROPORTION.features)
    values = count(found.learned.sample(300, 1), [PROPORTION])[:, 0]
    inside = (values > 0.49) & (values < 0.81)
    assert inside.mean() > 0.97
