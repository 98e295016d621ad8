"""One axis of a facade as numbers: its lines, targets of its leaves, and constraints between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from grammarlab.facade.sizes.constraints import Rows, alignment, symmetry
from grammarlab.facade.sizes.lines import Lines, Sums, find_lines
from grammarlab.facade.tree import Facade, Floats

Weights = Literal["default", "paper"]
SMALLEST = 1e-3
"""Least size of a leaf, as a fraction of its target."""
_LIGHTEST = 1e-3
"""Least size, as a fraction of the facade, for default weights; smaller leaves have the weight of this size."""
_CAP = 10.0
"""Largest weight of the paper."""


@dataclass(frozen=True, slots=True)
class LineOrigin:
    """Original sizes and positions of the nodes of a facade, which are the targets."""

    position: Floats
    """[N, 2] metres; only differences within a column or a row of a grid matter."""
    size: Floats
    """[N, 2] metres, > 0."""
    whole: Floats
    """[2] size of the original facade, metres."""


@dataclass(frozen=True, eq=False)
class Axis:
    """One axis of a facade of M lines, in units of the facade's larger side."""

    along: int
    """0 for x, 1 for y."""
    lines: Lines
    extent: Sums
    """[P] sizes of leaves; leaves between the same lines are merged."""
    weight: Floats
    """[P] weight of a unit of length."""
    target: Floats
    """[P] target sizes of leaves."""
    least: Floats
    """[P] least sizes of leaves."""
    alignment: Rows
    symmetry: Rows


def leaf_weights(size: Floats, whole: Floats, weights: Weights) -> Floats:
    """[L, 2] weight of a metre of deviation of each leaf along each axis.

    By default a deviation is relative to the size of the leaf: of two adjacent leaves, one twice as large takes four
    times as much of a change. The paper's weight is the inverse of a leaf's share of the area of the facade, at most
    10, so it is the same for all leaves below a tenth of the facade.

    Args:
        size: [L, 2] metres.
        whole: [2] size of the facade, metres.
        weights: kind of weights.
    """
    if weights == "paper":
        return np.repeat(np.minimum(whole.prod() / size.prod(axis=1), _CAP)[:, None], 2, axis=1)
    return 1.0 / np.maximum(size, _LIGHTEST * whole.max())


def build_axis(facade: Facade, along: int, origin: LineOrigin, weight: Floats, scale: float) -> Axis:
    """One axis of a facade.

    Args:
        facade: facade with the tree and the grids.
        along: 0 for x, 1 for y.
        origin: targets of its nodes.
        weight: [L] weights of its leaves along the axis.
        scale: unit of length, metres.
    """
    lines = find_lines(facade.parent, facade.axis, along)
    position, size, leaf = origin.position[:, along] / scale, origin.size[:, along] / scale, facade.leaves
    _, first, pair = np.unique(lines.low[leaf] * lines.num + lines.high[leaf], return_index=True, return_inverse=True)
    weights = np.bincount(pair, weight**2)
    least = np.zeros(len(first))
    np.maximum.at(least, pair, SMALLEST * size[leaf])
    return Axis(
        along=along,
        lines=lines,
        extent=lines.extent(leaf[first]),
        weight=np.sqrt(weights),
        target=np.bincount(pair, weight**2 * size[leaf]) / weights,
        least=least,
        alignment=alignment(facade.grids, lines, along, position, size),
        symmetry=symmetry(facade.grids, lines, along, facade.label, size),
    )
