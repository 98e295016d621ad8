"""When to stop: what more scores can be expected to gain.

The divergence that is left is estimated by functions drawn from the posterior: each could be what the person likes, and
the mean of their divergences from the predicted density is the expected one. It is taken to fall with the number of
scores to the power of -`FALL`, which is what simulated persons were measured to do. A learner that is sure of something
wrong does not know it, so single estimates are right within a factor of two about twice in three only.
"""

from __future__ import annotations

import numpy as np

from grammarlab.learning.designs.design_space import Designs
from grammarlab.learning.round import State, Study
from grammarlab.learning.targets.divergence import jensen_shannon
from grammarlab.preference.questions.draws import draws

MORE = 16
"""Scores whose gain is told."""
FALL = 3.0
"""Power of the number of scores with which the divergence falls."""
_DESIGNS = 500
"""Of the pool, evenly spaced, on which densities are compared."""
_DRAWS = 24


def expected_gain(study: Study[Designs], state: State, more: int = MORE) -> float | None:
    """How much nearer, in nats, the learned density would come to what is liked by some more scores.

    Args:
        study: the pool and its tables.
        state: what is known.
        more: how many scores.

    Returns:
        Expected drop of the Jensen-Shannon divergence, 0 to ln 2; None where nothing is liked yet, or the method of
        learning knows no functions that it holds possible.
    """
    left = expected_divergence(study, state)
    known = state.num_answers
    return None if left is None else left * (1.0 - (known / (known + more)) ** FALL)


def expected_divergence(study: Study[Designs], state: State) -> float | None:
    """How far, in nats, the learned density is expected to be from what is liked; None as for `expected_gain`."""
    product = state.product
    if product is None:
        return None
    weights = study.tables(state.wide).made.weights
    made = np.flatnonzero(weights > 0.0)
    num = min(_DESIGNS, len(made))
    some = made[np.arange(num) * len(made) // num]
    rows, weights = study.table(state).rows[some], weights[some]
    found = draws(product, rows, _DRAWS, np.random.default_rng(study.settings.seed))
    if found is None:
        return None
    # A function that likes nothing leaves the density of the grammar.
    *possible, predicted = [
        weights * values if values.any() else weights for values in (*found, product.predict(rows).mean)
    ]
    return float(np.mean([jensen_shannon(density, predicted) for density in possible]))
