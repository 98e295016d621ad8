"""Relations of two draws that may matter: their ratio, or their difference, such as height to width."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.forest import Forest
from grammarlab.features.counting.counts import count
from grammarlab.features.patterns.pattern import Draw, Sum
from grammarlab.features.search.sums import explained

Floats = NDArray[np.float64]

MOST = 8
"""Largest number of relations."""
_MOST_DRAWS = 48
"""Largest number of draws; of more, the first ones are used."""
_TINY = 1e-300


def find_relations(forests: Sequence[Forest], scores: Floats, names: Sequence[str]) -> tuple[list[Sum], float]:
    """Ratios and differences of two draws that explain more of the scores than either draw, best first.

    Many do so by chance: whether scores need one is for others to judge.

    Args:
        forests: the scored models.
        scores: [n] their scores, in their order.
        names: candidate draws, by `Site.name`.

    Returns:
        The relations, and the log of the number of all: what the choice of one costs, in nats.
    """
    names = names[:_MOST_DRAWS]
    pairs = np.stack(np.triu_indices(len(names), 1), axis=1)
    if len(scores) < 2 or not len(pairs):
        return [], 0.0
    values = np.concatenate([count(forest, [Draw(name) for name in names]) for forest in forests])
    alone = explained(values, scores)
    positive = pairs[np.isin(pairs, np.flatnonzero((values > 0.0).all(axis=0))).all(axis=1)]
    found: list[tuple[float, Sum]] = []
    for logarithmic, possible in ((True, positive), (False, pairs)):
        columns = np.log(np.maximum(values, _TINY)) if logarithmic else values
        shares = explained(columns[:, possible[:, 0]] - columns[:, possible[:, 1]], scores)
        for place in np.flatnonzero(shares > alone[possible].max(axis=1)).tolist():
            one, other = (int(site) for site in possible[place])
            found.append((float(shares[place]), Sum.of((names[one], names[other]), (1.0, -1.0), logarithmic)))
    best = sorted(found, key=lambda each: -each[0])[:MOST]
    return [relation for _, relation in best], float(np.log(2 * len(pairs)))
