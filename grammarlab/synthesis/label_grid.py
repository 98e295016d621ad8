"""Labels of the units of a facade, in rows and columns, and wishes of a person for the labels of a new one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grammarlab.errors import FacadeError

Rows = Literal["ground", "top", "between"]
"""Rows of a grid: the lowest, the highest, or those between them."""
Labels = NDArray[np.int64]
HOLE = -1
"""Label of an unknown cell."""
MOST_CELLS = 40_000
"""Largest number of cells of a grid: 200 x 200."""


@dataclass(frozen=True, slots=True)
class Count:
    """The number of occurrences of a label."""

    label: str
    least: int
    most: int


@dataclass(frozen=True, slots=True)
class Only:
    """A label that occurs only in these rows."""

    label: str
    rows: Rows


@dataclass(frozen=True, slots=True)
class Fixed:
    """A cell with a given label."""

    row: int
    """Index from 0, at the bottom."""
    column: int
    """Index from 0, at the left."""
    label: str


@dataclass(frozen=True, slots=True)
class Wishes:
    """All wishes for one facade; none by default."""

    counts: tuple[Count, ...] = ()
    only: tuple[Only, ...] = ()
    fixed: tuple[Fixed, ...] = ()
    equal_corners: bool = False
    """Whether the left and the right corner of the lowest row have the same label, and so those of the highest row."""
    symmetric: bool = False
    """Whether every row is a palindrome."""
    keep: bool = True
    """Whether a unit that occurs once on the example's ground floor, such as its door, occurs exactly once there, in
    addition to those that `fixed` puts above."""


@dataclass(frozen=True, slots=True)
class LabelGrid:
    """A facade as an array of labels."""

    labels: Labels
    """[rows, columns] label of each unit, row 0 at the bottom, column 0 at the left; `HOLE` for an unknown one."""
    names: tuple[str, ...]
    """Unique name of each label."""

    @classmethod
    def from_labels(cls, labels: ArrayLike, names: Sequence[str] | None = None) -> LabelGrid:
        """A checked grid; labels without given names are named by their number.

        Args:
            labels: [rows, columns] integers from 0, or `HOLE`; row 0 at the bottom.
            names: one for each label.

        Raises:
            FacadeError: If there is no cell, a label has no name, or the grid is too large.
        """
        try:
            values = np.asarray(labels)
        except ValueError as error:
            raise FacadeError("labels: expected rows of equal length.") from error
        if values.ndim != 2 or values.size == 0:
            raise FacadeError(f"labels: expected rows and columns with at least one cell, found shape {values.shape}.")
        if values.size > MOST_CELLS:
            raise FacadeError(
                f"labels: {values.shape[0]} x {values.shape[1]} cells; at most {MOST_CELLS:,} are allowed."
            )
        if not np.issubdtype(values.dtype, np.integer):
            raise FacadeError(f"labels: expected whole numbers, found {values.dtype}.")
        grid = values.astype(np.int64)
        if grid.min() < HOLE or grid.max() >= MOST_CELLS:
            raise FacadeError(f"labels: expected 0 to {MOST_CELLS - 1:,}, or {HOLE} for a hole; found {grid.min()}.")
        if grid.max() < 0:
            raise FacadeError("labels: all cells are holes; label at least one.")
        label_names = tuple(str(k) for k in range(int(grid.max()) + 1)) if names is None else tuple(names)
        if grid.max() >= len(label_names):
            raise FacadeError(f"labels: label {grid.max()} has no name; {len(label_names)} names are given.")
        if len(set(label_names)) < len(label_names):
            raise FacadeError("labels: a name occurs twice; each label needs a different name.")
        grid.setflags(write=False)
        return cls(grid, label_names)

    @property
    def rows(self) -> int:
        return self.labels.shape[0]

    @property
    def columns(self) -> int:
        return self.labels.shape[1]

    def label(self, name: str) -> int:
        """Number of a name.

        Raises:
            FacadeError: If the name is unknown; the message lists the known names.
        """
        if name not in self.names:
            raise FacadeError(f"unknown label {name!r}; expected one of {', '.join(self.names)}.")
        return self.names.index(name)


def unnumbered(name: str) -> str:
    """The name of a label without its distinguishing number.

    >>> unnumbered("window-2"), unnumbered("shop-window")
    ('window', 'shop-window')
    """
    head, _, number = name.rpartition("-")
    return head if head and number.isdigit() else name


def single_units(grid: LabelGrid) -> tuple[int, int]:
    """Numbers of units that occur once, and of all units; bare wall is none.

    >>> single_units(LabelGrid.from_labels([[0, 1, 0], [2, 2, 2]], ["window", "door", "wall"]))
    (1, 3)
    """
    counts = np.bincount(grid.labels[grid.labels >= 0], minlength=len(grid.names))
    counts = counts[[unnumbered(name) != "wall" for name in grid.names]]
    return int((counts == 1).sum()), int(counts.sum())


def joined(examples: Sequence[LabelGrid]) -> list[LabelGrid]:
    """The grids with one numbering of names, in order of occurrence."""
    names = tuple(dict.fromkeys(name for example in examples for name in example.names))
    grids = []
    for example in examples:
        number = np.array([names.index(name) for name in example.names] + [HOLE])  # index -1 is the hole's
        grids.append(LabelGrid.from_labels(number[example.labels], names))
    return grids
