"""Independent rows of windows: their least energies, over all labels of the three rows that each covers.

The cheapest sequence of states, for costs of three consecutive states, is found by dynamic programming; palindromes are
sequences of half the length.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from grammarlab.synthesis.label_grid import Labels
from grammarlab.synthesis.labels.problem import AWAY, WINDOW, Problem

Costs = NDArray[np.float64]
_Scalar = TypeVar("_Scalar", bound=np.generic)
_PAIRS = ((0, 1), (0, 2), (1, 2))
"""Pairs of the windows before, at and after a cell."""


@dataclass(frozen=True, slots=True)
class WindowStrips:
    """Rows of windows of a problem."""

    problem: Problem
    rows: NDArray[np.int64]
    """[strips] row of the centres of each strip."""
    targets: Labels
    """[strips, columns + 2, patches, 3, 3] labels of the patches of each window; the positions before and after have no
    labels, and the first patch is repeated in windows with fewer patches."""
    allowed: NDArray[np.bool_]
    """[strips, 3, columns, labels] labels that the cells may have."""
    inside: NDArray[np.bool_]
    """[strips, 3] whether each row of a strip is in the grid."""
    cache: dict[bytes, list[CellTargets]] = field(default_factory=dict)
    """Cached tables from `targets`."""

    @classmethod
    def from_problem(cls, problem: Problem, rows: Sequence[int]) -> WindowStrips:
        chosen = np.asarray(rows, dtype=np.int64)
        kinds = np.full((len(chosen), problem.columns + 2), -1, dtype=np.int64)
        kinds[:, 1:-1] = problem.kind[chosen]
        around = chosen[:, None] + np.arange(-1, 2)
        inside = (around >= 0) & (around < problem.rows)
        allowed = problem.domain[np.clip(around, 0, problem.rows - 1)]
        return cls(problem, chosen, problem.padded_patches[kinds], allowed, inside)

    def least(self, prices: Costs) -> tuple[Costs, Labels]:
        """The least energy of each strip, and its labels.

        The chain is of patches: three consecutive patches determine the best label of each cell between them. The
        result is exact.

        Args:
            prices: [strips, 3, columns, labels] added for each label of each cell.

        Returns:
            energies [strips] and labels [strips, 3, columns]; -1 outside of the grid.
        """
        allowed_prices = np.where(self.allowed, prices, np.inf)
        allowed_prices[~self.inside] = 0.0
        size = self.targets.shape[2]
        value = np.zeros((len(self.rows), 1, size))
        choices = []
        columns = self.problem.columns
        for column in range(columns):
            through = value[:, :, :, None] + self._cost(allowed_prices, column)
            choice = through.argmin(axis=1)
            value = np.take_along_axis(through, choice[:, None], axis=1)[:, 0]
            choices.append(choice)
        # The position after the last column has one state; so has the one before the first.
        last = value[:, :, 0]
        strip = np.arange(len(self.rows))
        after, here = np.zeros(len(self.rows), dtype=np.int64), last.argmin(axis=1)
        energies = last[strip, here]
        labels = np.empty((len(self.rows), WINDOW, columns), dtype=np.int64)
        for column in range(columns - 1, -1, -1):
            before = choices[column][strip, here, after]
            labels[:, :, column] = self._labels(allowed_prices, column, (before, here, after))
            here, after = before, here
        labels[~self.inside] = -1
        return energies, labels

    def _targets(self, column: int) -> tuple[Labels, Labels, Labels]:
        """[strips, states, 3 rows] labels of the patches of the windows before, at and after a column, in its cells."""
        before, here, after = (self.targets[:, column + step] for step in range(3))
        before = before[:, :1] if column == 0 else before
        after = after[:, :1] if column == self.problem.columns - 1 else after
        return before[..., 2], here[..., 1], after[..., 0]

    def _cost(self, prices: Costs, column: int) -> NDArray[np.float32]:
        """[strips, before, here, after] least cost of the cells of a column for given patches of three windows."""
        targets = self._cells(column)
        total = targets[0].costs(prices[:, 0, column].astype(np.float32))
        for row in range(1, WINDOW):
            total += targets[row].costs(prices[:, row, column].astype(np.float32))
        return total

    def _cells(self, column: int) -> list[CellTargets]:
        """Target labels of the three cells of each strip in a column; columns with equal neighbours share them."""
        kinds = self.problem.kind[self.rows]
        key = kinds[:, max(0, column - 1) : column + 2].tobytes() + bytes([column == 0])
        if key not in self.cache:
            targets = self._targets(column)
            self.cache[key] = [
                CellTargets.from_targets([target[:, :, row] for target in targets]) for row in range(WINDOW)
            ]
        return self.cache[key]

    def _labels(self, prices: Costs, column: int, states: Sequence[NDArray[np.int64]]) -> Labels:
        """[strips, 3] the best label of each cell of a column for given patches of three windows."""
        strip = np.arange(len(self.rows))
        cost = prices[:, :, column].copy()
        for target, state in zip(self._targets(column), states, strict=True):
            label = target[strip, state][:, :, None]
            cost += (np.arange(cost.shape[2]) != label) & (label != AWAY)
        return cost.argmin(axis=2)


@dataclass(frozen=True, slots=True)
class CellTargets:
    """Labels of a cell in the patches of the windows before, at and after it: all data that do not depend on prices."""

    targets: tuple[Labels, ...]
    """Three arrays [strips, states]."""
    others: tuple[NDArray[np.float32], ...]
    """For each of the three: [strips, before, here, after] how many of the three have the same label."""
    number: NDArray[np.float32]
    """[strips, before, here, after] how many have a label."""

    @classmethod
    def from_targets(cls, targets: Sequence[Labels]) -> CellTargets:
        expanded = [_axis(target, axis) for axis, target in enumerate(targets)]
        agree = [(expanded[first] == expanded[second]).astype(np.float32) for first, second in _PAIRS]
        others = []
        for axis in range(WINDOW):
            first, second = (pair for pair, both in zip(agree, _PAIRS, strict=True) if axis in both)
            others.append(first + second + np.float32(1.0))
        number = sum(
            ((target_labels != AWAY).astype(np.float32) for target_labels in expanded),
            np.zeros((1, 1, 1, 1), np.float32),
        )
        return cls(tuple(targets), tuple(others), number)

    def costs(self, prices: NDArray[np.float32]) -> NDArray[np.float32]:
        """[strips, before, here, after] least cost of the cell: a label's price plus 1 for each window that differs.

        Args:
            prices: [strips, labels] prices of its labels.
        """
        strips = np.arange(len(prices))[:, None]
        least = prices.min(axis=1)[:, None, None, None]
        target_prices = [
            np.where(target != AWAY, prices[strips, np.maximum(target, 0)], np.float32(np.inf))
            for target in self.targets
        ]
        best, middle, after = (
            _axis(price, axis) - others
            for axis, (price, others) in enumerate(zip(target_prices, self.others, strict=True))
        )
        for option in (middle, after, least):
            np.minimum(best, option, out=best)
        best += self.number
        return best


@dataclass(frozen=True, slots=True)
class SequenceTally:
    """Sums over a sequence with upper limits, such as counts of labels."""

    weight: tuple[NDArray[np.int64], ...]
    """By position: [states, sums] contribution of each state."""
    least: tuple[int, ...]
    most: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Chain:
    """A sequence of states."""

    states: NDArray[np.int64]
    """[positions] states."""
    cost: float
    """Infinite if no sequence is allowed."""


def cheapest_palindrome(
    costs: Sequence[Costs], state_costs: Sequence[Costs], tally: SequenceTally | None = None
) -> Chain:
    """The cheapest sequence whose positions k and -1 - k have the same state.

    Args:
        costs: by position: [states before, states here, states after] cost of three neighbours; all positions have the
            same states.
        state_costs: by position: [states] cost of a single state; infinite if it is not allowed.
        tally: limits of sums over the sequence.
    """
    size = len(costs)
    half = (size + 1) // 2
    odd = size % 2 == 1
    if size == 1:
        return cheapest(costs, state_costs, tally)
    folded = [costs[position] + costs[-1 - position].transpose(2, 1, 0) for position in range(half - 1)]
    middle = costs[half - 1]
    states = np.arange(middle.shape[1])
    if odd:  # the last position is the middle: its neighbours are equal
        last = middle[states[:, None], states[None, :], states[:, None]]
    else:
        after = costs[half]
        last = middle[:, states, states] + after[states, states, :].T
    folded_costs = [
        state_costs[position] + (state_costs[-1 - position] if 2 * position + 1 < size else 0.0)
        for position in range(half)
    ]
    chain = cheapest([*folded, last[:, :, None]], folded_costs, _doubled(tally, half, odd))
    rest = chain.states[:-1] if odd else chain.states
    return Chain(np.concatenate([chain.states, rest[::-1]]), chain.cost)


def cheapest(costs: Sequence[Costs], state_costs: Sequence[Costs], tally: SequenceTally | None = None) -> Chain:
    """The cheapest sequence, by dynamic programming over pairs of neighbours.

    Args:
        costs: by position: [states before, states here, states after] cost of three neighbours; there is one state
            before the first position and one after the last.
        state_costs: by position: [states] cost of a single state; infinite if it is not allowed.
        tally: limits of sums over the sequence.
    """
    if tally is not None:
        return _tallied(costs, state_costs, tally)
    value = state_costs[0][None, :]
    choices = []
    for position in range(len(costs) - 1):
        through = value[:, :, None] + costs[position]
        choice = through.argmin(axis=0)
        choices.append(choice)
        value = np.take_along_axis(through, choice[None], axis=0)[0] + state_costs[position + 1][None, :]
    last = value + costs[-1][:, :, 0]
    before, here = np.unravel_index(int(last.argmin()), last.shape)
    states = [int(here), int(before)]
    for choice in reversed(choices):
        states.append(int(choice[states[-1], states[-2]]))
    return Chain(np.array(states[: len(costs)][::-1]), float(last[before, here]))


def _axis(values: NDArray[_Scalar], axis: int) -> NDArray[_Scalar]:
    """[strips, states] along one of the three axes of states."""
    shape = [len(values), 1, 1, 1]
    shape[axis + 1] = values.shape[1]
    return values.reshape(shape)


def _tallied(costs: Sequence[Costs], state_costs: Sequence[Costs], tally: SequenceTally) -> Chain:
    """The cheapest sequence with limits: the sums, capped just above each limit, are part of the state."""
    sizes = np.array(tally.most) + 1
    sums = np.stack([axis.ravel() for axis in np.indices(sizes.tolist())], axis=1)  # [totals, sums]
    radix = np.concatenate([np.cumprod(sizes[::-1])[::-1][1:], [1]])
    totals = len(sums)

    def added(position: int) -> NDArray[np.int64]:
        """[totals, states] total after a state, or `totals` if it exceeds a limit."""
        after = sums[:, None, :] + tally.weight[position][None, :, :]
        return np.where((after < sizes).all(axis=2), after @ radix, totals)

    start = added(0)[0]
    value = np.full((1, len(state_costs[0]), totals + 1), np.inf)
    value[0, np.arange(len(state_costs[0])), start] = state_costs[0]
    value[:, :, totals] = np.inf
    choices = []
    for position in range(len(costs) - 1):
        through = value[:, :, None, :totals] + costs[position][:, :, :, None]
        best, choice = through.min(axis=0), through.argmin(axis=0)  # [here, after, totals]
        total_after = added(position + 1)
        here, after = best.shape[:2]
        value = np.full((here, after, totals + 1), np.inf)
        source = np.full((here, after, totals + 1), -1)
        for total in range(totals):
            for state in range(after):
                reached = total_after[total, state]
                better = best[:, state, total] + state_costs[position + 1][state] < value[:, state, reached]
                value[better, state, reached] = best[better, state, total] + state_costs[position + 1][state]
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


def _doubled(tally: SequenceTally | None, half: int, odd: bool) -> SequenceTally | None:
    if tally is None:
        return None
    weights: list[NDArray[np.int64]] = [2 * weight for weight in tally.weight[:half]]
    if odd:
        weights[-1] = tally.weight[half - 1]
    return SequenceTally(tuple(weights), tally.least, tally.most)
