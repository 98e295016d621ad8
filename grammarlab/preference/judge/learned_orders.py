"""Orders of alternatives by which sequences never fall, as the scores say.

From the order of the text and from its reverse, two alternatives change places as long as the scores are explained
better; the better end counts. The price of an order is that of its choice among all.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from operator import itemgetter
from typing import NamedTuple

import numpy as np
from scipy.special import gammaln

from grammarlab.arrays import Floats, Ints
from grammarlab.preference.growth.screening import explained


class LearnedOrder(NamedTuple):
    """A flag: whether a sequence of choices never falls in an order of the alternatives."""

    sequence: tuple[int, ...]
    """Indices of the choices."""
    order: tuple[int, ...]
    """Numbers of the alternatives, from the lowest to the highest."""
    price: float
    """Log of the number of sequences and of orders, in nats."""

    def values(self, numbers: Ints) -> Floats:
        """[n] the flag, for numbers [n, K] of the alternatives of choices."""
        return _never_falls(numbers[:, list(self.sequence)], np.array([self.order]))[0]


def learned_orders(numbers: Ints, sequences: Sequence[tuple[int, ...]], scores: Floats) -> Iterator[LearnedOrder]:
    """The best order of each sequence that may have several.

    Args:
        numbers: [n, K] number of the alternative of each choice, 0 for none.
        sequences: indices of choices with the same alternatives.
        scores: [n] 0-100.
    """
    if not np.ptp(scores) > 0.0:
        return
    for sequence in sequences:
        parts = numbers[:, list(sequence)]
        num = int(parts.max(initial=0))
        if num > 2:
            of_text = np.arange(1, num + 1)
            order, _ = max((_improved(parts, start, scores) for start in (of_text, of_text[::-1])), key=itemgetter(1))
            price = np.log(len(sequences)) + gammaln(num + 1)
            yield LearnedOrder(sequence, tuple(order.tolist()), float(price))


def _improved(parts: Ints, order: Ints, scores: Floats) -> tuple[Ints, float]:
    """An order that no change of places of two alternatives improves, and how much it explains."""
    swaps = np.array(list(combinations(range(len(order)), 2)))
    every, worth = np.arange(len(swaps)), -np.inf
    while True:
        orders = np.repeat(order[None], len(swaps) + 1, axis=0)
        orders[every[:, None], swaps] = orders[every[:, None], swaps[:, ::-1]]
        worths = explained(_never_falls(parts, orders).astype(np.int64), 2, scores)
        best = int(np.argmax(worths))
        if worths[best] <= worth:
            return order, worth
        order, worth = orders[best], float(worths[best])


def _never_falls(parts: Ints, orders: Ints) -> Floats:
    """[P, n] whether sequences [n, L] of two parts or more never fall in each of some orders [P, K]."""
    ranks = np.concatenate([np.zeros((len(orders), 1), dtype=np.int64), 1 + np.argsort(orders, axis=1)], axis=1)
    before = np.zeros((len(orders), len(parts)), dtype=np.int64)
    holds = np.tile((parts > 0).sum(axis=1) >= 2, (len(orders), 1))
    for column in parts.T:
        rank = ranks[:, column]
        holds &= (rank == 0) | (rank >= before)
        before = np.where(rank == 0, before, rank)
    return holds.astype(np.float64)
