"""Palindromic chains, as chains of half the length."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from grammarlab.facade.examples.labels.bounds.chains import Chain, Costs, SequenceTally, cheapest


def cheapest_palindrome(costs: Sequence[Costs], own: Sequence[Costs], tally: SequenceTally | None = None) -> Chain:
    """The cheapest sequence whose places k and -1 - k have the same state.

    Args:
        costs: see `cheapest`; the same states at all places.
        own: see `cheapest`.
        tally: limits of sums over the sequence.
    """
    size = len(costs)
    half = (size + 1) // 2
    odd = size % 2 == 1
    if size == 1:
        return cheapest(costs, own, tally)
    folded = [costs[place] + costs[-1 - place].transpose(2, 1, 0) for place in range(half - 1)]
    middle = costs[half - 1]
    states = np.arange(middle.shape[1])
    if odd:  # the last place is the middle: its neighbours are equal
        last = middle[states[:, None], states[None, :], states[:, None]]
    else:
        after = costs[half]
        last = middle[:, states, states] + after[states, states, :].T
    alone = [own[place] + (own[-1 - place] if 2 * place + 1 < size else 0.0) for place in range(half)]
    chain = cheapest([*folded, last[:, :, None]], alone, _doubled(tally, half, odd))
    rest = chain.states[:-1] if odd else chain.states
    return Chain(np.concatenate([chain.states, rest[::-1]]), chain.cost)


def _doubled(tally: SequenceTally | None, half: int, odd: bool) -> SequenceTally | None:
    if tally is None:
        return None
    weights: list[NDArray[np.int64]] = [2 * weight for weight in tally.weight[:half]]
    if odd:
        weights[-1] = tally.weight[half - 1]
    return SequenceTally(tuple(weights), tally.least, tally.most)
