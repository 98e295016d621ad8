"""Panels of a solved layout, shapes at the crossings of its letters, as a facade or as a scene."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.derivation.functions.color_functions import parse_color
from grammarlab.derivation.materials import CHANNELS, Materials
from grammarlab.facade.looks import THICKNESS, LabelLook, look_of
from grammarlab.facade.reading.assembling import OUTSIDE
from grammarlab.facade.reading.cutting import cut
from grammarlab.facade.reading.filling import WALL, fill
from grammarlab.facade.reading.overlaps import VisiblePieces
from grammarlab.facade.tree import Facade, X, Y
from grammarlab.geometry.meshes.primitives import box
from grammarlab.layers.design import Design, Layer, Shape, Word
from grammarlab.layers.solving import Layout
from grammarlab.scene.instances import Scene

Rectangle = tuple[int, int, int, int]
"""Line indices of left, bottom, right and top."""
_NEGLIGIBLE_SHARE = 1e-7
"""Largest difference of equal coordinates and least width of panels, as a fraction of the canvas."""
_LEAST_SHARE = 0.4
"""Least share of its cell that a shape takes along an axis, for any inset."""
_MIN_THICKNESS_M = 0.01
"""Least thickness of a box, metres."""


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

    def visible_rectangles(self) -> list[list[Rectangle]]:
        """For each panel, rectangles of all cells without an opaque panel above it."""
        hidden = np.zeros(self.topmost.shape, dtype=bool)
        visible = []
        for panel in self.panels:
            visible.append(rectangles(~hidden[_cells(panel.lines)], panel.lines))
            if panel.opaque:
                hidden[_cells(panel.lines)] = True
        return visible


def panels_of(design: Design, layout: Layout, width: float, height: float) -> Panels:
    """Panels of a layout.

    Args:
        design: the solved design.
        layout: its solution for this canvas.
        width: width of the canvas, metres.
        height: height of the canvas, metres.
    """
    canvas = (width, height)
    along = [_placed_words(design, layout, axis) for axis in (X, Y)]
    lines = tuple(
        _merged(np.concatenate([letters[1].ravel() for letters in along[axis]]), canvas[axis]) for axis in (X, Y)
    )
    panels: list[Panel] = []
    for number, layer in enumerate(design.visible_layers):
        across, up = (_visible_letters(layer, axis, *along[axis][number], lines[axis]) for axis in (X, Y))
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


def rectangles(visible: NDArray[np.bool_], lines: Rectangle) -> list[Rectangle]:
    """Rectangles that cover the true cells [rows, columns] of a panel: runs of equal rows are merged."""
    left, bottom, _, top = lines
    if visible.all():
        return [lines]
    merged: list[Rectangle] = []
    open_runs: dict[tuple[int, int], int] = {}
    for row in range(top - bottom + 1):
        runs = _runs(visible[row]) if row < top - bottom else []
        for run in [run for run in open_runs if run not in runs]:
            merged.append((left + run[0], bottom + open_runs.pop(run), left + run[1], bottom + row))
        for run in runs:
            open_runs.setdefault(run, row)
    return merged


def flattened(panels: Panels) -> Facade:
    """The facade of all visible shapes.

    The visible rest of a partly hidden shape is divided into rectangles. Regions without a straight cut are divided
    with as few cuts as possible; shapes that are fully visible are cut last. Empty parts of the facade are `outside`,
    or show the lowest shape that covers the whole canvas.
    """
    frame = (0, 0, len(panels.lines[X]) - 1, len(panels.lines[Y]) - 1)
    everywhere = [number for number, panel in enumerate(panels.panels) if panel.lines == frame]
    behind = everywhere[-1] if everywhere else WALL
    boxes: list[tuple[int, int, int, int]] = []
    source: list[int] = []
    whole: list[bool] = []
    for number, panel in enumerate(panels.panels):
        left, bottom, right, top = panel.lines
        visible = panels.topmost[bottom:top, left:right] == number
        if visible.any() and number != behind:
            visible_boxes = rectangles(visible, panel.lines)
            boxes += visible_boxes
            source += [number] * len(visible_boxes)
            whole += [len(visible_boxes) == 1] * len(visible_boxes)
    pieces = VisiblePieces(
        np.array(boxes).reshape(-1, 4), np.array(source, dtype=np.int64), np.array(whole, dtype=np.bool_)
    )
    tiles, tile_panel = fill(pieces, frame, split=True)
    tile_panel = np.where(tile_panel == WALL, behind, tile_panel)
    low, high = (
        np.stack([panels.lines[X][tiles[:, side]], panels.lines[Y][tiles[:, side + 1]]], axis=1) for side in (0, 2)
    )
    names = [
        OUTSIDE if panel_index == WALL else panels.panels[panel_index].shape.label
        for panel_index in tile_panel.tolist()
    ]
    return cut(low, high, names)[0]


def relief(design: Design, panels: Panels) -> Scene:
    """One model: x to the right, y up, the front of a wall at z = `THICKNESS` and all backs at 0.

    Shapes that are not opaque are in front of the shapes that are visible through them; opaque ones replace those
    below.
    """
    layers = design.visible_layers
    position, size, looks = [], [], []
    for panel, boxes in zip(panels.panels, panels.visible_rectangles(), strict=True):
        look = look_of(panel.shape.label)
        depth = max(_MIN_THICKNESS_M, THICKNESS + look.front + panel.shape.depth + layers[panel.layer].depth)
        for left, bottom, right, top in boxes:
            low = panels.lines[X][left], panels.lines[Y][bottom]
            position.append((*low, 0.0))
            size.append((panels.lines[X][right] - low[X], panels.lines[Y][top] - low[Y], depth))
            looks.append(look)
    distinct = sorted(set(looks), key=lambda look: (look.color, look.front))
    material = np.array([distinct.index(look) for look in looks], dtype=np.int32)
    order = np.argsort(material, kind="stable")
    num = len(looks)
    channels = np.array([_channels(look) for look in distinct]).reshape(-1, len(CHANNELS))
    return Scene(
        num_models=1,
        meshes=box(),
        materials=Materials(channels, ("",) * len(distinct)),
        model=np.zeros(num, dtype=np.int32),
        mesh=np.zeros(num, dtype=np.int32),
        material=material[order],
        position=np.array(position).reshape(-1, 3)[order],
        size=np.array(size).reshape(-1, 3)[order],
        frame=np.zeros(num, dtype=np.int32),
        frames=np.eye(3)[None],
        texture_map=np.full(num, -1, dtype=np.int32),
        texture_maps=np.zeros((0, 2, 4)),
        origins=np.zeros((1, 3)),
    )


def _cells(lines: Rectangle) -> tuple[slice, slice]:
    left, bottom, right, top = lines
    return slice(bottom, top), slice(left, right)


def _runs(visible: NDArray[np.bool_]) -> list[tuple[int, int]]:
    steps = np.flatnonzero(np.diff(np.concatenate([[False], visible, [False]]).astype(np.int8)))
    return [(int(start), int(end)) for start, end in zip(steps[::2], steps[1::2], strict=True)]


def _placed_words(design: Design, layout: Layout, axis: int) -> list[tuple[Word, Floats]]:
    """For each layer that is on, its word and the ends of its letters [letters, 2], metres."""
    placed = dict(zip(layout.groups, layout.sizing.placed, strict=True))
    words, rows = [], dict[tuple[int, str], int]()
    for layer in design.visible_layers:
        group = (axis, layer.groups[axis])
        row = rows[group] = rows.get(group, -1) + 1
        ends = np.stack([placed[group].lower[row], placed[group].upper[row]], axis=1)
        words.append((layout.alignments[group].words[row], ends))
    return words


def _merged(ends: Floats, canvas: float) -> Floats:
    """Different coordinates within the canvas; nearly equal ones are merged."""
    inside = np.sort(np.clip(np.concatenate([[0.0, canvas], ends]), 0.0, canvas))
    distinct = inside[np.concatenate([[True], np.diff(inside) > _NEGLIGIBLE_SHARE * canvas])]
    distinct[-1] = canvas
    return distinct


def _visible_letters(
    layer: Layer, axis: int, word: Word, ends: Floats, lines: Floats
) -> list[tuple[str, bool, int, int]]:
    """Visible letters: symbol, whether it is opaque, and line indices of its ends."""
    mask = layer.masks[axis]
    first, last = (np.abs(lines[:, None] - np.clip(side, lines[0], lines[-1])).argmin(axis=0) for side in ends.T)
    return [
        (letter.symbol, letter.opaque, int(start), int(end))
        for letter, start, end in zip(word, first, last, strict=True)
        if start < end and not letter.transparent and (mask is None or letter.symbol in mask)
    ]


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
    resized: list[Panel] = []
    for panel, inner_box in zip(panels.panels, boxes, strict=True):
        left, bottom, right, top = panel.lines
        cell = panels.lines[X][left], panels.lines[Y][bottom], panels.lines[X][right], panels.lines[Y][top]
        whole, inner = _nearest(cell, (lines[X], lines[Y])), _nearest(inner_box, (lines[X], lines[Y]))
        resized.append(replace(panel, lines=inner))
        if inner != whole and panel.shape.frame:
            resized.append(replace(panel, lines=whole, shape=Shape(panel.shape.frame)))
    return Panels((lines[X], lines[Y]), tuple(resized))


def _box(panel: Panel, lines: tuple[Floats, Floats]) -> tuple[float, float, float, float]:
    """Coordinates of a shape in its cell, metres; at least a part of the cell remains."""
    sides = []
    for axis in (X, Y):
        low, high = (float(lines[axis][panel.lines[side]]) for side in (axis, axis + 2))
        before, after = panel.shape.inset[axis], panel.shape.inset[axis + 2]
        share = min(1.0, (1.0 - _LEAST_SHARE) * (high - low) / (before + after)) if before + after else 0.0
        sides.append((low + share * before, high - share * after))
    (left, right), (bottom, top) = sides
    return left, bottom, right, top


def _nearest(box: tuple[float, float, float, float], lines: tuple[Floats, Floats]) -> Rectangle:
    """Line indices of the sides of a box."""
    left, bottom, right, top = (
        int(np.abs(lines[side % 2] - coordinate).argmin()) for side, coordinate in enumerate(box)
    )
    return left, bottom, right, top


def _channels(look: LabelLook) -> tuple[float, ...]:
    color = dict(zip(("color.r", "color.g", "color.b", "opacity"), parse_color(look.color) or (), strict=False))
    return tuple({**CHANNELS, **color, "metallic": look.metallic, "roughness": look.roughness}.values())
