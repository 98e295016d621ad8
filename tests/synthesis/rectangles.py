"""Rectangles in files of meshes: sheets, and a free-standing wall with boxes on it."""

from pathlib import Path

import numpy as np


def empty_file(path: Path) -> Path:
    path.write_text("")
    return path


def with_sheets(path: Path, *corners: list[list[float]]) -> Path:
    """A file with further rectangles, which touch nothing."""
    text = path.read_text()
    num = sum(line.startswith("v ") for line in text.splitlines())
    for rectangle in corners:
        text += "".join(f"v {x} {y} {z}\n" for x, y, z in rectangle) + f"f {num + 1} {num + 2} {num + 3} {num + 4}\n"
        num += 4
    path.write_text(text)
    return path


def box(x: float, y: float, z: float, depth: float = 0.15) -> list[list[list[float]]]:
    """A box of 1.5 x 1.8 m as rectangles."""
    corner = np.array([x, y, z]) + np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]) * [1.5, 1.8, 1.0]
    front = corner + np.array([0.0, 0.0, depth])
    sides = [[corner[k], corner[k - 1], front[k - 1], front[k]] for k in range(4)]
    return [np.array(each).tolist() for each in (corner[::-1], front, *sides)]


WALL = [[0.0, 0.0, 0.0], [20.0, 0.0, 0.0], [20.0, 14.0, 0.0], [0.0, 14.0, 0.0]]
BOXES = [part for y in (4.0, 7.5) for x in (3.5, 7.0, 10.5, 14.0) for part in box(x, y, 0.0)]
