"""Choices with the nodes above them: the lines by which patterns find them.

A line is the symbols of the nodes from some node down to a choice, and the index of each below the first one among the
successors of its parent.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from grammarlab.arrays import MOST_COLUMNS, Ints
from grammarlab.features.patterns.pattern import Below, Pattern
from grammarlab.tastes.labelled_nodes import LabelledNodes
from grammarlab.tastes.roles import Roles

MAX_ANCESTORS = 12
"""Largest number of nodes above a choice in a line."""


@dataclass(frozen=True, eq=False)
class Line:
    """R choices of one kind with the same line above them."""

    nodes: LabelledNodes
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
    labels: tuple[tuple[int, ...], ...]
    """Labels of each alternative, by number; several for several symbols, none for an alternative they lack."""

    @cached_property
    def alternatives(self) -> tuple[tuple[Pattern, ...], ...]:
        """Patterns of each alternative. Most lines are never put into words, and so are not made patterns."""
        return tuple(
            tuple(self._pattern(self.nodes.pattern(label)) for label in alternative) for alternative in self.labels
        )

    @cached_property
    def num_characters(self) -> int:
        """Number of characters of the patterns of all alternatives and of what is between them in a formula."""
        return sum(len(f"{{{pattern}}} + ") for alternative in self.alternatives for pattern in alternative)

    @cached_property
    def any(self) -> tuple[Pattern, ...]:
        """The line with any alternative, for each symbol of the choice."""
        return tuple(self._pattern(bare) for bare in self.bare)

    @cached_property
    def bare(self) -> tuple[Pattern, ...]:
        """The choice alone with any alternative, for each of its symbols."""
        listed = (self.nodes.pattern(label) for alternative in self.labels for label in alternative)
        return tuple(dict.fromkeys(replace(pattern, branch=()) for pattern in listed))

    def _pattern(self, node: Pattern) -> Pattern:
        """The line with a node in place of the choice."""
        for symbol, child in zip(self.chain[-2::-1], self.children[::-1], strict=True):
            node = Pattern(symbol, below=(Below((node,), child),))
        return node


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
        for members in _alike(self._paths[length][inside], self._symbols[length][inside], last[inside])[:MOST_COLUMNS]:
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
        rows, symbols = self._above[0][part], self.nodes.labels.symbols
        levels = [self._symbols[level][part] for level in range(length, -1, -1)]
        chain = tuple(symbols[int(level[0])] if (level == level[0]).all() else None for level in levels)
        kind = int(self._kind[part[0]])
        return Line(
            nodes=self.nodes,
            kind=kind,
            rows=rows,
            tops=self._above[length][part],
            number=self.roles.number[self.nodes.label[rows]],
            chain=chain,
            children=tuple(int(self.nodes.child[self._above[level][part[0]]]) for level in range(length - 1, -1, -1)),
            labels=self._labels(kind, np.unique(levels[-1]).tolist()),
        )

    def _labels(self, kind: int, symbols: Sequence[int]) -> tuple[tuple[int, ...], ...]:
        """Labels of each alternative of choices of one kind."""
        labels = [label for label in self._members[kind] if self.nodes.labels.symbol_numbers[label] in symbols]
        numbers = self.roles.number[labels].tolist()
        return tuple(
            tuple(label for label, other in zip(labels, numbers, strict=True) if other == number)
            for number in range(1, 1 + max(numbers))
        )

    @cached_property
    def _members(self) -> list[list[int]]:
        """Labels of each kind."""
        kinds = range(int(self.roles.kind.max(initial=-1)) + 1)
        return [np.flatnonzero(self.roles.kind == kind).tolist() for kind in kinds]


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
