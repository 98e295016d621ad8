"""Windows of a new grid, the patches of the examples that each is compared with, and the energy of a grid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.synthesis.label_grid import HOLE, LabelGrid, Labels
from grammarlab.synthesis.labels.ground_floor import with_upper_storeys

MOST_COMPARED = 400_000_000
"""Largest number of windows times patches of a problem."""
WINDOW = 3
"""Rows and columns of a window: the paper's w; centres of windows are |w / 4| = 1 cell apart."""
AWAY = -2
"""Label of a cell of a window that is not compared: beyond a border, or a hole."""
_MAX_COMPARISONS = 10_000_000
"""Largest number of windows times patches that are compared at once."""


@dataclass(frozen=True, slots=True)
class Problem:
    """Labels that differ from the nearest patch, summed over windows; each cell has a set of allowed labels."""

    kind: NDArray[np.int64]
    """[rows, columns] index of the list of patches for the window at each cell; -1 for no window."""
    patches: tuple[Labels, ...]
    """By kind: [patches, 3, 3] different patches; `AWAY` in cells that are not compared."""
    domain: NDArray[np.bool_]
    """[rows, columns, labels] whether each cell may have each label."""

    @property
    def rows(self) -> int:
        return self.kind.shape[0]

    @property
    def columns(self) -> int:
        return self.kind.shape[1]

    @property
    def num_labels(self) -> int:
        return self.domain.shape[2]

    @property
    def padded_patches(self) -> Labels:
        """[kinds + 1, patches, 3, 3] patches; kinds with fewer repeat theirs, and the last kind has no labels."""
        most = max(len(patches) for patches in self.patches)
        padded = [patches[np.arange(most) % len(patches)] for patches in self.patches]
        return np.array([*padded, np.full((most, WINDOW, WINDOW), AWAY, dtype=np.int64)])

    def transposed(self) -> Problem:
        """The problem with rows and columns exchanged."""
        turned = tuple(np.ascontiguousarray(patches.transpose(0, 2, 1)) for patches in self.patches)
        return Problem(np.ascontiguousarray(self.kind.T), turned, np.ascontiguousarray(self.domain.transpose(1, 0, 2)))

    def within(self, domain: NDArray[np.bool_]) -> Problem:
        """The problem with other domains."""
        return replace(self, domain=domain)


def bordered(examples: Sequence[LabelGrid], regions: Labels) -> Problem:
    """A window at every cell, compared with the windows of the examples at the same borders.

    A corner is compared with the same corner, the ground floor with the ground floor, and a cell has the labels that
    the examples have at that border. Storeys that the examples lack are copies of their upper storeys, see
    `with_upper_storeys`: only the ground floor is compared with a ground floor. A single row is compared with the
    ground floor, a single column with any, and columns between the ends of the grid with both of an example that has
    two.

    Args:
        examples: examples with one numbering of labels.
        regions: [rows, columns] example of each cell, or -1 for any of them.
    """
    rows, columns = regions.shape
    vertical, horizontal = _sides(rows), _sides(columns)
    raised = list(zip(examples, with_upper_storeys(examples, regions), strict=True))
    ids: dict[tuple[int, int, int], int] = {}
    kind = np.empty((rows, columns), dtype=np.int64)
    patches, allowed = [], []
    for row, column in np.ndindex(rows, columns):
        key = (int(vertical[row]), int(horizontal[column]), int(regions[row, column]))
        if key not in ids:
            ids[key] = len(patches)
            pairs = [raised[key[2]]] if key[2] >= 0 else raised
            if not key[0] & 1:  # upper rows come from examples that have some
                pairs = [pair for pair in pairs if pair[0].rows > 1] or pairs
            chosen = [example for _, example in pairs]
            patches.append(_distinct(np.concatenate([_windows_like(example, key[0], key[1]) for example in chosen])))
            allowed.append(_allowed(chosen, key[0], key[1]))
        kind[row, column] = ids[key]
    return Problem(kind, tuple(patches), np.array(allowed)[kind])


def unbordered(examples: Sequence[LabelGrid], regions: Labels) -> Problem:
    """The paper's windows: those inside the grid, each compared with all windows of the examples.

    A window has fewer than 3 rows or columns if the grid, or the smallest example, has fewer.

    Args:
        examples: examples with one numbering of labels.
        regions: [rows, columns] example of each cell, or -1 for any of them.
    """
    rows, columns = regions.shape
    height = min(WINDOW, rows, *(example.rows for example in examples))
    width = min(WINDOW, columns, *(example.columns for example in examples))
    names = len(examples[0].names)
    lists = [_inner(examples, height, width), *(_inner([example], height, width) for example in examples)]
    kind = np.full((rows, columns), -1, dtype=np.int64)
    up, right = _before(height), _before(width)
    inner = slice(up, up + rows - height + 1), slice(right, right + columns - width + 1)
    kind[inner] = regions[inner] + 1
    present = np.array(
        [_present(_all_labels(group), names) for group in (examples, *([example] for example in examples))]
    )
    return Problem(kind, tuple(lists), present[regions + 1])


def energy(problem: Problem, labels: Labels) -> int:
    """E(O): number of differing labels, summed over all windows (Eq. 1)."""
    return int(distances(problem, labels)[1].sum())


def distances(problem: Problem, labels: Labels) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The nearest patch of the window at each cell, the first of equals, and the number of differing labels (Eq. 2).

    Args:
        problem: the windows and their patches.
        labels: [rows, columns] labels of the grid.

    Returns:
        [rows, columns] nearest patch, and number of differing labels; -1 and 0 for cells without a window.
    """
    nearest = np.full(labels.shape, -1, dtype=np.int64)
    differ = np.zeros(labels.shape, dtype=np.int64)
    ring = np.full((problem.rows + 2, problem.columns + 2), AWAY, dtype=np.int64)
    ring[1:-1, 1:-1] = labels
    for kind, patches in enumerate(problem.patches):
        row, column = np.nonzero(problem.kind == kind)
        turn = max(1, _MAX_COMPARISONS // len(patches))
        for start in range(0, len(row), turn):
            cells = row[start : start + turn], column[start : start + turn]
            counts = np.zeros((len(cells[0]), len(patches)), dtype=np.uint8)
            for up, right in np.ndindex(WINDOW, WINDOW):
                target = patches[:, up, right]
                here = ring[cells[0] + up, cells[1] + right]
                counts += (here[:, None] != target) & (target != AWAY)
            nearest[cells] = counts.argmin(axis=1)
            differ[cells] = counts.min(axis=1)
    return nearest, differ


def votes(problem: Problem, nearest: NDArray[np.int64]) -> NDArray[np.int64]:
    """Number of windows over a cell that have each label there, if each is replaced by its nearest patch.

    Args:
        problem: the windows and their patches.
        nearest: [rows, columns] patch of the window at each cell.

    Returns:
        [rows, columns, labels] counts.
    """
    counts = np.zeros((problem.rows + 2, problem.columns + 2, problem.num_labels), dtype=np.int64)
    for kind, patches in enumerate(problem.patches):
        row, column = np.nonzero(problem.kind == kind)
        for up, right in np.ndindex(WINDOW, WINDOW):
            label = patches[nearest[row, column], up, right]
            counted = label != AWAY
            np.add.at(counts, (row[counted] + up, column[counted] + right, label[counted]), 1)
    return counts[1:-1, 1:-1]


def _sides(size: int) -> NDArray[np.int64]:
    """[size] borders of each row: 1 for the first, 2 for the last, 3 for both, 0 for none."""
    sides = np.zeros(size, dtype=np.int64)
    sides[0] |= 1
    sides[-1] |= 2
    return sides


def _distinct(windows: Labels) -> Labels:
    """Different windows; those with more holes than others are left out."""
    holes = (windows == AWAY).sum(axis=(1, 2))
    return np.unique(windows[holes == holes.min()], axis=0)


def _windows_like(example: LabelGrid, vertical: int, horizontal: int) -> Labels:
    """Windows [n, 3, 3] of an example at cells with these borders."""
    windows = _padded(example.labels)[_cells_like(example, vertical, horizontal)].copy()
    for side, index in ((1, 0), (2, 2)):  # cells beyond a border are not compared
        if vertical & side:
            windows[:, :, index, :] = AWAY
        if horizontal & side:
            windows[:, :, :, index] = AWAY
    return windows.reshape(-1, WINDOW, WINDOW)


def _padded(labels: Labels) -> Labels:
    """Windows [rows, columns, 3, 3] at the cells; `AWAY` beyond the borders and at holes."""
    ring = np.full((labels.shape[0] + 2, labels.shape[1] + 2), AWAY, dtype=np.int64)
    ring[1:-1, 1:-1] = np.where(labels == HOLE, AWAY, labels)
    return np.lib.stride_tricks.sliding_window_view(ring, (WINDOW, WINDOW))


def _cells_like(example: LabelGrid, vertical: int, horizontal: int) -> tuple[NDArray[np.int64], ...]:
    """Index of the cells with these borders."""
    rows = _matching(_sides(example.rows), vertical, alone=1)
    columns = _matching(_sides(example.columns), horizontal, alone=0)
    return np.ix_(rows, columns)


def _matching(sides: NDArray[np.int64], borders: int, alone: int) -> NDArray[np.int64]:
    """Rows of an example for a row with these borders.

    Args:
        sides: borders of the example's rows.
        borders: borders of the new grid's row.
        alone: borders that the only row of a new grid keeps if the example has several rows.
    """
    equal = np.flatnonzero(sides == borders)
    if len(equal):
        return equal
    required = alone if borders == 3 else borders
    return np.flatnonzero((sides & required) == required)


def _allowed(examples: Sequence[LabelGrid], vertical: int, horizontal: int) -> NDArray[np.bool_]:
    """[labels] labels at these borders; if all are holes, those of these rows, or of all rows of upper storeys."""
    num_labels = len(examples[0].names)
    lowest = 0 if vertical & 1 else 1
    for parts in (
        [example.labels[_cells_like(example, vertical, horizontal)] for example in examples],
        [example.labels[_matching(_sides(example.rows), vertical, alone=1)] for example in examples],
        [example.labels[lowest:] for example in examples],
    ):
        labels = _present(np.concatenate([part.ravel() for part in parts]), num_labels)
        if labels.any():
            return labels
    return _present(_all_labels(examples), num_labels)


def _present(labels: Labels, num_labels: int) -> NDArray[np.bool_]:
    """[num_labels] whether each label occurs."""
    return np.bincount(labels[labels >= 0].ravel(), minlength=num_labels)[:num_labels] > 0


def _all_labels(examples: Sequence[LabelGrid]) -> Labels:
    return np.concatenate([example.labels.ravel() for example in examples])


def _inner(examples: Sequence[LabelGrid], height: int, width: int) -> Labels:
    """Windows of height x width cells, padded with cells that are not compared."""
    parts = []
    for example in examples:
        views = np.lib.stride_tricks.sliding_window_view(example.labels, (height, width)).reshape(-1, height, width)
        windows = np.full((len(views), WINDOW, WINDOW), AWAY, dtype=np.int64)
        up, right = 1 - _before(height), 1 - _before(width)
        windows[:, up : up + height, right : right + width] = np.where(views == HOLE, AWAY, views)
        parts.append(windows)
    return _distinct(np.concatenate(parts))


def _before(size: int) -> int:
    """Number of cells of a window below, or left of, its centre."""
    return (size - 1) // 2
