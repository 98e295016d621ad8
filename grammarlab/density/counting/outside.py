"""Outside weights of subtrees, and their decomposition into outside weights of children.

The *outside weights* of a symbol are one number per state: the value, under the preference, of the rest of the tree.
Only proportions matter, so states with proportional outside weights everywhere are not distinguished. A node
whose children were read by a `Scan` has joint outside weights for all of them; `decompose` writes these as a sum of
products with one factor per child, which a grammar can express: choose the summand, then derive each child with its
own outside weights.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.density.counting.automaton import Scan
from grammarlab.errors import InexactError

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_DIGITS = 44
"""Binary digits that equal weights share: relative 6e-14."""


@dataclass(frozen=True, slots=True)
class OutsideTerm:
    """A summand: a weight times outside weights of each child of a scan."""

    weight: float
    futures: tuple[Floats, ...]
    """Outside weights [S] for each step of the scan; the largest is 1."""


def snapped(weights: Floats) -> Floats:
    """Weights without the digits that rounding errors may change."""
    mantissa, exponent = np.frexp(weights)
    return np.ldexp(np.rint(np.ldexp(mantissa, _DIGITS)), exponent - _DIGITS)


def decompose(scan: Scan, future: Floats, max_products: int) -> list[OutsideTerm]:
    """Joint outside weights of the children of a scan as a sum of products.

    A decision diagram over the children is built from the last child to the first; nodes whose branches are
    proportional are one. Each path from the top to the end is a product.

    Args:
        scan: computes the state of the parent from the states of the children.
        future: [S] outside weights of the parent.
        max_products: largest number of products.

    Raises:
        InexactError: If there are more products.
    """
    levels: list[tuple[Floats, Ints]] = []
    scale = future[scan.final]
    node = np.where(scale > 0.0, 0, -1)
    for step in reversed(scan.steps):
        weights, below = scale[step.next], node[step.next]
        scale = weights.max(axis=1, initial=0.0)
        weights = np.divide(weights, scale[:, None], out=np.zeros_like(weights), where=scale[:, None] > 0.0)
        first, node = _distinct(weights, below)
        node = np.where(scale > 0.0, node, -1)
        levels.append((weights[first], below[first]))
    products: list[OutsideTerm] = []
    for product in _paths(levels[::-1], float(scale[0]), int(node[0])):
        products.append(product)
        if len(products) > max_products:
            raise InexactError(
                f"some rule would need more than {max_products:,} alternatives to keep its parts in step: too many "
                "for an exact grammar"
            )
    return products


def _distinct(weights: Floats, below: Ints) -> tuple[Ints, Ints]:
    """Classes of rows that are equal up to rounding: the first row of each [K], and the class of each row."""
    if len(weights) == 1:
        return np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.int64)
    rows = np.concatenate([snapped(weights), below.astype(np.float64)], axis=1)
    _, first, kind = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return first, kind.reshape(-1)


def _paths(levels: list[tuple[Floats, Ints]], scale: float, top: int) -> Iterator[OutsideTerm]:
    """The paths of the diagram from a node, depth first."""
    if top < 0:
        return
    waiting: list[tuple[int, int, tuple[Floats, ...], float]] = [(0, top, (), scale)]
    while waiting:
        level, node, futures, weight = waiting.pop()
        if level == len(levels):
            yield OutsideTerm(weight, futures)
            continue
        weights, below = levels[level][0][node], levels[level][1][node]
        for target in sorted({int(t) for t in below if t >= 0}, reverse=True):
            future = np.where(below == target, weights, 0.0)
            largest = float(future.max())
            waiting.append((level + 1, target, (*futures, future / largest), weight * largest))
