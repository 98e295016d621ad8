"""Wind: a still pose of a tree whose stems bend like cantilevers, without an effect on anything that is drawn.

A stem of length L and radius r under an even load p per length is inclined at its tip by p L³ / (6 E I), with
I = π r⁴ / 4, and at a share Z of its length by 1 - (1 - Z)³ of that. The load is the pressure of the wind on the
silhouette of the stem, of what it bears, and across the wind only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.trees.branching import num_segments
from grammarlab.trees.draws import values
from grammarlab.trees.orientation import axes_from_frames, crossed, dots, frames_from_axes, turned_about
from grammarlab.trees.skeleton import Stems

_AIR_DENSITY = 1.2
"""kg/m³."""
_WOOD_MODULUS = 8e9
"""Pa: Young's modulus of green wood along the grain."""
_SAIL = 30.0
"""Silhouette of a stem with its twigs and leaves by that of its wood; a rough mean of trees in leaf."""

_SLENDEREST = 200.0
"""Length by radius beyond which no twig keeps itself straight; thinner ones of the model bend like these."""


def in_wind(rows: Floats, levels: Sequence[Stems]) -> list[Stems]:
    """The stems of trees, level by level, bent by the wind of their parameters.

    Args:
        rows: [n, P] parameters of the trees.
        levels: stems at rest.
    """
    if not values(rows, np.arange(len(rows)), "wind_speed").any():
        return list(levels)
    bent: list[Stems] = []
    for level, stems in enumerate(levels):
        bent.append(_bent(rows, level, stems, levels[level - 1], bent[level - 1]) if level else _bent(rows, 0, stems))
    return bent


def _bent(rows: Floats, level: int, stems: Stems, rest: Stems | None = None, parents: Stems | None = None) -> Stems:
    """Stems of a level, bent.

    Args:
        rows: [n, P] parameters of the trees.
        level: the level.
        stems: stems at rest.
        rest: their parents at rest; None for trunks.
        parents: their parents, bent.
    """
    segments = num_segments(rows, stems.tree, level)
    turn, point = _start(stems) if rest is None or parents is None else _start_on(rows, level, stems, rest, parents)
    points, frames = stems.points.copy(), stems.frames.copy()
    wind, slope = _wind(rows, stems.tree), _tip_slope(rows, stems)
    for segment in range(int(segments.max(initial=0))):
        new = np.flatnonzero((stems.first == segment) & stems.is_clone)
        turn[..., new], point[new] = turn[..., stems.source[new]], point[stems.source[new]]
        active = np.flatnonzero((segments > segment) & (stems.first <= segment))
        node = stems.node_offsets[active] + segment - stems.first[active]
        more = slope[active] * (_slope_at(segment, segments[active]) - _slope_at(segment - 1, segments[active]))
        turn[..., active] = _towards(turn[..., active], stems.frames[node, :, 2].T, wind[:, active], more)
        step = stems.points[node + 1] - stems.points[node]
        points[node], frames[node] = point[active], _rotated(turn[..., active], stems.frames[node])
        point[active] += _applied(turn[..., active], step.T).T
        ends = segments[active] == segment + 1
        points[node[ends] + 1], frames[node[ends] + 1] = point[active[ends]], frames[node[ends]]
    calm = np.repeat(values(rows, stems.tree, "wind_speed") == 0.0, stems.num_nodes)
    points[calm], frames[calm] = stems.points[calm], stems.frames[calm]  # without the rounding
    return replace(stems, points=points, frames=frames)


def _start(stems: Stems) -> tuple[Floats, Floats]:
    """Rotations [3, 3, S], by their columns, and places [S, 3] with which trunks begin."""
    turn = np.repeat(np.eye(3)[..., None], len(stems), axis=2)
    return turn, stems.points[stems.node_offsets[:-1]].copy()


def _start_on(rows: Floats, level: int, stems: Stems, rest: Stems, parents: Stems) -> tuple[Floats, Floats]:
    """Rotations and places with which stems begin on their parents."""
    parent = stems.parent
    place = stems.offset / parents.length[parent] * num_segments(rows, stems.tree, level - 1)
    segment = np.minimum(place.astype(np.int64), rest.first[parent] + rest.num_nodes[parent] - 2)
    node = rest.node_offsets[parent] + segment - rest.first[parent]
    turn = parents.frames[node] @ rest.frames[node].transpose(0, 2, 1)
    step = parents.points[node + 1] - parents.points[node]
    return axes_from_frames(turn), parents.points[node] + (place - segment)[:, None] * step


def _wind(rows: Floats, tree: Ints) -> Floats:
    """[3, S] unit vectors: where the wind blows to."""
    angle = np.radians(values(rows, tree, "wind_direction"))
    return np.stack([np.cos(angle), np.zeros_like(angle), -np.sin(angle)])


def _tip_slope(rows: Floats, stems: Stems) -> Floats:
    """[S] radians by which tips of stems across the wind are inclined."""
    pressure = 0.5 * _AIR_DENSITY * values(rows, stems.tree, "wind_speed") ** 2
    slenderness = np.minimum(_SLENDEREST, stems.length / np.maximum(stems.radius, 1e-9 * stems.length))
    return 4.0 * _SAIL * pressure / (3.0 * np.pi * _WOOD_MODULUS) * slenderness**3


def _slope_at(segment: int, segments: Ints) -> Floats:
    """[S] inclination of the middle of a segment by that of the tip; 0 before the first."""
    share = np.maximum(0.0, (segment + 0.5) / segments)
    return 1.0 - (1.0 - share) ** 3


def _towards(turn: Floats, direction: Floats, wind: Floats, angle: Floats) -> Floats:
    """Rotations [3, 3, S] after a turn of their direction towards the wind, at most until both agree."""
    current = _applied(turn, direction)
    axis = crossed(current, wind)
    across = np.sqrt(dots(axis, axis))
    rest = np.arctan2(across, dots(current, wind))
    axis = axis / np.where(across > 0.0, across, 1.0)
    return turned_about(turn, axis, np.minimum(angle * across, rest))


def _applied(turn: Floats, vectors: Floats) -> Floats:
    """[3, S] vectors after rotations [3, 3, S]."""
    return turn[0] * vectors[0] + turn[1] * vectors[1] + turn[2] * vectors[2]


def _rotated(turn: Floats, frames: Floats) -> Floats:
    """[S, 3, 3] frames after rotations [3, 3, S]."""
    return frames_from_axes(turn) @ frames
