"""Closed buildings whose units are known: boxes with recessed windows, and a door, in one mesh without T-junctions."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

WINDOW, DOOR = (1.2, 1.5), 0.3
"""Width and height of windows, and the height of the bottom of doors above the ground, metres."""
SILL, RECESS, MARGIN, BASE, TOP = 0.8, 0.2, 1.0, 0.6, 0.8


@dataclass(frozen=True, eq=False)
class House:
    """A mesh and its known contents."""

    points: NDArray[np.float64]
    triangles: NDArray[np.int64]
    labels: NDArray[np.int64]
    """[rows, columns] of the front: 0 for windows, 1 for the door, 2 for broad windows; row 0 at the bottom."""
    pitch: tuple[float, float]

    def write(self, path: Path, digits: int = 9) -> Path:
        """The mesh as an OBJ file."""
        lines = [f"v {x:.{digits}f} {y:.{digits}f} {z:.{digits}f}" for x, y, z in self.points.tolist()]
        lines += [f"f {a} {b} {c}" for a, b, c in (self.triangles + 1).tolist()]
        path.write_text("\n".join(lines) + "\n")
        return path


def house(
    columns: int = 6,
    rows: int = 6,
    side: int = 4,
    *,
    pitch: float = 3.0,
    storey: float = 3.0,
    door: int | None = 3,
    broad: tuple[tuple[int, int], ...] = (),
    noise: float = 0.0,
    seed: int = 0,
) -> House:
    """A house with windows on all four sides, y up, its front to z.

    Args:
        columns: of the front and the back.
        rows: storeys.
        side: columns of the other walls.
        pitch: metres between columns.
        storey: metres between rows.
        door: column of the front whose lowest window is a door; None for no door.
        broad: rows and columns of the front with windows 1.5 times as wide.
        noise: largest error of each coordinate, metres.
        seed: seed of the noise.
    """
    ends = {0.0, BASE + rows * storey + TOP}
    ends |= {BASE + r * storey + SILL + at for r in range(rows) for at in (0.0, WINDOW[1])}
    ys = sorted(ends | {DOOR})
    width, depth = (2 * MARGIN + number * pitch for number in (columns, side))
    mesh = _Mesh()
    front: set[float] = set()
    corners = [(0.0, depth), (width, depth), (width, 0.0), (0.0, 0.0)]
    for turn, (number, length) in enumerate([(columns, width), (side, depth)] * 2):
        right = np.array([[1, 0, 0], [0, 0, -1], [-1, 0, 0], [0, 0, 1]][turn])
        out = np.array([[0, 0, 1], [1, 0, 0], [0, 0, -1], [-1, 0, 0]][turn])
        low = np.array([corners[turn][0], 0.0, corners[turn][1]])
        halves = {
            (r, c): WINDOW[0] / 2 * (1.5 if turn == 0 and (r, c) in broad else 1.0)
            for r in range(rows)
            for c in range(number)
        }
        lines = {MARGIN + pitch * (c + 0.5) + s * half for (_, c), half in halves.items() for s in (-1, 1)}
        # The back has the lines of the front too, so that the roof meets both without T-junctions.
        lines |= {width - x for x in front} if turn == 2 else set()
        front = lines if turn == 0 else front
        xs = sorted({0.0, length} | {round(x, 9) for x in lines})
        opening = np.zeros((len(ys) - 1, len(xs) - 1), dtype=bool)
        middle_y, middle_x = (np.array(each[:-1]) + np.diff(each) / 2 for each in (ys, xs))
        for (r, c), half in halves.items():
            bottom = DOOR if turn == 0 and r == 0 and c == door else BASE + r * storey + SILL
            top = BASE + r * storey + SILL + WINDOW[1]
            over = np.abs(middle_x - MARGIN - pitch * (c + 0.5)) < half
            opening |= ((middle_y > bottom) & (middle_y < top))[:, None] & over
        mesh.wall(low, right, out, xs, ys, opening)
    xs = sorted({x for x, _, z in mesh.corners if z == depth})
    zs = sorted({z for x, _, z in mesh.corners if x == width})
    for y, up in ((0.0, False), (ys[-1], True)):
        for a, b in pairwise(xs):
            for c, d in pairwise(zs):
                around = [(a, y, c), (a, y, d), (b, y, d), (b, y, c)]
                mesh.quad(around if up else around[::-1])
    labels = np.zeros((rows, columns), dtype=np.int64)
    for place in broad:
        labels[place] = 2
    if door is not None:
        labels[0, door] = 1
    points = np.array(list(mesh.corners))
    points = points + np.random.default_rng(seed).uniform(-noise, noise, points.shape)
    return House(points, np.array(mesh.triangles), labels, (pitch, storey))


class _Mesh:
    """Triangles over corners without duplicates."""

    def __init__(self) -> None:
        self.corners: dict[tuple[float, float, float], int] = {}
        self.triangles: list[tuple[int, int, int]] = []

    def quad(self, around: list[tuple[float, float, float]]) -> None:
        keys = [(round(x, 9) + 0.0, round(y, 9) + 0.0, round(z, 9) + 0.0) for x, y, z in around]
        a, b, c, d = (self.corners.setdefault(key, len(self.corners)) for key in keys)
        self.triangles += [(a, b, c), (a, c, d)]

    def wall(self, low, right, out, xs, ys, opening) -> None:
        def at(x: float, y: float, depth: float) -> tuple[float, float, float]:
            x_, y_, z_ = (low + right * x + out * depth + [0, y, 0]).tolist()
            return x_, y_, z_

        for i, j in np.ndindex(opening.shape):
            (x0, x1), (y0, y1) = xs[j : j + 2], ys[i : i + 2]
            d = -RECESS if opening[i, j] else 0.0
            self.quad([at(x0, y0, d), at(x1, y0, d), at(x1, y1, d), at(x0, y1, d)])
            if not opening[i, j]:
                continue
            if not opening[i, j - 1]:
                self.quad([at(x0, y0, 0), at(x0, y0, d), at(x0, y1, d), at(x0, y1, 0)])
            if not opening[i, j + 1]:
                self.quad([at(x1, y0, d), at(x1, y0, 0), at(x1, y1, 0), at(x1, y1, d)])
            if not opening[i - 1, j]:
                self.quad([at(x0, y0, 0), at(x1, y0, 0), at(x1, y0, d), at(x0, y0, d)])
            if not opening[i + 1, j]:
                self.quad([at(x0, y1, d), at(x1, y1, d), at(x1, y1, 0), at(x0, y1, 0)])
