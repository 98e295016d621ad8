"""Facades as people draw boxes on photographs: nearly aligned, nearly of one size, and overlapping."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Drawing:
    boxes: np.ndarray
    """[N, 4] left, bottom, right, top, in pixels, y up."""
    names: list[str]
    size: tuple[int, int]
    rows: int
    columns: int


def drawing(seed: int, jitter: float = 2.0) -> Drawing:
    """Windows in rows and columns with sills, full-width cornices, a pillar, and a door over two rows."""
    randomness = np.random.default_rng(seed)
    rows, columns = int(randomness.integers(2, 7)), int(randomness.integers(2, 9))
    width, height = columns * 120 + 40, rows * 150 + 40
    boxes: list[list[float]] = [[0, 0, width, height]]
    names = ["facade"]

    def add(name: str, *sides: float) -> None:
        boxes.append(list(np.array(sides) + randomness.uniform(-jitter, jitter, 4)))
        names.append(name)

    door = int(randomness.integers(columns))
    for row in range(rows):
        for column in range(columns):
            left, bottom = 40 + 120 * column + 20, 40 + 150 * row + 30
            if column == door and row < 2:
                if row == 0:
                    add("door", left, 5, left + 60, bottom + 200)
                continue
            add("window", left, bottom, left + 60, bottom + 90)
            add("sill", left - 8, bottom - 8, left + 68, bottom + 1)
        if row > 1 and randomness.random() < 0.5:
            add("cornice", 4, 40 + 150 * row - 5, width - 4, 40 + 150 * row + 8)
    add("pillar", 4, 4, 24, height - 4)
    table = np.clip(np.array(boxes), 0, [width, height] * 2)
    return Drawing(table, names, (width, height), rows, columns)
