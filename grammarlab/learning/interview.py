"""Interview: rounds of questions to a respondent and learning from the answers.

The next factor to ask about is the one whose scores are expected to change the learned density most. Some factors are
known after a few scores, and others take most of them. The divergence that a factor leaves open is estimated as in
`grammarlab.learning.stopping`, with the other factors at their predictions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Ints
from grammarlab.learning.answers import Answers
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.design_space import Designs
from grammarlab.learning.questions import ask
from grammarlab.learning.round import State, Study, init, step
from grammarlab.learning.stopping import remaining_divergence, some_designs
from grammarlab.preference.base import MAX_SCORE
from grammarlab.preference.factors import ProductPreference
from grammarlab.randomness import derived_seed

Person = Callable[[Sequence[Address], Ints], NDArray[np.float64]]
"""Function from designs by ascending address, with repeats, and the number [k] of each answer, 0 for the first one, to
scores [k, K], 0 to 100, for K factors."""
MIN_SCORES = 24
"""Number of scores of every factor before one is preferred."""
MIN_TURN_SHARE = 0.5
"""Least share of the scores that a factor would get in turn, since a learner that is sure may be wrong."""
_GAIN_TOLERANCE = 1e-3
"""Gain in nats below which gains are equal."""


def interview(
    study: Study[Designs], factors: Sequence[str], person: Person, *, budget: int, batch: int = 8, seed: int = 0
) -> Iterator[State]:
    """The states after each round, until the budget is spent or the pool is used up.

    Each round is about the factor with the highest expected gain (`grammarlab.learning.interview`), and a design is
    asked about at most once per factor. The choice of designs in round r for factor f draws from a key of (seed, r, f),
    so a shorter interview is the beginning of a longer one, except that its last batch may be shorter.

    Args:
        study: the pool and the settings.
        factors: names of K >= 1 factors.
        person: the respondent.
        budget: scores to ask for, all factors together, >= 1.
        batch: designs per round, >= 1; the last round is cut to the budget.
        seed: 0 <= seed < 2**64.
    """
    state, rounds = init(study), 0
    while state.num_answers < min(budget, len(study.pool) * len(factors)):
        num = min(batch, budget - state.num_answers)
        active = next_factor(study, state, factors, num)
        choice = derived_seed(seed, rounds, active, 0)
        designs = ask(study, state, num, choice, factor=factors[active])
        order = np.array(sorted(range(len(designs)), key=designs.__getitem__), dtype=np.int64)
        scores = np.empty(len(designs))
        scores[order] = person([designs[index] for index in order.tolist()], state.num_answers + order)[:, active]
        answers = Answers(factors[active], designs, scores)
        state = step(study, state, (answers,))
        rounds += 1
        yield state


def next_factor(study: Study[Designs], state: State, factors: Sequence[str], num: int) -> int:
    """Index of the factor to ask about next.

    Args:
        study: the pool and the settings.
        state: the state.
        factors: names of K >= 1 factors.
        num: number of scores of the next round, >= 1.

    Returns:
        The factor with the highest expected gain; of equal ones, and while any factor has too few scores or none above
        0, and for learning methods without a posterior, the first one of those with the fewest scores. One with
        scores for the whole pool comes last.
    """
    num_scores = [len(state.answers[name].designs) if name in state.answers else 0 for name in factors]
    behind = int(np.argmin(num_scores))
    fewest = max(MIN_SCORES, MIN_TURN_SHARE * sum(num_scores) / len(factors))
    if len(factors) == 1 or num_scores[behind] < fewest or not set(factors) <= set(state.liked):
        return behind
    gains = _gains(study, state, factors, num_scores, num)
    if gains is None:
        return behind
    # A person may have compared or scored more models than the pool has.
    unfinished = [index for index, number in enumerate(num_scores) if number < len(study.pool)]
    return min(
        unfinished or range(len(factors)), key=lambda index: (-max(gains[index], _GAIN_TOLERANCE), num_scores[index])
    )


def _gains(
    study: Study[Designs], state: State, factors: Sequence[str], num_scores: Sequence[int], num: int
) -> list[float] | None:
    """Expected gain of more scores of each factor, in nats; None without a posterior.

    With n scores of a factor, and a divergence that is proportional to 1 / n, k more are a gain of a share k / (n + k).
    """
    rows, weights = some_designs(study, state)
    preferences = [state.preferences[name] for name in factors]
    values = [np.clip(state.preferences[name].predict(rows).mean, 0.0, MAX_SCORE) for name in factors]
    gains = list[float]()
    for index, (preference, number) in enumerate(zip(preferences, num_scores, strict=True)):
        others = weights * np.prod([scores for other, scores in enumerate(values) if other != index], axis=0)
        product = ProductPreference({factors[index]: preference})
        divergence = remaining_divergence(
            product, rows, others if others.any() else weights, number, study.settings.seed
        )
        if divergence is None:
            return None
        gains.append(divergence * num / (number + num))
    return gains
