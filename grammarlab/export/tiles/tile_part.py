"""Part of the content of a tile in its document."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class TilePart:
    """Nodes of a document and what they draw."""

    nodes: tuple[int, ...]
    draws: int
    """Primitives, each of which a viewer draws by itself."""
    triangles: int
    """Triangles with all instances."""

    @staticmethod
    def total(parts: Sequence[TilePart]) -> TilePart:
        """Several parts as one."""
        return TilePart(
            tuple(node for part in parts for node in part.nodes),
            sum(part.draws for part in parts),
            sum(part.triangles for part in parts),
        )


def by_first_use(keys: NDArray[np.integer]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows of the first use of each different key in a column [n], ascending, and the number [n] of each key so.

    >>> first, number = by_first_use(np.array([7, 3, 7, 5]))
    >>> first.tolist(), number.tolist()
    ([0, 1, 3], [0, 1, 0, 2])
    """
    _, first, number = np.unique(keys, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return first[order], rank[number]


def row_numbers(rows: NDArray[np.int64]) -> NDArray[np.int64]:
    """[n] number of each row [n, k] among the different ones."""
    order = np.lexsort(rows.T)
    ordered = rows[order]
    number = np.empty(len(rows), dtype=np.int64)
    number[order] = np.cumsum(np.append(0, (ordered[1:] != ordered[:-1]).any(axis=1)))
    return number
