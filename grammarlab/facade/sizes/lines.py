"""The lines of a facade: the edges shared by its nodes, which are its free variables under total decomposition.

Along one axis, a node extends from one line to another. Adjacent parts share the line between them; parts across have
the lines of their parent. So sizes that are differences of lines satisfy the decomposition for any lines, and the
hierarchy rows C_h of paper 000, section 5 are not needed: the lines span their null space. A leaf has one size, so for
L leaves with R hierarchy rows there are L - R lines besides the first.

Parts share lines over the whole facade as well, whatever its grids are (`SharedLines`). What stands exactly above or
beside each other has sides at one coordinate, and these stay one line. Elements of one label and one size stay alike.
Different lines keep their order, and softly their distances, so that a sill remains below its window though no part
lies between their sides. A facade that is only stretched satisfies all of this.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from grammarlab.arrays import Floats, Ints
from grammarlab.facade.looks import look_of
from grammarlab.facade.tree import TOLERANCE, Facade

_ROUND_OFF = 1e-12
"""Largest factor that counts as 0."""


@dataclass(frozen=True, slots=True)
class Sums:
    """K sums of T multiples of lines each, before they become a matrix."""

    line: Ints
    """[K, T] indices of lines; one may occur several times in a sum."""
    factor: Floats
    """[K, T] factors; 0 in sums with fewer terms."""

    def __len__(self) -> int:
        return len(self.line)

    def minus(self, other: Sums) -> Sums:
        """[K, 2T] differences of two lists of sums."""
        return Sums(np.hstack([self.line, other.line]), np.hstack([self.factor, -other.factor]))

    def times(self, factor: Floats) -> Sums:
        """[K, T] sums times a factor [K] each."""
        return Sums(self.line, self.factor * factor[:, None])

    def shifted(self, first: int) -> Sums:
        """[K, T] sums over lines whose indices are larger by a constant."""
        return Sums(self.line + first, self.factor)

    def evaluate(self, position: Floats) -> Floats:
        """[K] values of the sums for lines at these positions [M]."""
        return (self.factor * position[self.line]).sum(axis=1)

    def over(self, merged: Ints) -> Sums:
        """[K, T] sums over merged lines, without repeated lines in a sum.

        Args:
            merged: [M] merged line of each line.
        """
        order = np.argsort(merged[self.line], axis=1)
        line = np.take_along_axis(merged[self.line], order, axis=1)
        factor = np.take_along_axis(self.factor, order, axis=1)
        for term in range(1, line.shape[1]):
            same = line[:, term] == line[:, term - 1]
            factor[same, term] += factor[same, term - 1]
            factor[same, term - 1] = 0.0
        return Sums(line, np.where(np.abs(factor) > _ROUND_OFF, factor, 0.0))

    def equal_pairs(self) -> tuple[Ints, Ints]:
        """[J] pairs of lines that are equal if such a sum is 0."""
        used = self.factor != 0.0
        pair = (used.sum(axis=1) == 2) & (np.abs(self.factor.sum(axis=1)) <= _ROUND_OFF)
        lines = self.line[pair][used[pair]].reshape(-1, 2)
        return lines[:, 0], lines[:, 1]

    def matrix(self, num_lines: int) -> sparse.csr_array:
        """[K, M] matrix for M lines; its rows may have several entries for a line."""
        starts = np.arange(0, self.line.size + 1, self.line.shape[1])
        return sparse.csr_array((self.factor.ravel(), self.line.ravel(), starts), shape=(len(self), num_lines))


@dataclass(frozen=True, slots=True)
class Lines:
    """M lines of a facade of N nodes along one axis; the first is the start of the facade."""

    low: Ints
    """[N] line of the left or bottom edge of each node."""
    high: Ints
    """[N] line of the right or top edge."""
    num: int
    """M: number of lines, at least 2."""

    def reach(self, node: Ints, share: Floats) -> Sums:
        """[K, 2] the coordinate at a share [K] of the size of each of K nodes: beta + eps alpha."""
        return Sums(np.stack([self.low[node], self.high[node]], axis=1), np.stack([1.0 - share, share], axis=1))

    def extent(self, node: Ints) -> Sums:
        """[K, 2] the size of each of K nodes: alpha."""
        return Sums(np.stack([self.low[node], self.high[node]], axis=1), np.tile([-1.0, 1.0], (len(node), 1)))

    def spans(self, line_position: Floats) -> tuple[Floats, Floats]:
        """[N] position and [N] size of each node for lines at these positions [M]."""
        return line_position[self.low], line_position[self.high] - line_position[self.low]

    def positions(self, position: Floats, size: Floats) -> Floats:
        """[M] positions of the lines of a facade whose nodes have these positions [N] and sizes [N]."""
        line_position = np.zeros(self.num)
        line_position[self.high] = position + size
        line_position[self.low] = position
        return line_position


@dataclass(frozen=True, slots=True)
class SharedLines:
    """What one axis keeps over the whole facade."""

    same: Sums
    """[R] differences of lines at one coordinate, which stay 0."""
    alike: Sums
    """[S] differences of the sizes of elements of one label and one size, which stay 0."""
    distance: Sums
    """[D] distances of neighbouring lines, > 0."""


def stacked(sums: Sequence[Sums]) -> Sums:
    """[K, T] concatenated lists of sums, with the number of terms of the longest."""
    shape = sum(len(block) for block in sums), max(block.line.shape[1] for block in sums)
    line, factor = np.zeros(shape, dtype=np.int64), np.zeros(shape)
    start = 0
    for block in sums:
        line[start : start + len(block), : block.line.shape[1]] = block.line
        factor[start : start + len(block), : block.line.shape[1]] = block.factor
        start += len(block)
    return Sums(line, factor)


def find_lines(parent: Ints, axis: NDArray[np.int8], along: int) -> Lines:
    """The lines of a tree.

    Args:
        parent: [N] parent of each node, as in `Facade`; -1 for the root.
        axis: [N] axis along which each node is divided, as in `Facade`.
        along: 0 for the lines from the left to the right, 1 for those from the bottom to the top.
    """
    num_nodes = len(parent)
    order = 1 + np.argsort(parent[1:], kind="stable")
    follows = (parent[order[1:]] == parent[order[:-1]]) & (axis[parent[order[1:]]] == along)
    before = np.full(num_nodes, -1, dtype=np.int64)
    before[order[1:][follows]] = order[:-1][follows]
    ends_itself = np.zeros(num_nodes, dtype=bool)
    ends_itself[before[before >= 0]] = ends_itself[0] = True
    # Source of a node's line: itself, the previous sibling, or its parent, and so on.
    number = np.cumsum(ends_itself)
    high = number[_followed(np.where(ends_itself, np.arange(num_nodes), parent))]
    starter = _followed(np.where((before >= 0) | (np.arange(num_nodes) == 0), np.arange(num_nodes), parent))
    low = np.where(before[starter] >= 0, number[before[starter]], 0)
    return Lines(low, high, int(number[-1]) + 1)


def find_shared_lines(facade: Facade, lines: Lines, low: Floats, size: Floats) -> SharedLines:
    """The shared lines of one axis.

    Args:
        facade: the facade, with its labels.
        lines: lines of the axis.
        low: [N] original position of each node along the axis, metres.
        size: [N] its original size, metres.
    """
    tolerance = TOLERANCE * float(size[0])
    coordinate = _numbered(lines.positions(low, size), tolerance)
    order = np.argsort(coordinate, kind="stable")
    is_same = coordinate[order[1:]] == coordinate[order[:-1]]
    neighbours = np.stack([order[1:], order[:-1]], axis=1)
    difference = np.tile([1.0, -1.0], (len(neighbours), 1))
    return SharedLines(
        same=Sums(neighbours[is_same], difference[is_same]),
        alike=_alike(facade, lines, coordinate, _numbered(size, tolerance)),
        distance=Sums(neighbours[~is_same], difference[~is_same]),
    )


def _numbered(values: Floats, tolerance: float) -> Ints:
    """[K] number of each value, ascending; equal for values [K] that follow each other within a tolerance."""
    order = np.argsort(values, kind="stable")
    number = np.empty(len(values), dtype=np.int64)
    number[order] = (np.diff(values[order], prepend=values[order[:1]]) > tolerance).cumsum()
    return number


def _alike(facade: Facade, lines: Lines, coordinate: Ints, extent: Ints) -> Sums:
    """Differences of the sizes of consecutive elements of one label and one size, between different lines each."""
    is_element = np.array([not look_of(name).is_flexible for name in facade.labels] + [False])
    node = np.flatnonzero(is_element[facade.label])
    between = np.stack([facade.label, extent, coordinate[lines.low], coordinate[lines.high]])[:, node]
    _, first = np.unique(between, axis=1, return_index=True)
    node, between = node[first], between[:, first]
    is_alike = (between[:2, 1:] == between[:2, :-1]).all(axis=0)
    return lines.extent(node[1:][is_alike]).minus(lines.extent(node[:-1][is_alike]))


def _followed(pointer: Ints) -> Ints:
    """[N] end of the chain from each node: the first node that points to itself."""
    while True:
        further = pointer[pointer]
        if (further == pointer).all():
            return pointer
        pointer = further
