"""Scenes built by hand for the tests of scenes, files and pictures."""

from __future__ import annotations

import numpy as np

from grammarlab.derivation.materials import CHANNELS, Materials
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.scene import Scene

BOX, QUAD, CYLINDER, ROOF, SPHERE = range(5)
STONE, GLASS, TILE, FRAME, STEEL, LAMP = range(6)
UPRIGHT = np.eye(3)
TURNED = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])


def box() -> Meshes:
    points = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    return Meshes.single(points, [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])


def quad() -> Meshes:
    return Meshes.single(np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]]), [[0, 1, 2, 3]])


def cylinder(sides: int = 32) -> Meshes:
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = np.stack([0.5 + 0.5 * np.cos(angle), 0 * angle, 0.5 - 0.5 * np.sin(angle)], axis=1)
    following = [(i + 1) % sides for i in range(sides)]
    walls = [[i, following[i], sides + following[i], sides + i] for i in range(sides)]
    caps = [list(range(sides))[::-1], list(range(sides, 2 * sides))]
    return Meshes.single(np.concatenate([ring, ring + np.array([0, 1, 0])]), walls + caps)


def gable() -> Meshes:
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1], [0, 1, 0.5], [1, 1, 0.5]], dtype=float)
    return Meshes.single(points, [[0, 1, 2, 3], [3, 2, 5, 4], [1, 0, 4, 5], [0, 3, 4], [2, 1, 5]])


def sphere(rings: int = 16, sides: int = 32) -> Meshes:
    up = np.pi * np.arange(1, rings) / rings
    around = 2 * np.pi * np.arange(sides) / sides
    ring = np.stack(
        [
            np.outer(np.sin(up), np.cos(around)),
            np.outer(-np.cos(up), np.ones(sides)),
            np.outer(np.sin(up), -np.sin(around)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    points = np.concatenate([ring, [[0, -1, 0], [0, 1, 0]]]) / 2 + 0.5
    south, north = len(ring), len(ring) + 1

    def at(row: int, column: int) -> int:
        return row * sides + column % sides

    faces = [[south, at(0, i + 1), at(0, i)] for i in range(sides)]
    faces += [[north, at(rings - 2, i), at(rings - 2, i + 1)] for i in range(sides)]
    faces += [[at(r, i), at(r, i + 1), at(r + 1, i + 1), at(r + 1, i)] for r in range(rings - 2) for i in range(sides)]
    return Meshes.single(points, faces)


def materials(**channels: float) -> Materials:
    """The materials above; `channels` change the first of them."""
    defaults = list(CHANNELS.values())
    rows = np.array([defaults] * 6)
    rows[STONE, :3] = 0.86, 0.80, 0.69
    rows[GLASS, :6] = 0.30, 0.42, 0.50, 0.55, 0.0, 0.08
    rows[TILE, :3] = 0.62, 0.30, 0.22
    rows[FRAME, :3] = 0.96, 0.95, 0.92
    rows[STEEL, :6] = 0.75, 0.76, 0.78, 1.0, 1.0, 0.3
    rows[LAMP, 6:9] = 1.0, 0.8, 0.4
    for name, value in channels.items():
        rows[0, list(CHANNELS).index(name.replace("_", "."))] = value
    return Materials(rows, ("",) * len(rows))


Row = tuple[int, int, tuple[float, float, float], tuple[float, float, float], np.ndarray]


def house(width: float = 10.0, floors: int = 2) -> list[Row]:
    """A stone house with recessed windows, a gable roof, a porch of columns, a steel pipe and a lamp."""
    depth, storey = 8.0, 3.0
    height = floors * storey
    rows: list[Row] = [(BOX, STONE, (0, 0, 0), (width, height, depth), UPRIGHT)]
    rows.append((BOX, FRAME, (-0.2, height - 0.25, -0.2), (width + 0.4, 0.25, depth + 0.4), UPRIGHT))
    rows.append((ROOF, TILE, (-0.4, height, -0.4), (width + 0.8, 2.6, depth + 0.8), UPRIGHT))
    for floor in range(floors):
        for column in range(int(width // 2.5)):
            x, y = 0.7 + column * 2.5, floor * storey + 0.9
            rows.append((QUAD, GLASS, (x, y, depth + 0.02), (1.1, 1.5, 0), UPRIGHT))
            for left, bottom, wide, high in ((-0.1, 0, 0.1, 1.5), (1.1, 0, 0.1, 1.5), (-0.1, 1.5, 1.3, 0.1)):
                rows.append((BOX, FRAME, (x + left, y + bottom, depth), (wide, high, 0.12), UPRIGHT))
            rows.append((BOX, FRAME, (x - 0.2, y - 0.12, depth), (1.5, 0.12, 0.25), UPRIGHT))
        rows.append((QUAD, GLASS, (width + 0.02, floor * storey + 0.9, 5.0), (1.5, 1.5, 0), TURNED))
    rows += [(CYLINDER, FRAME, (x, 0, depth + 1.2), (0.35, 2.6, 0.35), UPRIGHT) for x in (0.6, 2.6)]
    rows.append((BOX, STONE, (0.3, 2.6, depth), (3.0, 0.2, 1.8), UPRIGHT))
    rows.append((CYLINDER, STEEL, (width - 1.5, height, depth / 2 + 1.5), (0.5, 3.0, 0.5), UPRIGHT))
    rows.append((SPHERE, LAMP, (1.6, 2.2, depth + 0.8), (0.3, 0.3, 0.3), UPRIGHT))
    return rows


def scene_of(models: list[list[Row]], table: Materials | None = None) -> Scene:
    """A batch from the shapes of each model."""
    rows = [row for model in models for row in model]
    return Scene(
        len(models),
        Meshes.concatenate([box(), quad(), cylinder(), gable(), sphere()]),
        table or materials(),
        np.repeat(np.arange(len(models), dtype=np.int32), [len(model) for model in models]),
        np.array([row[0] for row in rows], dtype=np.int32),
        np.array([row[1] for row in rows], dtype=np.int32),
        np.array([row[2] for row in rows], dtype=float).reshape(-1, 3),
        np.array([row[3] for row in rows], dtype=float).reshape(-1, 3),
        np.arange(len(rows), dtype=np.int32),
        np.array([row[4] for row in rows], dtype=float).reshape(-1, 3, 3),
        np.full(len(rows), -1, dtype=np.int32),
        np.zeros((0, 2, 4)),
        np.zeros((len(models), 3)),
    )


def street() -> Scene:
    """Three houses of different sizes."""
    return scene_of([house(), house(7.5, 3), house(15.0, 4)])
