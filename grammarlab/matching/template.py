"""Templates: wires with ends that are linear in named parameters, such as the width and height of a window."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from grammarlab.arrays import Floats, Ints

ARC_PIECES = 8
"""Number of chords of an arc."""
WIDTH, HEIGHT = 0, 1
"""The first parameters of every template; its lower left corner is its origin."""


@dataclass(frozen=True, eq=False)
class Template:
    """S wires with D parameters."""

    name: str
    """`window_2x3`; a template with counts has their values appended, such as `sash[panes=3]`."""
    base: str
    """Name in the file."""
    counts: tuple[tuple[str, int], ...]
    """Discrete parameters; each combination of values is a separate template."""
    parameters: tuple[str, ...]
    """[D] names: `width`, `height`, then others."""
    usual: Floats
    """[D] usual values, metres."""
    low: Floats
    """[D] least values, metres, > 0."""
    high: Floats
    """[D] largest values, metres, > low."""
    wires: Floats
    """[S, 5, 1 + D] start x, y, end x, y and height of the arc over its chord, to the right; see `outline`."""
    limits: Floats
    """[C, 1 + D] linear forms that are at least 0: a constant, and a coefficient of each parameter."""

    @property
    def pieces(self) -> Floats:
        """[R, 7, 1 + D] the wires with arcs divided into chords, for `outline`."""
        rows = []
        for wire in self.wires:
            parts = ARC_PIECES if np.abs(wire[4]).max() > 0.0 else 1
            for part in range(parts):
                ends = np.zeros((2, wire.shape[1]))
                ends[:, 0] = part / parts, (part + 1) / parts
                rows.append(np.vstack([wire, ends]))
        return np.array(rows)


@dataclass(frozen=True, eq=False)
class Stack:
    """T templates as arrays of one shape, so that one call fits all of them."""

    pieces: Floats
    """[T, R, 7, 1 + D] pieces; of length 0 for templates with fewer."""
    usual: Floats
    """[T, D] usual values; 1 for templates with fewer parameters."""
    low: Floats
    """[T, D] least values."""
    high: Floats
    """[T, D] largest values."""
    limits: Floats
    """[T, C, 1 + D] limits; padded with limits that always hold."""
    used: Floats
    """[T, D] 1 for the parameters of a template."""
    guess: Floats
    """[T] first guess: 1 for the size of the visible points with usual proportions, 0 for the usual values from their
    lower left corner, -1 for these from the upper right corner."""

    def subset(self, selection: Ints) -> Stack:
        """Some of the templates."""
        return Stack(**{field.name: getattr(self, field.name)[selection] for field in fields(self)})


def stack(templates: Sequence[Template]) -> Stack:
    """The templates as one array; the number of pieces is rounded up, so that few different ones are compiled."""
    pieces = [template.pieces for template in templates]
    num = len(templates)
    most = 4 * -(-max(map(len, pieces)) // 4)
    size = max(len(template.parameters) for template in templates)
    num_limits = max(1, *(len(template.limits) for template in templates))
    stacked = np.zeros((num, most, 7, 1 + size))
    usual, low, high = np.ones((num, size)), np.full((num, size), 0.5), np.full((num, size), 2.0)
    limits, used = np.zeros((num, num_limits, 1 + size)), np.zeros((num, size))
    for index, (template, rows) in enumerate(zip(templates, pieces, strict=True)):
        count = len(template.parameters)
        stacked[index, : len(rows), :, : 1 + count] = rows
        usual[index, :count], low[index, :count], high[index, :count] = template.usual, template.low, template.high
        limits[index, : len(template.limits), : 1 + count] = template.limits
        used[index, :count] = 1.0
    return Stack(
        pieces=stacked,
        usual=usual,
        low=low,
        high=high,
        limits=limits,
        used=used,
        guess=np.ones(num),
    )


def points_along(template: Template, parameters: Floats) -> Floats:
    """[R, 2, 2] start and end of the pieces of a template, in NumPy, for drawings and meshes."""
    rows = template.pieces
    values = rows[:, :5, 0] + rows[:, :5, 1:] @ parameters
    start, end, height = values[:, 0:2], values[:, 2:4], values[:, 4]
    chord = end - start
    half = 2.0 * np.arctan2(2.0 * height, np.linalg.norm(chord, axis=1))
    half = np.where(np.abs(half) < 1e-3, 1e-3, half)
    across = np.stack([chord[:, 1], -chord[:, 0]], axis=1)
    drawn = []
    for part in (rows[:, 5, 0], rows[:, 6, 0]):
        angle = half * (2.0 * part - 1.0)
        along = np.where(np.abs(height) < 1e-9, part, 0.5 + 0.5 * np.sin(angle) / np.sin(half))
        out = np.where(np.abs(height) < 1e-9, 0.0, 0.5 * (np.cos(angle) - np.cos(half)) / np.sin(half))
        drawn.append(start + along[:, None] * chord + out[:, None] * across)
    return np.stack(drawn, axis=1)
