"""Panels of a solved layout: shapes at the crossings of horizontal and vertical letters of a layer."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from grammarlab.facade.layers.designs.design import Design, Layer, Shape
from grammarlab.facade.layers.letters import Word
from grammarlab.facade.layers.solving import Layout
from grammarlab.facade.tree import Floats, Ints, X, Y

_SLIVER = 1e-7
"""Largest difference of equal coordinates and least width of panels, as a fraction of the canvas."""

_LEAST_SHARE = 0.4
"""Least share of its cell that a shape takes along an axis, for any inset."""

Rectangle = tuple[int, int, int, int]
"""Line indices of left, bottom, right and top."""


@dataclass(frozen=True, slots=True)
class Panel:
    """A shape of a layer."""

    layer: int
    """Index among the layers that are on, from the topmost down."""
    symbols: tuple[str, str]
    """Horizontal and vertical symbol."""
    shape: Shape
    lines: Rectangle
    opaque: bool
    """Whether it hides the layers below it."""


@dataclass(frozen=True, eq=False)
class Panels:
    """All panels of a layout that are at least partly visible, from the topmost layer down."""

    lines: tuple[Floats, Floats]
    """Coordinates along x and y, metres, ascending, from 0 to the end of the canvas."""
    panels: tuple[Panel, ...]

    @cached_property
    def topmost(self) -> Ints:
        """[rows, columns] index of the panel in front in each cell between lines; -1 for none."""
        front = np.full((len(self.lines[Y]) - 1, len(self.lines[X]) - 1), -1, dtype=np.int64)
        for number in range(len(self.panels) - 1, -1, -1):
            front[_cells(self.panels[number].lines)] = number
        return front

    def seen(self) -> list[list[Rectangle]]:
        """For each panel, rectangles of all cells without an opaque panel above it."""
        hidden = np.zeros(self.topmost.shape, dtype=bool)
        found = []
        for panel in self.panels:
            found.append(rectangles(~hidden[_cells(panel.lines)], panel.lines))
            if panel.opaque:
                hidden[_cells(panel.lines)] = True
        return found


def panels_of(design: Design, layout: Layout, width: float, height: float) -> Panels:
    """Panels of a layout.

    Args:
        design: the solved design.
        layout: its solution for this canvas.
        width: width of the canvas, metres.
        height: height of the canvas, metres.
    """
    canvas = (width, height)
    along = [_places(design, layout, axis) for axis in (X, Y)]
    lines = tuple(_merged(np.concatenate([each[1].ravel() for each in along[axis]]), canvas[axis]) for axis in (X, Y))
    panels: list[Panel] = []
    for number, layer in enumerate(design.visible_layers):
        across, up = (_seen(layer, axis, *along[axis][number], lines[axis]) for axis in (X, Y))
        panels += [
            Panel(
                number,
                (column[0], row[0]),
                design.shape(layer, column[0], row[0]),
                (column[2], row[2], column[3], row[3]),
                column[1] and row[1],
            )
            for row in up
            for column in across
        ]
    return _inset(Panels((lines[X], lines[Y]), tuple(panels)))


def _inset(panels: Panels) -> Panels:
    """Shapes that are smaller than their cells, each with its frame below it."""
    if not any(any(panel.shape.inset) for panel in panels.panels):
        return panels
    boxes = [_box(panel, panels.lines) for panel in panels.panels]
    sides = np.array(boxes).reshape(-1, 2, 2)
    lines = tuple(
        _merged(np.concatenate([panels.lines[axis], sides[:, :, axis].ravel()]), panels.lines[axis][-1])
        for axis in (X, Y)
    )
    found: list[Panel] = []
    for panel, box in zip(panels.panels, boxes, strict=True):
        left, bottom, right, top = panel.lines
        place = panels.lines[X][left], panels.lines[Y][bottom], panels.lines[X][right], panels.lines[Y][top]
        whole, inner = _nearest(place, (lines[X], lines[Y])), _nearest(box, (lines[X], lines[Y]))
        found.append(replace(panel, lines=inner))
        if inner != whole and panel.shape.frame:
            found.append(replace(panel, lines=whole, shape=Shape(panel.shape.frame)))
    return Panels((lines[X], lines[Y]), tuple(found))


def _box(panel: Panel, lines: tuple[Floats, Floats]) -> tuple[float, float, float, float]:
    """Coordinates of a shape in its cell, metres; at least a part of the cell remains."""
    found = []
    for axis in (X, Y):
        low, high = (float(lines[axis][panel.lines[side]]) for side in (axis, axis + 2))
        before, after = panel.shape.inset[axis], panel.shape.inset[axis + 2]
        share = min(1.0, (1.0 - _LEAST_SHARE) * (high - low) / (before + after)) if before + after else 0.0
        found.append((low + share * before, high - share * after))
    (left, right), (bottom, top) = found
    return left, bottom, right, top


def _nearest(box: tuple[float, float, float, float], lines: tuple[Floats, Floats]) -> Rectangle:
    """Line indices of the sides of a box."""
    left, bottom, right, top = (int(np.abs(lines[side % 2] - at).argmin()) for side, at in enumerate(box))
    return left, bottom, right, top


def rectangles(shown: NDArray[np.bool_], lines: Rectangle) -> list[Rectangle]:
    """Rectangles that cover the true cells [rows, columns] of a panel: runs of equal rows are merged."""
    left, bottom, _, top = lines
    if shown.all():
        return [lines]
    found: list[Rectangle] = []
    open_runs: dict[tuple[int, int], int] = {}
    for row in range(top - bottom + 1):
        runs = _runs(shown[row]) if row < top - bottom else []
        for run in [run for run in open_runs if run not in runs]:
            found.append((left + run[0], bottom + open_runs.pop(run), left + run[1], bottom + row))
        for run in runs:
            open_runs.setdefault(run, row)
    return found


def _runs(shown: NDArray[np.bool_]) -> list[tuple[int, int]]:
    steps = np.flatnonzero(np.diff(np.concatenate([[False], shown, [False]]).astype(np.int8)))
    return [(int(start), int(end)) for start, end in zip(steps[::2], steps[1::2], strict=True)]


def _cells(lines: Rectangle) -> tuple[slice, slice]:
    left, bottom, right, top = lines
    return slice(bottom, top), slice(left, right)


def _places(design: Design, layout: Layout, axis: int) -> list[tuple[Word, Floats]]:
    """For each layer that is on, its word and the ends of its letters [letters, 2], metres."""
    placed = dict(zip(layout.groups, layout.sizing.placed, strict=True))
    found, rows = [], dict[tuple[int, str], int]()
    for layer in design.visible_layers:
        group = (axis, layer.groups[axis])
        row = rows[group] = rows.get(group, -1) + 1
        ends = np.stack([placed[group].lower[row], placed[group].upper[row]], axis=1)
        found.append((layout.alignments[group].words[row], ends))
    return found


def _merged(ends: Floats, canvas: float) -> Floats:
    """Different coordinates within the canvas; nearly equal ones are merged."""
    inside = np.sort(np.clip(np.concatenate([[0.0, canvas], ends]), 0.0, canvas))
    kept = inside[np.concatenate([[True], np.diff(inside) > _SLIVER * canvas])]
    kept[-1] = canvas
    return kept


def _seen(layer: Layer, axis: int, word: Word, ends: Floats, lines: Floats) -> list[tuple[str, bool, int, int]]:
    """Visible letters: symbol, whether it is opaque, and line indices of its ends."""
    mask = layer.masks[axis]
    first, last = (np.abs(lines[:, None] - np.clip(side, lines[0], lines[-1])).argmin(axis=0) for side in ends.T)
    return [
        (letter.symbol, letter.opaque, int(start), int(end))
        for letter, start, end in zip(word, first, last, strict=True)
        if start < end and not letter.transparent and (mask is None or letter.symbol in mask)
    ]
