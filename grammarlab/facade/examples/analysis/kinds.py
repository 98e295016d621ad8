"""Which units of a wall are equal: labels of cells by what stands in them and how deep it lies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.facade.examples.analysis.elements import Elements, off_plane
from grammarlab.facade.examples.analysis.lattice import Lattice
from grammarlab.facade.examples.analysis.walls import Wall
from grammarlab.facade.examples.building.surface import Bools, Floats
from grammarlab.facade.examples.label_grid import LabelGrid

_SAME_SIZE, _NOISES = 0.02, 2.0
"""Metres, and multiples of the noise, by which elements of equal units differ at most."""
_SAME_CELL = 0.08
"""Part by which cells of equal units differ at most; units are scaled to the size of their row and column anyway."""
_SAME_DEPTH, _DEPTH_NOISES = 0.03, 5.0
_DIFFERENT = 0.12
"""Part of what is off the plane from which depths that differ make another unit."""
_LEAST_AREA = 0.3
"""Square metres of which that part is taken at least."""
_GROUND, _DOOR_HEIGHT, _DOOR_WIDTH = 0.6, 1.8, 2.4
"""Metres: above the lowest point of the wall, least height, and width up to which something is a door."""


@dataclass(frozen=True, slots=True)
class _Cell:
    size: Floats
    boxes: Floats
    """[K, 4] low and high corners of its elements, from the middle of the cell."""
    depth: Floats
    """[h, w] metres before the plane."""
    off: Bools
    step: float


def label_grid(wall: Wall, elements: Elements, columns: Lattice, rows: Lattice) -> LabelGrid:
    """The label of each cell, with names by what it looks like: window, door, shop, wall, unit."""
    cells = _cells(wall, elements, columns, rows)
    labels = np.zeros((len(rows), len(columns)), dtype=np.int64)
    leaders: list[tuple[_Cell, bool]] = []
    for row, column in np.ndindex(labels.shape):
        cell = cells[row][column]
        for number, (leader, _) in enumerate(leaders):
            if _equal(cell, leader, wall.noise):
                labels[row, column] = number
                break
        else:
            labels[row, column] = len(leaders)
            leaders.append((cell, row == 0 and rows.line[0] + 0.0 <= wall.low[1] + 4.0))
    return LabelGrid.of(labels, _names([_name(cell, low, wall, rows) for cell, low in leaders]))


def _cells(wall: Wall, elements: Elements, columns: Lattice, rows: Lattice) -> list[list[_Cell]]:
    off, map_ = off_plane(wall), wall.map
    depth = np.where(np.isfinite(map_.depth), map_.depth - wall.depth, -9.0)
    found = []
    for row in range(len(rows)):
        found.append([])
        for column in range(len(columns)):
            low = np.array([columns.line[column], rows.line[row]])
            high = np.array([columns.line[column + 1], rows.line[row + 1]])
            own = np.flatnonzero((columns.member == column) & (rows.member == row))
            boxes = np.hstack([elements.low[own], elements.high[own]]) - np.tile((low + high) / 2.0, 2)
            part = map_.rows(low[1], high[1]), map_.columns(low[0], high[0])
            boxes = boxes[np.lexsort(boxes.T[::-1])]
            found[-1].append(_Cell(high - low, boxes, depth[part], off[part], map_.step))
    return found


def _equal(a: _Cell, b: _Cell, noise: float) -> bool:
    if len(a.boxes) != len(b.boxes) or (np.abs(a.size - b.size) > _SAME_CELL * np.maximum(a.size, b.size)).any():
        return False
    if len(a.boxes):
        sizes = [each.boxes[:, 2:] - each.boxes[:, :2] for each in (a, b)]
        if np.abs(sizes[0] - sizes[1]).max() > _SAME_SIZE + _NOISES * noise:
            return False
    height, width = (min(a.depth.shape[axis], b.depth.shape[axis]) for axis in (0, 1))
    if not height * width:
        return True
    shown = [each[_middle(each, height, width)] for each in (a.depth, b.depth)]
    masks = [each[_middle(each, height, width)] for each in (a.off, b.off)]
    differs = np.abs(np.clip(shown[0], -1.0, 2.0) - np.clip(shown[1], -1.0, 2.0)) > _SAME_DEPTH + _DEPTH_NOISES * noise
    area = max(float((masks[0] | masks[1]).sum()), _LEAST_AREA / a.step**2)
    return float(differs.sum()) <= _DIFFERENT * area


def _middle(values: Floats, height: int, width: int) -> tuple[slice, slice]:
    y, x = (values.shape[0] - height) // 2, (values.shape[1] - width) // 2
    return slice(y, y + height), slice(x, x + width)


def _name(cell: _Cell, is_low: bool, wall: Wall, rows: Lattice) -> str:
    if not len(cell.boxes):
        return "wall"
    if len(cell.boxes) > 1:
        return "unit"
    width, height = cell.boxes[0, 2:] - cell.boxes[0, :2]
    above = rows.line[0] + cell.boxes[0, 1] + cell.size[1] / 2.0 - wall.low[1]
    if is_low and above <= _GROUND and height >= _DOOR_HEIGHT:
        return "door" if width <= _DOOR_WIDTH else "shop"
    return "window"


def _names(names: list[str]) -> list[str]:
    """Names with numbers where one comes more than once."""
    return [
        name if (before := names[:place].count(name)) == 0 else f"{name}-{before + 1}"
        for place, name in enumerate(names)
    ]
