"""Ground floors and storeys of a new grid of labels, and room for its counted labels.

Unless wishes say otherwise, units of the ground floor stay there, and a door that occurs once stays single. Examples
with fewer kinds of storeys than the new grid get more, so that a ground floor is not repeated above itself.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from grammarlab.arrays import Flags
from grammarlab.errors import FacadeError
from grammarlab.facade.looks import is_door
from grammarlab.synthesis.label_grid import HOLE, Count, LabelGrid, Labels, Wishes

Domain = NDArray[np.bool_]
LabelCount = tuple[int, int, int]
"""Label, least and largest count."""
_UPPER_STOREYS = 3
"""Upper storeys that stand for any number: over the ground floor, between others, and at the top."""
_MAX_PLACED_UNITS = 400
"""Largest number of units that are placed before the search; more are left to it."""


def with_upper_storeys(examples: Sequence[LabelGrid], regions: Labels) -> list[LabelGrid]:
    """The examples with their upper storeys repeated, as far as the new grid has rows that they lack.

    Rows between the lowest and the highest of an example with two rows are its upper row. The upper rows of an example
    with one row are this row, with the nearest other unit in place of doors and shops. They stay if there is no other
    unit, or if a map uses the example only above the ground floor.

    Args:
        examples: examples with one numbering of labels.
        regions: [rows, columns] example of each cell of the new grid, or -1 for any of them.
    """
    return [_raised(example, regions, number) for number, example in enumerate(examples)]


def rows_of_labels(examples: Sequence[LabelGrid], rows: int) -> NDArray[np.bool_]:
    """[rows, labels] rows of a new grid that may have each label: those of the ground or the top alone stay there."""
    size = len(examples[0].names)
    low = np.array([_touches_ground(name) for name in examples[0].names])
    total, ground, top = (np.zeros(size, dtype=np.int64) for _ in range(3))
    for example in examples:
        number, floor, roof = (_label_numbers(part, size) for part in (example.labels, *example.labels[[0, -1]]))
        total += number
        ground += floor if example.rows > 1 else floor * low
        top += roof * (example.rows > 2)
    allowed = np.ones((rows, size), dtype=np.bool_)
    allowed[1:, (ground > 0) & (ground == total)] = False
    allowed[:-1, (top > 0) & (top == total)] = False
    return allowed


def storey_notes(examples: Sequence[LabelGrid], regions: Labels) -> tuple[str, ...]:
    """Statements in words about doors and shops in the upper rows of a grid, if all examples have one row."""
    if len(regions) == 1 or regions.max() >= 0 or any(example.rows > 1 for example in examples):
        return ()
    labels = {label for example in examples for label in example.labels[example.labels != HOLE].tolist()}
    low = [_touches_ground(examples[0].names[label]) for label in labels]
    if not any(low):
        return ()
    if all(low):
        return ("the example has one storey of doors and shops only, so they are repeated above the ground floor",)
    return ("the example has one storey; storeys above it are the same without its doors and shops",)


def make_way(domain: Domain, wide: Domain, label: int, most: int, fixed: Collection[tuple[int, int]]) -> None:
    """Cells whose only label has a largest count below their number get those of a wider domain."""
    forced = _forced_cells(domain, label)
    if int(forced.sum()) > max(0, most):
        for row, column in np.argwhere(forced).tolist():
            if (row, column) not in fixed:
                domain[row, column] = wide[row, column]


def check_room(domain: Domain, names: tuple[str, ...], counts: Sequence[LabelCount]) -> None:
    """Checks that all counts fit together, not only one by one.

    Raises:
        FacadeError: If they do not.
    """
    required = np.array([label for label, least, _ in counts for _ in range(least)], dtype=np.int64)
    if not 0 < len(required) <= _MAX_PLACED_UNITS:
        return
    refused = ~domain.reshape(-1, domain.shape[2]).T[required]  # [required, cells]
    if len(required) > refused.shape[1] or refused[linear_sum_assignment(refused)].any():
        text = ", ".join(f"{names[label]} at least {least} times" for label, least, _ in counts if least)
        raise FacadeError(f"wishes: {text}: there is not enough room for all of these together.")


def keep_ground_units(
    domain: Domain,
    examples: Sequence[LabelGrid],
    wishes: Wishes,
    counts: Sequence[LabelCount],
    above: NDArray[np.int64],
) -> tuple[list[LabelCount], list[str]]:
    """Counts of the units of the ground floor, and notes about those that cannot be kept.

    Cells that could only have units that occur once get other units of the ground floor, or else those above it. If
    only end columns are there, units from between the corners may replace theirs, unless those are special.

    Args:
        domain: [rows, columns, labels] whether each cell may have each label; extended as described.
        examples: examples with one numbering of labels.
        wishes: wishes for the grid; labels with a count among them are left out.
        counts: counts from these wishes.
        above: [labels] number of cells above the ground floor in which a map allows each label.
    """
    names, columns = examples[0].names, domain.shape[1]
    counted = {label for label, _, _ in counts}
    labels = [(label, once) for label, once in ground_labels(examples) if label not in counted]
    fixed = {(wish.row, wish.column) for wish in wishes.fixed}
    filled = _fill(domain, examples, [label for label, once in labels if once], fixed)
    symmetric = wishes.symmetric or (wishes.equal_corners and columns == 2)
    least = sum(count[1] for count in counts)
    ground_counts: list[LabelCount] = []
    notes: list[str] = []
    for label, once in labels:
        if once and not filled:
            notes.append(f"{names[label]} occurs once in the example, which has no other unit for the ground floor")
            continue
        count = None
        if least < max(1, columns - 2):
            _open_ends(domain, examples, label, fixed)
            count = _count(domain, examples[0], label, once, symmetric, int(above[label]))
        if count is None:
            notes.append(f"{names[label]} is on the ground floor of the example; there is no room for it here")
        else:
            ground_counts.append(count)
            least += 1
    return ground_counts, notes


def ground_labels(examples: Sequence[LabelGrid]) -> list[tuple[int, bool]]:
    """Labels that only the ground floor has, and whether each occurs at most once per example.

    A label is one of them if it is a door by its name, or if the ground floor has it only between its corners and
    repeats another label there. In an example of one row, only doors and shops are labels of the ground floor.

    Returns:
        Labels that occur once first, and doors first among them.
    """
    size = len(examples[0].names)
    door = np.array([is_door(name) for name in examples[0].names])
    low = np.array([_touches_ground(name) for name in examples[0].names])
    total, most, floor, inner, grounded = (np.zeros(size, dtype=np.int64) for _ in range(5))
    for example in examples:
        number = _label_numbers(example.labels, size)
        between = _label_numbers(example.labels[0, _between_corners(example)], size)
        total, most = total + number, np.maximum(most, number)
        floor, inner = floor + _label_numbers(example.labels[0], size), inner + between
        grounded += between if example.rows > 1 else between * low
    repeats = bool((total[inner > 0] > 1).any())
    special = (total > 0) & (((grounded == total) & repeats) | ((floor == total) & door))
    labels = [(int(label), bool(most[label] == 1)) for label in np.flatnonzero(special)]
    return sorted(labels, key=lambda pair: (not pair[1], not door[pair[0]]))


def label_count(domain: Domain, example: LabelGrid, count: Count, symmetric: bool) -> LabelCount:
    """The count of a label, checked on its own.

    Args:
        domain: [rows, columns, labels] whether each cell may have each label.
        example: an example with the numbering of labels.
        count: name of the label, and its limits.
        symmetric: whether every row is a palindrome.

    Raises:
        FacadeError: If the label is unknown, or no grid can have so many or so few of it.
    """
    label = example.label(count.label)
    text = f"{count.label} {count.least} to {count.most} times"
    if count.least < 0 or count.most < count.least:
        raise FacadeError(f"wishes: {text}; expected counts of at least 0, the first at most the second.")
    able = int(domain[:, :, label].sum())
    if able < count.least:
        raise FacadeError(f"wishes: {text}, but only {able} cells may be {count.label}.")
    forced = int(_forced_cells(domain, label).sum())
    if forced > count.most:
        raise FacadeError(f"wishes: {text}, but {forced} cells can only be {count.label}.")
    columns = domain.shape[1]
    odd = columns % 2 == 1 and domain[:, columns // 2, label].any()
    if symmetric and count.least == count.most and count.least % 2 == 1 and not odd:
        raise FacadeError(f"wishes: symmetric and {text} contradict each other: an odd number needs a middle column.")
    return label, count.least, count.most


def _raised(example: LabelGrid, regions: Labels, number: int) -> LabelGrid:
    rows = len(regions)
    if example.rows > 2 or rows <= example.rows:
        return example
    upper = example.labels[-1]
    if example.rows == 1 and (number in regions[0] or number not in regions):
        upper = _upper_row(example)
    return replace(example, labels=np.vstack([example.labels[:1], *[upper[None]] * _UPPER_STOREYS]))


def _upper_row(example: LabelGrid) -> Labels:
    """[columns] the only row of an example without units that touch the ground."""
    row = example.labels[0]
    low = np.array([*(_touches_ground(name) for name in example.names), True])[row]  # index -1 is the hole's
    if low.all():
        return row
    others = np.flatnonzero(~low)
    nearest = others[np.searchsorted((others[:-1] + others[1:]) / 2.0, np.arange(len(row)))]
    return np.where(row == HOLE, HOLE, row[nearest])


def _touches_ground(name: str) -> bool:
    """Whether a unit with this name is a door or a shop."""
    return is_door(name) or "shop" in name.lower()


def _label_numbers(labels: Labels, size: int) -> Labels:
    """[size] number of cells with each label."""
    return np.bincount(labels[labels >= 0].ravel(), minlength=size)


def _forced_cells(domain: Domain, label: int) -> NDArray[np.bool_]:
    """[rows, columns] whether a label is the only one of a cell."""
    return domain[:, :, label] & (domain.sum(axis=2) == 1)


def _between_corners(example: LabelGrid) -> slice:
    """The columns between the ends; all columns of an example that has no others."""
    return slice(1, -1) if example.columns > 2 else slice(None)


def _fill(
    domain: Domain, examples: Sequence[LabelGrid], once: Sequence[int], fixed: Collection[tuple[int, int]]
) -> bool:
    """Gives other labels to cells of the ground floor that may only have labels that occur once, if they are more.

    Returns:
        Whether there are other labels, or none is needed.
    """
    single = np.isin(np.arange(domain.shape[2]), once)
    columns = np.arange(domain.shape[1])
    free = np.array([(0, column) not in fixed for column in columns.tolist()])
    ends = (columns == 0) | (columns == columns[-1])
    filling = _filling(examples, single)
    for part in (~ends, ends):
        bare = free & ~(domain[0] & ~single).any(axis=1)
        if int(bare.sum()) <= len(once):
            return True
        domain[0, bare & part] |= filling
    return bool(filling.any())


def _filling(examples: Sequence[LabelGrid], single: Flags) -> Flags:
    """[labels] the labels beside units that occur once, except special ends without shops; or else those above them."""
    size = len(single)
    low = np.array([_touches_ground(name) for name in examples[0].names])
    adjacent, above = np.zeros(size, dtype=np.bool_), np.zeros(size, dtype=np.bool_)
    for example in examples:
        columns = [column for column in range(example.columns) if not _special_end(example, column)]
        plain = (_label_numbers(example.labels[0, columns], size) > 0) | (
            low & (_label_numbers(example.labels[0], size) > 0)
        )
        adjacent |= plain & ~_of_one_end(example, size)
        above |= _label_numbers(example.labels[1:2, _between_corners(example)], size) > 0
    adjacent &= ~single
    return adjacent if adjacent.any() else above & ~single


def _special_end(example: LabelGrid, column: int) -> bool:
    """Whether a column is at an end and has upper units that no column between the ends has."""
    if 0 < column < example.columns - 1 or example.columns < 3:
        return False
    upper = example.labels[1:, column]
    return not np.isin(upper[upper >= 0], example.labels[:, 1:-1]).all()


def _of_one_end(example: LabelGrid, size: int) -> Flags:
    """[labels] whether only the left end has a label, or only the right end; none of an example without an inside."""
    number = _label_numbers(example.labels, size)
    ends = [_label_numbers(example.labels[:, column], size) for column in (0, -1)]
    return (number > 0) & ((ends[0] == number) | (ends[1] == number)) & (example.columns > 2)


def _open_ends(domain: Domain, examples: Sequence[LabelGrid], label: int, fixed: Collection[tuple[int, int]]) -> None:
    """Allows a label in the end columns of the ground floor if no cell may have it and they are like others."""
    if domain[:, :, label].any():
        return
    for column in (0, -1):
        cell = (0, column % domain.shape[1])
        if cell not in fixed and not all(_special_end(example, column % example.columns) for example in examples):
            domain[*cell, label] = True


def _count(
    domain: Domain, example: LabelGrid, label: int, once: bool, symmetric: bool, above: int
) -> LabelCount | None:
    """One on the ground floor, besides those that wishes or a map put above it; None if there is no room."""
    forced = _forced_cells(domain, label).sum(axis=1)
    floor = max(1, int(forced[0])) if once else 1
    least = max(1, (floor if domain[0, :, label].any() else 0) + int(forced[1:].sum()))
    # Symmetric grids may only have room for a pair.
    limits = (least + above, least + above + 1) if once else (max(least, int(domain[:, :, label].sum())),)
    for most in limits:
        try:
            return label_count(domain, example, Count(example.names[label], least, most), symmetric)
        except FacadeError:
            continue
    return None
