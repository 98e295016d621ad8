"""Clashes of trees: how much of their stems lies inside other stems.

Points are spread evenly over the length of all stems of a tree, and each is compared with the nearest pieces of stems
(a KD-tree over short pieces of the segments of all trees), so that the cost is bounded for any tree.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from grammarlab.arrays import Flags, Floats, Ints, index_in_row, row_of_value
from grammarlab.trees.skeleton import Skeleton, Stems
from grammarlab.trees.taper import radii

_NUM_POINTS = 200
"""Points per tree: shares are multiples of .5 %."""
_NUM_PIECES = 32
"""Pieces of a straight line as long as the largest coordinate of a tree."""
_NUM_NEAREST = 8
"""Pieces of each level that a point is compared with; more do not fit around a point unless stems clash anyway."""
_JOINT = 2.0
"""Length of a joint by the radius of the parent there: a child at 30 degrees to its parent leaves it at twice the
radius."""
_SPACING = 4.0
"""Distance of trees whose coordinates are -1 to 1."""
_WHOLE = float(1 << 40)
"""Units of a tree's length: whole numbers, so that sums do not depend on the other trees of a batch."""
_MIN_SIZE = 1e-9
"""Metres, smallest divisor."""


def clash_shares(skeleton: Skeleton) -> Floats:
    """[n] share of the length of the stems that lies inside stems other than their parents, children and forks.

    Joints, where stems begin inside their parents, are left out.

    Args:
        skeleton: the trees.
    """
    num = skeleton.num_trees
    if not num:
        return np.zeros(0)
    segments = [_segments(skeleton, level) for level in range(len(skeleton.levels))]
    scale = _scale(skeleton)
    points = _spread(segments, num)
    clashes = np.zeros(len(points.tree), dtype=bool)
    for level, part in enumerate(segments):
        clashes |= _inside(skeleton, level, part, points, scale)
    return np.bincount(points.tree[clashes], minlength=num) / _NUM_POINTS


@dataclass(frozen=True, slots=True)
class _Segments:
    """K segments of the stems of a level."""

    tree: Ints
    stem: Ints
    """[K] row of the stem."""
    base: Floats
    """[K, 3] where it begins."""
    step: Floats
    """[K, 3] from there to its end."""
    start: Floats
    """[K] metres along the stem to where it begins."""
    length: Floats
    """[K] metres."""
    share: Floats
    """[2, K] share of the whole stem at both ends."""
    radius: Floats
    """[K] metres, the larger one of both ends."""
    joint: Floats
    """[K] metres along the stem that belong to its joint."""
    stem_id: Ints
    """[K] identity of the stem with its clones, among all levels."""
    parent_id: Ints
    """[K] that of its parent."""


@dataclass(frozen=True, slots=True)
class _Points:
    """Points on stems."""

    tree: Ints
    position: Floats
    stem_id: Ints
    parent_id: Ints


def _segments(skeleton: Skeleton, level: int) -> _Segments:
    stems = skeleton.levels[level]
    is_start = np.ones(len(stems.points), dtype=bool)
    is_start[stems.node_offsets[1:] - 1] = False
    node = np.flatnonzero(is_start)
    stem = row_of_value(stems.num_nodes - 1)
    step = stems.points[node + 1] - stems.points[node]
    own = _identities(skeleton, level)
    radius = radii(skeleton, level, row_of_value(stems.num_nodes), stems.along)
    parent = _identities(skeleton, level - 1)[stems.parent] if level else np.full(len(stems), -1, dtype=np.int64)
    return _Segments(
        tree=stems.tree[stem],
        stem=stem,
        base=stems.points[node],
        step=step,
        start=stems.along[node] * stems.length[stem],
        length=np.sqrt((step**2).sum(axis=1)),
        share=np.stack([stems.along[node], stems.along[node + 1]]),
        radius=np.maximum(radius[node], radius[node + 1]),
        joint=_joints(skeleton, level)[stem],
        stem_id=own[stem],
        parent_id=parent[stem],
    )


def _identities(skeleton: Skeleton, level: int) -> Ints:
    """[S] number of each stem among those of all levels, the same for its clones."""
    first = sum(len(stems) for stems in skeleton.levels[:level])
    return first + _unsplit(skeleton.levels[level])


def _unsplit(stems: Stems) -> Ints:
    """[S] row of the stem that is not a clone and from which each split, at once or again and again."""
    row = np.where(stems.is_clone, stems.source, np.arange(len(stems)))
    while True:
        further = row[row]
        if (further == row).all():
            return row
        row = further


def _joints(skeleton: Skeleton, level: int) -> Floats:
    """[S] metres of each stem that belong to its joint."""
    stems = skeleton.levels[level]
    if not level:
        return np.zeros(len(stems))
    length = skeleton.levels[level - 1].length[stems.parent]
    along = np.clip(stems.offset / np.maximum(length, _MIN_SIZE), 0.0, 1.0)
    return _JOINT * radii(skeleton, level - 1, stems.parent, along)


def _scale(skeleton: Skeleton) -> Floats:
    """[n] metres, the largest coordinate of the nodes of each tree."""
    scale = np.full(skeleton.num_trees, _MIN_SIZE)
    for stems in skeleton.levels:
        np.maximum.at(scale, stems.tree[row_of_value(stems.num_nodes)], np.abs(stems.points).max(axis=1))
    return scale


def _spread(levels: list[_Segments], num_trees: int) -> _Points:
    """Points at equal distances along all stems of each tree, without those in joints."""
    tree, length = (np.concatenate([getattr(part, name) for part in levels]) for name in ("tree", "length"))
    order = np.argsort(tree, kind="stable")
    total = np.bincount(tree, length, num_trees)
    units = np.floor(length / np.maximum(total[tree], _MIN_SIZE) * _WHOLE).astype(np.int64)[order]
    ends, per_tree = np.cumsum(units), np.bincount(tree[order], units, num_trees).astype(np.int64)
    starts = np.cumsum(per_tree) - per_tree
    rank = (2 * np.arange(_NUM_POINTS) + 1)[None, :]
    place = starts[:, None] + per_tree[:, None] * rank // (2 * _NUM_POINTS)
    place = place[per_tree > 0].ravel()
    index = np.searchsorted(ends, place, side="right")
    share = (place - (ends - units)[index]) / units[index]
    rows = order[index]
    columns = {
        name: np.concatenate([getattr(part, name) for part in levels])[rows]
        for name in ("base", "step", "start", "length", "joint", "stem_id", "parent_id")
    }
    is_free = columns["start"] + share * columns["length"] > columns["joint"]
    position = columns["base"] + share[:, None] * columns["step"]
    return _Points(tree[rows][is_free], position[is_free], columns["stem_id"][is_free], columns["parent_id"][is_free])


def _inside(skeleton: Skeleton, level: int, segments: _Segments, points: _Points, scale: Floats) -> Flags:
    """Whether each point lies inside a stem of a level that is not a relative."""
    point, segment = _near(segments, points, scale)
    is_relative = (
        (points.stem_id[point] == segments.stem_id[segment])
        | (points.parent_id[point] == segments.stem_id[segment])
        | (segments.parent_id[segment] == points.stem_id[point])
    )
    is_other = ~is_relative & (points.tree[point] == segments.tree[segment])
    point, segment = point[is_other], segment[is_other]
    step, relative = segments.step[segment], points.position[point] - segments.base[segment]
    length = segments.length[segment]
    share = np.clip((relative * step).sum(axis=1) / np.maximum(length, _MIN_SIZE) ** 2, 0.0, 1.0)
    distance = np.sqrt(((relative - share[:, None] * step) ** 2).sum(axis=1))
    is_free = segments.start[segment] + share * length > segments.joint[segment]
    counted = np.flatnonzero(is_free & (distance < segments.radius[segment]))
    segment, first, last = segment[counted], *segments.share[:, segment[counted]]
    thickness = radii(skeleton, level, segments.stem[segment], first + share[counted] * (last - first))
    inside = np.zeros(len(points.tree), dtype=bool)
    inside[point[counted[distance[counted] < thickness]]] = True
    return inside


def _near(segments: _Segments, points: _Points, scale: Floats) -> tuple[Ints, Ints]:
    """Pairs of a point and a segment with a piece near it."""
    size = scale[segments.tree]
    num = np.maximum(np.ceil(segments.length / size * _NUM_PIECES), 1.0).astype(np.int64)
    segment = row_of_value(num)
    share = (index_in_row(num) + 0.5) / num[segment]
    middles = segments.base[segment] + share[:, None] * segments.step[segment]
    # Trees stand beside each other, so that one search finds the neighbours in all of them.
    pieces = KDTree(_placed(middles, segments.tree[segment], scale), balanced_tree=False, compact_nodes=False)
    # A point inside a stem is at most this far from the middle of one of its pieces.
    reach = (0.5 * segments.length / num + segments.radius) / size
    sites = _placed(points.position, points.tree, scale)
    distance, piece = pieces.query(sites, k=_NUM_NEAREST, distance_upper_bound=float(reach.max(initial=0.0)))
    near = np.append(segment, len(segments.length))[piece]
    point, rank = np.nonzero(distance < np.append(reach, 0.0)[near])
    return point, near[point, rank]


def _placed(positions: Floats, tree: Ints, scale: Floats) -> Floats:
    placed = positions / scale[tree, None]
    placed[:, 0] += _SPACING * tree
    return placed
