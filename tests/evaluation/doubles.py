"""A small world for the protocol: rows of random bits, a score that two of them decide, a learner that remembers."""

import numpy as np

from grammarlab.evaluation.preparation import Material
from tests.learning.bits import SIZE, BitsSpace, score_of, study_of

LABELLED, POOL = 300, SIZE


def world(num_factors=1, weights=None, score=score_of, **settings):
    """A material of bits; see `tests.learning.bits`."""
    space = BitsSpace()
    (labelled,) = space.sample(False, LABELLED, seed=11)
    study = study_of(space, others=(labelled,), **{"widens": False, **settings})
    return Material(
        tuple(f"factor {k}" for k in range(num_factors)),
        score(labelled)[:, :num_factors],
        np.ones(LABELLED) if weights is None else weights,
        study,
        lambda addresses, _numbers: score(space.make(addresses))[:, :num_factors],
        lambda addresses: score(space.make(addresses))[:, :num_factors],
    )
