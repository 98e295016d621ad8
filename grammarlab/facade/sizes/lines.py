"""The lines of a facade: the edges that its nodes share, as what the total decomposition property leaves free.

Along one axis a node reaches from one line to another. What follows each other shares the line between; what stands
across has the lines of its parent. So sizes that are differences of lines decompose whatever the lines are, and the
hierarchy rows C_h of paper 000, section 5 need not be written down: the lines span their null space. A leaf has one
size, so of L leaves with R hierarchy rows there are L - R lines besides the first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from grammarlab.facade.tree import Floats, Ints

_ROUND_OFF = 1e-12
"""Factors up to this are 0."""


@dataclass(frozen=True, slots=True)
class Sums:
    """K sums of T multiples of lines each, before they become a matrix."""

    line: Ints
    """[K, T] which lines; one may occur several times in a sum."""
    factor: Floats
    """[K, T] by what each is multiplied; 0 where a sum has fewer terms."""

    def __len__(self) -> int:
        return len(self.line)

    def minus(self, other: Sums) -> Sums:
        """[K, 2T] differences of sums and as many others."""
        return Sums(np.hstack([self.line, other.line]), np.hstack([self.factor, -other.factor]))

    def times(self, factor: Floats) -> Sums:
        """[K, T] sums times a factor [K] each."""
        return Sums(self.line, self.factor * factor[:, None])

    def shifted(self, first: int) -> Sums:
        """[K, T] sums over lines whose numbers are larger by so much."""
        return Sums(self.line + first, self.factor)

    def at(self, place: Floats) -> Floats:
        """[K] when the lines lie at these places [M]."""
        return (self.factor * place[self.line]).sum(axis=1)

    def over(self, merged: Ints) -> Sums:
        """[K, T] sums over lines of which some have become one, each line named once per sum.

        Args:
            merged: [M] what each line has become.
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
        """[J] two lines each that are equal where such a sum is 0."""
        used = self.factor != 0.0
        pair = (used.sum(axis=1) == 2) & (np.abs(self.factor.sum(axis=1)) <= _ROUND_OFF)
        lines = self.line[pair][used[pair]].reshape(-1, 2)
        return lines[:, 0], lines[:, 1]

    def matrix(self, num_lines: int) -> sparse.csr_array:
        """[K, M] for M lines; its rows may name a line several times."""
        starts = np.arange(0, self.line.size + 1, self.line.shape[1])
        return sparse.csr_array((self.factor.ravel(), self.line.ravel(), starts), shape=(len(self), num_lines))


def stacked(sums: Sequence[Sums]) -> Sums:
    """[K, T] one list of sums after the other, with as many terms as the longest has."""
    shape = sum(len(each) for each in sums), max(each.line.shape[1] for each in sums)
    line, factor = np.zeros(shape, dtype=np.int64), np.zeros(shape)
    start = 0
    for each in sums:
        line[start : start + len(each), : each.line.shape[1]] = each.line
        factor[start : start + len(each), : each.line.shape[1]] = each.factor
        start += len(each)
    return Sums(line, factor)


@dataclass(frozen=True, slots=True)
class Lines:
    """M lines of a facade of N nodes along one axis; the first is where the facade begins."""

    low: Ints
    """[N] line at which each node begins: at its left or at its bottom."""
    high: Ints
    """[N] line at which it ends."""
    num: int
    """M: how many there are, at least 2."""

    def reach(self, node: Ints, share: Floats) -> Sums:
        """[K, 2] the coordinate at a share [K] of the size of each of K nodes: beta + eps alpha."""
        return Sums(np.stack([self.low[node], self.high[node]], axis=1), np.stack([1.0 - share, share], axis=1))

    def extent(self, node: Ints) -> Sums:
        """[K, 2] the size of each of K nodes: alpha."""
        return Sums(np.stack([self.low[node], self.high[node]], axis=1), np.tile([-1.0, 1.0], (len(node), 1)))

    def laid(self, place: Floats) -> tuple[Floats, Floats]:
        """[N] position and [N] size of each node when the lines lie at these places [M]."""
        return place[self.low], place[self.high] - place[self.low]

    def places(self, position: Floats, size: Floats) -> Floats:
        """[M] where the lines of a facade lie whose nodes have these positions [N] and sizes [N]."""
        place = np.zeros(self.num)
        place[self.high] = position + size
        place[self.low] = position
        return place


def find_lines(parent: Ints, axis: NDArray[np.int8], along: int) -> Lines:
    """The lines of a tree.

    Args:
        parent: [N] as in `Facade`.
        axis: [N]
        along: 0 for the lines from the left to the right, 1 for those from the bottom to the top.
    """
    num_nodes = len(parent)
    order = 1 + np.argsort(parent[1:], kind="stable")
    follows = (parent[order[1:]] == parent[order[:-1]]) & (axis[parent[order[1:]]] == along)
    before = np.full(num_nodes, -1, dtype=np.int64)
    before[order[1:][follows]] = order[:-1][follows]
    ends_itself = np.zeros(num_nodes, dtype=bool)
    ends_itself[before[before >= 0]] = ends_itself[0] = True
    # Whose line a node has: its own, that of the sibling before it, or that of its parent, and so on.
    number = np.cumsum(ends_itself)
    high = number[_followed(np.where(ends_itself, np.arange(num_nodes), parent))]
    starter = _followed(np.where((before >= 0) | (np.arange(num_nodes) == 0), np.arange(num_nodes), parent))
    low = np.where(before[starter] >= 0, number[before[starter]], 0)
    return Lines(low, high, int(number[-1]) + 1)


def _followed(pointer: Ints) -> Ints:
    """[N] where each ends that goes from node to node until one that points to itself."""
    while True:
        further = pointer[pointer]
        if (further == pointer).all():
            return pointer
        pointer = further
