"""Derivation trees as rows for a page."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from grammarlab.runs.sample.trace import TreeRow

MOST_ROWS = 2000
"""Largest number of rows of a tree."""


def listed_tree(
    rows: Iterator[TreeRow], extra: Callable[[Sequence[int]], Sequence[Any]] = lambda _nodes: ()
) -> list[list[Any]]:
    """Rows as depth, symbol, note, line and details; what follows `MOST_ROWS` is counted.

    Args:
        rows: the rows of one tree.
        extra: further values of a row, from the nodes of its shapes.
    """
    listed: list[list[Any]] = []
    rest = 0
    for row in rows:
        if len(listed) == MOST_ROWS:
            rest += 1
            continue
        place = row.rule_at or row.made_at
        line = 0 if place is None else place.line
        listed.append([row.depth, row.symbol, row.note, line, " · ".join(row.details), *extra(row.nodes)])
    return listed + ([[1, "", f"… {rest:,} more rows", 0, "", *extra(())]] if rest else [])
