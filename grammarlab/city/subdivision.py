"""Parcels of blocks: recursive cuts along oriented boxes with forced street access.

The method is that of C. Vanegas et al., "Procedural generation of parcels in urban modeling", Eurographics 2012,
section 5.

A plot is cut across or along its smallest box; cuts that would leave a part without a street are not made. Whether a
plot is cut at all is drawn so that the areas of parcels have a given log-normal distribution: in a halving tree, the
share of the *ground* that belongs to parcels of an area decides, and for a log-normal distribution of parcels with the
median m and the spread s that share is log-normal with the median m exp(s^2) and the same spread.

The address of a parcel is its path in the block: 1 for the block, 2p and 2p + 1 for the parts of plot p. All plots of
all blocks are cut together, level by level, but each by its own address only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.special import ndtr

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.city.plot_cuts import Boxes, Cuts, Plots, cuts_along, parts_of, smallest_boxes
from grammarlab.city.shared_corners import SNAP, snapped
from grammarlab.randomness import Keys, fold, uniforms

_MAX_LEVELS = 30
"""Budget: cuts that follow each other; each takes at least a fifth away."""
_BLOCK_SHARE = 0.35
"""Prior: share of the variance of log areas that is between blocks."""
_FRACTIONS = (0.5, 0.36, 0.64)
"""Places of cuts along a box, as shares of its side."""
_JITTER = 0.06
"""Prior: largest random distance of a cut from its place, as a share of the side."""
_MIN_FILL = 0.55
"""Tolerance: least area of a part by that of its box; a triangle has 0.5."""
_KEPT_FILL = 0.9
"""Tolerance: parts of a bent plot, with a lower fill, may lose a tenth of it."""
_LEAST_AREA = 2.3
"""Tolerance: standard deviations of log area below the median at which parcels end: one in a hundred is smaller."""
_ASPECT_EXCESS = 2.0
"""Tolerance: a part may be this much longer than its target, in standard deviations of log aspects."""
_SHORTER = 0.75
"""Tolerance: parts are always allowed to be less elongated than their plot by this factor."""
_BREADTH = 0.8
"""Tolerance: narrower side of the box of a part, by the shortest frontage."""
_SQUARE = 1.6
"""Tolerance: parts with a lower aspect are always allowed; both halves of a
plot of 1 to 1.25 have 1.6."""
_PART_LANE = 16
"""First of both words that lead from the key of a plot to those of its parts."""
_CLEARANCE = 0.02
"""Tolerance: metres between a corner and other edges of a plot, above which they are clearly apart."""
_STOP, _PLACE, _ASPECT, _BLOCK = 0, 1, 2, 3
"""Sites of draws below the key of a plot."""


@dataclass(frozen=True, slots=True, eq=False)
class SizeColumns:
    """Sizes of the parcels of N plots; the fields of `grammarlab.city.layout_request.ParcelSizes`, [N] each."""

    area: Floats
    spread: Floats
    frontage: Floats
    aspect: Floats
    aspect_spread: Floats

    def take(self, rows: NDArray[np.integer]) -> SizeColumns:
        """The sizes of the plots at these indices."""
        return SizeColumns(
            self.area[rows], self.spread[rows], self.frontage[rows], self.aspect[rows], self.aspect_spread[rows]
        )


@dataclass(frozen=True, slots=True, eq=False)
class PlotTree:
    """N parcels, ordered by block and path."""

    plots: Plots
    block: Ints
    """[N] row of the block."""
    path: Ints
    """[N] address in the block."""


@dataclass(frozen=True, slots=True, eq=False)
class _Nodes:
    """Plots that may be cut, with what decides about them."""

    plots: Plots
    block: Ints
    path: Ints
    key: Keys
    median: Floats
    """[N] median area by block, in terms of parcels of the block."""
    sizes: SizeColumns

    def take(self, rows: NDArray[np.integer]) -> _Nodes:
        return _Nodes(
            self.plots.take(rows),
            self.block[rows],
            self.path[rows],
            self.key[rows],
            self.median[rows],
            self.sizes.take(rows),
        )


def subdivided(blocks: Plots, keys: Keys, sizes: SizeColumns) -> PlotTree:
    """Cut blocks into parcels.

    Args:
        blocks: B blocks, each with a street.
        keys: [B] keys of their draws.
        sizes: sizes of parcels by block.
    """
    between = sizes.spread * _BLOCK_SHARE**0.5
    # Blocks of small parcels have more of them: by ground, the mean of the log median is higher by the variance.
    median = sizes.area * np.exp(between * _normal(keys, _BLOCK) + between**2)
    nodes = _Nodes(blocks, np.arange(len(blocks)), np.ones(len(blocks), dtype=np.int64), keys, median, sizes)
    leaves: list[_Nodes] = []
    corners = blocks.corners
    for _ in range(_MAX_LEVELS):
        if not len(nodes.plots):
            break
        parcels, nodes, corners = _cut(nodes, corners)
        leaves.append(parcels)
    leaves.append(nodes)
    block = np.concatenate([leaf.block for leaf in leaves])
    path = np.concatenate([leaf.path for leaf in leaves])
    order = np.lexsort((path, block))
    plots = Plots.concatenate([leaf.plots for leaf in leaves]).take(order)
    return PlotTree(plots, block[order], path[order])


def _normal(keys: Keys, site: int) -> Floats:
    """Standard normal draws by Box and Muller."""
    first, second = uniforms(keys, site), uniforms(keys, site + 64)
    return np.sqrt(-2.0 * np.log1p(-first)) * np.cos(2 * np.pi * second)


def _is_final(nodes: _Nodes) -> Flags:
    """Whether plots are parcels, by draws."""
    within = nodes.sizes.spread * (1.0 - _BLOCK_SHARE) ** 0.5
    scale = np.maximum(within, 1e-3)
    centre = np.log(nodes.median) + within**2
    deviation = np.log(nodes.plots.area) - centre
    above = ndtr((deviation + np.log(2.0) / 2) / scale)
    below = ndtr((deviation - np.log(2.0) / 2) / scale)
    return uniforms(nodes.key, _STOP) * above < above - below


def _cut(nodes: _Nodes, corners: Floats) -> tuple[_Nodes, _Nodes, Floats]:
    """The plots that are parcels, the parts of all others, and the corners so far with those of the cuts."""
    is_open = ~_is_final(nodes)
    pending, final = nodes.take(np.flatnonzero(is_open)), nodes.take(np.flatnonzero(~is_open))
    if not len(pending.plots):
        return final, pending, corners
    cuts = snapped(pending.plots, _best_cuts(pending), corners)
    cuts = cuts.take(np.flatnonzero(_are_clear(pending.plots, cuts)))
    is_cut = np.zeros(len(pending.plots), dtype=np.bool_)
    is_cut[cuts.row] = True
    parents = pending.take(cuts.row)
    parts = [
        _Nodes(
            plots,
            parents.block,
            2 * parents.path + side,
            fold(parents.key, _PART_LANE + side),
            parents.median,
            parents.sizes,
        )
        for side, plots in enumerate(parts_of(pending.plots, cuts))
    ]
    final = _joined([final, pending.take(np.flatnonzero(~is_cut))])
    return final, _joined(parts), np.concatenate([corners, cuts.end.reshape(-1, 2)])


def _are_clear(plots: Plots, cuts: Cuts) -> Flags:
    """[K] whether both parts are valid and have no neck that their plot does not have.

    Beside an arc, a cut whose end has moved may cross it, or almost touch it.
    """
    clearance = np.minimum(_CLEARANCE, shapely.minimum_clearance(plots.outline[cuts.row]))
    parts = [part.outline for part in parts_of(plots, cuts)]
    return np.all([shapely.is_valid(part) & (shapely.minimum_clearance(part) >= clearance) for part in parts], axis=0)


def _joined(parts: list[_Nodes]) -> _Nodes:
    return _Nodes(
        Plots.concatenate([part.plots for part in parts]),
        np.concatenate([part.block for part in parts]),
        np.concatenate([part.path for part in parts]),
        np.concatenate([part.key for part in parts]),
        np.concatenate([part.median for part in parts]),
        SizeColumns(*(np.concatenate([getattr(part.sizes, name) for part in parts]) for name in SizeColumns.__slots__)),
    )


def _best_cuts(nodes: _Nodes) -> Cuts:
    """The best cut of each plot that may be cut."""
    boxes = smallest_boxes(nodes.plots.outline)
    candidates = [
        _candidates(nodes, boxes, fraction, is_across) for is_across in (True, False) for fraction in _FRACTIONS
    ]
    cuts = Cuts(*(np.concatenate([getattr(cut, name) for cut, _ in candidates]) for name in Cuts.__slots__))
    badness = np.concatenate([badness for _, badness in candidates])
    order = np.lexsort((np.arange(len(badness)), badness, cuts.row))
    order = order[np.isfinite(badness[order])]
    _, position = np.unique(cuts.row[order], return_index=True)
    return cuts.take(order[position])


def _candidates(nodes: _Nodes, boxes: Boxes, fraction: float, is_across: bool) -> tuple[Cuts, Floats]:
    """A cut of each plot across or along its box, and how bad the parts are; infinite if they are not allowed."""
    place = fraction + _JITTER * (2.0 * uniforms(nodes.key, _PLACE) - 1.0)
    normal = np.stack([-boxes.axis[:, 1], boxes.axis[:, 0]], axis=1)
    axis, direction = (boxes.axis, normal) if is_across else (normal, boxes.axis)
    low, high = nodes.plots.extent(axis)
    position = low + place * (high - low)
    cuts = cuts_along(nodes.plots, position[:, None] * axis, direction)
    target = np.maximum(nodes.sizes.aspect * np.exp(nodes.sizes.aspect_spread * _normal(nodes.key, _ASPECT)), 1.0)
    most = np.maximum(target * np.exp(_ASPECT_EXCESS * nodes.sizes.aspect_spread), _SQUARE)
    fill = np.minimum(_MIN_FILL, _KEPT_FILL * nodes.plots.area / (boxes.length * boxes.breadth))
    shape = _Shape(target, np.maximum(most, _SHORTER * boxes.aspect), fill).take(cuts.row)
    sizes = nodes.sizes.take(cuts.row)
    badness = np.full(len(cuts.row), abs(fraction - 0.5))
    for part in parts_of(nodes.plots, cuts):
        badness += _badness(part, sizes, shape)
    return cuts, badness


@dataclass(frozen=True, slots=True, eq=False)
class _Shape:
    """What shape the parts of N plots are to have."""

    target: Floats
    """[N] the best ratio of the sides of their boxes."""
    most: Floats
    """[N] the largest one."""
    fill: Floats
    """[N] least area by that of the box."""

    def take(self, rows: NDArray[np.integer]) -> _Shape:
        return _Shape(self.target[rows], self.most[rows], self.fill[rows])


def _badness(part: Plots, sizes: SizeColumns, shape: _Shape) -> Floats:
    """[K] distance of the shapes of K parts from their target, infinite for parts that may not be."""
    area = part.area
    is_allowed = (area >= sizes.area * np.exp(-_LEAST_AREA * sizes.spread)) & (
        part.frontage >= sizes.frontage + 2 * SNAP
    )
    badness = np.full(len(area), np.inf)
    rows = np.flatnonzero(is_allowed)
    boxes, shape = smallest_boxes(part.take(rows).outline), shape.take(rows)
    is_shaped = (
        (boxes.breadth >= _BREADTH * sizes.frontage[rows])
        & (area[rows] >= shape.fill * boxes.length * boxes.breadth)
        & (boxes.aspect <= shape.most)
    )
    badness[rows] = np.where(is_shaped, np.abs(np.log(boxes.aspect / shape.target)), np.inf)
    return badness
