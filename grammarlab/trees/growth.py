"""Skeletons of trees from their parameters, level by level (Weber and Penn, SIGGRAPH 1995)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Floats, Ints, take_rows
from grammarlab.randomness import Keys, fold
from grammarlab.trees import branching
from grammarlab.trees.budget import MAX_NODES, check_rows, check_stems
from grammarlab.trees.draws import STEMS, Site, counts, values, varied
from grammarlab.trees.envelope import crown_ratio, pruned_lengths
from grammarlab.trees.foliage import foliage
from grammarlab.trees.orientation import trunk_axes, turned_about_vertical
from grammarlab.trees.parameters import COLUMN, NUM_LEVELS
from grammarlab.trees.skeleton import Skeleton, Stems
from grammarlab.trees.stem_paths import forked, traced
from grammarlab.trees.taper import tapered
from grammarlab.trees.wind import in_wind

_LEAST_SHARE = 0.1
"""Smallest share of a size that its spread may leave, so that every tree has a trunk."""
_LEAST_TRUNK = 0.01
"""Smallest length of a trunk by the height for which the tree is drawn."""
_LEAST_STEM = 1e-4
"""Stems shorter than this share of the height do not grow."""


@dataclass(frozen=True, slots=True, eq=False)
class _Sizes:
    """Sizes of trees in metres."""

    scale: Floats
    """[n] height for which a tree is drawn."""
    height: Floats
    """[n] the same, stretched by z_scale."""
    trunk: Floats
    """[n] length of the trunk before this stretch."""
    radius: Floats
    """[n] radius of the trunk."""


@dataclass(frozen=True, slots=True, eq=False)
class _Shoots:
    """W stems of a level before they split and are pruned, ordered by tree."""

    tree: Ints
    parent: Ints
    key: Keys
    offset: Floats
    point: Floats
    """[W, 3] metres: where it begins."""
    axes: Floats
    """[3, 3, W] axes with which it begins."""
    length: Floats
    """[W] metres, before pruning."""
    room: Floats
    """[W] metres: radius of the parent there; of trunks their own."""

    def longer_than(self, least: Floats) -> _Shoots:
        """Those with a length above a limit [n], in metres, of their tree."""
        rows = np.flatnonzero(self.length > least[self.tree])
        if len(rows) == len(self.tree):
            return self
        return _Shoots(
            tree=self.tree[rows],
            parent=self.parent[rows],
            key=self.key[rows],
            offset=self.offset[rows],
            point=self.point[rows],
            axes=self.axes[..., rows],
            length=self.length[rows],
            room=self.room[rows],
        )


def grow(rows: Floats, keys: Keys, heading: Floats | None = None) -> Skeleton:
    """The skeletons of trees.

    A tree is the same alone and in any batch. It takes about 300 bytes per node and 500 per leaf; `grow_chunks` bounds
    the memory of a batch.

    Args:
        rows: [n, P] parameters (`grammarlab.trees.parameters.COLUMNS`), within their limits.
        keys: [n] keys of the trees (`grammarlab.randomness.root_keys`).
        heading: [n] radians by which whole trees are turned about the vertical: trunks curve about one axis, so that
            without it all trees of a forest would lean along z. 0 for all when left out; wind is not turned.

    Raises:
        UsageError: If a parameter is not a number or out of its limits, or a tree too large.

    >>> import grammarlab as gl
    >>> trees = gl.sample(gl.load("palm"), 2, seed=1)
    >>> len(gl.grow(trees.rows, trees.keys).leaves) == len(trees.leaves)
    True
    """
    rows = np.asarray(rows, dtype=np.float64)
    check_rows(rows)
    trunk_keys = fold(keys, STEMS)
    sizes = _sizes(rows, trunk_keys)
    levels = [_stems(rows, sizes, 0, _trunks(rows, sizes, trunk_keys, heading), None)]
    while len(levels) < NUM_LEVELS:
        level = len(levels)
        stems = _stems(rows, sizes, level, _shoots(rows, sizes, level, levels), levels[-1])
        if not len(stems):
            break
        levels.append(stems)
    levels = in_wind(rows, levels)
    return Skeleton(rows, keys, sizes.scale, tuple(levels), foliage(rows, levels, sizes.height))


def _sizes(rows: Floats, trunk_keys: Keys) -> _Sizes:
    trees = np.arange(len(rows))

    def size(name: str, site: Site) -> Floats:
        drawn = varied(rows, trees, name, trunk_keys, site)
        return np.maximum(drawn, _LEAST_SHARE * values(rows, trees, name))

    scale = size("scale", Site.SCALE)
    height = scale * size("z_scale", Site.Z_SCALE)
    share = np.maximum(varied(rows, trees, "length_0", trunk_keys, Site.LENGTH), _LEAST_TRUNK)
    radius = share * scale * values(rows, trees, "ratio") * size("scale_0", Site.RADIUS)
    return _Sizes(scale, height, share * scale, radius)


def _trunks(rows: Floats, sizes: _Sizes, keys: Keys, heading: Floats | None) -> _Shoots:
    num = len(rows)
    axes = trunk_axes(num)
    return _Shoots(
        tree=np.arange(num),
        parent=np.full(num, -1),
        key=keys,
        offset=np.zeros(num),
        point=np.zeros((num, 3)),
        axes=axes if heading is None else turned_about_vertical(axes, heading),
        length=sizes.trunk * sizes.height / sizes.scale,
        room=sizes.radius,
    )


def _shoots(rows: Floats, sizes: _Sizes, level: int, levels: list[Stems]) -> _Shoots:
    """Stems of a level, from those of the levels before."""
    stems = levels[level - 1]
    segments = branching.num_segments(rows, stems.tree, level - 1)
    bare = branching.bare_share(rows, stems, sizes.height, level - 1)
    start = branching.bearing_start(stems, bare, segments)
    num = branching.num_children(rows, level, stems, levels[level - 2] if level > 1 else None, sizes.trunk)
    num = branching.rounded(num * (1.0 - start) / np.where(bare < 1.0, 1.0 - bare, 1.0))
    num[counts(rows, stems.tree, "levels") <= level] = 0
    check_stems(rows, level, np.bincount(stems.tree, num, len(rows)))
    spots = branching.spots(stems, start, segments, num)
    tree, key = stems.tree[spots.stem], fold(fold(stems.key[spots.stem], Site.CHILDREN), spots.index)
    reference = sizes.trunk[tree] if level == 1 else stems.length[spots.stem]
    factor = varied(rows, tree, f"length_{level}", key, Site.LENGTH)
    if level == 1:
        factor *= crown_ratio(rows, tree, branching.below_top(spots.along, bare[spots.stem]))
    else:
        factor *= 1.0 - 0.6 * spots.along
    taper = values(rows, tree, f"taper_{level - 1}")
    return _Shoots(
        tree=tree,
        parent=spots.stem,
        key=key,
        offset=spots.along * stems.length[spots.stem],
        point=spots.positions(stems),
        axes=branching.child_axes(rows, level, spots, stems, bare, key),
        length=factor * reference,
        room=tapered(stems.radius[spots.stem], stems.length[spots.stem], taper, spots.along),
    ).longer_than(_LEAST_STEM * sizes.scale)


def _stems(rows: Floats, sizes: _Sizes, level: int, shoots: _Shoots, parents: Stems | None) -> Stems:
    """Stems of a level with their clones, paths, lengths and radii."""
    forks = forked(rows, level, shoots.tree, shoots.key)
    paths = traced(rows, level, shoots.tree, shoots.axes, forks)
    root = forks.root
    length, radius = shoots.length, shoots.room
    if parents is not None:
        length = pruned_lengths(rows, sizes.height, sizes.scale, shoots.tree, shoots.point, length, root, paths)
        reference = sizes.trunk[shoots.tree] if level == 1 else parents.length[shoots.parent]
        thinner = (length / reference) ** values(rows, shoots.tree, "ratio_power")
        radius = np.minimum(radius, parents.radius[shoots.parent] * thinner)
    node_root = np.repeat(root, np.diff(paths.node_offsets))
    stems = Stems(
        tree=shoots.tree[root],
        parent=shoots.parent[root],
        source=forks.source,
        first=forks.first,
        key=forks.key,
        offset=shoots.offset[root],
        length=length[root],
        radius=radius[root],
        node_offsets=paths.node_offsets,
        points=shoots.point[node_root] + length[node_root, None] * paths.points,
        frames=paths.frames,
        along=paths.along,
    )
    return _longer_than(stems, _LEAST_STEM * sizes.scale)


def _longer_than(stems: Stems, least: Floats) -> Stems:
    """Stems with a length above a limit [n], in metres, of their tree; clones are as long as the stem they are of."""
    rows = np.flatnonzero(stems.length > least[stems.tree])
    if len(rows) == len(stems):
        return stems
    row = np.full(len(stems) + 1, -1)  # the last one is for source -1
    row[rows] = np.arange(len(rows))
    nodes, node_offsets = take_rows(stems.node_offsets, rows)
    return Stems(
        tree=stems.tree[rows],
        parent=stems.parent[rows],
        source=row[stems.source[rows]],
        first=stems.first[rows],
        key=stems.key[rows],
        offset=stems.offset[rows],
        length=stems.length[rows],
        radius=stems.radius[rows],
        node_offsets=node_offsets,
        points=stems.points[nodes],
        frames=stems.frames[nodes],
        along=stems.along[nodes],
    )


def grow_chunks(
    rows: Floats, keys: Keys, max_nodes: int = MAX_NODES // 4, heading: Floats | None = None
) -> Iterator[Skeleton]:
    """The skeletons of trees, in consecutive chunks that bound the memory.

    Args:
        rows: [n, P] parameters.
        keys: [n] keys of the trees.
        max_nodes: nodes that a chunk has at most, a leaf counted as two; a tree that may have more is a chunk of its
            own.
        heading: [n] as of `grow`.

    Raises:
        UsageError: As `grow`.
    """
    rows = np.asarray(rows, dtype=np.float64)
    check_rows(rows)

    def chunk(start: int, end: int) -> Skeleton:
        return grow(rows[start:end], keys[start:end], None if heading is None else heading[start:end])

    nodes = np.minimum(expected_nodes(rows), max_nodes)
    start, total = 0, 0.0
    for tree, num in enumerate(nodes):
        if tree > start and total + num > max_nodes:
            yield chunk(start, tree)
            start, total = tree, 0.0
        total += num
    if start < len(rows):
        yield chunk(start, len(rows))


def expected_nodes(rows: Floats) -> Floats:
    """[n] nodes and, counted twice, leaves of trees whose stems bear as many as they can."""
    num = 1.0 + rows[:, COLUMN["base_splits"]]
    nodes = np.zeros(len(rows))
    for level in range(NUM_LEVELS):
        segments = rows[:, COLUMN[f"curve_res_{level}"]]
        num = num * (1.0 + rows[:, COLUMN[f"seg_splits_{level}"]]) ** (segments - 1.0)
        if level > 0:
            num = num * rows[:, COLUMN[f"branches_{level}"]]
        nodes += np.where(rows[:, COLUMN["levels"]] > level, num * (segments + 1.0), 0.0)
        leaves = num * np.abs(rows[:, COLUMN["leaves"]]) * rows[:, COLUMN["leaf_quality"]]
        nodes += np.where(rows[:, COLUMN["levels"]] == level + 1, 2.0 * leaves, 0.0)
    return nodes
