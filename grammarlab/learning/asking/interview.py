"""Interview: rounds of questions to a respondent and learning from the answers."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from grammarlab.learning.answers import Answers
from grammarlab.learning.asking.questions import ask
from grammarlab.learning.asking.turns import next_factor
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.design_space import Designs
from grammarlab.learning.round import State, Study, init, step
from grammarlab.randomness import derived_seed

Person = Callable[[Sequence[Address], int], NDArray[np.float64]]
"""Function from designs by ascending address, with repeats, and the number of earlier scores to scores [k, K],
0 to 100, for K factors."""


def interview(
    study: Study[Designs], factors: Sequence[str], person: Person, *, budget: int, batch: int = 8, seed: int = 0
) -> Iterator[State]:
    """The states after each round, until the budget is spent or the pool is used up.

    Each round is about the factor with the highest expected gain (`grammarlab.learning.asking.turns`), and a design is
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
        asked = ask(study, state, num, choice, factor=factors[active])
        order = sorted(range(len(asked)), key=asked.__getitem__)
        scores = np.empty(len(asked))
        scores[order] = person([asked[place] for place in order], state.num_answers)[:, active]
        answers = Answers(factors[active], asked, scores)
        state = step(study, state, (answers,))
        rounds += 1
        yield state
