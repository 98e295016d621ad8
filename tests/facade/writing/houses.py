"""Facades that are easily counted."""

import numpy as np

from grammarlab.facade.tree import LEAF, Facade, X, Y, laid_out, plain


def house(columns: int, rows: int, door: int | None = None) -> Facade:
    """Rows of equal windows with wall between them, a door in the lowest row, a cornice on top."""
    parent, axis, names, wanted = [-1], [Y], [""], [[1.0, 1.0]]

    def add(above: int, along: int, name: str, width: float, height: float) -> int:
        parent.append(above)
        axis.append(along)
        names.append(name)
        wanted.append([width, height])
        return len(parent) - 1

    place_of_door = columns // 2 if door is None else door
    add(0, LEAF, "wall", 1.0, 0.8)
    for row in range(rows):
        above = add(0, X, "", 1.0, 1.0)
        for column in range(columns):
            add(above, LEAF, "wall", 0.9, 1.5)
            add(above, LEAF, "door" if row == 0 and column == place_of_door else "window", 1.1, 1.5)
        add(above, LEAF, "wall", 0.9, 1.5)
        add(0, LEAF, "wall", 1.0, 1.2)
    add(0, LEAF, "cornice", 1.0, 0.4)
    position, size = laid_out(np.array(parent), np.array(axis, dtype=np.int8), np.array(wanted))
    return plain(np.array(parent), np.array(axis, dtype=np.int8), position, size, names)
