"""Alignment of words: the matrix of substrings whose columns fit each other best (paper 003, section 5.2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from grammarlab.facade.layers.letters import Word
from grammarlab.facade.layers.weights import Weights

Part = tuple[int, int]
"""A letter's index in its word, and which of its parts this is: 0, unless columns split the letter."""
Element = tuple[Part, ...]
"""What stands in one row and one column; empty where the row makes space."""


@dataclass(frozen=True)
class Alignment:
    """Words that are cut at the same columns."""

    words: tuple[Word, ...]
    """m rows, from the top layer down."""
    cells: tuple[tuple[Element, ...], ...]
    """[m, n]"""
    omega: float
    """Metres: the sum of the errors of columns."""
    span: float
    """Metres: the sum of the widest elements of columns."""
    merged: int
    """Letters of elements beyond their first."""
    energy: float
    """Of omega and merged letters, weighted."""
    bound: float
    """No alignment that comes after those before it in the list has less energy than this."""
    proven: bool
    """Whether `bound` is `energy`."""

    @property
    def num_columns(self) -> int:
        """n"""
        return len(self.cells[0]) if self.cells else 0

    def columns(self) -> list[list[str]]:
        """[n][m] each element as text, from the top layer down; an empty one is 'ε'."""
        raise NotImplementedError


def alignments(
    words: Sequence[Word],
    canvas: float,
    weights: Weights,
    count: int = 1,
    *,
    tolerance: float,
    effort: int = 200_000,
) -> list[Alignment]:
    """The best different alignments of some words, best first; fewer where there are not that many.

    Args:
        words: m words, from the top layer down.
        canvas: metres, > 0.
        weights: of omega and merged letters.
        count: how many.
        tolerance: mu, metres that the span may miss of the canvas, >= 0.
        effort: columns that are tried at most.
    """
    raise NotImplementedError
