"""Words as rows of an alignment: the possible elements at each position, and the columns they form.

A row is an automaton. Its state is the number of letters read, and whether the last of them, a transparent letter,
continues in the next column. State 2p is p letters read; state 2p - 1 is the same with the last letter still open.
States never decrease, and each matrix of an alignment is one path for each row. Lengths are in integer units.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from typing import NamedTuple

from grammarlab.layers.design import Letter, Word

EMPTY, TRANSPARENT, OPAQUE, PARTIAL = range(4)
"""Kinds of elements: no letters, no visible letters, only letters that hide the layers below, others."""


class RowStep(NamedTuple):
    """A possible next element of a row."""

    size: int
    """Least total size of its letters, units; the exact size if it is fixed."""
    state: int
    """State of the row after it."""
    kind: int
    protected: bool
    """Whether it contains an unoccludable letter."""
    merged: int
    """Number of its letters beyond the first."""
    loose: tuple[int, ...] = ()
    """Unsized or split letters, whose width is free."""

    @property
    def fixed(self) -> bool:
        """Whether all of its letters have fixed sizes."""
        return not self.loose


class Steps(NamedTuple):
    """Steps from one state; the lists are in order of size."""

    empty: RowStep | None
    fixed: tuple[RowStep, ...]
    fixed_sizes: tuple[int, ...]
    fixed_merged: tuple[int, ...]
    """Least number of merged letters of each step and the later ones; ascending."""
    elastic: tuple[RowStep, ...]
    elastic_sizes: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class AlignedRow:
    """Layers with the same word, and so the same elements in all columns."""

    word: Word
    layers: tuple[int, ...]
    """Indices of the layers, from the top down."""
    sizes: tuple[int, ...]
    """Size of each letter, units; 0 for an unsized letter."""
    remaining: tuple[int, ...]
    """[2n + 1] units that surely remain after each state."""
    most: int
    """Largest number of letters of an element."""
    _steps: dict[int, Steps] = field(default_factory=dict)

    @property
    def last(self) -> int:
        """The state in which all letters have been read."""
        return 2 * len(self.word)

    @property
    def hides(self) -> bool:
        """Whether an element of it can explain a gap below it."""
        return any(letter.hides for letter in self.word)

    def steps(self, state: int) -> Steps:
        """Possible next elements of the row in this state."""
        cached = self._steps.get(state)
        if cached is None:
            cached = self._steps[state] = _steps(self, state)
        return cached


class Column(NamedTuple):
    """A column, or the upper elements of one."""

    steps: tuple[RowStep, ...]
    low: int
    """Smallest fixed element, units; 0 for an unexplained gap; -1 before the first."""
    high: int
    """Widest element, units."""
    fixed: bool
    opaque: bool
    partial: int
    """Rows with elements that cover only a part, as bits."""
    protected: int
    """Rows whose elements must not cover only a part, as bits."""
    price: int
    """Price of merged letters."""


START = Column(steps=(), low=-1, high=0, fixed=False, opaque=False, partial=0, protected=0, price=0)
"""A column without elements."""


def unit_of(canvas: float) -> float:
    """Unit of length, a power of ten near 1e-11 of the canvas: decimal sizes are integers, and their sums are exact."""
    return 10.0 ** (math.floor(math.log10(canvas)) - 10)


def build_rows(words: Sequence[Word], unit: float) -> list[AlignedRow]:
    """The different words, in the order of the topmost layer of each."""
    layers: dict[Word, list[int]] = {}
    for layer, word in enumerate(words):
        layers.setdefault(tuple(word), []).append(layer)
    rows = []
    for word, row_layers in layers.items():
        sizes = tuple(0 if letter.size is None else max(round(letter.size / unit), 1) for letter in word)
        remaining = [0]
        for letter, size in zip(reversed(word), reversed(sizes), strict=True):
            remaining += [remaining[-1], remaining[-1] + (0 if letter.transparent else size)]
        rows.append(AlignedRow(word, tuple(row_layers), sizes, tuple(reversed(remaining)), len(word) or 1))
    return rows


def may_be_empty(word: Word, read: int) -> bool:
    """Whether a gap is allowed between these letters: not beside attached letters, nor if a neighbour can be wider."""
    return not any(letter.attached or letter.transparent for letter in word[max(read - 1, 0) : read + 1])


def column_size(column: Sequence[RowStep]) -> tuple[int, int, bool]:
    """Error and width of a column, in units, and whether an element of it is fixed."""
    low, high, fixed, opaque = -1, 0, False, False
    for step in column:
        if step.fixed and (step.kind != EMPTY or not opaque):
            low = step.size if low < 0 else min(low, step.size)
        high, opaque = max(high, step.size), opaque or step.kind == OPAQUE
        fixed = fixed or (step.fixed and step.kind != EMPTY)
    return (high - low if low >= 0 else 0), high, fixed


def _steps(row: AlignedRow, state: int) -> Steps:
    word, read, is_open = row.word, (state + 1) // 2, bool(state % 2)
    empty = RowStep(0, state, EMPTY, False, 0) if not is_open and may_be_empty(word, read) else None
    transparent = is_open or (read < len(word) and word[read].transparent)
    elements = _transparent(row, read, is_open) if transparent else _visible(row, read)
    elements.sort(key=lambda step: (step.size, step.merged, step.state))
    fixed = tuple(step for step in elements if step.fixed)
    elastic = tuple(step for step in elements if not step.fixed)
    merged = tuple(accumulate((step.merged for step in reversed(fixed)), min))[::-1]
    return Steps(
        empty, fixed, tuple(step.size for step in fixed), merged, elastic, tuple(step.size for step in elastic)
    )


def _transparent(row: AlignedRow, read: int, is_open: bool) -> list[RowStep]:
    """Elements of transparent letters; the first and the last letter may be parts."""
    elements: list[RowStep] = []
    size, letters = 0, int(is_open)
    loose: tuple[int, ...] = (read - 1,) if is_open else ()
    if is_open:
        elements += [RowStep(0, state, TRANSPARENT, False, 0, loose) for state in (2 * read, 2 * read - 1)]
    for index in range(read, len(row.word)):
        if not row.word[index].transparent or letters >= row.most:
            break
        # An open letter continues in the next column; a closed one ends in this column.
        elements.append(RowStep(size, 2 * index + 1, TRANSPARENT, False, letters, (*loose, index)))
        size += row.sizes[index]
        loose = (*loose, index) if row.word[index].size is None else loose
        elements.append(RowStep(size, 2 * index + 2, TRANSPARENT, False, letters, loose))
        letters += 1
    return elements


def _visible(row: AlignedRow, read: int) -> list[RowStep]:
    """Elements of letters that are not transparent."""
    elements: list[RowStep] = []
    size, kind, protected = 0, OPAQUE, False
    loose: tuple[int, ...] = ()
    for index in range(read, min(len(row.word), read + row.most)):
        letter: Letter = row.word[index]
        if letter.transparent:
            break
        size += row.sizes[index]
        kind = kind if letter.hides else PARTIAL
        protected, loose = protected or letter.unoccludable, (*loose, index) if letter.size is None else loose
        elements.append(RowStep(size, 2 * index + 2, kind, protected, index - read, loose))
    return elements
