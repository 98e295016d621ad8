"""Wishes as sets of allowed labels, counts and symmetry; contradictions are reported in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import FacadeError
from grammarlab.synthesis.label_grid import LabelGrid, Labels, Rows, Wishes
from grammarlab.synthesis.labels.ground_floor import (
    Domain,
    check_room,
    keep_ground_units,
    label_count,
    make_way,
    rows_of_labels,
)


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
            count = int((labels == label).sum())
            cells += max(0, least - count, count - most)
        cells += sum(int(labels[row, 0] != labels[row, -1]) for row in self.equal_ends)
        if self.symmetric:
            cells += int((labels != labels[:, ::-1]).sum()) // 2
        return cells


def demands_of(domain: Domain, examples: Sequence[LabelGrid], wishes: Wishes, *, mapped: bool = False) -> LabelDemands:
    """Constraints from wishes and defaults.

    A wish takes precedence over the examples' borders: a label with a wish for a row is allowed there.

    Args:
        domain: [rows, columns, labels] labels that the examples have at the same borders.
        examples: examples with one numbering of labels.
        wishes: wishes for the grid.
        mapped: whether a map from cells to examples may put units of the ground floor above it.

    Raises:
        FacadeError: If labels are unknown, cells are outside of the grid, or wishes contradict each other.
    """
    anywhere = domain | (domain.any(axis=(0, 1)) & rows_of_labels(examples, len(domain))[:, None])
    narrowed = _only(domain.copy(), anywhere, examples[0], wishes)
    narrowed = _fixed(narrowed, examples[0], wishes)
    fixed = {(wish.row, wish.column): wish.label for wish in wishes.fixed}
    rows, columns = narrowed.shape[:2]
    wide = _only(anywhere.copy(), anywhere, examples[0], wishes)
    for count in wishes.counts:
        make_way(narrowed, wide, examples[0].label(count.label), count.most, fixed)
    if wishes.equal_corners or wishes.symmetric:
        pairs = {(row, 0) for row in (0, rows - 1)} if wishes.equal_corners else set()
        pairs |= set(np.ndindex(rows, columns // 2)) if wishes.symmetric else set()
        for row, column in sorted(pairs):
            _agree(narrowed, (row, column), (row, columns - 1 - column), fixed)
    counts = [label_count(narrowed, examples[0], count, wishes.symmetric) for count in wishes.counts]
    check_room(narrowed, examples[0].names, counts)
    notes: list[str] = []
    if wishes.keep:
        above = domain[1:].sum(axis=(0, 1)) if mapped else np.zeros(domain.shape[2], dtype=np.int64)
        ground_counts, notes = keep_ground_units(narrowed, examples, wishes, counts, above)
        counts += ground_counts
    counts.sort(key=lambda count: count[2])
    ends = tuple(sorted({0, rows - 1})) if wishes.equal_corners else ()
    return LabelDemands(narrowed, tuple(counts), wishes.symmetric, ends, tuple(notes))


def _only(domain: Domain, anywhere: Domain, example: LabelGrid, wishes: Wishes) -> Domain:
    """The domain with labels in the rows that wishes name; cells that lose their only label get those of `anywhere`."""
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
        domain[alone] = anywhere[alone]
        domain[~rows, :, label] = False
    empty = np.argwhere(~domain.any(axis=2))
    if len(empty):
        row, column = empty[0].tolist()
        text = ", ".join(f"{wish.label} only {wish.rows}" for wish in wishes.only)
        raise FacadeError(f"wishes: {text}: no label is left for row {row}, column {column}.")
    return domain


def _rows(where: Rows, rows: int) -> NDArray[np.bool_]:
    index = np.arange(rows)
    if where == "ground":
        return index == 0
    return index == rows - 1 if where == "top" else (index > 0) & (index < rows - 1)


def _fixed(domain: Domain, example: LabelGrid, wishes: Wishes) -> Domain:
    fixed_labels: dict[tuple[int, int], str] = {}
    rows, columns = domain.shape[:2]
    for wish in wishes.fixed:
        cell = (wish.row, wish.column)
        if not (0 <= wish.row < rows and 0 <= wish.column < columns):
            raise FacadeError(
                f"wishes: row {wish.row}, column {wish.column} is fixed; the grid has rows 0 to {rows - 1} and "
                f"columns 0 to {columns - 1}."
            )
        if fixed_labels.setdefault(cell, wish.label) != wish.label:
            raise FacadeError(
                f"wishes: row {wish.row}, column {wish.column} cannot be both {fixed_labels[cell]} and {wish.label}."
            )
        label = example.label(wish.label)
        for only in wishes.only:
            if only.label == wish.label and not _rows(only.rows, rows)[wish.row]:
                raise FacadeError(f"wishes: {wish.label} only {only.rows}, but row {wish.row} has one.")
        domain[cell] = False
        domain[wish.row, wish.column, label] = True
    return domain


def _agree(domain: Domain, a: tuple[int, int], b: tuple[int, int], fixed: dict[tuple[int, int], str]) -> None:
    """Two cells get their common labels, or the labels of either if there are none; a fixed cell determines both."""
    both = domain[a] & domain[b]
    if not both.any():
        if a in fixed and b in fixed:
            raise FacadeError(
                f"wishes: row {a[0]}: column {a[1]} is fixed to {fixed[a]} and column {b[1]} to "
                f"{fixed[b]}, but they have to be equal."
            )
        both = domain[a] if a in fixed else domain[b] if b in fixed else domain[a] | domain[b]
    domain[a] = domain[b] = both
