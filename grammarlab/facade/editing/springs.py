"""Facades as springs: least energy of sizes along one axis, and the numbers of repetitions that fit a size best.

A leaf is a spring with a preferred size and a give, parts in a row are springs in series, and parts side by side across
are parallel springs. So each part is a spring, and the energy of a facade without grids is in closed form: grids can
only increase it.

A row of springs of length a, give q and energy e, repeated n times, plus fixed ones, has the energy e0 + sum n e + r^2
/ g with r = size - a0 - sum n a and g = q0 + sum n q. For every u it is at least e0 + sum n e + 2 u r - u^2 g. This
bound is separable in the counts, so that its least value over any ranges of counts is known; the best u maximises it.
Branch and bound over the integers n uses it. Strips beside the rows are as long as the longest row; their energy
follows from the range of its lengths.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from heapq import heapify, heappop, heappush

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.facade.editing.pieces import take
from grammarlab.facade.editing.repeats import Repeats
from grammarlab.facade.editing.variations import Variation
from grammarlab.facade.grid import Grid
from grammarlab.facade.sizes.constraints import LineOrigin, Weights, build_axis, leaf_weights
from grammarlab.facade.sizes.lines import Sums
from grammarlab.facade.sizes.model import build_model
from grammarlab.facade.sizes.size_wishes import Size
from grammarlab.facade.tree import LEAF, Facade, X

_LOCKED_GIVE = 1e-6
"""Give of a locked spring, as a fraction of its own: 0 would not allow parallel locked springs."""
_ROUNDING = 1e-9
"""Relative error of the energy of a solution."""
_HALVINGS = 40
"""Number of halvings of the range of u; any u gives a valid bound."""
_MAX_IMPOSSIBLE = 10
"""Number of consecutive impossible counts after which the search ends."""
_BOXES_PER_TRIAL = 20
"""Number of boxes that are halved per trial."""


@dataclass(frozen=True, slots=True)
class Springs:
    """N springs: at a size s each has the energy rest + (s - length)^2 / give."""

    length: Floats
    """[N] size of least energy, metres."""
    give: Floats
    """[N] > 0, square metres per unit of energy."""
    rest: Floats
    """[N] energy at that size, >= 0: from different preferred sizes of parallel parts."""

    def energy(self, node: int, size: float) -> float:
        """Energy of a node at a size, metres."""
        return float(self.rest[node] + (size - self.length[node]) ** 2 / self.give[node])


@dataclass(frozen=True, eq=False)
class Strips:
    """Parts beside R rows of S kinds of springs; their target is the length of the longest row without locks."""

    length: Floats
    """[R, S] lengths, metres."""
    fixed_length: Floats
    """[R] length of the fixed part, metres."""
    stiffness: float
    """Energy for a square metre of deviation at their original length."""
    whole: float
    """Their original length, metres."""

    def bound(self, size: float, least: Ints, most: Ints) -> float:
        """Lower bound of their energy at a size, metres, for counts in these ranges [S].

        Strips of n times the length have at most n^2 times the give, and shorter ones at most the same give.
        """
        shortest, longest = (float((self.fixed_length + self.length @ counts).max()) for counts in (least, most))
        nearest = min(max(size, shortest), longest)
        return self.stiffness * ((size - nearest) / max(nearest / self.whole, 1.0)) ** 2


@dataclass(frozen=True, eq=False)
class SpringRows:
    """R rows of springs of equal size, made of S kinds of springs, each of which is equally frequent in every row."""

    length: Floats
    """[R, S] lengths, metres."""
    give: Floats
    """[R, S] give."""
    rest: Floats
    """[S] energy of one repetition over all rows."""
    fixed_length: Floats
    """[R] length of the fixed part, metres."""
    fixed_give: Floats
    """[R] give of the fixed part; below 0 if the first repetition has less give than the others."""
    fixed_rest: float
    """Energy of the fixed parts at rest, summed over rows."""
    size: float
    """Size of each row, metres."""
    share: Floats
    """[S] proportional number of each kind."""
    price: Floats
    """[S] > 0, energy for a deviation of one from the share; quadratic."""
    strips: Strips | None = None

    def unevenness(self, counts: Ints) -> float:
        """Cost of the deviation of counts [S] from the shares."""
        return float(self.price @ np.square(counts - self.share))

    def energy(self, counts: Ints) -> float:
        """Energy of counts [S] without ties between rows, and without unevenness; that of strips at least."""
        missing, give = self.size - self.fixed_length - self.length @ counts, self.fixed_give + self.give @ counts
        energy = float(self.fixed_rest + counts @ self.rest + (missing**2 / give).sum())
        return energy + self.strip_bound(counts, counts)

    def strip_bound(self, least: Ints, most: Ints) -> float:
        """Lower bound of the energy of strips for counts in these ranges [S]."""
        return self.strips.bound(self.size, least, most) if self.strips else 0.0

    def bound(self, least: Ints, most: Ints) -> float:
        """Lower bound of the cost of counts in these ranges [S]."""
        length, give = self.length.sum(axis=0), self.give.sum(axis=0)
        missing, fixed_give = float((self.size - self.fixed_length).sum()), float(self.fixed_give.sum())
        reach = (abs(missing) + float(most @ length)) / (fixed_give + float(least @ give))
        low, high = -reach, reach
        best = -np.inf
        for _ in range(_HALVINGS):
            u = 0.5 * (low + high)
            unit_cost = self.rest - 2.0 * u * length - u**2 * give
            counts = np.clip(np.rint(self.share - 0.5 * unit_cost / self.price), least, most)
            cost = float(counts @ unit_cost + self.price @ (counts - self.share) ** 2)
            best = max(best, self.fixed_rest + 2.0 * u * missing - u**2 * fixed_give + cost)
            if missing - counts @ length > u * (fixed_give + counts @ give):
                low = u
            else:
                high = u
        return best + self.strip_bound(least, most)


@dataclass(frozen=True, slots=True)
class Box:
    """Ranges of counts."""

    rows: SpringRows
    """Rows whose counts are searched."""
    least: Ints
    """[S] least counts."""
    most: Ints
    """[S] largest counts."""
    owner: int = 0
    """Index of the repeated grid, if there are several."""

    def bound(self) -> float:
        """Lower bound of the cost in the box."""
        if (self.least == self.most).all():
            return self.rows.energy(self.least) + self.rows.unevenness(self.least)
        return self.rows.bound(self.least, self.most)

    def least_unevenness(self) -> float:
        """Least unevenness of counts in the box."""
        return float(np.abs(np.clip(self.rows.share, self.least, self.most) - self.rows.share).sum())

    def halves(self) -> tuple[Box, Box]:
        """The box divided in two, across the range that covers the most metres."""
        across = int(((self.most - self.least) * self.rows.length.mean(axis=0)).argmax())
        middle = (self.least[across] + self.most[across]) // 2
        most, least = self.most.copy(), self.least.copy()
        most[across], least[across] = middle, middle + 1
        return replace(self, most=most), replace(self, least=least)


@dataclass(frozen=True, slots=True)
class BestCounts:
    """The best counts found."""

    owner: int
    """Owner of their box."""
    counts: Ints
    """[S] counts."""
    cost: float
    """Their energy plus unevenness."""
    bound: float
    """Lower bound of the cost of all counts; at most the cost."""
    tries: int
    """Number of counts that were solved for."""


def springs(
    facade: Facade, along: int, target: Floats, weight: Floats, locked: Mapping[int, float] | None = None
) -> Springs:
    """Each node of a facade as a spring.

    Args:
        facade: the facade.
        along: 0 for widths, 1 for heights.
        target: [N] target sizes of leaves, metres.
        weight: [L] weights of leaves, from `leaf_weights`.
        locked: locked sizes of nodes, metres; their springs have hardly any give.
    """
    locked = locked or {}
    parent, axis = facade.parent.tolist(), facade.axis.tolist()
    length, give, rest = ([0.0] * len(facade) for _ in range(3))
    stiffness, pull, square = ([0.0] * len(facade) for _ in range(3))
    for leaf, size, leaf_weight in zip(
        facade.leaves.tolist(), target[facade.leaves].tolist(), weight.tolist(), strict=True
    ):
        length[leaf], give[leaf] = size, 1.0 / leaf_weight**2
    for node in range(len(facade) - 1, -1, -1):
        if axis[node] not in {LEAF, along}:
            length[node], give[node] = pull[node] / stiffness[node], 1.0 / stiffness[node]
            rest[node] += max(square[node] - pull[node] * length[node], 0.0)
        if node in locked:
            rest[node] += (locked[node] - length[node]) ** 2 / give[node]
            length[node], give[node] = locked[node], _LOCKED_GIVE * give[node]
        above = parent[node]
        if node == 0:
            break
        rest[above] += rest[node]
        if axis[above] == along:
            length[above] += length[node]
            give[above] += give[node]
        else:
            stiffness[above] += 1.0 / give[node]
            pull[above] += length[node] / give[node]
            square[above] += length[node] ** 2 / give[node]
    return Springs(np.array(length), np.array(give), np.array(rest))


def origin_of(facade: Facade, variation: Variation) -> LineOrigin:
    """Target sizes and source positions of the nodes of a variation."""
    return LineOrigin(facade.position[variation.source], variation.target, facade.size[0])


def energy_beside(repeats: Repeats, facade: Facade, wish: Size, weights: Weights, row_kinds: Sequence[int]) -> float:
    """Lower bound of the energy of the parts beside the bands, for any columns; without strips.

    Of the rows for these parts, only those that do not depend on columns are kept: equal sizes, and alignment in
    columns (for heights, rows) of a grid without elements in a band.

    Args:
        repeats: bands that can be repeated.
        facade: facade of the original sizes.
        wish: target of the whole facade.
        weights: weights of deviations.
        row_kinds: kinds of rows.
    """
    before, repeated = repeats.before, {*(band.node for band in repeats.bands), *repeats.strips}
    whole = before.facade
    parts = [part for part in whole.children[0].tolist() if part not in repeated] if 0 not in repeated else []
    if not parts:
        return 0.0
    source = np.concatenate([np.arange(part, int(whole.end[part])) for part in parts])
    if len(parts) > 1:
        source = np.append(0, source)
    new_index = np.full(len(whole), -1, dtype=np.int64)
    new_index[source] = np.arange(len(source))
    parent = new_index[whole.parent[source]]
    parent[0] = -1
    target = before.target[source]
    reduced = take(whole, parent, whole.axis[source], source, target)
    grids = [_grid_beside(grid, new_index, wish.axis) for grid in whole.grids]
    reduced = replace(reduced, grids=tuple(grid for grid in grids if len(grid.node)))
    origin = LineOrigin(facade.position[before.source[source]], target, facade.size[0])
    return least_energy(reduced, origin, [wish], weights, row_kinds) * (1.0 - _ROUNDING)


def least_energy(
    facade: Facade, origin: LineOrigin, wishes: Sequence[Size], weights: Weights, row_kinds: Sequence[int]
) -> float:
    """Energy of the best sizes along one axis under these kinds of rows; infinite if there are none."""
    # One unit for all variations of a facade, so that rounding errors choose the same anchors in all of them.
    leaf, scale, along = facade.leaves, float(origin.whole.max()), wishes[0].axis
    weight = leaf_weights(origin.size[leaf], origin.whole, weights)[:, along]
    axis = build_axis(facade, along, origin, weight, scale)
    model = build_model([axis], wishes, scale)
    selected = np.isin(model.kind, row_kinds)
    sums, is_zero = model.program.rows, model.program.is_zero[selected]
    program = replace(model.program, rows=Sums(sums.line[selected], sums.factor[selected]), is_zero=is_zero)
    position = program.solve(model.value[selected])
    if position is None:
        return np.inf
    size = axis.lines.spans(model.lines(position)[0])[1]
    return float(np.square(weight * (size[leaf] - origin.size[leaf, along])).sum())


def best_counts(
    boxes: Sequence[Box], solve: Callable[[int, Ints], float], start: Ints, gap: float, slack: float, most_tries: int
) -> BestCounts:
    """Counts whose cost is within a gap of the least cost.

    Args:
        boxes: ranges of counts to search.
        solve: the cost of an owner's counts; at least that of its rows of springs, infinite for impossible counts.
        start: [S] initial counts of the first owner.
        gap: relative tolerance of the cost.
        slack: absolute tolerance of the cost.
        most_tries: largest number of counts to solve for, and of boxes to halve for each.
    """
    best, owner, cost, tries, halved = start, boxes[0].owner, solve(boxes[0].owner, start), 1, 0
    heap = [(box.bound(), box.least_unevenness(), number, box) for number, box in enumerate(boxes)]
    heapify(heap)
    number = len(heap)
    bound = cost
    while heap:
        bound, _, _, box = heappop(heap)
        hopeless = tries >= _MAX_IMPOSSIBLE and np.isinf(cost)
        if (
            bound >= cost * (1.0 - gap) - slack
            or tries >= most_tries
            or halved >= _BOXES_PER_TRIAL * most_tries
            or hopeless
        ):
            break
        if (box.least == box.most).all():
            new_cost, tries = solve(box.owner, box.least), tries + 1
            if new_cost < cost:
                best, owner, cost = box.least, box.owner, new_cost
            continue
        halved += 1
        for half in box.halves():
            heappush(heap, (half.bound(), half.least_unevenness(), number, half))
            number += 1
    else:
        bound = cost
    return BestCounts(owner, best, cost, min(bound, cost), tries)


def _grid_beside(grid: Grid, new_index: Ints, along: int) -> Grid:
    """The elements of a grid beside bands; in a line of their own if other elements of the line are in a band."""
    is_outside = new_index[grid.node] >= 0
    line = grid.column if along == X else grid.row
    mixed = np.isin(line, line[~is_outside])
    line = np.where(mixed, line.max(initial=-1) + 1 + np.arange(len(line)), line)[is_outside]
    row, column = (grid.row[is_outside], line) if along == X else (line, grid.column[is_outside])
    return Grid(grid.name, new_index[grid.node[is_outside]], row, column)
