"""Candidates for places of trees: a Poisson process in space and time whose points have addresses.

A surface is cut into square cells (`grammarlab.geometry.footprints.equal_area`). Each cell has a Poisson number of
candidates, spread evenly over it and over the times 0 to `FULL`. All that is random about a candidate follows from the
seed, its cell and its number there, never from the outline of an area.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints, index_in_row, row_of_value
from grammarlab.errors import UsageError
from grammarlab.geometry.footprints.equal_area import AbstractSurface
from grammarlab.randomness import Keys, derived_seed, fold, root_keys, uniforms

FULL = 8.0
"""Last time, in candidates per cell. A budget: by then, nine in ten trees of an endless time stand."""
MAX_CELLS = 4_000_000
"""Most cells of an area with its margin."""
_BLOCK_CELLS = 1 << 18
"""Cells whose candidates are in memory at once: 2 million."""
_LANE = 1852401013
"""Branch of a seed for candidates, apart from those of its models."""
_NUMBER, _POINTS = 0, 1
"""Places below the key of a cell: the draw of its number of candidates, and the candidates."""
_TIME, _ACROSS, _ALONG = 0, 1, 2
"""Sites of the draws of a candidate."""
_POISSON = np.exp(-FULL) * np.cumsum(np.cumprod(np.concatenate([[1.0], FULL / np.arange(1, 64)])))
"""[64] share of cells with at most so many candidates; more than 63 have a probability of 1e-34."""


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """n candidates, in the order of their cells."""

    model: Keys
    """[n] their addresses as numbers below 2**63: the index of the tree under the seed, the same in every area."""
    time: Floats
    """[n] 0 <= time < `FULL`; of two that are too close to each other, the earlier one comes first."""
    coordinates: Floats
    """[n, 2] in the coordinates of the source of the area."""

    def __len__(self) -> int:
        return len(self.model)

    def take(self, rows: Ints | Flags) -> Candidates:
        """The candidates of some rows."""
        return Candidates(self.model[rows], self.time[rows], self.coordinates[rows])


def candidates_in(
    surface: AbstractSurface, boxes: Floats, side: float, seed: int, until: float = FULL
) -> Iterator[Candidates]:
    """All candidates of the cells that meet some boxes, in blocks, up to a time.

    Args:
        surface: the surface.
        boxes: [b, 2, 2] lowest and highest points of each box on the map of the surface.
        side: metres; the side of a cell on the map, about.
        seed: seed of the run.
        until: candidates have times below.

    Raises:
        UsageError: If the boxes have more than `MAX_CELLS` cells.
    """
    sides = surface.sides(side)
    cells = _different(surface, _cells_of(np.floor(boxes / sides).astype(np.int64), side), side)
    root = root_keys(derived_seed(seed, _LANE), np.zeros(1, np.uint64))
    for start in range(0, len(cells), _BLOCK_CELLS):
        block = cells[start : start + _BLOCK_CELLS]
        key = fold(fold(np.repeat(root, len(block)), _words(block[:, 0])), _words(block[:, 1]))
        yield _candidates_of(surface, block, key, sides, until)


def _cells_of(corners: Ints, side: float) -> Ints:
    """[c, 2] columns and rows of the cells in boxes from one cell to another [b, 2, 2], both included."""
    low, size = corners[:, 0], corners[:, 1] - corners[:, 0] + 1
    counts = size.prod(axis=1)
    num = size.prod(axis=1, dtype=np.float64).sum()
    if num > MAX_CELLS:
        raise UsageError(
            f"the area and its surroundings have {num:,.0f} cells of {side:.2g} m, and at most {MAX_CELLS:,} can be "
            "planted: choose a smaller area, or larger trees."
        )
    box, number = row_of_value(counts), index_in_row(counts)
    return np.column_stack([low[box, 0] + number % size[box, 0], low[box, 1] + number // size[box, 0]])


def _different(surface: AbstractSurface, cells: Ints, side: float) -> Ints:
    """The different cells, counted once around the earth."""
    column, row = surface.columns(cells[:, 0], side), cells[:, 1]
    west, south, width = column.min(), row.min(), np.ptp(column) + 1
    place = np.unique((row - south) * width + (column - west))
    return np.column_stack([place % width + west, place // width + south])


def _candidates_of(surface: AbstractSurface, cells: Ints, key: Keys, sides: Floats, until: float) -> Candidates:
    """Candidates of cells [c, 2] with keys [c]."""
    counts = np.searchsorted(_POISSON, uniforms(key, _NUMBER), side="right")
    model = fold(fold(np.repeat(key, counts), _POINTS), index_in_row(counts)) >> np.uint64(1)
    time = FULL * uniforms(model, _TIME)
    early = time < until
    model, time, cell = model[early], time[early], np.repeat(cells, counts, axis=0)[early]
    shares = np.column_stack([uniforms(model, _ACROSS), uniforms(model, _ALONG)])
    return Candidates(model, time, surface.coordinates((cell + shares) * sides))


def _words(numbers: Ints) -> Ints:
    """[n] whole numbers >= 0 for any whole numbers: 0, -1, 1 and -2 become 0, 1, 2 and 3."""
    return np.where(numbers >= 0, 2 * numbers, -2 * numbers - 1)
