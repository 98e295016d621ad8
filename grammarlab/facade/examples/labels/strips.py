"""Lower bounds of the energy: every row of windows by itself, exactly."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.facade.examples.label_grid import Labels
from grammarlab.facade.examples.labels.chains import Chain, Costs, cheapest
from grammarlab.facade.examples.labels.problem import AWAY, WINDOW, Problem


def strip(problem: Problem, row: int, prices: Costs) -> tuple[Chain, list[Labels]]:
    """The least energy of the windows centred in one row, over all labels of the three rows that they cover.

    The chain is of patches: when the patches of the windows along the row are chosen, the best label of a cell is
    another cell's business no more.

    Args:
        problem: what windows are compared with.
        row: of the centres.
        prices: [3, columns, labels] added for each label.
    """
    nothing = np.full((1, WINDOW, WINDOW), AWAY, dtype=np.int64)
    kinds = problem.kind[row]
    lists = [problem.patches[kind] if kind >= 0 else nothing for kind in kinds]
    padded = [nothing, *lists, nothing]
    costs, own = [], []
    for column in range(problem.columns):
        before, here, after = padded[column : column + 3]
        total = np.zeros((len(before), len(here), len(after)))
        for up in range(WINDOW):
            cell = row + up - 1
            if 0 <= cell < problem.rows:
                table = _table(problem.domain[cell, column], prices[up, column])
                total += table[np.ix_(before[:, up, 2], here[:, up, 1], after[:, up, 0])]
        costs.append(total)
        own.append(np.zeros(len(here)))
    return cheapest(costs, own), lists


def _table(domain: NDArray[np.bool_], prices: Costs) -> Costs:
    """[labels + 2] * 3: least cost of a cell for which three windows want these labels; the last one wants none."""
    size = len(domain)
    differ = np.ones((size, size + 2))
    differ[np.arange(size), np.arange(size)] = 0.0
    differ[:, AWAY] = 0.0
    own = np.where(domain, prices, np.inf)
    total = own[:, None, None, None] + differ[:, :, None, None] + differ[:, None, :, None] + differ[:, None, None, :]
    return total.min(axis=0)


def lower_bound(problem: Problem) -> int:
    """What no grid's energy is below: all rows of windows, or all columns of windows, each at its best."""
    return max(_sum(problem), _sum(problem.transposed()))


def _sum(problem: Problem) -> int:
    """Sum of the least energies of the rows of windows; equal rows are solved once."""
    prices = np.zeros((WINDOW, problem.columns, problem.num_labels))
    known: dict[bytes, float] = {}
    total = 0.0
    for row in range(problem.rows):
        key = problem.kind[row].tobytes() + problem.domain[max(0, row - 1) : row + 2].tobytes()
        key += bytes([row == 0])
        if key not in known:
            known[key] = strip(problem, row, prices)[0].cost
        total += known[key]
    return round(total)
