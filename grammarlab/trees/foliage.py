"""Leaves and blossoms of the last stems (Weber and Penn, sections 4.6 and 4.9)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints, index_in_row, row_of_value
from grammarlab.randomness import Keys, fold, uniforms
from grammarlab.trees import branching
from grammarlab.trees.budget import check_leaves
from grammarlab.trees.draws import Site, counts, values, varied_by
from grammarlab.trees.orientation import (
    axes_from_frames,
    declination,
    frames_from_axes,
    turned_about,
    turned_about_vertical,
    turned_about_x,
    turned_about_y,
)
from grammarlab.trees.parameters import NUM_LEVELS, SPREAD
from grammarlab.trees.skeleton import Leaves, Stems

_UNITS = 1 << 24
"""Units of a leaf: sums of whole numbers do not depend on the batch, sums of floats do."""
_TOLERANCE = 1e-9
"""Below this a horizontal direction is not defined: by the height of a leaf for its place, by 1 for its upper side."""


def foliage(rows: Floats, levels: Sequence[Stems], height: Floats) -> Leaves:
    """The leaves and blossoms of trees.

    Args:
        rows: [n, P] parameters of the trees.
        levels: their stems.
        height: [n] metres: the heights for which the trees are drawn.

    Raises:
        UsageError: If a tree has too many leaves.
    """
    bearing = [_Bearing.read(rows, level, levels, height) for level in range(len(levels))]
    check_leaves(rows, np.sum([np.bincount(part.stems.tree, part.num, len(rows)) for part in bearing], axis=0))
    parts = [leaves for part in bearing for leaves in (_along(rows, part), _fans(rows, part))]
    return Leaves.joined([part for part in parts if len(part)] or parts[:1])


@dataclass(frozen=True, slots=True, eq=False)
class _Bearing:
    """The leaves of S stems of a level, in numbers."""

    level: int
    angles: int
    """Level whose angles the leaves use: the one after, if there is one."""
    stems: Stems
    bare: Floats
    """[S] share of the length without leaves."""
    start: Floats
    """[S] share of the length from which a stem bears leaves: a clone bears none before it splits off."""
    num: Floats
    """[S] leaves, before rounding."""
    is_fan: Flags
    """[S] whether they are at the tip."""

    @classmethod
    def read(cls, rows: Floats, level: int, levels: Sequence[Stems], height: Floats) -> _Bearing:
        stems = levels[level]
        bare = branching.bare_share(rows, stems, height, level)
        start = branching.bearing_start(stems, bare, branching.num_segments(rows, stems.tree, level))
        leaves = values(rows, stems.tree, "leaves")
        share = stems.offset / levels[level - 1].length[stems.parent] if level > 0 else np.ones(len(stems))
        # S(4, share) = .5 + .5 share: the outer ones bear more.
        along = leaves * (0.5 + 0.5 * share) * (1.0 - start) / np.where(bare < 1.0, 1.0 - bare, 1.0)
        num = np.where(leaves < 0.0, -leaves, along) * values(rows, stems.tree, "leaf_quality")
        num[counts(rows, stems.tree, "levels") != level + 1] = 0.0
        return cls(level, min(level + 1, NUM_LEVELS - 1), stems, bare, start, num, leaves < 0.0)


def carried(tree: Ints, numbers: Floats) -> Ints:
    """[S] whole numbers whose sums up to any stem of a tree are those of numbers [S], rounded: halves up.

    Args:
        tree: [S] tree of each stem, ascending.
        numbers: [S] numbers >= 0.

    >>> carried(np.array([0, 0, 0, 0, 1]), np.array([0.4, 0.4, 0.4, 0.4, 0.4])).tolist()
    [0, 1, 0, 1, 0]
    """
    sums = np.concatenate([[0], np.cumsum(np.rint(numbers * _UNITS).astype(np.int64))])
    sums_before, sums_after = (
        sums[:-1] - sums[np.searchsorted(tree, tree)],
        sums[1:] - sums[np.searchsorted(tree, tree)],
    )
    return (sums_after + _UNITS // 2) // _UNITS - (sums_before + _UNITS // 2) // _UNITS


def _along(rows: Floats, part: _Bearing) -> Leaves:
    """Leaves along stems."""
    stems = part.stems
    num = carried(stems.tree, np.where(part.is_fan, 0.0, part.num))
    spots = branching.spots(stems, part.start, branching.num_segments(rows, stems.tree, part.level), num)
    keys = _keys(stems, spots.stem, spots.index)
    axes = branching.child_axes(rows, part.angles, spots, stems, part.bare, keys)
    return _leaves(rows, part, spots.stem, spots.along, spots.positions(stems), axes, keys)


def _fans(rows: Floats, part: _Bearing) -> Leaves:
    """Leaves in fans at the tips of stems: open by the angle of rotation, in the plane of the stem's x axis."""
    stems = part.stems
    num = carried(stems.tree, np.where(part.is_fan, part.num, 0.0))
    stem, index = row_of_value(num), index_in_row(num)
    keys, tree, node = _keys(stems, stem, index), stems.tree[stem], stems.node_offsets[stem + 1] - 1
    share = np.where(num[stem] > 1, index / np.maximum(1, num[stem] - 1) - 0.5, 0.0)
    spread = varied_by(values(rows, tree, f"rotate_{part.angles}{SPREAD}"), keys, Site.ROTATE)
    open_ = np.radians(share * np.abs(values(rows, tree, f"rotate_{part.angles}")) + spread)
    axes = turned_about_y(axes_from_frames(stems.frames[node]), open_)
    along = np.ones(len(stem))
    axes = turned_about_x(axes, branching.down_angles(rows, part.angles, tree, along, part.bare[stem], keys))
    return _leaves(rows, part, stem, along, stems.points[node], axes, keys)


def _keys(stems: Stems, stem: Ints, index: Ints) -> Keys:
    return fold(fold(stems.key[stem], Site.LEAVES), index)


def _leaves(
    rows: Floats, part: _Bearing, stem: Ints, along: Floats, position: Floats, axes: Floats, keys: Keys
) -> Leaves:
    tree = part.stems.tree[stem]
    is_blossom = uniforms(keys, Site.BLOSSOM) < values(rows, tree, "blossom_rate")
    blade = np.where(is_blossom, values(rows, tree, "blossom_scale"), values(rows, tree, "leaf_scale"))
    length = blade / np.sqrt(values(rows, tree, "leaf_quality"))
    return Leaves(
        tree=tree,
        stem=stem,
        level=np.full(len(tree), part.level, np.int8),
        offset=along * part.stems.length[stem],
        position=position,
        frame=frames_from_axes(_to_light(axes, position, values(rows, tree, "leaf_bend"))),
        length=length,
        width=np.where(is_blossom, length, length * values(rows, tree, "leaf_scale_x")),
        is_blossom=is_blossom,
    )


def _to_light(axes: Floats, position: Floats, bend: Floats) -> Floats:
    """Axes of leaves [3, 3, L] whose upper sides turn outward about the vertical, then up, by shares [L]."""
    if not bend.any():
        return axes
    upper = axes[1]
    outside = np.arctan2(position[:, 0], position[:, 2]) - np.arctan2(upper[0], upper[2])
    outside = np.remainder(outside + np.pi, 2.0 * np.pi) - np.pi
    # Neither a leaf on the trunk's axis nor one that lies level has an outside.
    axis_tolerance = _TOLERANCE * np.abs(position[:, 1])
    has_outside = np.hypot(position[:, 0], position[:, 2]) > axis_tolerance
    has_side = np.hypot(upper[0], upper[2]) > _TOLERANCE
    axes = turned_about_vertical(axes, np.where(has_outside & has_side, bend * outside, 0.0))
    upper = axes[1]
    level = np.hypot(upper[0], upper[2])
    # The horizontal axis about which the upper side turns towards the sky; for one that looks down, any will do.
    axis = np.zeros_like(upper)
    safe = np.where(level > _TOLERANCE, level, 1.0)
    axis[0] = np.where(level > _TOLERANCE, -upper[2] / safe, 1.0)
    axis[2] = np.where(level > _TOLERANCE, upper[0] / safe, 0.0)
    return turned_about(axes, axis, bend * declination(upper))
