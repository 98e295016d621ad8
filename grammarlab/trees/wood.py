"""Wood of trees: the tubes of all stems, each begun on the axis of its parent as it is drawn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.trees.detail import StemDetail, lobes
from grammarlab.trees.draws import values
from grammarlab.trees.rings import Collars, Stations, collars, full_stations, joined_radii
from grammarlab.trees.skeleton import Skeleton
from grammarlab.trees.stem_axes import Axes, axes_of_level, interpolated
from grammarlab.trees.taper import radii
from grammarlab.trees.tubes import Rings

_THINNEST = 1e-4
"""Smallest radius of a cross-section in metres, but for tips."""


@dataclass(frozen=True, slots=True, eq=False)
class LevelPlan:
    """Stems of a level before it is known how they are drawn."""

    axes: Axes
    collars: Collars
    stations: Stations
    """Cross-sections at full detail."""


@dataclass(frozen=True, slots=True, eq=False)
class DrawnLevel:
    """Drawn stems of a level."""

    drawn: Flags
    """[S] stems of the skeleton that are drawn."""
    row: Ints
    """[S] row of each among these; meaningless for the others."""
    stations: Stations
    rings: Rings

    def centres(self, stems: Ints, along: Floats) -> Floats:
        """[K, 3] points on the axes of drawn stems [K] of the skeleton at shares [K] of their length."""
        stations = self.stations
        return interpolated(stations.offsets, stations.along, self.rings.centre, self.row[stems], along)


def plan(skeleton: Skeleton, level: int) -> LevelPlan:
    """Curves and cross-sections of all stems of a level."""
    stems = skeleton.levels[level]
    axes = axes_of_level(stems, _clone_radii(skeleton, level))
    parts = collars(skeleton, level)
    return LevelPlan(axes, parts, full_stations(skeleton, level, axes, parts))


def draw(skeleton: Skeleton, level: int, plan: LevelPlan, detail: StemDetail, parents: DrawnLevel | None) -> DrawnLevel:
    """Cross-sections of the stems of a level that are drawn.

    Args:
        skeleton: the trees.
        level: the level.
        plan: the stems of the level.
        detail: how they are drawn.
        parents: the level before; None for trunks.
    """
    stems = skeleton.levels[level]
    rows = np.flatnonzero(detail.drawn)
    axes = plan.axes if len(rows) == len(stems) else plan.axes.take(rows)
    if parents is not None:
        children = ~stems.is_clone[rows]
        child = rows[children]
        length = skeleton.levels[level - 1].length[stems.parent[child]]
        starts = parents.centres(stems.parent[child], stems.offset[child] / np.maximum(length, 1e-9))
        axes = axes.begun(children, starts)
    stations = plan.stations.take(rows).thinned(detail.num_stations[rows])
    stem = stations.stem()
    centre, tangent, side = axes.positions(stem, stations.along)
    first = stations.offsets[:-1]
    radius = joined_radii(skeleton, level, rows[stem], stations.along, plan.collars, first)
    is_end = np.zeros(len(radius), dtype=bool)
    is_end[stations.offsets[1:] - 1] = True
    radius = np.where(is_end, radius, np.maximum(radius, _THINNEST))
    row = np.cumsum(detail.drawn) - 1
    tree = stems.tree[rows]
    rings = Rings(
        tree=tree,
        offsets=stations.offsets,
        sides=detail.sides[rows],
        centre=centre,
        tangent=tangent,
        side=side,
        radius=radius,
        lobes=lobes(skeleton, level)[rows],
        lobe_depth=values(skeleton.rows, tree, "lobe_depth"),
    )
    return DrawnLevel(detail.drawn, row, stations, rings)


def _clone_radii(skeleton: Skeleton, level: int) -> Floats:
    """[S] metres: radii of clones where they begin."""
    stems = skeleton.levels[level]
    rows = np.flatnonzero(stems.is_clone)
    radius = np.zeros(len(stems))
    radius[rows] = radii(skeleton, level, rows, stems.along[stems.node_offsets[rows]])
    return radius
