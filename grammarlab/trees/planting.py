"""Trees planted in an area: nowhere too close, and the same in every area that contains their place.

Candidates (`grammarlab.trees.arrivals`) arrive one after the other, and one stands unless a tree that stands already
is too close: nearer than both crowns and the gap need. This is random sequential addition, or the third hard-core
process of Matérn with times (B. Matérn, *Spatial Variation*, 1960). Whether a candidate stands depends only on earlier
ones near it, on still earlier ones near those, and so on for `MAX_ROUNDS` steps at most; so an outline changes nothing
but which trees are inside. It follows that

- a larger area has the trees of each smaller one inside it, and
- a denser forest, which ends at a later time, has those of a sparser one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.errors import UsageError
from grammarlab.geometry.footprints.area import Area
from grammarlab.geometry.footprints.equal_area import Plane
from grammarlab.randomness import Keys, derived_seed, fold
from grammarlab.trees.arrivals import FULL, Candidates, candidates_in

Crowns = Callable[[Keys], Floats]
"""Radii [n] in metres of the crowns of models [n] under a seed."""

MAX_ROUNDS = 64
"""Most steps from a candidate to those that decide about it. With 25 candidates within reach, the most there are on
average, 64 that follow each other in time are less likely than 1e-20."""
MAX_TREES = 100_000
"""Most trees of an area."""
HECTARE = 10_000.0
"""Square metres."""
_NUM_REFERENCES = 256
"""Number of trees from which sizes of crowns are learned: the first ones of the seed."""
_RANGE = 1.25
"""A candidate whose crown is larger than the largest of those by this factor does not stand; one whose crown is smaller
than the smallest of those by this factor has the room of that size."""
_MIN_SHARE, _MIN_SIDE = 0.25, 0.05
"""Smallest mean distance of neighbours that touch, by the mean width of a crown, and in metres."""
_TRIAL_CELLS = 48
"""Side of the square on which the density at each time is measured, in cells: a thousand trees."""
_TRIAL_TIMES = 256
_TRIAL_LANE = 7
_SLACK = 1.01
"""Distances on a map in metres may be this much longer than those on the ground, as a factor; they are up to here:"""
_MAX_DISTANCE = 1e6
"""Metres from the middle of an area in degrees to its farthest corner."""
_PARTS = FULL * 0.5 ** np.arange(5, 0, -1)
"""Times that end the parts in which candidates are decided."""
States: TypeAlias = NDArray[np.int8]
"""1 for trees that stand, 0 for candidates that fall, -1 for those that are not decided."""
_STANDS, _FALLS, _OPEN = np.int8(1), np.int8(0), np.int8(-1)
_SPARE = 1.2
"""Candidates looked at beyond those that the density of a number of trees needs, as a factor."""


@dataclass(frozen=True, slots=True, eq=False)
class Planting:
    """Trees in an area, the earliest first."""

    model: Keys
    """[n] indices of the trees under the seed: their addresses."""
    coordinates: Floats
    """[n, 2] in the coordinates of the source."""
    position: Floats
    """[n, 3] of the base of the trunk, in world metres."""
    radius: Floats
    """[n] of the room for the crown, in metres."""
    density: float
    """Trees per hectare of a large area planted in the same way; the same density has the same trees."""
    is_full: bool
    """Whether hardly another tree fits."""

    def __len__(self) -> int:
        return len(self.model)


@dataclass(frozen=True, eq=False)
class Spacing:
    """Distances of the trees of a species under a seed."""

    crowns: Crowns
    seed: int
    gap: float = 0.0
    """Metres between the crowns of neighbours; negative if they may reach into each other."""

    def __post_init__(self) -> None:
        if not np.isfinite(self.gap):
            raise UsageError(f"gap: expected a number of metres, found {self.gap}.")
        width = 2 * self.references.mean()
        least = max(_MIN_SHARE * width, _MIN_SIDE)
        if self.side < least:
            raise UsageError(
                f"gap: expected at least {least - width:.2f} m for crowns of {width:.3g} m width, found {self.gap:g}."
            )

    @cached_property
    def references(self) -> Floats:
        """Radii of the crowns of the first trees of the seed."""
        return self.crowns(np.arange(_NUM_REFERENCES, dtype=np.uint64))

    @cached_property
    def side(self) -> float:
        """Side of the cells: the mean distance of neighbours that touch."""
        return float(2 * self.references.mean() + self.gap)

    @cached_property
    def largest(self) -> float:
        """Largest radius of a crown of a tree that stands."""
        return float(_RANGE * self.references.max())

    @cached_property
    def smallest(self) -> float:
        """Smallest radius of the room for a crown."""
        return float(self.references.min() / _RANGE)

    @property
    def reach(self) -> float:
        """Largest distance at which a tree has an effect on another, in metres."""
        return max(2 * self.largest + self.gap, 0.0)

    @cached_property
    def densities(self) -> tuple[Floats, Floats]:
        """Times from 0 to `FULL`, and the density at each: trees per square metre, ascending.

        They are measured on a square on which crowns have the sizes of the references. With so few trees, the share of
        candidates that stand is known better than their number.
        """
        box = np.array([[0.0, 0.0], [1.0, 1.0]]) * (_TRIAL_CELLS - 0.5) * self.side
        seed = derived_seed(self.seed, _TRIAL_LANE)
        trial = _joined(list(candidates_in(Plane(), box[None], self.side, seed)))
        radius = self.references[(fold(trial.model, _TRIAL_LANE) % np.uint64(_NUM_REFERENCES)).astype(np.int64)]
        stands = decided(trial, trial.coordinates, radius, self, np.ones(len(trial), np.bool_)) == _STANDS
        inner = (np.abs(trial.coordinates - box[1] / 2) < box[1] / 2 - self.reach).all(axis=1)
        if not inner.any():
            inner[:] = True
        time = np.linspace(0.0, FULL, _TRIAL_TIMES + 1)
        num_candidates, num_trees = (
            np.searchsorted(np.sort(trial.time[rows]), time) for rows in (inner, inner & stands)
        )
        share = np.divide(num_trees, num_candidates, out=np.ones(len(time)), where=num_candidates > 0)
        return time, np.maximum.accumulate(time * share) / self.side**2

    def time_of(self, density: float) -> float:
        """Time at which a large area has so many trees per square metre; `FULL` if it never has."""
        time, densities = self.densities
        return float(np.interp(density, densities, time)) if density < densities[-1] else FULL

    def density_at(self, time: float) -> float:
        """Trees per square metre of a large area at a time."""
        return float(np.interp(time, *self.densities))


def planted(area: Area, spacing: Spacing, *, density: float | None = None, limit: int | None = None) -> Planting:
    """Trees in an area.

    Args:
        area: the trunks are inside it, and crowns may reach over its edge.
        spacing: distances of the trees.
        density: trees per hectare of a large area; None for as many as the limit.
        limit: most trees; the earliest ones stand.

    Raises:
        UsageError: If there is neither a density nor a limit, if one is out of range, or the area has too many trees.
    """
    _check(area, spacing, density, limit)
    end = FULL if density is None else spacing.time_of(density / HECTARE)
    stands = _Stands(area, spacing)
    until = end if limit is None else min(end, spacing.time_of(_SPARE * (limit + 1) / area.size))
    while True:
        trees, radius = stands.inside(until)
        if limit is None or len(trees) > limit or until >= end:
            break
        until = min(end, _SPARE * until)
    order = np.lexsort((trees.model, trees.time))
    trees, radius, times = trees.take(order), radius[order], trees.time[order]
    is_full = end >= FULL
    if limit is not None and len(trees) > limit:
        trees, radius, end = trees.take(np.arange(limit)), radius[:limit], float(times[limit])
        is_full, density = False, None
    last = float(trees.time.max(initial=0.0))
    east, north = area.east_north(trees.coordinates).T
    return Planting(
        model=trees.model,
        coordinates=trees.coordinates,
        position=np.column_stack([east, np.zeros(len(trees)), -north]) + 0.0,
        radius=radius,
        density=_short(spacing, last, end) if density is None or is_full else density,
        is_full=is_full,
    )


def decided(candidates: Candidates, space: Floats, radius: Floats, spacing: Spacing, is_complete: Flags) -> States:
    """[n] 1 for candidates that stand, 0 for those that fall, -1 if that is not known.

    Args:
        candidates: n candidates.
        space: [n, 2 or 3] positions in metres.
        radius: [n] radii of their crowns.
        spacing: distances of the trees.
        is_complete: [n] whether all candidates within reach of it are among the candidates. The others are not decided,
            and have the largest radius.
    """
    earlier, later = _conflicts(candidates, space, radius, spacing)
    state = np.where(radius <= spacing.largest, _OPEN, _FALLS)
    num = len(state)
    for _ in range(MAX_ROUNDS):
        blocked = np.bincount(later[state[earlier] == _STANDS], minlength=num) > 0
        waits = np.bincount(later[state[earlier] == _OPEN], minlength=num) > 0
        falls = (state == _OPEN) & blocked & is_complete
        stands = (state == _OPEN) & ~blocked & ~waits & is_complete
        if not (falls.any() or stands.any()):
            return state
        state[falls], state[stands] = _FALLS, _STANDS
        useful = (state[later] == _OPEN) & (state[earlier] != _FALLS)
        earlier, later = earlier[useful], later[useful]
    return state


@dataclass(eq=False)
class _Stands:
    """The trees of an area at several times; radii of crowns are asked for once."""

    area: Area
    spacing: Spacing

    def __post_init__(self) -> None:
        self._models = np.zeros(0, np.uint64)
        self._radii = np.zeros(0)

    def inside(self, until: float) -> tuple[Candidates, Floats]:
        """Trees in the area at a time, and the radii of their crowns."""
        reach = self.spacing.reach
        margin, widest = 3 * reach, (MAX_ROUNDS + 1) * reach * _SLACK
        while True:
            near, east_north = self._near(margin, until)
            is_complete = self.area.is_near(east_north, margin - reach * _SLACK)
            state, radius = self._decided(near, is_complete)
            inside = self.area.contains(near.coordinates)
            if margin >= widest or not (state[inside] == _OPEN).any():
                rows = inside & (state == _STANDS)
                return near.take(rows), radius[rows]
            margin = min(margin + reach, widest)

    def _decided(self, candidates: Candidates, is_complete: Flags) -> tuple[States, Floats]:
        """[n] states of candidates, and the radii of those that stand.

        Part by part of the time, since most candidates of a dense forest fall beside trees that stand already, however
        small their crowns are: these do not have to grow. Nor do those of which not all neighbours are known: they are
        taken for the largest trees, which may stand or not.
        """
        space = self.area.surface.space(candidates.coordinates)
        state, radius = np.full(len(candidates), _OPEN), np.zeros(len(candidates))
        part = np.searchsorted(_PARTS, candidates.time, side="right")
        active = np.zeros(0, np.int64)
        for number in range(len(_PARTS) + 1):
            rows = np.flatnonzero(part == number)
            trees = active[state[active] == _STANDS]
            shaded = _are_near(space[rows], space[trees], radius[trees] + self.spacing.gap + self.spacing.smallest)
            state[rows[shaded]] = _FALLS
            rows = rows[~shaded]
            known = rows[is_complete[rows]]
            radius[known] = self._radius(candidates.model[known])
            radius[rows[~is_complete[rows]]] = self.spacing.largest
            rows = np.concatenate([active, rows])
            state[rows] = decided(candidates.take(rows), space[rows], radius[rows], self.spacing, is_complete[rows])
            active = rows[state[rows] != _FALLS]
        return state, radius

    def _near(self, margin: float, until: float) -> tuple[Candidates, Floats]:
        """Candidates at most so far from the area, and their places in metres to the east and north."""
        area, spacing = self.area, self.spacing
        boxes = area.surface.boxes(area.bounds, margin * _SLACK)
        blocks, positions = [], []
        for block in candidates_in(area.surface, boxes, spacing.side, spacing.seed, until):
            east_north = area.east_north(block.coordinates)
            near = area.is_near(east_north, margin)
            blocks.append(block.take(near))
            positions.append(east_north[near])
        return _joined(blocks), np.concatenate(positions)

    def _radius(self, model: Keys) -> Floats:
        """[n] radii of the room for the crowns of models."""
        unknown = np.setdiff1d(model, self._models)
        models = np.concatenate([self._models, unknown])
        radii = np.concatenate([self._radii, self.spacing.crowns(unknown)]) if len(unknown) else self._radii
        order = np.argsort(models)
        self._models, self._radii = models[order], radii[order]
        return np.maximum(self._radii[np.searchsorted(self._models, model)], self.spacing.smallest)


def _conflicts(candidates: Candidates, space: Floats, radius: Floats, spacing: Spacing) -> tuple[Ints, Ints]:
    """Pairs of candidates that are too close: rows of the earlier and of the later one."""
    usable = np.flatnonzero(radius <= spacing.largest)
    pairs = KDTree(space[usable]).query_pairs(spacing.reach * (1 + 1e-9), output_type="ndarray")
    one, other = usable[pairs].T.astype(np.int64)
    distance = np.sqrt(((space[one] - space[other]) ** 2).sum(axis=1))
    one, other = (rows[distance < radius[one] + radius[other] + spacing.gap] for rows in (one, other))
    time, model = candidates.time, candidates.model
    swap = (time[one] > time[other]) | ((time[one] == time[other]) & (model[one] > model[other]))
    return np.where(swap, other, one), np.where(swap, one, other)


def _are_near(points: Floats, others: Floats, distance: Floats) -> Flags:
    """[n] whether points [n, 2 or 3] are nearer to one of the others [m, 2 or 3] than its distance [m]."""
    near = np.zeros(len(points), np.bool_)
    # A little less than the distance, where rounding cannot change what the exact comparison says.
    rows = KDTree(points).query_ball_point(others, np.maximum(distance, 0.0) * (1 - 1e-9)) if len(points) else []
    for neighbours in rows:
        near[neighbours] = True
    return near


def _joined(blocks: list[Candidates]) -> Candidates:
    return Candidates(
        np.concatenate([block.model for block in blocks]),
        np.concatenate([block.time for block in blocks]),
        np.concatenate([block.coordinates for block in blocks]),
    )


def _short(spacing: Spacing, last: float, end: float) -> float:
    """The shortest density in trees per hectare whose time is after the last tree and not after the end."""
    low, high = (spacing.density_at(time) * HECTARE for time in (last, end))
    for digits in range(2, 17):
        density = float(f"{(low + high) / 2:.{digits}g}")
        if last < spacing.time_of(density / HECTARE) <= end:
            return density
    return high


def _check(area: Area, spacing: Spacing, density: float | None, limit: int | None) -> None:
    if density is None and limit is None:
        raise UsageError("how many trees? Expected a density or a number.")
    if density is not None and not (np.isfinite(density) and density > 0):
        raise UsageError(f"density: expected more than 0 trees per hectare, found {density:g}.")
    if limit is not None and limit < 1:
        raise UsageError(f"number of trees: expected at least 1, found {limit}.")
    if (
        area.ground is not None
        and np.abs(np.array([polygon.bounds for polygon in area.outlines])).max() > _MAX_DISTANCE
    ):
        raise UsageError(
            f"the outlines of the area are more than {_MAX_DISTANCE / 1000:,.0f} km apart: plant one after the other."
        )
    end = FULL if density is None else spacing.time_of(density / HECTARE)
    num = spacing.density_at(end) * area.size
    if (num if limit is None else min(num, limit)) > MAX_TREES:
        raise UsageError(
            f"about {num:,.0f} trees would stand on {area.size / HECTARE:,.0f} hectares, and at most {MAX_TREES:,} are "
            "planted at once: choose a smaller density, number or area."
        )
