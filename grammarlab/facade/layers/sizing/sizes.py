"""Sizes of symbols and positions of letters: least squares under an alignment (paper 003, section 5.3)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from grammarlab.facade.layers.alignment.align import Alignment
from grammarlab.facade.layers.sizing.equations import Equations, equations, is_gapped
from grammarlab.facade.layers.sizing.squares import Squares
from grammarlab.facade.tree import Floats

_LEAST = 1e-6
"""Least size of a letter, as a fraction of the canvas."""


@dataclass(frozen=True)
class PlacedAlignment:
    """An alignment with positions, in metres from the start of the canvas."""

    ends: Floats
    """[n + 1] borders of columns: the first is 0, the last is the canvas."""
    lower: tuple[Floats, ...]
    """[m][letters] start of each letter of each row."""
    upper: tuple[Floats, ...]
    """[m][letters] end of each letter of each row."""


@dataclass(frozen=True)
class SymbolSizes:
    """Sizes with the least deviation from preferred sizes."""

    sizes: Mapping[str, float]
    """Size of each symbol, metres, the same at all occurrences; in the order of first use."""
    placed: tuple[PlacedAlignment, ...]
    """Positions for each alignment."""
    error: float
    """Sum of squared deviations from preferred sizes, square metres."""
    residual: float
    """Largest violation of the equations and of optimality, measured on the positions, metres."""


def size_letters(alignments: Sequence[tuple[Alignment, float]], *, gaps: bool = False) -> SymbolSizes | None:
    """The best sizes for alignments of both axes and all groups, each with its canvas; None if there are none.

    Args:
        alignments: each with the length of its canvas, metres.
        gaps: whether elements with letters that are not opaque keep their size, centred in their column (supplement
            002,
            section 3.4); otherwise they fill it.
    """
    canvases = [canvas for _, canvas in alignments]
    if not canvases:
        return SymbolSizes({}, (), 0.0, 0.0)
    system = equations(alignments, gaps=gaps)
    scale = max(canvases)
    squares = Squares(system.matrix, system.value, system.target_index, system.target, _LEAST * min(canvases), scale)
    size = squares.solve()
    if size is None:
        return None
    placed = tuple(
        _placed(system, size, number, alignment, canvas, gaps=gaps)
        for number, (alignment, canvas) in enumerate(alignments)
    )
    sizes = {name[1]: float(size[at]) for name, at in system.index.items() if name[0] == "symbol"}
    missed = max(_missed(one, each, sizes) for one, (each, _) in zip(placed, alignments, strict=True))
    error = float(np.square(size[system.target_index] - system.target).sum())
    return SymbolSizes(sizes, placed, error, max(missed, squares.optimality(size)))


def _placed(
    system: Equations, size: Floats, number: int, alignment: Alignment, canvas: float, *, gaps: bool
) -> PlacedAlignment:
    """Positions of the letters of an alignment."""
    widths = [size[system.index["column", number, column]] for column in range(alignment.num_columns)]
    ends = np.concatenate([[0.0], np.cumsum(widths)])
    ends[-1] = canvas
    lower, upper = [], []
    first = {word: row for row, word in enumerate(alignment.words)}
    for row, (word, elements) in enumerate(zip(alignment.words, alignment.cells, strict=True)):
        split = {at for element in elements for at, part in element if part}
        low, high = np.full(len(word), np.inf), np.zeros(len(word))
        for column, element in enumerate(elements):
            keys = [
                ("part", number, first[word], at, part) if at in split else ("symbol", word[at].symbol)
                for at, part in element
            ]
            edges = np.concatenate([[0.0], np.cumsum([size[system.index[key]] for key in keys])]) + ends[column]
            if is_gapped(alignment, row, element, gaps=gaps):
                edges += 0.5 * (ends[column + 1] - edges[-1])
            else:
                edges[-1] = ends[column + 1]
            for (at, _), begin, end in zip(element, edges, edges[1:], strict=False):
                low[at], high[at] = min(low[at], begin), end
        lower.append(low)
        upper.append(high)
    return PlacedAlignment(ends, tuple(lower), tuple(upper))


def _missed(placed: PlacedAlignment, alignment: Alignment, sizes: Mapping[str, float]) -> float:
    """Largest difference of a letter's length and the size of its symbol, metres."""
    return max(
        (
            abs(float(upper[at] - lower[at]) - sizes[letter.symbol])
            for word, lower, upper in zip(alignment.words, placed.lower, placed.upper, strict=True)
            for at, letter in enumerate(word)
        ),
        default=0.0,
    )
