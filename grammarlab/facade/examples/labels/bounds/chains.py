"""Cheapest sequence of states for costs of three consecutive states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Costs = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class SequenceTally:
    """Sums over a sequence with upper limits, such as counts of labels."""

    weight: tuple[NDArray[np.int64], ...]
    """By place: [states, sums] contribution of each state."""
    least: tuple[int, ...]
    most: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Chain:
    """A sequence of states."""

    states: NDArray[np.int64]
    """[places] states."""
    cost: float
    """Infinite if no sequence is allowed."""


def cheapest(costs: Sequence[Costs], own: Sequence[Costs], tally: SequenceTally | None = None) -> Chain:
    """The cheapest sequence, by dynamic programming over pairs of neighbours.

    Args:
        costs: by place: [states before, states here, states after] cost of three neighbours; there is one state before
            the first place and one after the last.
        own: by place: [states] cost of a single state; infinite if it is not allowed.
        tally: limits of sums over the sequence.
    """
    if tally is not None:
        return _tallied(costs, own, tally)
    value = own[0][None, :]
    choices = []
    for place in range(len(costs) - 1):
        through = value[:, :, None] + costs[place]
        choice = through.argmin(axis=0)
        choices.append(choice)
        value = np.take_along_axis(through, choice[None], axis=0)[0] + own[place + 1][None, :]
    last = value + costs[-1][:, :, 0]
    before, here = np.unravel_index(int(last.argmin()), last.shape)
    states = [int(here), int(before)]
    for choice in reversed(choices):
        states.append(int(choice[states[-1], states[-2]]))
    return Chain(np.array(states[: len(costs)][::-1]), float(last[before, here]))


def _tallied(costs: Sequence[Costs], own: Sequence[Costs], tally: SequenceTally) -> Chain:
    """The cheapest sequence with limits: the sums, capped just above each limit, are part of the state."""
    sizes = np.array(tally.most) + 1
    sums = np.stack([axis.ravel() for axis in np.indices(sizes.tolist())], axis=1)  # [totals, sums]
    radix = np.concatenate([np.cumprod(sizes[::-1])[::-1][1:], [1]])
    totals = len(sums)

    def added(place: int) -> NDArray[np.int64]:
        """[totals, states] total after a state, or `totals` if it exceeds a limit."""
        after = sums[:, None, :] + tally.weight[place][None, :, :]
        return np.where((after < sizes).all(axis=2), after @ radix, totals)

    start = added(0)[0]
    value = np.full((1, len(own[0]), totals + 1), np.inf)
    value[0, np.arange(len(own[0])), start] = own[0]
    value[:, :, totals] = np.inf
    choices = []
    for place in range(len(costs) - 1):
        through = value[:, :, None, :totals] + costs[place][:, :, :, None]
        best, choice = through.min(axis=0), through.argmin(axis=0)  # [here, after, totals]
        to = added(place + 1)
        here, after = best.shape[:2]
        value = np.full((here, after, totals + 1), np.inf)
        source = np.full((here, after, totals + 1), -1)
        for total in range(totals):
            for state in range(after):
                reached = to[total, state]
                better = best[:, state, total] + own[place + 1][state] < value[:, state, reached]
                value[better, state, reached] = best[better, state, total] + own[place + 1][state]
                source[better, state, reached] = total
        value[:, :, totals] = np.inf
        choices.append((choice, source))
    last = value[:, :, :totals] + costs[-1][:, :, :1]
    last[:, :, (sums < np.array(tally.least)).any(axis=1)] = np.inf
    before, here, total = (int(index) for index in np.unravel_index(int(last.argmin()), last.shape))
    cost = float(last[before, here, total])
    states = [here, before]
    if np.isfinite(cost):
        for choice, source in reversed(choices):
            total = int(source[states[-1], states[-2], total])
            states.append(int(choice[states[-1], states[-2], total]))
    else:
        states += [0] * len(choices)
    return Chain(np.array(states[: len(costs)][::-1]), cost)
