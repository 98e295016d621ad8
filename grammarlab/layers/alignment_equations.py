"""Equations of alignments between sizes of symbols, and a bound of their error (paper 003, section 5.3).

The unknowns are sizes: one for each symbol, shared by all of its letters, one for each column, and one for each part of
a split letter. An element that is a single letter or part is as wide as its column: one unknown for both.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from grammarlab.arrays import Floats, Ints, connected
from grammarlab.layers.alignment.align import Alignment, Element
from grammarlab.layers.design import Word

Unknown = tuple[Any, ...]
"""("symbol", name), ("column", alignment, column) or ("part", alignment, word, letter, part)."""
_RANK_TOLERANCE = 1e-9
"""Singular values below this fraction of the largest are 0."""


@dataclass(frozen=True)
class Equations:
    """Linear equations between U unknown sizes."""

    index: dict[Unknown, int]
    """Index of the size of each unknown, 0 to U - 1."""
    matrix: Floats
    """[R, U] coefficients."""
    value: Floats
    """[R] right-hand sides, metres."""
    target: Floats
    """[P] preferred sizes of symbols, metres."""
    target_index: Ints
    """[P] index of the size of each of these symbols."""

    @property
    def num_sizes(self) -> int:
        """Number U of sizes."""
        return self.matrix.shape[1]


@dataclass(frozen=True, eq=False)
class SizeEquations:
    """Equations between the sizes of symbols, after elimination of widths of columns and unsized symbols."""

    symbols: tuple[str, ...]
    """The S symbols with a preferred size."""
    size: Floats
    """[S] preferred sizes, metres."""
    matrix: Floats
    """[R, S] coefficients."""
    value: Floats
    """[R] right-hand sides, metres."""


def demands(alignment: Alignment, canvas: float, *, gaps: bool) -> SizeEquations:
    """The size equations of one alignment."""
    system = equations([(alignment, canvas)], gaps=gaps)
    symbols = tuple(
        name for name in dict.fromkeys(letter.symbol for word in alignment.words for letter in word if letter.size)
    )
    index = [system.index["symbol", symbol] for symbol in symbols]
    sizes = {letter.symbol: letter.size for word in alignment.words for letter in word if letter.size is not None}
    free = np.ones(system.num_sizes, dtype=np.bool_)
    free[index] = False
    u, singular, _ = np.linalg.svd(system.matrix[:, free], full_matrices=True)
    rank = int((singular > _RANK_TOLERANCE * singular.max(initial=1.0)).sum())
    null_space = u[:, rank:].T
    matrix = np.zeros((len(null_space), len(symbols)))
    # Symbols that share an unknown share its column.
    for unknown in set(index):
        matrix[:, index.index(unknown)] = null_space @ system.matrix[:, unknown]
    same = [
        (index.index(unknown), position) for position, unknown in enumerate(index) if index.index(unknown) != position
    ]
    equal = np.zeros((len(same), len(symbols)))
    for row, (one, other) in zip(equal, same, strict=True):
        row[one], row[other] = 1.0, -1.0
    size = np.array([sizes[symbol] for symbol in symbols])
    value = np.concatenate([null_space @ system.value, np.zeros(len(same))])
    return SizeEquations(symbols, size, np.concatenate([matrix, equal]), value)


def equations(alignments: Sequence[tuple[Alignment, float]], *, gaps: bool) -> Equations:
    """Equations of alignments, each with its canvas; see `size_letters`."""
    builder = _Equations(gaps=gaps)
    for number, (alignment, canvas) in enumerate(alignments):
        builder.add(number, alignment, canvas)
    return builder.done()


def is_gapped(alignment: Alignment, row: int, element: Element, *, gaps: bool) -> bool:
    """Whether the letters of an element keep their size, centred in their column (supplement 002, section 3.4)."""
    letters = [alignment.words[row][index] for index, _ in element]
    if not gaps or any(letter.transparent or letter.size is None for letter in letters):
        return False
    return any(not letter.opaque for letter in letters)


def demands_alone(word: Word, canvas: float) -> SizeEquations | None:
    """The size equation of a word that fills the canvas alone; None if a letter takes the remaining length."""
    counts = Counter(letter.symbol for letter in word)
    if any(letter.size is None or not letter.hides for letter in word):
        return None
    sizes = {letter.symbol: letter.size for letter in word}
    size, often = np.array([sizes[name] for name in counts], dtype=np.float64), np.array(list(counts.values()))
    return SizeEquations(tuple(counts), size, often[None].astype(np.float64), np.array([canvas]))


def least_error(systems: Sequence[SizeEquations]) -> float:
    """Lower bound of the sum of squared deviations from preferred sizes under all equations, square metres."""
    if not systems:
        return 0.0
    sizes: dict[str, float] = {}
    for system in systems:
        sizes |= zip(system.symbols, system.size, strict=True)
    column = {symbol: position for position, symbol in enumerate(sizes)}
    matrix = np.zeros((sum(len(system.value) for system in systems), len(sizes)))
    row = 0
    for system in systems:
        matrix[row : row + len(system.value), [column[symbol] for symbol in system.symbols]] = system.matrix
        row += len(system.value)
    residual = np.concatenate([system.value for system in systems]) - matrix @ np.array(list(sizes.values()))
    if not matrix.size:
        return 0.0
    change = np.linalg.lstsq(matrix, residual, rcond=_RANK_TOLERANCE)[0]
    # Slightly less, since rounding errors must not make the bound too large.
    return float(np.square(change).sum()) * (1.0 - 1e-9)


@dataclass
class _Equations:
    gaps: bool
    number: dict[Unknown, int] = field(default_factory=dict)
    equal: list[tuple[int, int]] = field(default_factory=list)
    """Pairs of unknowns of the same size."""
    targets: dict[Unknown, float] = field(default_factory=dict)
    rows: list[tuple[Counter[Unknown], float]] = field(default_factory=list)

    def node(self, unknown: Unknown) -> int:
        """Number of an unknown, in the order of their first mention."""
        return self.number.setdefault(unknown, len(self.number))

    def add(self, number: int, alignment: Alignment, canvas: float) -> None:
        for row in {word: row for row, word in enumerate(alignment.words)}.values():
            self._row(number, alignment, row)
        whole = Counter[Unknown](("column", number, column) for column in range(alignment.num_columns))
        self.rows.append((whole, canvas))

    def _row(self, number: int, alignment: Alignment, row: int) -> None:
        word, elements = alignment.words[row], alignment.cells[row]
        for letter in word:
            self.node(("symbol", letter.symbol))
            if letter.size is not None:
                self.targets["symbol", letter.symbol] = letter.size
        split = {index for element in elements for index, part in element if part}
        for column, element in enumerate(elements):
            unknowns: list[Unknown] = [
                ("part", number, row, index, part) if index in split else ("symbol", word[index].symbol)
                for index, part in element
            ]
            if not element or is_gapped(alignment, row, element, gaps=self.gaps):
                continue
            if len(unknowns) == 1:
                self.equal.append((self.node(("column", number, column)), self.node(unknowns[0])))
            else:
                total = Counter[Unknown](unknowns)
                total["column", number, column] -= 1
                self.rows.append((total, 0.0))
        for index in split:
            total = Counter[Unknown](
                ("part", number, row, index, part) for element in elements for other, part in element if other == index
            )
            total["symbol", word[index].symbol] -= 1
            self.rows.append((total, 0.0))

    def done(self) -> Equations:
        for total, _ in self.rows:
            for unknown in total:
                self.node(unknown)
        size = connected(len(self.number), *np.array(self.equal, dtype=np.int64).reshape(-1, 2).T)
        index = dict(zip(self.number, size.tolist(), strict=True))
        matrix = np.zeros((len(self.rows), size.max(initial=-1) + 2))
        for row, (total, value) in zip(matrix, self.rows, strict=True):
            for unknown, factor in total.items():
                row[index[unknown]] += factor
            row[-1] = value
        matrix = np.unique(matrix, axis=0)
        matrix = matrix[matrix.any(axis=1)]
        return Equations(
            index,
            matrix[:, :-1],
            matrix[:, -1],
            np.array(list(self.targets.values()), dtype=np.float64),
            np.array([index[unknown] for unknown in self.targets], dtype=np.int64),
        )
