"""Wishes as sets of allowed labels, counts and symmetry; contradictions are reported in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from grammarlab.errors import FacadeError
from grammarlab.facade.examples.label_grid import LabelGrid, Labels
from grammarlab.facade.examples.wishes import Count, Rows, Wishes

Domain = NDArray[np.bool_]
_MOST_PLACED = 400
"""Largest number of units that are placed before the search; more are left to it."""


@dataclass(frozen=True, slots=True)
class LabelDemands:
    """Constraints of a grid."""

    domain: Domain
    """[rows, columns, labels] whether each cell may have each label."""
    counts: tuple[tuple[int, int, int], ...]
    """Label, least and largest count."""
    symmetric: bool
    equal_ends: tuple[int, ...] = ()
    """Rows whose first and last cell have the same label."""
    notes: tuple[str, ...] = ()
    """Defaults that could not be kept, in words."""

    def domain_kept(self, labels: Labels) -> bool:
        """Whether each cell has an allowed label."""
        rows, columns = np.indices(labels.shape)
        return bool(self.domain[rows, columns, labels].all())

    def broken(self, labels: Labels) -> int:
        """Lower bound of the number of cells that have to change before a grid satisfies all constraints."""
        rows, columns = np.indices(labels.shape)
        cells = int((~self.domain[rows, columns, labels]).sum())
        for label, least, most in self.counts:
            often = int((labels == label).sum())
            cells += max(0, least - often, often - most)
        cells += sum(int(labels[row, 0] != labels[row, -1]) for row in self.equal_ends)
        if self.symmetric:
            cells += int((labels != labels[:, ::-1]).sum()) // 2
        return cells


def demands_of(domain: Domain, examples: Sequence[LabelGrid], wishes: Wishes) -> LabelDemands:
    """Constraints from wishes and defaults.

    A wish takes precedence over the examples' borders: a label with a wish for a row is allowed there.

    Args:
        domain: [rows, columns, labels] labels that the examples have at the same borders.
        examples: examples with one numbering of labels.
        wishes: wishes for the grid.

    Raises:
        FacadeError: If labels are unknown, cells are outside of the grid, or wishes contradict each other.
    """
    found = _only(domain.copy(), examples[0], wishes)
    found = _fixed(found, examples[0], wishes)
    fixed = {(wish.row, wish.column): wish.label for wish in wishes.fixed}
    rows, columns = found.shape[:2]
    wide = _only(np.broadcast_to(domain.any(axis=(0, 1)), domain.shape).copy(), examples[0], wishes)
    for count in wishes.counts:
        _make_way(found, wide, examples[0].label(count.label), count.most, fixed)
    if wishes.equal_corners or wishes.symmetric:
        pairs = {(row, 0) for row in (0, rows - 1)} if wishes.equal_corners else set()
        pairs |= set(np.ndindex(rows, columns // 2)) if wishes.symmetric else set()
        for row, column in sorted(pairs):
            _agree(found, (row, column), (row, columns - 1 - column), fixed)
    counts = [_counted(found, examples[0], count, wishes.symmetric) for count in wishes.counts]
    _check_room(found, examples[0].names, counts)
    least = sum(count[1] for count in counts)
    notes = []
    if wishes.keep:
        wished = {label for label, _, _ in counts}
        for label, once in sorted(ground_labels(examples), key=lambda each: not each[1]):
            name = examples[0].names[label]
            if label in wished:
                continue
            able = int(found[:, :, label].sum())
            tried = (1, 2) if once else (max(1, able),)  # symmetric grids may only have room for a pair
            for most in tried if least < max(1, columns - 2) else ():
                try:
                    counts.append(_counted(found, examples[0], Count(name, 1, most), wishes.symmetric))
                except FacadeError:
                    continue
                least += 1
                break
            else:
                notes.append(f"{name} is on the ground floor of the example; there is no room for it here")
    counts.sort(key=lambda each: each[2])
    ends = tuple(sorted({0, rows - 1})) if wishes.equal_corners else ()
    return LabelDemands(found, tuple(counts), wishes.symmetric, ends, tuple(notes))


def _make_way(domain: Domain, wide: Domain, label: int, most: int, fixed: Mapping[tuple[int, int], str]) -> None:
    """Cells whose only label has a largest count below their number get the labels that any cell may have."""
    forced = domain[:, :, label] & (domain.sum(axis=2) == 1)
    if int(forced.sum()) > max(0, most):
        for cell in map(tuple, np.argwhere(forced).tolist()):
            if cell not in fixed:
                domain[cell] = wide[cell]


def _check_room(domain: Domain, names: tuple[str, ...], counts: Sequence[tuple[int, int, int]]) -> None:
    """Checks that all counts fit together, not only one by one."""
    wanted = np.array([label for label, least, _ in counts for _ in range(least)], dtype=np.int64)
    if not 0 < len(wanted) <= _MOST_PLACED:
        return
    refused = ~domain.reshape(-1, domain.shape[2]).T[wanted]  # [wanted, cells]
    if len(wanted) > refused.shape[1] or refused[linear_sum_assignment(refused)].any():
        text = ", ".join(f"{names[label]} at least {least} times" for label, least, _ in counts if least)
        raise FacadeError(f"wishes: {text}: there is not enough room for all of these together.")


def ground_labels(examples: Sequence[LabelGrid]) -> list[tuple[int, bool]]:
    """Labels that only the ground floor has, between its corners, and whether each occurs at most once per example."""
    size = len(examples[0].names)
    tall = [example.labels for example in examples if example.rows > 1]
    inner = np.zeros(size, dtype=np.int64)
    often, most = np.zeros(size, dtype=np.int64), np.zeros(size, dtype=np.int64)
    for labels in tall:
        most = np.maximum(most, np.bincount(labels[labels >= 0], minlength=size))
        inner += np.bincount(labels[0, 1:-1][labels[0, 1:-1] >= 0], minlength=size)
        often += np.bincount(labels[labels >= 0], minlength=size)
    if not (often[inner > 0] > 1).any():  # nothing repeats there, so no label is special
        return []
    return [(int(label), bool(most[label] == 1)) for label in np.flatnonzero((inner > 0) & (inner == often))]


def _only(domain: Domain, example: LabelGrid, wishes: Wishes) -> Domain:
    for wish in wishes.only:
        label = example.label(wish.label)
        rows = _rows(wish.rows, len(domain))
        if not rows.any():
            raise FacadeError(
                f"wishes: {wish.label} only {wish.rows}, but a grid of {len(domain)} rows has no such row."
            )
        if not domain[rows, :, label].any():
            domain[rows, :, label] = True
        alone = domain.sum(axis=2) == 1
        alone &= domain[:, :, label] & ~rows[:, None]
        domain[alone] = domain.any(axis=(0, 1))
        domain[~rows, :, label] = False
    empty = np.argwhere(~domain.any(axis=2))
    if len(empty):
        row, column = empty[0].tolist()
        text = ", ".join(f"{wish.label} only {wish.rows}" for wish in wishes.only)
        raise FacadeError(f"wishes: {text}: no label is left for row {row}, column {column}.")
    return domain


def _rows(where: Rows, rows: int) -> NDArray[np.bool_]:
    place = np.arange(rows)
    if where == "ground":
        return place == 0
    return place == rows - 1 if where == "top" else (place > 0) & (place < rows - 1)


def _fixed(domain: Domain, example: LabelGrid, wishes: Wishes) -> Domain:
    seen: dict[tuple[int, int], str] = {}
    rows, columns = domain.shape[:2]
    for wish in wishes.fixed:
        cell = (wish.row, wish.column)
        if not (0 <= wish.row < rows and 0 <= wish.column < columns):
            raise FacadeError(
                f"wishes: row {wish.row}, column {wish.column} is fixed; the grid has rows 0 to {rows - 1} and "
                f"columns 0 to {columns - 1}."
            )
        if seen.setdefault(cell, wish.label) != wish.label:
            raise FacadeError(
                f"wishes: row {wish.row}, column {wish.column} cannot be both {seen[cell]} and {wish.label}."
            )
        label = example.label(wish.label)
        for only in wishes.only:
            if only.label == wish.label and not _rows(only.rows, rows)[wish.row]:
                raise FacadeError(f"wishes: {wish.label} only {only.rows}, but row {wish.row} has one.")
        domain[cell] = False
        domain[wish.row, wish.column, label] = True
    return domain


def _agree(domain: Domain, one: tuple[int, int], other: tuple[int, int], fixed: dict[tuple[int, int], str]) -> None:
    """Two cells get their common labels, or the labels of either if there are none; a fixed cell determines both."""
    both = domain[one] & domain[other]
    if not both.any():
        if one in fixed and other in fixed:
            raise FacadeError(
                f"wishes: row {one[0]}: column {one[1]} is fixed to {fixed[one]} and column {other[1]} to "
                f"{fixed[other]}, but they have to be equal."
            )
        both = domain[one] if one in fixed else domain[other] if other in fixed else domain[one] | domain[other]
    domain[one] = domain[other] = both


def _counted(domain: Domain, example: LabelGrid, count: Count, symmetric: bool) -> tuple[int, int, int]:
    label = example.label(count.label)
    text = f"{count.label} {count.least} to {count.most} times"
    if count.least < 0 or count.most < count.least:
        raise FacadeError(f"wishes: {text}; expected counts of at least 0, the first at most the second.")
    able = int(domain[:, :, label].sum())
    if able < count.least:
        raise FacadeError(f"wishes: {text}, but only {able} cells may be {count.label}.")
    forced = int((domain[:, :, label] & (domain.sum(axis=2) == 1)).sum())
    if forced > count.most:
        raise FacadeError(f"wishes: {text}, but {forced} cells can only be {count.label}.")
    columns = domain.shape[1]
    odd = columns % 2 == 1 and domain[:, columns // 2, label].any()
    if symmetric and count.least == count.most and count.least % 2 == 1 and not odd:
        raise FacadeError(f"wishes: symmetric and {text} contradict each other: an odd number needs a middle column.")
    return label, count.least, count.most
