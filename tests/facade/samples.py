"""Small facades, written as nested parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.facade.editing.grids import with_grid
from grammarlab.facade.tree import LEAF, Facade, X, Y, laid_out, plain


@dataclass(frozen=True)
class Node:
    axis: int
    parts: tuple[Node, ...] = ()
    label: str = ""
    size: tuple[float, float] = (1.0, 1.0)


def leaf(label: str, width: float = 1.0, height: float = 1.0) -> Node:
    return Node(LEAF, (), label, (width, height))


def across(*parts: Node, label: str = "") -> Node:
    """Parts from the left to the right."""
    return Node(X, parts, label)


def stacked(*parts: Node, label: str = "") -> Node:
    """Parts from the bottom to the top."""
    return Node(Y, parts, label)


def built(top: Node) -> Facade:
    parent, axis, names, sizes = [], [], [], []

    def visit(node: Node, above: int) -> None:
        number = len(parent)
        parent.append(above)
        axis.append(node.axis)
        names.append(node.label)
        sizes.append(node.size)
        for part in node.parts:
            visit(part, number)

    visit(top, -1)
    columns = np.array(parent), np.array(axis, dtype=np.int8)
    return plain(*columns, *laid_out(*columns, np.array(sizes)), names)


def windows(num_rows: int, num_columns: int, sizes: tuple[float, ...] = (1.0,), *, bays: bool = False) -> Facade:
    """A wall of windows with their grid, by storeys or by bays; the widths of the columns repeat."""
    widths = [sizes[column % len(sizes)] for column in range(num_columns)]
    total = sum(widths) + 0.5 * (num_columns + 1)
    if bays:
        columns = [
            stacked(*[leaf("wall", width)] + [leaf("window", width, 1.5), leaf("wall", width)] * num_rows)
            for width in widths
        ]
        gap = leaf("wall", 0.5, 2.5 * num_rows + 1)
        top = across(gap, *[part for column in columns for part in (column, gap)])
    else:
        gap = leaf("wall", 0.5, 1.5)
        row = across(gap, *[part for width in widths for part in (leaf("window", width, 1.5), gap)])
        band = leaf("wall", total)
        top = stacked(band, *[part for _ in range(num_rows) for part in (row, band)])
    facade = built(top)
    return with_grid(facade, "window", [node for node in facade.leaves if facade.name_of(node) == "window"])


def door_over_two_rows() -> Facade:
    """Three rows of three windows, the middle ones of the lower two replaced by one door (Figure 11)."""

    def bay() -> Node:
        return stacked(leaf("window", 1, 1), leaf("wall", 1, 1), leaf("window", 1, 1))

    lower = across(
        leaf("wall", 1, 3), bay(), leaf("wall", 1, 3), leaf("door", 1, 3), leaf("wall", 1, 3), bay(), leaf("wall", 1, 3)
    )
    gap, window = leaf("wall", 1, 1), leaf("window", 1, 1)
    upper = across(gap, window, gap, window, gap, window, gap)
    return built(stacked(lower, leaf("wall", 7, 1), upper, leaf("wall", 7, 1)))
