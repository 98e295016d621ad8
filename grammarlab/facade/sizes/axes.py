"""One axis of a facade as numbers: its lines, what its leaves would like to be, and what ties them together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from grammarlab.facade.sizes.constraints import Rows, alignment, symmetry
from grammarlab.facade.sizes.lines import Lines, Sums, find_lines
from grammarlab.facade.tree import Facade, Floats

Weights = Literal["default", "paper"]
SMALLEST = 1e-3
"""Part of its wanted size that every leaf keeps."""
_LIGHTEST = 1e-3
"""What is smaller than this part of the facade weighs no more by default."""
_CAP = 10.0
"""Largest weight of the paper."""


@dataclass(frozen=True, slots=True)
class LineOrigin:
    """Sizes and places that the nodes of a facade had where they come from, and would like to have again."""

    position: Floats
    """[N, 2] metres; only differences within a column or a row of a grid count."""
    size: Floats
    """[N, 2] metres, > 0."""
    whole: Floats
    """[2] metres, of the facade that they come from."""


@dataclass(frozen=True, eq=False)
class Axis:
    """One axis of a facade of M lines, in parts of the facade's larger side."""

    along: int
    """0 for x, 1 for y."""
    lines: Lines
    extent: Sums
    """[P] sizes of leaves, of those between the same lines once."""
    weight: Floats
    """[P] of a metre."""
    target: Floats
    """[P] sizes that leaves would like to have."""
    least: Floats
    """[P] sizes that they keep."""
    alignment: Rows
    symmetry: Rows


def leaf_weights(size: Floats, whole: Floats, weights: Weights) -> Floats:
    """[L, 2] weight of a metre by which each leaf deviates along each axis.

    By default a deviation counts as part of the size that deviates: of two leaves that have to give, the one twice as
    large gives four times as much. The paper's weight is the inverse of a leaf's share of the area of the facade, at
    most 10, so it is the same for all leaves below a tenth of the facade.

    Args:
        size: [L, 2] metres.
        whole: [2] metres, of the facade.
        weights: which.
    """
    if weights == "paper":
        return np.repeat(np.minimum(whole.prod() / size.prod(axis=1), _CAP)[:, None], 2, axis=1)
    return 1.0 / np.maximum(size, _LIGHTEST * whole.max())


def build_axis(facade: Facade, along: int, origin: LineOrigin, weight: Floats, scale: float) -> Axis:
    """One axis of a facade.

    Args:
        facade: whose tree and grids it is.
        along: 0 for x, 1 for y.
        origin: what its nodes would like to be.
        weight: [L] of its leaves along the axis.
        scale: metres that count as 1.
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
