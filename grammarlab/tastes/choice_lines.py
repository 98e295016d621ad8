"""Choices with the nodes above them: the lines by which patterns find them.

A line is the symbols of the nodes from some node down to a choice, and the index of each below the first one among the
successors of its parent.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import Ints
from grammarlab.features.patterns.pattern import Below, Pattern
from grammarlab.tastes.labelled_nodes import LabelledNodes
from grammarlab.tastes.roles import Roles

MAX_ANCESTORS = 12
"""Largest number of nodes above a choice in a line."""
_MAX_LINES = 600
"""Largest number of lines of one length."""


class Line(NamedTuple):
    """R choices of one kind with the same line above them."""

    kind: int
    rows: Ints
    """[R] the nodes of the choices."""
    tops: Ints
    """[R] the first nodes of the lines."""
    number: Ints
    """[R] number of the alternative that was taken, from 1."""
    chain: tuple[str | None, ...]
    """Symbols from the first node down to the choice; None for several."""
    children: tuple[int, ...]
    """Indices below the first node."""
    alternatives: tuple[tuple[Pattern, ...], ...]
    """Patterns of each alternative, by number; several for several symbols, none for an alternative they lack."""

    def pattern(self, node: Pattern) -> Pattern:
        """A node in place of the choice."""
        for symbol, child in zip(self.chain[-2::-1], self.children[::-1], strict=True):
            node = Pattern(symbol, below=(Below((node,), child),))
        return node

    @property
    def any(self) -> tuple[Pattern, ...]:
        """The line with any alternative, for each symbol of the choice."""
        listed = [pattern for alternatives in self.alternatives for pattern in alternatives]
        return tuple(dict.fromkeys(without_branch(pattern) for pattern in listed))


def without_branch(pattern: Pattern) -> Pattern:
    """A line with any branch of the choice at its end."""
    if not pattern.below:
        return replace(pattern, branch=())
    (below,) = pattern.below
    return replace(pattern, below=(replace(below, run=(without_branch(below.run[0]),)),))


@dataclass(frozen=True)
class Lines:
    """All choices of comparable kinds."""

    nodes: LabelledNodes
    roles: Roles

    def groups(self, length: int, *, by_symbol: bool) -> Iterator[Line]:
        """Lines with so many nodes above the choice.

        Args:
            length: number of nodes above.
            by_symbol: whether choices of several symbols of one kind are several lines.
        """
        inside = np.flatnonzero(self._above[length] >= 0)
        last = self._symbols[0] if by_symbol else self._kind
        for members in _alike(self._paths[length][inside], self._symbols[length][inside], last[inside])[:_MAX_LINES]:
            yield self._line(inside[members], length)

    def way(self, row: int) -> tuple[int, ...]:
        """Indices of successors from the root down to a node: its order in the text of the rules."""
        way: list[int] = []
        while row >= 0:
            way.append(int(self.nodes.child[row]))
            row = int(self.nodes.parent[row])
        return tuple(way[::-1])

    @cached_property
    def _above(self) -> list[Ints]:
        """[1 + A] rows of the choices, their parents and so on; -1 above roots."""
        above = [np.flatnonzero(self.roles.kind[self.nodes.label] >= 0)]
        for _ in range(MAX_ANCESTORS):
            above.append(np.where(above[-1] >= 0, self.nodes.parent[above[-1]], -1))
        return above

    @cached_property
    def _symbols(self) -> list[Ints]:
        return [np.where(rows >= 0, self.nodes.symbol[rows], -1) for rows in self._above]

    @cached_property
    def _kind(self) -> Ints:
        return self.roles.kind[self.nodes.label[self._above[0]]]

    @cached_property
    def _paths(self) -> list[Ints]:
        """[1 + A] a number for the indices of successors on the way down to each choice."""
        paths = [np.zeros(len(self._above[0]), dtype=np.int64)]
        for rows in self._above[:-1]:
            paths.append(_codes(paths[-1], np.where(rows >= 0, self.nodes.child[rows], 0)))
        return paths

    def _line(self, part: Ints, length: int) -> Line:
        labels, rows = self.nodes.labels, self._above[0][part]
        levels = [np.unique(self._symbols[level][part]) for level in range(length, -1, -1)]
        chain = tuple(labels.symbols[level[0]] if len(level) == 1 else None for level in levels)
        children = tuple(int(self.nodes.child[self._above[level][part[0]]]) for level in range(length - 1, -1, -1))
        kind, number = int(self._kind[part[0]]), self.roles.number[self.nodes.label[rows]]
        tops = self._above[length][part]
        bare = Line(kind=kind, rows=rows, tops=tops, number=number, chain=chain, children=children, alternatives=())
        return bare._replace(alternatives=self._alternatives(bare, levels[-1]))

    def _alternatives(self, line: Line, symbols: Ints) -> tuple[tuple[Pattern, ...], ...]:
        labels = np.flatnonzero((self.roles.kind == line.kind) & np.isin(self._symbol_of, symbols))
        numbers = self.roles.number[labels]
        return tuple(
            tuple(line.pattern(self.nodes.pattern(label)) for label in labels[numbers == number].tolist())
            for number in range(1, 1 + int(numbers.max()))
        )

    @property
    def _symbol_of(self) -> Ints:
        return self.nodes.labels.symbol_numbers


def _codes(*keys: Ints) -> Ints:
    """The same number for equal keys."""
    code = np.zeros(len(keys[0]), dtype=np.int64)
    for key in keys:
        code = np.unique(code * (int(key.max(initial=0)) + 1) + key, return_inverse=True)[1].reshape(-1)
    return code


def _alike(*keys: Ints) -> Sequence[Ints]:
    """Indices with equal keys."""
    code = _codes(*keys)
    order = np.argsort(code, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(code[order])) + 1) if len(order) else []
