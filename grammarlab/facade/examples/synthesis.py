"""Other grids of labels after the manner of examples, of any size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from grammarlab.facade.examples.label_grid import LabelGrid, Labels
from grammarlab.facade.examples.wishes import Wishes

Method = Literal["exact", "em"]


@dataclass(frozen=True, slots=True)
class Quality:
    """How near a grid is to its examples; each from 0 to 1."""

    patch_similarity: float
    """Bidirectional: 1 when every window of the grid is one of the examples' and every one of theirs is in the grid."""
    cooccurrence: float
    """Total variation distance of the pairs of labels side by side and one above the other; 0 when equally frequent."""
    histogram: float
    """Total variation distance of the labels; 0 when equally frequent."""
    novelty: float
    """Part of the grid's windows that are in no example."""


@dataclass(frozen=True, slots=True)
class Synthesis:
    """A new grid of labels, and how good it is."""

    grid: LabelGrid
    method: Method
    energy: int
    """Labels that differ, summed over one window about every cell, each against the nearest window of the examples that
    has the same borders: the paper's energy (Eq. 1 and 2) with borders. Both methods are measured by it."""
    bound: int
    """No grid that keeps the same wishes has less energy; 0 by method em, which knows none."""
    proven: bool
    """Energy and bound are equal."""
    paper_energy: int
    """E(O) of the paper's Eq. 1: windows of 3 x 3 cells within the grid only, borders forgotten."""
    history: tuple[int, ...]
    """By method em, the paper's energy after each iteration; else empty."""
    quality: Quality
    notes: tuple[str, ...]
    """What had to give way, in words."""


def synthesize(
    examples: Sequence[LabelGrid],
    rows: int,
    columns: int,
    *,
    method: Method = "exact",
    wishes: Wishes = Wishes(),
    seed: int = 0,
    count: int = 1,
    regions: Labels | None = None,
) -> list[Synthesis]:
    """Grids of the same kind as the examples, best first, no two equal.

    Args:
        examples: one or more; labels of equal name are equal.
        rows: of the new grid, 1 or more.
        columns: of the new grid, 1 or more.
        method: `exact` keeps borders and wishes and bounds the energy; `em` is the paper's, for comparison: it keeps
            neither.
        wishes: what is asked of the grid.
        seed: of all random choices.
        count: grids wanted; fewer come where fewer were found.
        regions: [rows, columns] which example each cell is made after; all examples everywhere, when left out.

    Raises:
        FacadeError: for wishes that contradict each other, or sizes out of range.
    """
    raise NotImplementedError
