"""Stopping: the expected gain of more scores.

The remaining divergence is estimated by functions drawn from the posterior: each is a possible preference, and
the mean of their divergences from the predicted density is the expected one. It is assumed to fall with the number of
scores to the power of -`FALL`, as measured with simulated persons. An overconfident learner underestimates it:
single estimates are right within a factor of two only about two times in three.
"""

from __future__ import annotations

import numpy as np

from grammarlab.learning.designs.design_space import Designs
from grammarlab.learning.round import State, Study
from grammarlab.learning.targets.divergence import jensen_shannon
from grammarlab.preference.questions.draws import draws

MORE = 16
"""Number of scores whose gain is reported."""
FALL = 3.0
"""Power of the number of scores with which the divergence falls."""
_DESIGNS = 500
"""Number of designs of the pool, evenly spaced, on which densities are compared."""
_DRAWS = 24


def expected_gain(study: Study[Designs], state: State, more: int = MORE) -> float | None:
    """Expected decrease, by more scores, of the divergence of the learned density from the target density, in nats.

    Args:
        study: the pool and its tables.
        state: the state.
        more: number of scores.

    Returns:
        Expected drop of the Jensen-Shannon divergence, 0 to ln 2; None if nothing is liked yet, or the learning method
        has no posterior.
    """
    left = expected_divergence(study, state)
    known = state.num_answers
    return None if left is None else left * (1.0 - (known / (known + more)) ** FALL)


def expected_divergence(study: Study[Designs], state: State) -> float | None:
    """Expected divergence of the learned density from the target density in nats; None as in `expected_gain`."""
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
