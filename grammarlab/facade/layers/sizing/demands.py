"""Size equations of alignments, and a lower bound of the size error of several of them together."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grammarlab.facade.layers.alignment.align import Alignment
from grammarlab.facade.layers.letters import Word
from grammarlab.facade.layers.sizing.equations import equations
from grammarlab.facade.tree import Floats

_RANK = 1e-9
"""Singular values below this fraction of the largest are 0."""


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
    left, size, _ = np.linalg.svd(system.matrix[:, free], full_matrices=True)
    rank = int((size > _RANK * size.max(initial=1.0)).sum())
    kept = left[:, rank:].T
    matrix = np.zeros((len(kept), len(symbols)))
    # Symbols that share an unknown share its column.
    for unknown in set(index):
        matrix[:, index.index(unknown)] = kept @ system.matrix[:, unknown]
    same = [(index.index(unknown), at) for at, unknown in enumerate(index) if index.index(unknown) != at]
    equal = np.zeros((len(same), len(symbols)))
    for row, (one, other) in zip(equal, same, strict=True):
        row[one], row[other] = 1.0, -1.0
    size = np.array([sizes[symbol] for symbol in symbols])
    value = np.concatenate([kept @ system.value, np.zeros(len(same))])
    return SizeEquations(symbols, size, np.concatenate([matrix, equal]), value)


def demands_alone(word: Word, canvas: float) -> SizeEquations | None:
    """The size equation of a word that fills the canvas alone; None if a letter takes the remaining length."""
    counts = Counter(letter.symbol for letter in word)
    if any(letter.size is None or not letter.hides for letter in word):
        return None
    sizes = {letter.symbol: letter.size for letter in word}
    size, often = np.array([sizes[name] for name in counts], dtype=np.float64), np.array(list(counts.values()))
    return SizeEquations(tuple(counts), size, often[None].astype(np.float64), np.array([canvas]))


def least_error(together: Sequence[SizeEquations]) -> float:
    """Lower bound of the sum of squared deviations from preferred sizes under all equations, square metres."""
    if not together:
        return 0.0
    sizes: dict[str, float] = {}
    for each in together:
        sizes |= zip(each.symbols, each.size, strict=True)
    place = {symbol: at for at, symbol in enumerate(sizes)}
    matrix = np.zeros((sum(len(each.value) for each in together), len(sizes)))
    row = 0
    for each in together:
        matrix[row : row + len(each.value), [place[symbol] for symbol in each.symbols]] = each.matrix
        row += len(each.value)
    miss = np.concatenate([each.value for each in together]) - matrix @ np.array(list(sizes.values()))
    if not matrix.size:
        return 0.0
    change = np.linalg.lstsq(matrix, miss, rcond=_RANK)[0]
    # Slightly less, since rounding errors must not make the bound too large.
    return float(np.square(change).sum()) * (1.0 - 1e-9)
