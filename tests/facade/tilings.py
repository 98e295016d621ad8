"""Small tilings, and a brute-force test whether straight cuts divide them."""

from collections.abc import Iterator

import numpy as np

from grammarlab.facade.tree import Facade

Box = tuple[int, int, int, int]
"""Left, bottom, right, top."""


def corners(boxes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return boxes[:, :2], boxes[:, 2:]


def tiling(facade: Facade) -> tuple[np.ndarray, list[str]]:
    """The leaves of a facade, with exactly equal coordinates at common sides."""
    low, high = facade.position[facade.leaves], (facade.position + facade.size)[facade.leaves]
    return np.round(np.hstack([low, high]) * 2**20) / 2**20, [facade.name_of(node) for node in facade.leaves]


def grid_tilings(side: int, most: int) -> Iterator[list[Box]]:
    """Every tiling of a grid of cells with at most this many rectangles."""

    def place(taken: frozenset[tuple[int, int]], boxes: list[Box]) -> Iterator[list[Box]]:
        free = next(((x, y) for y in range(side) for x in range(side) if (x, y) not in taken), None)
        if free is None:
            yield boxes
        elif len(boxes) < most:
            left, bottom = free
            for right in range(left + 1, side + 1):
                for top in range(bottom + 1, side + 1):
                    cells = {(x, y) for x in range(left, right) for y in range(bottom, top)}
                    if not cells & taken:
                        yield from place(taken | cells, [*boxes, (left, bottom, right, top)])

    yield from place(frozenset(), [])


def divides(boxes: list[Box], axis: int, line: float) -> bool:
    """Whether a line has boxes on both sides and crosses none."""
    sides = [(box[axis + 2] <= line) - (box[axis] >= line) for box in boxes]
    return 0 not in sides and len(set(sides)) == 2


def guillotine(boxes: list[Box]) -> bool:
    """Whether lines separate all boxes, by trying all."""
    if len(boxes) < 2:
        return True
    for axis in (0, 1):
        for line in {box[axis] for box in boxes}:
            if divides(boxes, axis, line):
                below = [box for box in boxes if box[axis + 2] <= line]
                return guillotine(below) and guillotine([box for box in boxes if box[axis] >= line])
    return False
