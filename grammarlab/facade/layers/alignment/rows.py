"""Words as rows of an alignment: the elements that each place of a word offers, in whole units of length.

A row is an automaton. Its state is how many letters have been read, and whether the last of them, a transparent one,
goes on in the next column. State 2p is p letters read; state 2p - 1 is the same with the last letter still open. So no
step goes back, and each matrix of an alignment is one path for each row.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from typing import NamedTuple

from grammarlab.facade.layers.letters import Letter, Word

EMPTY, TRANSPARENT, OPAQUE, PARTIAL = range(4)
"""Kinds of elements: no letters, none that is seen, only letters that hide what is below, others."""


class RowStep(NamedTuple):
    """An element that a row may have next."""

    size: int
    """Units that its letters have at least; exactly where it is fixed."""
    state: int
    """Of the row after it."""
    kind: int
    protected: bool
    """Whether a letter of it is unoccludable."""
    merged: int
    """Letters beyond its first."""
    loose: tuple[int, ...] = ()
    """Letters that are unsized or split: how wide they are is open."""

    @property
    def fixed(self) -> bool:
        """Whether all of its letters have their sizes."""
        return not self.loose


class Steps(NamedTuple):
    """What a state offers; the lists grow in size."""

    empty: RowStep | None
    fixed: tuple[RowStep, ...]
    fixed_sizes: tuple[int, ...]
    fixed_merged: tuple[int, ...]
    """The least number of merged letters from each of them on; it grows."""
    elastic: tuple[RowStep, ...]
    elastic_sizes: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class AlignedRow:
    """Layers that have the same word, and so the same elements in all columns."""

    word: Word
    layers: tuple[int, ...]
    """From the top down."""
    sizes: tuple[int, ...]
    """Units of each letter; 0 where it is unsized."""
    left: tuple[int, ...]
    """[2n + 1] units that are surely still to come after a state."""
    most: int
    """Letters of an element."""
    _steps: dict[int, Steps] = field(default_factory=dict)

    @property
    def last(self) -> int:
        """The state in which all letters have been read."""
        return 2 * len(self.word)

    @property
    def hides(self) -> bool:
        """Whether an element of it may explain an empty one below."""
        return any(letter.hides for letter in self.word)

    def steps(self, state: int) -> Steps:
        """What the row may have next, in this state."""
        found = self._steps.get(state)
        if found is None:
            found = self._steps[state] = _steps(self, state)
        return found


def unit_of(canvas: float) -> float:
    """A power of ten that is about 1e-11 of the canvas: decimal sizes are whole, and sums of them exact."""
    return 10.0 ** (math.floor(math.log10(canvas)) - 10)


def build_rows(words: Sequence[Word], unit: float) -> list[AlignedRow]:
    """The different words, in the order of the topmost layer of each."""
    layers: dict[Word, list[int]] = {}
    for layer, word in enumerate(words):
        layers.setdefault(tuple(word), []).append(layer)
    rows = []
    for word, where in layers.items():
        sizes = tuple(0 if letter.size is None else max(round(letter.size / unit), 1) for letter in word)
        left = [0]
        for letter, size in zip(reversed(word), reversed(sizes), strict=True):
            left += [left[-1], left[-1] + (0 if letter.transparent else size)]
        rows.append(AlignedRow(word, tuple(where), sizes, tuple(reversed(left)), len(word) or 1))
    return rows


def may_be_empty(word: Word, read: int) -> bool:
    """Whether a row may make space between these letters: not beside attached ones, nor where one could be wider."""
    return not any(letter.attached or letter.transparent for letter in word[max(read - 1, 0) : read + 1])


def _steps(row: AlignedRow, state: int) -> Steps:
    word, read, is_open = row.word, (state + 1) // 2, bool(state % 2)
    empty = RowStep(0, state, EMPTY, False, 0) if not is_open and may_be_empty(word, read) else None
    transparent = is_open or (read < len(word) and word[read].transparent)
    found = _transparent(row, read, is_open) if transparent else _seen(row, read)
    found.sort(key=lambda step: (step.size, step.merged, step.state))
    fixed = tuple(step for step in found if step.fixed)
    elastic = tuple(step for step in found if not step.fixed)
    merged = tuple(accumulate((step.merged for step in reversed(fixed)), min))[::-1]
    return Steps(
        empty, fixed, tuple(step.size for step in fixed), merged, elastic, tuple(step.size for step in elastic)
    )


def _transparent(row: AlignedRow, read: int, is_open: bool) -> list[RowStep]:
    """Elements of transparent letters, the first and the last of which may be parts."""
    found: list[RowStep] = []
    size, letters = 0, int(is_open)
    loose: tuple[int, ...] = (read - 1,) if is_open else ()
    if is_open:
        found += [RowStep(0, state, TRANSPARENT, False, 0, loose) for state in (2 * read, 2 * read - 1)]
    for at in range(read, len(row.word)):
        if not row.word[at].transparent or letters >= row.most:
            break
        # Open, the letter goes on in the next column; closed, it ends in this one.
        found.append(RowStep(size, 2 * at + 1, TRANSPARENT, False, letters, (*loose, at)))
        size += row.sizes[at]
        loose = (*loose, at) if row.word[at].size is None else loose
        found.append(RowStep(size, 2 * at + 2, TRANSPARENT, False, letters, loose))
        letters += 1
    return found


def _seen(row: AlignedRow, read: int) -> list[RowStep]:
    """Elements of letters that are not transparent."""
    found: list[RowStep] = []
    size, kind, protected = 0, OPAQUE, False
    loose: tuple[int, ...] = ()
    for at in range(read, min(len(row.word), read + row.most)):
        letter: Letter = row.word[at]
        if letter.transparent:
            break
        size += row.sizes[at]
        kind = kind if letter.hides else PARTIAL
        protected, loose = protected or letter.unoccludable, (*loose, at) if letter.size is None else loose
        found.append(RowStep(size, 2 * at + 2, kind, protected, at - read, loose))
    return found
