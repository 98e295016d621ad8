"""Wishes of a person for the labels of a new facade."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Rows = Literal["ground", "top", "between"]


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
