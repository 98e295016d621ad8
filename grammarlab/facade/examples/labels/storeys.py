"""Storeys of examples that have fewer kinds of them than a new grid: a ground floor is not repeated above itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.facade.examples.label_grid import HOLE, LabelGrid, Labels
from grammarlab.facade.looks import is_door

_UPPER = 3
"""Upper storeys that stand for any number: over the ground floor, between others, and at the top."""


def touches_ground(name: str) -> bool:
    """Whether a unit with this name is a door or a shop."""
    return is_door(name) or "shop" in name.lower()


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
    low = np.array([touches_ground(name) for name in examples[0].names])
    often, ground, top = (np.zeros(size, dtype=np.int64) for _ in range(3))
    for example in examples:
        number, floor, roof = (label_numbers(part, size) for part in (example.labels, *example.labels[[0, -1]]))
        often += number
        ground += floor if example.rows > 1 else floor * low
        top += roof * (example.rows > 2)
    allowed = np.ones((rows, size), dtype=np.bool_)
    allowed[1:, (ground > 0) & (ground == often)] = False
    allowed[:-1, (top > 0) & (top == often)] = False
    return allowed


def label_numbers(labels: Labels, size: int) -> Labels:
    """[size] number of cells with each label."""
    return np.bincount(labels[labels >= 0].ravel(), minlength=size)


def storey_notes(examples: Sequence[LabelGrid], regions: Labels) -> tuple[str, ...]:
    """Statements in words about doors and shops in the upper rows of a grid, if all examples have one row."""
    if len(regions) == 1 or regions.max() >= 0 or any(example.rows > 1 for example in examples):
        return ()
    labels = {label for example in examples for label in example.labels[example.labels != HOLE].tolist()}
    low = [touches_ground(examples[0].names[label]) for label in labels]
    if not any(low):
        return ()
    if all(low):
        return ("the example has one storey of doors and shops only, so they are repeated above the ground floor",)
    return ("the example has one storey; storeys above it are the same without its doors and shops",)


def _raised(example: LabelGrid, regions: Labels, number: int) -> LabelGrid:
    rows = len(regions)
    if example.rows > 2 or rows <= example.rows:
        return example
    upper = example.labels[-1]
    if example.rows == 1 and (number in regions[0] or number not in regions):
        upper = _upper_row(example)
    return replace(example, labels=np.vstack([example.labels[:1], *[upper[None]] * _UPPER]))


def _upper_row(example: LabelGrid) -> Labels:
    """[columns] the only row of an example without units that touch the ground."""
    row = example.labels[0]
    low = np.array([*(touches_ground(name) for name in example.names), True])[row]  # index -1 is the hole's
    if low.all():
        return row
    others = np.flatnonzero(~low)
    nearest = others[np.searchsorted((others[:-1] + others[1:]) / 2.0, np.arange(len(row)))]
    return np.where(row == HOLE, HOLE, row[nearest])
