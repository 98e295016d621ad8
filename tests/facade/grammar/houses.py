"""Facades with obvious counts."""

from collections.abc import Sequence

import numpy as np

from grammarlab.facade.tree import LEAF, Facade, X, Y, laid_out, plain

WIDTHS = {"W": 1.1, "B": 1.6, "D": 1.1}
LABELS = {"W": "window", "B": "window", "D": "door"}


def house(columns: int, rows: int) -> Facade:
    """Rows of equal windows with wall between them, a door in the middle of the lowest row, a cornice on top."""
    lowest = ["W"] * columns
    lowest[columns // 2] = "D"
    return of_columns(["".join(lowest), *["W" * columns] * (rows - 1)])


def of_columns(rows: Sequence[str], pier: float = 0.9, last: float = 0.9) -> Facade:
    """Rows, from the bottom up, of windows (W), broad windows (B) and doors (D), with wall between them."""
    parent, axis, names, wanted = [-1], [Y], [""], [[1.0, 1.0]]

    def add(above: int, along: int, name: str, width: float, height: float) -> int:
        parent.append(above)
        axis.append(along)
        names.append(name)
        wanted.append([width, height])
        return len(parent) - 1

    add(0, LEAF, "wall", 1.0, 0.8)
    for row in rows:
        above = add(0, X, "", 1.0, 1.0)
        for kind in row:
            add(above, LEAF, "wall", pier, 1.5)
            add(above, LEAF, LABELS[kind], WIDTHS[kind], 1.5)
        add(above, LEAF, "wall", last, 1.5)
        add(0, LEAF, "wall", 1.0, 1.2)
    add(0, LEAF, "cornice", 1.0, 0.4)
    position, size = laid_out(np.array(parent), np.array(axis, dtype=np.int8), np.array(wanted))
    return plain(np.array(parent), np.array(axis, dtype=np.int8), position, size, names)
