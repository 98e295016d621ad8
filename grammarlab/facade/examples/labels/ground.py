"""Units of the ground floor that a new grid keeps unless wishes say otherwise: a door that occurs once stays single."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import FacadeError
from grammarlab.facade.examples.label_grid import LabelGrid
from grammarlab.facade.examples.labels.counts import Domain, LabelCount, forced_cells, label_count
from grammarlab.facade.examples.labels.storeys import label_numbers, touches_ground
from grammarlab.facade.examples.wishes import Count, Wishes
from grammarlab.facade.looks import is_door

_Mask = NDArray[np.bool_]


def ground_labels(examples: Sequence[LabelGrid]) -> list[tuple[int, bool]]:
    """Labels that only the ground floor has, and whether each occurs at most once per example.

    A label is one of them if it is a door by its name, or if the ground floor has it only between its corners and
    repeats another label there. In an example of one row, only doors and shops are labels of the ground floor.

    Returns:
        Labels that occur once first, and doors first among them.
    """
    size = len(examples[0].names)
    door = np.array([is_door(name) for name in examples[0].names])
    low = np.array([touches_ground(name) for name in examples[0].names])
    often, most, floor, inner, grounded = (np.zeros(size, dtype=np.int64) for _ in range(5))
    for example in examples:
        number = label_numbers(example.labels, size)
        between = label_numbers(example.labels[0, _between_corners(example)], size)
        often, most = often + number, np.maximum(most, number)
        floor, inner = floor + label_numbers(example.labels[0], size), inner + between
        grounded += between if example.rows > 1 else between * low
    repeats = bool((often[inner > 0] > 1).any())
    special = (often > 0) & (((grounded == often) & repeats) | ((floor == often) & door))
    labels = [(int(label), bool(most[label] == 1)) for label in np.flatnonzero(special)]
    return sorted(labels, key=lambda pair: (not pair[1], not door[pair[0]]))


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
    kept: list[LabelCount] = []
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
            kept.append(count)
            least += 1
    return kept, notes


def _count(
    domain: Domain, example: LabelGrid, label: int, once: bool, symmetric: bool, above: int
) -> LabelCount | None:
    """One on the ground floor, besides those that wishes or a map put above it; None if there is no room."""
    forced = forced_cells(domain, label).sum(axis=1)
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


def _filling(examples: Sequence[LabelGrid], single: _Mask) -> _Mask:
    """[labels] the labels beside units that occur once, except special ends without shops; or else those above them."""
    size = len(single)
    low = np.array([touches_ground(name) for name in examples[0].names])
    beside, above = np.zeros(size, dtype=np.bool_), np.zeros(size, dtype=np.bool_)
    for example in examples:
        places = [column for column in range(example.columns) if not _special_end(example, column)]
        plain = (label_numbers(example.labels[0, places], size) > 0) | (
            low & (label_numbers(example.labels[0], size) > 0)
        )
        beside |= plain & ~_of_one_end(example, size)
        above |= label_numbers(example.labels[1:2, _between_corners(example)], size) > 0
    beside &= ~single
    return beside if beside.any() else above & ~single


def _open_ends(domain: Domain, examples: Sequence[LabelGrid], label: int, fixed: Collection[tuple[int, int]]) -> None:
    """Allows a label in the end columns of the ground floor if no cell may have it and they are like others."""
    if domain[:, :, label].any():
        return
    for column in (0, -1):
        cell = (0, column % domain.shape[1])
        if cell not in fixed and not all(_special_end(example, column % example.columns) for example in examples):
            domain[*cell, label] = True


def _special_end(example: LabelGrid, column: int) -> bool:
    """Whether a column is at an end and has upper units that no column between the ends has."""
    if 0 < column < example.columns - 1 or example.columns < 3:
        return False
    upper = example.labels[1:, column]
    return not np.isin(upper[upper >= 0], example.labels[:, 1:-1]).all()


def _of_one_end(example: LabelGrid, size: int) -> _Mask:
    """[labels] whether only the left end has a label, or only the right end; none of an example without an inside."""
    number = label_numbers(example.labels, size)
    ends = [label_numbers(example.labels[:, column], size) for column in (0, -1)]
    return (number > 0) & ((ends[0] == number) | (ends[1] == number)) & (example.columns > 2)


def _between_corners(example: LabelGrid) -> slice:
    """The columns between the ends; all columns of an example that has no others."""
    return slice(1, -1) if example.columns > 2 else slice(None)
