"""Levels of detail: how many triangles each stem has, which stems and leaves are drawn, and how large leaves are.

Everything follows from the full tree and is chosen tree by tree, so that a tree is the same in any batch: fewer corners
and cross-sections, then no more of the thinnest stems, and fewer but larger leaves of the same total area. What reaches
farthest in a direction stays.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.randomness import fold, uniforms
from grammarlab.trees.draws import counts, values
from grammarlab.trees.leaf_shapes import num_blossom_triangles, num_leaf_triangles
from grammarlab.trees.rings import Stations
from grammarlab.trees.skeleton import Leaves, Skeleton, Stems
from grammarlab.trees.tubes import num_triangles

Detail = Literal["full", "medium", "low", "cards"]
DETAILS: tuple[str, ...] = get_args(Detail)
"""Levels of detail: a full tree, 40 % and 15 % of its triangles, and crossed pictures."""
SHARES = {"full": 1.0, "medium": 0.4, "low": 0.15}
"""Triangles by those of the full tree."""
_MOST_SIDES = (24, 16, 8, 5)
"""Largest number of corners of a cross-section, by level."""
_SIDES_BY_ROOT = 75.0
"""Corners more than three by the root of a radius in heights of the tree: a trunk of 40 cm at 14 m has 15, a twig 4."""
_SIDES_PER_LOBE = 6
_STEPS = ((1.0, 1.0), (1.0, 0.8), (0.8, 0.7), (0.67, 0.6), (0.5, 0.6), (0.4, 0.5), (0.3, 0.4), (0.2, 0.3), (0.0, 0.2))
"""Shares of the cross-sections of a stem and of their corners that coarser and coarser drawings have."""
_GROWTH_SHARE = 0.04
"""Largest growth of a leaf in a coarser drawing, by the height of the tree."""
_REACHING_STATIONS = 12
"""Cross-sections with which a stem that reaches farthest keeps its bends."""
_LANE = 32
"""Lane below the key of a stem for the order in which its leaves are left out."""


@dataclass(frozen=True, slots=True, eq=False)
class StemDetail:
    """Drawings of the stems of one level."""

    drawn: Flags
    """[S] whether a stem is drawn."""
    num_stations: Ints
    """[S] its cross-sections, tip included; at least two."""
    sides: Ints
    """[S] corners of a cross-section, at least three."""


@dataclass(frozen=True, slots=True, eq=False)
class LeafDetail:
    """Drawings of leaves."""

    rows: Ints
    """[K] leaves to draw, ascending."""
    growth: Floats
    """[K] factor of their length and width."""
    detail: int
    """Which mesh: 0 full, 1 medium, 2 low."""


def full_sides(skeleton: Skeleton, level: int) -> Ints:
    """[S] corners of the cross-sections of the stems of a level at full detail: more for thicker stems."""
    stems = skeleton.levels[level]
    share = stems.radius / np.maximum(skeleton.scale[stems.tree], 1e-9)
    sides = np.clip(3 + np.floor(_SIDES_BY_ROOT * np.sqrt(share)), 3, _MOST_SIDES[level]).astype(np.int64)
    return np.maximum(sides, np.minimum(_SIDES_PER_LOBE * lobes(skeleton, level), 96))


def lobes(skeleton: Skeleton, level: int) -> Ints:
    """[S] lobes around the stems of a level: those of the trunk only."""
    tree = skeleton.levels[level].tree
    return counts(skeleton.rows, tree, "lobes") if level == 0 else np.zeros(len(tree), np.int64)


def stem_details(
    skeleton: Skeleton, stations: list[Stations], leaf_triangles: Ints, full_leaf_triangles: Ints, detail: str
) -> list[StemDetail]:
    """Drawings of the stems of each level.

    Args:
        skeleton: the trees.
        stations: cross-sections of all stems at full detail, by level.
        leaf_triangles: [n] triangles of the leaves of each tree as they are drawn.
        full_leaf_triangles: [n] triangles of the leaves at full detail.
        detail: ``full``, ``medium`` or ``low``.
    """
    levels = range(len(skeleton.levels))
    sides = [full_sides(skeleton, level) for level in levels]
    full = [StemDetail(np.ones(len(k), bool), stations[level].counts, k) for level, k in enumerate(sides)]
    if detail == "full":
        return full
    tree = np.concatenate([stems.tree for stems in skeleton.levels])
    num = np.concatenate([part.num_stations for part in full])
    corners = np.concatenate(sides)
    total = _sums(tree, num_triangles(num - 1, corners), skeleton.num_trees)
    budget = np.maximum(SHARES[detail] * (total + full_leaf_triangles) - leaf_triangles, 0.5 * SHARES[detail] * total)
    step = np.full(skeleton.num_trees, len(_STEPS) - 1)
    options = [(_thinned(num, rings, 2), _thinned(corners, around, 3)) for rings, around in _STEPS]
    for index in reversed(range(len(_STEPS))):
        fits = _sums(tree, num_triangles(options[index][0] - 1, options[index][1]), skeleton.num_trees) <= budget
        step[fits] = index
    rings, around = (np.stack(columns) for columns in zip(*options, strict=True))
    row, chosen = np.arange(len(tree)), step[tree]
    num, corners = rings[chosen, row], around[chosen, row]
    # What is left of the budget goes to the thickest stems, drawn one step finer.
    finer = np.maximum(chosen - 1, 0)
    triangles = num_triangles(num - 1, corners)
    more = num_triangles(rings[finer, row] - 1, around[finer, row]) - triangles
    rest = budget - _sums(tree, triangles, skeleton.num_trees)
    radius = np.concatenate([stems.radius for stems in skeleton.levels])
    promoted = _running_sums(np.lexsort((-radius, tree)), tree, more) <= rest[tree]
    num, corners = np.where(promoted, rings[finer, row], num), np.where(promoted, around[finer, row], corners)
    reaching = _reaching(skeleton)
    whole = np.concatenate([part.num_stations for part in full])
    num = np.where(reaching, np.maximum(num, np.minimum(whole, _REACHING_STATIONS)), num)
    ends = np.cumsum([0, *(len(stems) for stems in skeleton.levels)])
    drawn = _thickest(skeleton, tree, num_triangles(num - 1, corners), budget, reaching)
    return [
        StemDetail(drawn[level], num[ends[level] : ends[level + 1]], corners[ends[level] : ends[level + 1]])
        for level in levels
    ]


def leaf_detail(skeleton: Skeleton, detail: str) -> tuple[LeafDetail, Ints, Ints]:
    """Leaves to draw, and the triangles [n] of the leaves of each tree as drawn and at full detail."""
    leaves, num_trees = skeleton.leaves, skeleton.num_trees
    index = tuple(SHARES).index(detail)
    full = _leaf_triangles(skeleton, 0)
    total = _sums(leaves.tree, full, num_trees)
    if detail == "full":
        rows = np.arange(len(leaves))
        return LeafDetail(rows, np.ones(len(rows)), 0), total, total
    triangles = _leaf_triangles(skeleton, index)
    # Leaves and blossoms are left out in equal shares, so that both keep their total areas.
    rank = _ranks(skeleton)
    group = 2 * leaves.tree + leaves.is_blossom
    number = np.bincount(group, minlength=2 * num_trees)
    size = np.bincount(group, triangles, 2 * num_trees)
    budget = SHARES[detail] * np.bincount(group, full, 2 * num_trees)
    share = np.where(size > 0, budget / np.maximum(size, 1.0), 1.0)
    # A few large leaves are a silhouette of their own, and all stay.
    longest = np.zeros(num_trees)
    np.maximum.at(longest, leaves.tree, leaves.length)
    room = _GROWTH_SHARE * skeleton.scale / np.maximum(longest, 1e-9)
    share = np.maximum(share, 1.0 / np.maximum(1.0 + room, 1.0).repeat(2) ** 2)
    most = np.ceil(np.minimum(share, 1.0) * number)
    drawn = rank < most[group]
    drawn |= _extremes(leaves.tree, leaves.position + leaves.length[:, None] * leaves.frame[:, :, 2], num_trees)
    area = leaves.length * leaves.width
    before = np.bincount(group, area, 2 * num_trees)
    after = np.bincount(group[drawn], area[drawn], 2 * num_trees)
    growth = np.sqrt(before / np.where(after > 0.0, after, 1.0))
    rows = np.flatnonzero(drawn)
    return LeafDetail(rows, growth[group[rows]], index), _sums(leaves.tree[rows], triangles[rows], num_trees), total


def _leaf_triangles(skeleton: Skeleton, index: int) -> Ints:
    """[L] triangles of leaves and blossoms, with stalks at full detail."""
    leaves, rows = skeleton.leaves, skeleton.rows
    blades = num_leaf_triangles(counts(rows, leaves.tree, "leaf_shape"), index)
    if index == 0:
        blades = blades + stalked(skeleton)
    return np.where(leaves.is_blossom, num_blossom_triangles(counts(rows, leaves.tree, "blossom_shape"), index), blades)


def _ranks(skeleton: Skeleton) -> Ints:
    """[L] rank of each leaf among the leaves, or the blossoms, of its tree in an order of its own."""
    leaves = skeleton.leaves
    draws = np.empty(len(leaves))
    for level, stems in enumerate(skeleton.levels):
        rows = np.flatnonzero(leaves.level == level)
        draws[rows] = uniforms(fold(stems.key[leaves.stem[rows]], _LANE), _index_of_leaf(leaves, rows))
    group = 2 * leaves.tree + leaves.is_blossom
    order = np.lexsort((draws, group))
    rank = np.empty(len(leaves), np.int64)
    sorted_group = group[order]
    rank[order] = np.arange(len(order)) - np.searchsorted(sorted_group, sorted_group)
    return rank


def _index_of_leaf(leaves: Leaves, rows: Ints) -> Ints:
    """[K] number of each leaf among those of its stem; the leaves of one stem are one run."""
    stem = leaves.stem[rows]
    starts = np.flatnonzero(np.concatenate([[True], stem[1:] != stem[:-1]])) if len(stem) else np.zeros(0, np.int64)
    run = np.cumsum(np.concatenate([[False], stem[1:] != stem[:-1]])) if len(stem) else starts
    return np.arange(len(stem)) - starts[run]


def _thickest(skeleton: Skeleton, tree: Ints, triangles: Ints, budget: Floats, reaching: Flags) -> list[Flags]:
    """[S] for each level, the stems to draw: the thickest, within a budget [n] of triangles of each tree.

    Stems of all levels that reach farthest come first, with all that carries them.
    """
    levels = skeleton.levels
    ends = np.cumsum([0, *(len(stems) for stems in levels)])
    radius = np.concatenate([stems.radius for stems in levels])
    drawn = [reaching[ends[level] : ends[level + 1]].copy() for level in range(len(levels))]
    for level in reversed(range(len(levels))):
        _mark_carriers(levels, drawn, level)
    first = np.concatenate(drawn)
    within = (_running_sums(np.lexsort((-radius, ~first, tree)), tree, triangles) <= budget[tree]) | first
    flags = [within[ends[level] : ends[level + 1]].copy() for level in range(len(levels))]
    for level, stems in enumerate(levels):
        if level > 0:
            flags[level] &= flags[level - 1][stems.parent]
        else:
            flags[level] |= ~stems.is_clone
        _drop_orphans(stems, flags[level])
    return flags


def _mark_carriers(levels: tuple[Stems, ...], drawn: list[Flags], level: int) -> None:
    """Add to the stems to draw the sources of clones and the parents of all of them."""
    stems = levels[level]
    carriers = np.flatnonzero(drawn[level] & stems.is_clone)
    while len(carriers):
        sources = stems.source[carriers]
        drawn[level][sources] = True
        carriers = sources[stems.is_clone[sources]]
    if level > 0:
        drawn[level - 1][stems.parent[drawn[level]]] = True


def _drop_orphans(stems: Stems, drawn: Flags) -> None:
    """Remove clones whose sources are not drawn."""
    while True:
        orphans = drawn & stems.is_clone & ~drawn[stems.source]
        if not orphans.any():
            return
        drawn[orphans] = False


def _reaching(skeleton: Skeleton) -> Flags:
    """[S] whether a stem, of all levels, has a node that is the farthest of its tree in a direction of the axes."""
    num_nodes = np.concatenate([stems.num_nodes for stems in skeleton.levels])
    tree = np.concatenate([stems.tree for stems in skeleton.levels])
    stem = np.repeat(np.arange(len(tree)), num_nodes)
    points = np.concatenate([stems.points for stems in skeleton.levels])
    flags = np.zeros(len(tree), dtype=bool)
    flags[stem[_extremes(tree[stem], points, skeleton.num_trees)]] = True
    return flags


def _extremes(tree: Ints, points: Floats, num_trees: int) -> Flags:
    """[N] whether a point [N, 3] has the largest or the smallest coordinate of those of its tree [N]."""
    flags = np.zeros(len(tree), dtype=bool)
    for column in (*points.T, *-points.T):
        best = np.full(num_trees, -np.inf)
        np.maximum.at(best, tree, column)
        flags |= column == best[tree]
    return flags


def stalked(skeleton: Skeleton) -> Flags:
    """[L] whether a leaf has a stalk of its own."""
    leaves = skeleton.leaves
    return (stalk_lengths(skeleton) > 0.0) & ~leaves.is_blossom


def stalk_lengths(skeleton: Skeleton) -> Floats:
    """[L] lengths of stalks by those of their blades."""
    return values(skeleton.rows, skeleton.leaves.tree, "leaf_stem_len")


def _running_sums(order: Ints, tree: Ints, numbers: Ints) -> Ints:
    """[S] sums of numbers [S] of the rows of the same tree up to each, in an order [S] in which trees ascend."""
    sums = np.cumsum(numbers[order])
    ordered = tree[order]
    sums -= np.concatenate([[0], sums])[np.searchsorted(ordered, ordered)]
    result = np.empty_like(sums)
    result[order] = sums
    return result


def _thinned(number: Ints, share: float, least: int) -> Ints:
    return np.maximum(np.rint(number * share).astype(np.int64), least)


def _sums(tree: Ints, numbers: Ints, num_trees: int) -> Ints:
    return np.bincount(tree, numbers, num_trees).astype(np.int64)
