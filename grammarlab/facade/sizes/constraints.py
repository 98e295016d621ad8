"""One axis of a facade as equations over its lines, with targets of its leaves (paper 000, section 5).

Decomposition needs no rows, since lines satisfy it (`lines.py`). Alignment preserves the distance between the anchors
of neighbours in a grid's column (along x) or row (along y); the anchors are the low edges, the centres or the high
edges, whichever vary least. Symmetry preserves the ratio of the sizes of similar parts: in one grid, with one label,
with nearly equal sizes. For equal sizes the ratio is 1, which is the paper's row; and a facade always satisfies its own
rows. Lines that the whole facade shares (`SharedLines`) are further rows of both kinds, without a grid.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.facade.grid import Grid
from grammarlab.facade.sizes.lines import Lines, Sums, find_lines, find_shared_lines, stacked
from grammarlab.facade.tree import TOLERANCE, Facade, X

Weights = Literal["default", "paper"]
"""Kind of weights of deviations, see `leaf_weights`."""
SIMILAR_SIZE_TOLERANCE = 0.1
"""Parts of one label are similar if each is larger than the next smaller one by at most this fraction."""
_ANCHORS = np.array([0.0, 0.5, 1.0])
"""The eps of Equation 2; the first is taken if all three vary equally."""
_LEAST_SIZE_RATIO = 1e-3
"""Least size of a leaf, as a fraction of its target."""
_LEAST_WEIGHTED_SIZE = 1e-3
"""Least size, as a fraction of the facade, for default weights; smaller leaves have the weight of this size."""
_MAX_PAPER_WEIGHT = 10.0
"""Largest weight of the paper."""


@dataclass(frozen=True, slots=True)
class Rows:
    """R equations: sums of lines with given values."""

    sums: Sums
    """[R] sums."""
    value: Floats
    """[R] values, in the unit of the original positions and sizes."""
    grid: Ints
    """[R] index of the grid of each row; the number of grids for rows of the whole facade."""

    def of_zeros(self) -> Rows:
        """The rows whose value is 0: a stretched facade satisfies these."""
        is_zero = np.abs(self.value) <= TOLERANCE
        return Rows(Sums(self.sums.line[is_zero], self.sums.factor[is_zero]), self.value[is_zero], self.grid[is_zero])

    def with_zeros(self, sums: Sums, grid: int) -> Rows:
        """These rows, and further ones of a grid, whose value is 0."""
        grids = np.append(self.grid, np.full(len(sums), grid))
        return Rows(stacked([self.sums, sums]), np.append(self.value, np.zeros(len(sums))), grids)


@dataclass(frozen=True, slots=True)
class LineOrigin:
    """Original sizes and positions of the nodes of a facade, which are the targets."""

    position: Floats
    """[N, 2] metres; only differences within a column or a row of a grid matter."""
    size: Floats
    """[N, 2] metres, > 0."""
    whole: Floats
    """[2] size of the original facade, metres."""
    shares_lines: bool = False
    """Whether these sizes and positions are those of one facade, whose shared lines stay."""


@dataclass(frozen=True, eq=False)
class Axis:
    """One axis of a facade of M lines, in units of the facade's larger side."""

    along: int
    """0 for x, 1 for y."""
    lines: Lines
    extent: Sums
    """[P] sizes of leaves, where leaves between the same lines are merged, and distances of neighbouring lines if they
    are shared: each counts like a leaf of this size."""
    weight: Floats
    """[P] weight of a unit of length."""
    target: Floats
    """[P] target sizes."""
    least: Floats
    """[P] least sizes."""
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
        return np.repeat(np.minimum(whole.prod() / size.prod(axis=1), _MAX_PAPER_WEIGHT)[:, None], 2, axis=1)
    return 1.0 / np.maximum(size, _LEAST_WEIGHTED_SIZE * whole.max())


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
    np.maximum.at(least, pair, _LEAST_SIZE_RATIO * size[leaf])
    axis = Axis(
        along=along,
        lines=lines,
        extent=lines.extent(leaf[first]),
        weight=np.sqrt(weights),
        target=np.bincount(pair, weight**2 * size[leaf]) / weights,
        least=least,
        alignment=_alignment(facade.grids, lines, along, position, size),
        symmetry=_symmetry(facade.grids, lines, along, facade.label, size),
    )
    return _with_shared_lines(axis, facade, origin, scale) if origin.shares_lines else axis


def _with_shared_lines(axis: Axis, facade: Facade, origin: LineOrigin, scale: float) -> Axis:
    """An axis that keeps the lines that the whole facade shares.

    Anchors of a grid that are not exactly in line keep their distance only softly, as all lines do.
    """
    position, size = origin.position[:, axis.along], origin.size[:, axis.along]
    shared, whole = find_shared_lines(facade, axis.lines, position, size), len(facade.grids)
    distance = shared.distance.evaluate(axis.lines.positions(position, size))
    weight = 1.0 / np.maximum(distance, _LEAST_WEIGHTED_SIZE * origin.whole.max())
    return replace(
        axis,
        extent=stacked([axis.extent, shared.distance]),
        weight=np.append(axis.weight, weight),
        target=np.append(axis.target, distance / scale),
        least=np.append(axis.least, _LEAST_SIZE_RATIO * distance / scale),
        alignment=axis.alignment.of_zeros().with_zeros(shared.same, whole),
        symmetry=axis.symmetry.with_zeros(shared.alike, whole),
    )


def _alignment(grids: Sequence[Grid], lines: Lines, along: int, position: Floats, size: Floats) -> Rows:
    """Rows that preserve the distances of neighbouring anchors in a column (row): C_a and d_a of Equation 1.

    Args:
        grids: G grids.
        lines: lines of the axis.
        along: 0 for x, which aligns columns; 1 for y, which aligns rows.
        position: [N] original positions along the axis, metres.
        size: [N] original sizes along the axis, metres.
    """
    node, grid_index, group, other = _members(grids, along)
    order = np.lexsort((other, group))
    node, grid_index, group = node[order], grid_index[order], group[order]
    anchors = position[node, None] + _ANCHORS * size[node, None]
    eps = _ANCHORS[_least_variance(anchors, group)][group]
    first = np.flatnonzero(group[1:] == group[:-1])
    ahead, behind = node[first], node[first + 1]
    share = eps[first]
    value = position[ahead] + share * size[ahead] - position[behind] - share * size[behind]
    # Anchors on the same lines keep their distance without a row.
    moves = (lines.low[ahead] != lines.low[behind]) & (share < 1.0)
    moves |= (lines.high[ahead] != lines.high[behind]) & (share > 0.0)
    sums = lines.reach(ahead, share).minus(lines.reach(behind, share))
    return Rows(Sums(sums.line[moves], sums.factor[moves]), value[moves], grid_index[first][moves])


def _members(grids: Sequence[Grid], along: int) -> tuple[Ints, Ints, Ints, Ints]:
    """[E] of all grids: node, grid, column or row numbered over all grids, and index within it."""
    if not grids:
        empty = np.zeros(0, dtype=np.int64)
        return empty, empty, empty, empty
    node = np.concatenate([grid.node for grid in grids])
    grid_index: Ints = np.repeat(np.arange(len(grids)), [len(grid.node) for grid in grids])
    column, row = np.concatenate([grid.column for grid in grids]), np.concatenate([grid.row for grid in grids])
    group, other = (column, row) if along == X else (row, column)
    counts = np.array([grid.num_columns if along == X else grid.num_rows for grid in grids])
    return node, grid_index, group + (np.cumsum(counts) - counts)[grid_index], other


def _least_variance(anchors: Floats, group: Ints) -> NDArray[np.intp]:
    """[G] index of the anchor [E, 3] that varies least within each group [E]."""
    counts = np.maximum(np.bincount(group), 1)
    variance = np.empty((len(counts), len(_ANCHORS)))
    for anchor in range(len(_ANCHORS)):
        mean = np.bincount(group, anchors[:, anchor]) / counts
        variance[:, anchor] = np.bincount(group, (anchors[:, anchor] - mean[group]) ** 2)
    # Rounding errors must not determine the choice.
    return (variance > variance.min(axis=1, keepdims=True) + 1e-18 * np.square(anchors).max(initial=0.0)).argmin(axis=1)


def _symmetry(grids: Sequence[Grid], lines: Lines, along: int, label: Ints, size: Floats) -> Rows:
    """Rows that preserve the ratio of the sizes of similar parts: C_s of Equation 1.

    Args:
        grids: G grids.
        lines: lines of the axis.
        along: 0 for widths, 1 for heights.
        label: [N] label of each node.
        size: [N] original sizes along the axis, metres, > 0.
    """
    node, grid_index, _, _ = _members(grids, along)
    # Nodes between the same lines have equal sizes without a row.
    _, first = np.unique(
        np.stack([grid_index, label[node], lines.low[node], lines.high[node]]), axis=1, return_index=True
    )
    node, grid_index = node[first], grid_index[first]
    order = np.lexsort((size[node], label[node], grid_index))
    node, grid_index = node[order], grid_index[order]
    similar = (grid_index[1:] == grid_index[:-1]) & (label[node[1:]] == label[node[:-1]])
    similar &= size[node[1:]] <= (1.0 + SIMILAR_SIZE_TOLERANCE) * size[node[:-1]]
    small, large = node[:-1][similar], node[1:][similar]
    sums = lines.extent(large).minus(lines.extent(small).times(size[large] / size[small]))
    return Rows(sums, np.zeros(len(small)), grid_index[1:][similar])
