"""Columns of an alignment while it is searched for: what their elements so far allow and cost."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from grammarlab.facade.layers.alignment.rows import EMPTY, OPAQUE, RowStep


class Column(NamedTuple):
    """A column, or the upper elements of one."""

    steps: tuple[RowStep, ...]
    low: int
    """Smallest fixed element, units; 0 for an unexplained gap; -1 before the first."""
    high: int
    """Widest element, units."""
    fixed: bool
    opaque: bool
    partial: int
    """Rows with elements that cover only a part, as bits."""
    protected: int
    """Rows whose elements must not cover only a part, as bits."""
    price: int
    """Price of merged letters."""


START = Column(steps=(), low=-1, high=0, fixed=False, opaque=False, partial=0, protected=0, price=0)
"""A column without elements."""


def column_size(column: Sequence[RowStep]) -> tuple[int, int, bool]:
    """Error and width of a column, in units, and whether an element of it is fixed."""
    low, high, fixed, opaque = -1, 0, False, False
    for step in column:
        if step.fixed and (step.kind != EMPTY or not opaque):
            low = step.size if low < 0 else min(low, step.size)
        high, opaque = max(high, step.size), opaque or step.kind == OPAQUE
        fixed = fixed or (step.fixed and step.kind != EMPTY)
    return (high - low if low >= 0 else 0), high, fixed
