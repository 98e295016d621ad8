"""What a person asks of the labels of a new facade."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Rows = Literal["ground", "top", "between"]


@dataclass(frozen=True, slots=True)
class Count:
    """How often a label comes."""

    label: str
    least: int
    most: int


@dataclass(frozen=True, slots=True)
class Only:
    """A label that comes in these rows only."""

    label: str
    rows: Rows


@dataclass(frozen=True, slots=True)
class Fixed:
    """A cell with a label that is given."""

    row: int
    """From 0, at the bottom."""
    column: int
    """From 0, at the left."""
    label: str


@dataclass(frozen=True, slots=True)
class Wishes:
    """All that is asked of one facade; nothing, unless said."""

    counts: tuple[Count, ...] = ()
    only: tuple[Only, ...] = ()
    fixed: tuple[Fixed, ...] = ()
    equal_corners: bool = False
    """The left and the right corner of the lowest row have one label; so have those of the highest row."""
    symmetric: bool = False
    """Every row reads the same from both sides."""
    keep: bool = True
    """A unit of the ground floor that the example has once, such as its door, comes exactly once."""
