"""Paths of stems, segment by segment for all stems of a level: curves, helices, attraction to the sky, and splits.

The mean number of clones per segment need not be whole (Weber and Penn, section 4.2). The error is diffused along all
segments of a level of one tree, in a fixed order: by segment, then by stem, the clones of a segment after all stems
before them. The k-th of them, from 0, has floor((k + 1) s + ½) - floor(k s + ½) clones. No other tree is involved, and
no draw.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints, index_in_row, offsets_from_counts, row_of_value
from grammarlab.randomness import Keys, fold, uniforms
from grammarlab.trees.branching import num_segments
from grammarlab.trees.budget import check_stems
from grammarlab.trees.draws import Site, Turn, counts, segment_keys, values, varied, varied_by
from grammarlab.trees.orientation import (
    declination,
    frames_from_axes,
    turned_about_vertical,
    turned_about_x,
    turned_about_z,
)
from grammarlab.trees.parameters import SPREAD

_SPREAD_LEAST, _SPREAD_MORE, _SPREAD_UPRIGHT = 20.0, 0.75, 30.0
"""Degrees, factor and degrees of the spread of clones about the vertical, of the paper's section 4.2."""


@dataclass(frozen=True, slots=True, eq=False)
class Forks:
    """S stems, clones included, ordered by tree."""

    root: Ints
    """[S] row of the whole stem, among those without clones."""
    source: Ints
    """[S] row of the stem that a clone split from; -1 for the others."""
    first: Ints
    """[S] segment with which a stem begins."""
    key: Keys
    """[S] keys."""
    direction: Floats
    """[S] radians by which a clone of the trunk's first segment spreads about the vertical; nan if it is drawn."""
    splits: tuple[Ints, ...]
    """For each segment: rows of the stems that have split just before it."""


def forked(rows: Floats, level: int, tree: Ints, keys: Keys) -> Forks:
    """Stems of a level with their clones.

    Args:
        rows: [n, P] parameters of the trees.
        level: the level.
        tree: [W] tree of each whole stem, ascending.
        keys: [W] keys.

    Raises:
        UsageError: If a tree has too many stems.
    """
    segments, rate = num_segments(rows, tree, level), values(rows, tree, f"seg_splits_{level}")
    base = counts(rows, tree, "base_splits") if level == 0 else np.zeros(len(tree), np.int64)
    whole = np.arange(len(tree))
    none = np.full(len(tree), -1)
    forks = Forks(whole, none, np.zeros(len(tree), np.int64), keys, np.full(len(tree), np.nan), ())
    visits = np.zeros(len(rows), np.int64)
    splits: list[Ints] = [none[:0]]
    for segment in range(int(segments.max(initial=0)) - 1 if rate.any() or base.any() else 0):
        trees = tree[forks.root]
        is_base = (base[forks.root] > 0) & (segment == 0)
        goes_on = segments[forks.root] > segment + 1
        k = visits[trees] + _rank(trees, len(rows))
        s = rate[forks.root]
        clones = np.floor((k + 1) * s + 0.5) - np.floor(k * s + 0.5)
        clones = np.where(goes_on, np.where(is_base, base[forks.root], clones), 0).astype(np.int64)
        visits += np.bincount(trees[goes_on & ~is_base], minlength=len(rows))
        check_stems(rows, level, np.bincount(trees, clones + 1.0, len(rows)))
        splits.append(np.flatnonzero(clones > 0))
        forks = _with_clones(forks, segment, clones, is_base)
    return _by_tree(forks, tree, splits)


def _rank(trees: Ints, num: int) -> Ints:
    """[S] number of a stem within its tree, from 0."""
    rank = np.empty(len(trees), np.int64)
    rank[np.argsort(trees, kind="stable")] = index_in_row(np.bincount(trees, minlength=num))
    return rank


def _with_clones(forks: Forks, segment: int, clones: Ints, is_base: Flags) -> Forks:
    source, index = row_of_value(clones), index_in_row(clones)
    even = 2.0 * np.pi * (index + 1) / (clones[source] + 1)
    return Forks(
        root=np.concatenate([forks.root, forks.root[source]]),
        source=np.concatenate([forks.source, source]),
        first=np.concatenate([forks.first, np.full(len(source), segment + 1)]),
        key=np.concatenate([forks.key, fold(fold(fold(forks.key[source], Site.CLONES), segment), index)]),
        direction=np.concatenate([forks.direction, np.where(is_base[source], even, np.nan)]),
        splits=(),
    )


def _by_tree(forks: Forks, tree: Ints, splits: list[Ints]) -> Forks:
    order = np.argsort(tree[forks.root], kind="stable")
    row = np.empty(len(order), np.int64)
    row[order] = np.arange(len(order))
    source = forks.source[order]
    return Forks(
        root=forks.root[order],
        source=np.where(source >= 0, row[source], -1),
        first=forks.first[order],
        key=forks.key[order],
        direction=forks.direction[order],
        splits=tuple(row[rows] for rows in splits),
    )


@dataclass(frozen=True, slots=True, eq=False)
class Paths:
    """Paths of S stems, each for a whole stem of length 1 that begins at the origin."""

    node_offsets: Ints
    """[S + 1] into the nodes."""
    points: Floats
    """[N, 3] nodes."""
    frames: Floats
    """[N, 3, 3] see `grammarlab.trees.skeleton.Stems`."""
    along: Floats
    """[N] share of the length."""


@dataclass(slots=True, eq=False)
class _Growth:
    """The ends of S stems while they grow."""

    axes: Floats
    """[3, 3, S] axes of the last segment, without the inclination of a helix."""
    point: Floats
    """[3, S] last node."""
    back: Floats
    """[S] radians by which later segments turn back after splits, each."""


def traced(rows: Floats, level: int, tree: Ints, axes: Floats, forks: Forks) -> Paths:
    """The paths of stems and clones.

    Args:
        rows: [n, P] parameters of the trees.
        level: level of the stems.
        tree: [W] tree of each whole stem.
        axes: [3, 3, W] axes with which they begin.
        forks: stems with clones.
    """
    trees = tree[forks.root]
    segments = num_segments(rows, trees, level)
    num_nodes = segments - forks.first + 1
    node_offsets = offsets_from_counts(num_nodes)
    index = index_in_row(num_nodes) + np.repeat(forks.first, num_nodes)
    points, frames = np.zeros((len(index), 3)), np.empty((len(index), 3, 3))
    state = _Growth(axes[..., forks.root], np.zeros((3, len(trees))), np.zeros(len(trees)))
    turns = _Turns.read(rows, level, trees, segments)
    for segment in range(int(segments.max(initial=0))):
        _start_clones(state, forks, segment)
        active = np.flatnonzero((segments > segment) & (forks.first <= segment))
        if segment > 0:
            later = _split(state, rows, level, trees, segments, forks, segment)
            state.axes[..., active] = _turned(state, turns, forks.key, active, segment)
            state.back += later
        directed = turns.inclined(state.axes[..., active], active, segment)
        node = node_offsets[active] + segment - forks.first[active]
        points[node] = state.point[:, active].T
        frames[node] = frames_from_axes(directed)
        state.point[:, active] += directed[2] / segments[active]
        ends = segments[active] == segment + 1
        points[node[ends] + 1], frames[node[ends] + 1] = state.point[:, active[ends]].T, frames[node[ends]]
    return Paths(node_offsets, points, frames, index / segments[row_of_value(num_nodes)])


def _start_clones(state: _Growth, forks: Forks, segment: int) -> None:
    """Let the clones of a segment begin where their sources are."""
    new = np.flatnonzero((forks.first == segment) & (forks.source >= 0))
    source = forks.source[new]
    state.axes[..., new] = state.axes[..., source]
    state.point[:, new], state.back[new] = state.point[:, source], state.back[source]


def _split(state: _Growth, rows: Floats, level: int, trees: Ints, segments: Ints, forks: Forks, segment: int) -> Floats:
    """Let stems that have split, and their clones, decline and spread.

    Returns:
        [S] radians by which each later segment turns back.
    """
    back = np.zeros(len(trees))
    sources = forks.splits[segment] if segment < len(forks.splits) else np.zeros(0, np.int64)
    if not len(sources):
        return back
    new = np.flatnonzero((forks.first == segment) & (forks.source >= 0))
    stems = np.concatenate([sources, new])
    base = values(rows, trees[stems], "base_splits")
    axes, keys = state.axes[..., stems], segment_keys(forks.key[stems], segment)
    slope = declination(axes[2])
    angle = np.radians(varied(rows, trees[stems], f"split_angle_{level}", keys, Turn.SPLIT))
    angle = np.maximum(0.0, angle - slope)
    spread = _spread(slope, keys)
    even = forks.direction[stems]
    spread = np.where(np.isnan(even), spread, even)
    # The paper turns clones only. A stem that goes on straight, or to the same side, would let the tree lean: it turns
    # to the other side, but among the stems of a split base, which lie evenly about.
    spread[: len(sources)] = 0.0
    angle[: len(sources)] *= np.where((level == 0) & (segment == 1) & (base[: len(sources)] > 0), 1.0, -1.0)
    state.axes[..., stems] = turned_about_vertical(turned_about_x(axes, angle), spread)
    back[stems] = angle / np.maximum(1, segments[stems] - segment - 1)
    return back


def _spread(slope: Floats, keys: Keys) -> Floats:
    """[S] radians about the vertical."""
    range_ = _SPREAD_MORE * (_SPREAD_UPRIGHT + np.abs(np.degrees(slope) - 90.0))
    spread = np.radians(_SPREAD_LEAST + range_ * uniforms(keys, Turn.SPREAD) ** 2)
    return np.where(uniforms(keys, Turn.SIDE) < 0.5, spread, -spread)


@dataclass(frozen=True, slots=True, eq=False)
class _Turns:
    """What turns the segments of S stems."""

    lower: Floats
    """[S] radians per segment of the lower half."""
    upper: Floats
    """[S] radians per segment of the upper half."""
    random: Floats
    """[S] largest random radians per segment."""
    helix: Floats
    """[S] radians between the axis of a helix and its segments; 0 for the others."""
    attraction: Floats
    """[S] attraction to the sky per segment."""
    segments: Ints

    @classmethod
    def read(cls, rows: Floats, level: int, trees: Ints, segments: Ints) -> _Turns:
        curve = np.radians(values(rows, trees, f"curve_{level}")) / segments
        back = np.radians(values(rows, trees, f"curve_back_{level}")) / segments
        spread = np.radians(values(rows, trees, f"curve_{level}{SPREAD}"))
        attraction = values(rows, trees, "attraction_up") if level >= 2 else np.zeros(len(trees))
        return cls(
            lower=np.where(back == 0.0, curve, 2.0 * curve),
            upper=np.where(back == 0.0, curve, 2.0 * back),
            random=np.maximum(spread, 0.0) / segments,
            helix=np.maximum(-spread, 0.0),
            attraction=attraction / segments,
            segments=segments,
        )

    def inclined(self, axes: Floats, stems: Ints, segment: int) -> Floats:
        """Axes of the segments of helices: inclined to one side after the other, one round per stem."""
        helices = np.flatnonzero(self.helix[stems] > 0.0)
        if not len(helices):
            return axes
        round_ = 2.0 * np.pi * segment / self.segments[stems[helices]]
        leading = turned_about_x(turned_about_z(axes[..., helices], round_), self.helix[stems[helices]])
        inclined = axes.copy()
        inclined[..., helices] = turned_about_z(leading, -round_)
        return inclined


def _turned(state: _Growth, turns: _Turns, keys: Keys, stems: Ints, segment: int) -> Floats:
    """[3, 3, A] axes of the next segments of stems [A]."""
    in_lower_half = 2 * segment < turns.segments[stems]
    angle = np.where(in_lower_half, turns.lower[stems], turns.upper[stems])
    angle += varied_by(turns.random[stems], segment_keys(keys[stems], segment), Turn.CURVE)
    angle -= state.back[stems]
    axes = turned_about_x(state.axes[..., stems], angle)
    attraction = turns.attraction[stems]
    return turned_about_x(axes, _turn_to_sky(axes, attraction)) if attraction.any() else axes


def _turn_to_sky(axes: Floats, attraction: Floats) -> Floats:
    """[A] radians about x that raise stems, or lower them, but never beyond the vertical."""
    y, z = axes[1, 1], axes[2, 1]
    turn = attraction * declination(axes[2]) * y
    to_zenith = np.abs(np.arctan2(y, z))
    limit = np.where(attraction >= 0.0, to_zenith, np.pi - to_zenith)
    return -np.clip(turn, -limit, limit)
