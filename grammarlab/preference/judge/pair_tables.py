"""Tables of pairs: which alternatives of two choices go together, as the scores say.

The cells of the tables of a choice with all later ones are summed by one product of matrices. A table is a flag,
the cells with the highest means against the others; its price is that of the choice of the pair, of the number of these
cells and of the cells.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import comb
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import MANY, Floats, Ints
from grammarlab.preference.growth.screening import gain_of_share


class PairTable(NamedTuple):
    """A flag: whether two choices are a pair of a table."""

    first: int
    second: int
    cells: tuple[tuple[int, int], ...]
    """Numbers of alternatives that go together, 0 for no alternative."""
    price: float
    """Log of the number of tables, in nats."""

    def values(self, numbers: Ints) -> Floats:
        """[n] the flag, for numbers [n, K] of the alternatives of choices."""
        codes = numbers[:, self.first] * (int(numbers.max(initial=0)) + 1) + numbers[:, self.second]
        return np.isin(codes, [a * (int(numbers.max(initial=0)) + 1) + b for a, b in self.cells]).astype(np.float64)


def pair_tables(numbers: Ints, scores: Floats) -> Iterator[PairTable]:
    """Tables that may explain scores more than each choice alone.

    Args:
        numbers: [n, K] number of the alternative of each choice, 0 for none.
        scores: [n] 0-100.

    >>> numbers = np.indices((3, 3)).reshape(2, -1).T.repeat(8, axis=0)
    >>> table = next(pair_tables(numbers, 90.0 * (numbers[:, 0] == numbers[:, 1])))
    >>> table.cells
    ((0, 0), (1, 1), (2, 2))
    """
    num = numbers.shape[1]
    if num < 2 or not np.ptp(scores) > 0.0:
        return
    centred = scores - scores.mean()
    first, second = np.triu_indices(num, 1)
    shares, cells = (table[first, second] for table in _explained(numbers, centred))
    worth = gain_of_share(shares, cells.astype(np.int64), len(scores))
    for index in np.argsort(np.log(2.0) * cells - worth, kind="stable")[:MANY].tolist():
        i, j = int(first[index]), int(second[index])
        chosen, num_cells = _chosen(numbers[:, [i, j]], centred), int(cells[index])
        price = np.log(len(first)) + np.log(num_cells) + np.log(float(comb(num_cells, len(chosen))))
        yield PairTable(i, j, chosen, float(price))


def _explained(numbers: Ints, centred: Floats) -> tuple[Floats, Floats]:
    """[K, K] share of the variance of the scores that each table explains, and number of its cells; of i < j only."""
    num, widths = numbers.shape[1], numbers.max(axis=0) + 1
    starts = np.cumsum(widths) - widths
    held = np.zeros((len(numbers), int(widths.sum())))
    held[np.arange(len(numbers))[:, None], starts + numbers] = 1.0
    shares, cells = np.zeros((num, num)), np.zeros((num, num))
    for one in range(num):
        of_one, later = held[:, starts[one] : starts[one] + widths[one]], held[:, starts[one] :]
        counts, sums = of_one.T @ later, (of_one * centred[:, None]).T @ later
        places = starts[one:] - starts[one]
        shares[one, one:] = _of_tables(sums**2 / np.maximum(counts, 1.0), places)
        cells[one, one:] = _of_tables((counts > 0.0).astype(np.float64), places)
    # Scores may differ by less than any normal number.
    return shares / max(float(centred @ centred), np.finfo(np.float64).tiny), cells


def _of_tables(cells: Floats, columns: Ints) -> Floats:
    """[C] sums over the cells [A, B] of each table, from the first ones of their columns [C]."""
    return np.add.reduceat(cells.sum(axis=0), columns)


def _chosen(pairs: Ints, centred: Floats) -> tuple[tuple[int, int], ...]:
    """The cells with the highest means, as many as divide the scores best."""
    cells, index = np.unique(pairs, axis=0, return_inverse=True)
    counts = np.bincount(index.reshape(-1)).astype(np.float64)
    sums = np.bincount(index.reshape(-1), centred)
    order = np.argsort(-sums / counts, kind="stable")
    above, number = np.cumsum(sums[order])[:-1], np.cumsum(counts[order])[:-1]
    best = int(np.argmax(above**2 / (number * (len(pairs) - number)), keepdims=True)[0]) if len(above) else 0
    return tuple(sorted((int(a), int(b)) for a, b in cells[order[: best + 1]]))
