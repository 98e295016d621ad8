"""Measures of trees, taken from their stems and leaves.

A model with 90 parameters is judged by few properties of what it draws: how tall and slender it is, whether it leans,
how much leaf its crown has. Foresters have terms for most of them, which are used here. Every measure is a function of
the skeleton only, the same for a tree alone and in any batch, and computed for all trees of a batch at once.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.trees.clashes import clash_shares
from grammarlab.trees.skeleton import Leaves, Skeleton
from grammarlab.trees.taper import radii

_BREAST_HEIGHT = 1.3
"""Metres: where foresters measure the diameter of a trunk."""
_SMALL_TRUNK = 0.5
"""Share of the length at which trunks shorter than 2.6 m are measured."""
_BLADE = 2.0 / 3.0
"""Area of a blade by its length and width (Montgomery 1911, and close to all broad leaves since)."""
_DIRECTIONS = 16
"""Directions in which a crown's extent is measured: its shadow is overestimated by 1.3 % at most."""
_MIN_SIZE = 1e-6
"""Metres, smallest divisor."""


@dataclass(frozen=True, slots=True)
class Measure:
    """A number that describes a tree."""

    name: str
    unit: str
    """``m``, ``m2``, or empty for shares, ratios and counts."""
    why: str
    """Definition and reason, in one sentence."""
    log: bool
    """Whether ratios of values matter instead of differences; zeros are possible."""


def _measures() -> Iterator[Measure]:
    yield Measure("height", "m", "highest point of stems and leaves above the ground", True)
    yield Measure("crown_width", "m", "spread of branches and leaves, the mean over directions", True)
    yield Measure(
        "crown_ratio", "", "width of the crown by its own height: below 1 for columns, above for parasols", True
    )
    yield Measure(
        "slenderness", "", "height by the diameter at 1.3 m: a slender tree breaks, a stout one is a stump", True
    )
    yield Measure(
        "straightness", "", "height of the ends of the trunk and its forks by their length: below 1 they bend", False
    )
    yield Measure(
        "lean", "", "distance of the crown's centre from the trunk's base by the height: whether it stands", True
    )
    yield Measure("lowest", "", "lowest point of the stems by the height: below 0 they grow into the ground", False)
    yield Measure(
        "child_thickness",
        "",
        "radius of branches by their parent's there, the mean by cross-section: wood gets finer at each fork",
        False,
    )
    yield Measure("leaf_area", "m2", "area of one side of all leaves: what the tree lives from", True)
    yield Measure("leaf_area_index", "", "leaf area by the area of the crown's shadow: how dense the crown is", True)
    yield Measure("clash", "", "share of the stems' length that lies inside other stems, away from joints", False)
    yield Measure(
        "twig_diameter", "m", "diameter of the thickest stem of the last level: wood is finest at the end", True
    )
    yield Measure("leaf_size", "", "mean length of leaves by the height: large leaves need a large plant", True)
    yield Measure("visible_leaves", "", "leaves seen from the side, those behind others left out", True)
    yield Measure("clear_stem", "m", "height of the lowest branch or leaf: what may pass below the crown", False)
    yield Measure("num_stems", "", "number of stems", True)
    yield Measure("num_leaves", "", "number of leaves, without blossoms", True)


MEASURES = {measure.name: measure for measure in _measures()}
"""All measures by name, in the order of the columns of `measure`."""


def measure_trees(skeleton: Skeleton) -> dict[str, Floats]:
    """Measures [n] of trees by their names.

    >>> import grammarlab as gl
    >>> trees = gl.sample(gl.load("palm"), 2, seed=1)
    >>> gl.measure_trees(trees)["height"].shape
    (2,)
    """
    return dict(zip(MEASURES, measure(skeleton).T, strict=True))


def measure(skeleton: Skeleton) -> Floats:
    """[n, M] the `MEASURES` of trees; finite."""
    if not skeleton.num_trees:
        return np.zeros((0, len(MEASURES)))
    body = _Body(skeleton)
    height, shadow = np.maximum(body.top, _MIN_SIZE), np.maximum(body.crown_shadow, _MIN_SIZE)
    columns = {
        "height": body.top,
        "crown_width": body.crown_width,
        "crown_ratio": body.crown_width / np.maximum(body.crown_height, _MIN_SIZE),
        "slenderness": height / np.maximum(body.trunk_diameter, _MIN_SIZE),
        "straightness": body.straightness,
        "lean": body.crown_distance / height,
        "lowest": body.bottom / height,
        "child_thickness": body.child_thickness,
        "leaf_area": body.leaf_area,
        "leaf_area_index": body.leaf_area / shadow,
        "clash": clash_shares(skeleton),
        "twig_diameter": body.twig_diameter,
        "leaf_size": body.leaf_length / height,
        "visible_leaves": body.visible_leaves,
        "clear_stem": body.clear_stem,
        "num_stems": body.num_stems,
        "num_leaves": body.num_leaves,
    }
    return np.column_stack([columns[name] for name in MEASURES]).astype(np.float64)


class _Body:
    """Quantities of n trees of which measures are made."""

    def __init__(self, skeleton: Skeleton) -> None:
        self.skeleton, self.levels, self.leaves = skeleton, skeleton.levels, _foliage(skeleton.leaves)
        self.num = skeleton.num_trees
        self.num_leaves = self._count(self.leaves.tree)
        self.num_stems = np.sum([self._count(stems.tree) for stems in self.levels], axis=0)
        nodes = [np.bincount(stems.tree, stems.num_nodes, self.num).astype(np.int64) for stems in self.levels]
        tips = self.leaves.position + self.leaves.frame[:, :, 2] * self.leaves.length[:, None]
        self.trunk = (self.levels[0].points, nodes[0])
        """Points [N, 3], by tree, and their number [n] in each tree."""
        branches = [(stems.points, num) for stems, num in zip(self.levels[1:], nodes[1:], strict=True)]
        self.stems = (self.trunk, *branches)
        self.crown = (*branches, (tips, self.num_leaves))

    # Heights ---------------------------------------------------------------------------------------------------------

    @cached_property
    def top(self) -> Floats:
        """Metres, the highest point."""
        return np.maximum(self._extreme(np.maximum, (self.trunk, *self.crown), 0.0), 0.0)

    @cached_property
    def bottom(self) -> Floats:
        """Metres, the lowest point of stems; trunks begin at 0."""
        return self._extreme(np.minimum, self.stems, 0.0)

    @cached_property
    def clear_stem(self) -> Floats:
        """Metres, the lowest point of the crown; the highest point of trees without one."""
        return np.where(self.has_crown, np.maximum(self._crown_bottom, 0.0), self.top)

    @cached_property
    def crown_height(self) -> Floats:
        """Metres from the lowest to the highest point of the crown; of the tree if it has none."""
        top = self._extreme(np.maximum, self.crown, 0.0)
        return np.where(self.has_crown, top - self._crown_bottom, self.top)

    @cached_property
    def has_crown(self) -> Flags:
        """Whether there are branches or leaves."""
        return np.sum([counts for _, counts in self.crown], axis=0) > 0

    @cached_property
    def _crown_bottom(self) -> Floats:
        return self._extreme(np.minimum, self.crown, 0.0)

    def _extreme(self, ufunc: np.ufunc, parts: Sequence[tuple[Floats, Ints]], empty: float) -> Floats:
        """Extreme height of points; ``empty`` for trees without any."""
        identity = -np.inf if ufunc is np.maximum else np.inf
        extreme = ufunc.reduce([_reduced(ufunc, points[:, 1], counts, identity) for points, counts in parts])
        return np.where(np.isfinite(extreme), extreme, empty)

    # The crown from above --------------------------------------------------------------------------------------------

    @cached_property
    def crown_width(self) -> Floats:
        """Metres, the mean over directions."""
        return 2.0 * self._reach.mean(axis=1)

    @cached_property
    def crown_shadow(self) -> Floats:
        """Square metres of the convex outline of the crown, from above."""
        # The outline is a polygon with one edge for each direction, at the crown's reach.
        step = 2.0 * np.pi / _DIRECTIONS
        neighbours = np.roll(self._reach, 1, axis=1) + np.roll(self._reach, -1, axis=1)
        edges = (neighbours - 2.0 * self._reach * np.cos(step)) / np.sin(step)
        return np.maximum(0.5 * (self._reach * edges).sum(axis=1), 0.0)

    @cached_property
    def crown_distance(self) -> Floats:
        """Metres from the trunk's base to the centre of the leaves, or, without leaves, of the nodes of stems."""
        leaf_sum = _reduced(np.add, self.leaves.position[:, ::2], self.num_leaves, 0.0)
        node_sum = np.sum([_reduced(np.add, points[:, ::2], counts, 0.0) for points, counts in self.stems], axis=0)
        num_nodes = np.sum([counts for _, counts in self.stems], axis=0)
        is_leafy = self.num_leaves > 0
        total = np.where(is_leafy[:, None], leaf_sum, node_sum)
        return np.hypot(total[:, 0], total[:, 1]) / np.maximum(np.where(is_leafy, self.num_leaves, num_nodes), 1)

    @cached_property
    def _reach(self) -> Floats:
        """[n, D] metres from the trunk's base to where the crown ends in each direction; of the trunk without one."""
        reach = np.maximum.reduce([_support(*part) for part in self.crown])
        return np.where(self.has_crown[:, None], reach, _support(*self.trunk))

    # Wood ------------------------------------------------------------------------------------------------------------

    @cached_property
    def trunk_diameter(self) -> Floats:
        """Metres, 1.3 m along the trunk; where it has split, of a trunk with the area of all parts."""
        trunks = self.levels[0]
        along = np.minimum(_BREAST_HEIGHT / np.maximum(trunks.length, _MIN_SIZE), _SMALL_TRUNK)
        # A clone is a part from where it split.
        exists = ~trunks.is_clone | (along > trunks.along[trunks.node_offsets[:-1]])
        radius = np.where(exists, radii(self.skeleton, 0, np.arange(len(trunks)), along), 0.0)
        return 2.0 * np.sqrt(np.bincount(trunks.tree, radius**2, self.num))

    @cached_property
    def straightness(self) -> Floats:
        """Height of the ends of trunks and their forks by their length, the mean."""
        trunks = self.levels[0]
        rise = trunks.points[trunks.node_offsets[1:] - 1, 1] / np.maximum(trunks.length, _MIN_SIZE)
        return np.bincount(trunks.tree, rise, self.num) / np.maximum(self._count(trunks.tree), 1)

    @cached_property
    def child_thickness(self) -> Floats:
        """Mean ratio of radii, weighted by the cross-section of the branches; 0 for trees without branches."""
        # Near its end a parent is as thin as any shoot there: the largest ratio is 1 for almost all trees.
        section, weighted = np.zeros(self.num), np.zeros(self.num)
        for level, (parents, children) in enumerate(pairwise(self.levels)):
            row = np.flatnonzero(~children.is_clone)
            parent, tree = children.parent[row], children.tree[row]
            along = np.clip(children.offset[row] / np.maximum(parents.length[parent], _MIN_SIZE), 0.0, 1.0)
            thickness = np.maximum(radii(self.skeleton, level, parent, along), _MIN_SIZE)
            radius = children.radius[row]
            section += np.bincount(tree, radius**2, self.num)
            weighted += np.bincount(tree, radius**3 / thickness, self.num)
        return weighted / np.maximum(section, _MIN_SIZE**2)

    @cached_property
    def twig_diameter(self) -> Floats:
        """Metres, at the base of the thickest stem of the last level of each tree."""
        radius = np.zeros(self.num)
        for level, stems in enumerate(self.levels):
            radius = np.where(self._count(stems.tree) > 0, self._thickest(level), radius)
        return 2.0 * radius

    def _thickest(self, level: int) -> Floats:
        """Metres, the largest radius of stems at their base."""
        stems, radius = self.levels[level], np.zeros(self.num)
        np.maximum.at(radius, stems.tree, stems.radius)
        return radius

    # Leaves ----------------------------------------------------------------------------------------------------------

    @cached_property
    def leaf_area(self) -> Floats:
        """Square metres, of one side."""
        area = self.leaves.length * self.leaves.width
        return np.bincount(self.leaves.tree, _BLADE * area, self.num).astype(np.float64)

    @cached_property
    def leaf_length(self) -> Floats:
        """Metres, the mean; 0 without leaves."""
        return np.bincount(self.leaves.tree, self.leaves.length, self.num) / np.maximum(self.num_leaves, 1)

    @cached_property
    def visible_leaves(self) -> Floats:
        """Leaves that no other hides, the mean of the views along x and along z.

        A view is a grid of squares as large as a leaf of the tree; of the leaves in a square one is seen.
        """
        tree, position = self.leaves.tree, self.leaves.position
        size = np.maximum(np.sqrt(self.leaf_area / np.maximum(self.num_leaves, 1)), _MIN_SIZE)
        cells = np.floor(position / size[tree, None]).astype(np.int64)
        front, side = (_num_different(tree, cells[:, across], cells[:, 1], self.num) for across in (0, 2))
        return (front + side) / 2.0

    def _count(self, trees: Ints) -> Ints:
        return np.bincount(trees, minlength=self.num)


def _foliage(leaves: Leaves) -> Leaves:
    """The leaves without the blossoms."""
    if not leaves.is_blossom.any():
        return leaves
    return leaves.take(~leaves.is_blossom)


def _reduced(ufunc: np.ufunc, values: Floats, counts: Ints, empty: float) -> Floats:
    """[n, ...] reduction of the rows [N, ...] of each tree; ``empty`` for trees without rows."""
    result = np.full((len(counts), *values.shape[1:]), empty)
    present = counts > 0
    if present.any():
        starts = (np.cumsum(counts) - counts)[present]
        result[present] = ufunc.reduceat(values, starts, axis=0)
    return result


def _support(points: Floats, counts: Ints) -> Floats:
    """[n, D] largest extent of points [N, 3] in each direction of the ground; -inf for trees without points."""
    angles = 2.0 * np.pi / _DIRECTIONS * np.arange(_DIRECTIONS // 2)
    along = points[:, :1] * np.cos(angles) + points[:, 2:] * np.sin(angles)
    # The other half of the directions are the opposite ones.
    forward = _reduced(np.maximum, along, counts, -np.inf)
    backward = -_reduced(np.minimum, along, counts, np.inf)
    return np.concatenate([forward, backward], axis=1)


def _num_different(tree: Ints, across: Ints, up: Ints, num_trees: int) -> Ints:
    """[n] number of different cells of the leaves of each tree."""
    if not len(tree):
        return np.zeros(num_trees, dtype=np.int64)
    across, up = across - across.min(), up - up.min()
    width, height = int(across.max()) + 1, int(up.max()) + 1
    # Sorting is several times as fast as hashing, which np.unique does.
    keys = np.sort((tree * height + up) * width + across)
    first = np.append(True, keys[1:] != keys[:-1])
    return np.bincount(keys[first] // (width * height), minlength=num_trees)
