"""Protocol of simulated persons: they score models, and the learned density is compared with the true one.

This is the protocol of section 4.7 of the paper, around an interview (`grammarlab.learning.interview`). Its
quantities:

- labelled set: n models (5,000 in the paper's protocol) drawn independently from the grammar with density p at a fixed
  seed, repeats kept, each with its true score u_i = product of the factors' scores / 100. Nobody is asked about them.
- label: one score (0-100) of one model of the pool for one factor, as the person answers
  (`grammarlab.evaluation.respondents`): the true score, or that with noise. With several factors, a label for each
  counts.
- round: ``batch`` models for one factor: the default method asks about the factor that is most open, others take turns.
- learned preference û_i: the product over the liked factors of the predicted mean / 100, clipped to 0-1; 1 before
  anything is liked.
- target weights p*_i = w_i u_i / sum_j w_j u_j and learned weights q_i = w_i û_i / sum_j w_j û_j, where w_i = 1 for
  ``base="grammar"`` (target density proportional to p u), 1 / p_i for ``base="uniform"`` (proportional to u).
  Where û is 0 everywhere, q_i = w_i / sum_j w_j.
- JS = H((p* + q) / 2) - H(p*) / 2 - H(q) / 2 in nats, 0 to ln 2; "original" is that of û = 1.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.evaluation.curves import Curve, Point
from grammarlab.evaluation.preparation import Material
from grammarlab.learning.interview import interview
from grammarlab.learning.round import State, init
from grammarlab.learning.targets.divergence import agreement
from grammarlab.preference.base import MAX_SCORE


def run(
    material: Material, batch: int, seed: int, max_labels: int, on_round: Callable[[State], None] = lambda _state: None
) -> tuple[State, Curve]:
    """All rounds up to a number of labels, or until the pool is used up.

    Args:
        material: the models and the person.
        batch: models per round, >= 1.
        seed: 0 <= seed < 2**64.
        max_labels: >= 1; the last round is cut to it.
        on_round: called with the state after every round.
    """
    state, points, liked = init(material.study), list[Point](), 0
    rounds = interview(material.study, material.factors, material.person, budget=max_labels, batch=batch, seed=seed)
    for after in rounds:
        liked += _newly_liked(material, state, after)
        state = after
        js, correlation = agreement(material.target, learned(material, state), material.weights)
        points.append(Point(state.num_answers, js, correlation, liked))
        on_round(state)
    return state, Curve(tuple(points))


def _newly_liked(material: Material, before: State, after: State) -> int:
    """Number of answers of a round about designs with a true score above 0."""
    num_liked = 0
    for index, factor in enumerate(material.factors):
        num_before = len(before.answers[factor].designs) if factor in before.answers else 0
        designs = after.answers[factor].designs[num_before:] if factor in after.answers else ()
        if designs:
            num_liked += int((material.true_scores(sorted(designs))[:, index] > 0.0).sum())
    return num_liked


def learned(material: Material, state: State) -> Floats:
    """[n] the learned preference of the labelled set, 0 to 1: 1 everywhere before anything is liked."""
    product = state.product
    if product is None:
        return np.ones(len(material.weights))
    return product.predict(material.study.table(state).others).mean / MAX_SCORE
