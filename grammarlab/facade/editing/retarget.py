"""A facade for another width or height, by repetition and removal of columns and rows.

`retarget` chooses the numbers of columns and rows that deform the facade least, with a proof. `stepwise` adds or
removes one column or row at a time, anywhere in the tree, without a proof.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.errors import FacadeError
from grammarlab.facade.editing.edit_sequences import sequences, strain
from grammarlab.facade.editing.grids import aligned, following
from grammarlab.facade.editing.repeats import Repeats, counts_in_words, find_repeats
from grammarlab.facade.editing.springs import (
    BestCounts,
    Box,
    SpringRows,
    Strips,
    best_counts,
    energy_beside,
    least_energy,
    origin_of,
    springs,
)
from grammarlab.facade.editing.variations import Variation, edits, inherited, lost, unedited
from grammarlab.facade.sizes.constraints import SIMILAR_SIZE_TOLERANCE, Weights, leaf_weights
from grammarlab.facade.sizes.model import ALIGNMENT, SYMMETRY, WISH
from grammarlab.facade.sizes.size_wishes import Aspect, Size, Wish, checked
from grammarlab.facade.sizes.solve import Resized, resize
from grammarlab.facade.tree import Facade, X, Y

Build = Callable[[Repeats, Sequence[int]], Variation]
"""Function that makes a facade with these columns, in this order, of the repeated bands."""
MOST_STEPS = 20
"""Largest number of added or removed columns or rows along one axis."""
OPTIMALITY_GAP = 1e-3
"""Tolerances: relative to the least deformation, plus the energy of a deviation of each leaf by this fraction of its
size, which is invisible."""
EVENNESS_DEVIATION = 0.1
"""Relative deviation of each leaf of a column that costs as much as one column too many or too few."""
_BEAM_WIDTH = 4
"""Number of variations that are continued after each step."""
_MAX_WORSE_STEPS = 2
"""Number of consecutive steps that may increase the deformation."""
_MAX_LEAVES = 150_000
"""Largest number of leaves of all variations along one axis: some seconds; large facades get fewer or none."""


@dataclass(frozen=True, eq=False)
class Repetition:
    """The columns of a grid along x, or its rows along y, counted from the bottom, after repetition."""

    grid: str
    along: int
    columns: tuple[int, ...]
    """Source of each new column."""
    counts: tuple[int, ...]
    """Number of copies of each original column."""
    deformation: float
    """Energy of the sizes along this axis, plus the cost of numbers of columns that differ from their shares."""
    bound: float
    """Lower bound of the deformation for all numbers of columns."""
    proven: bool
    """Whether the deformation is within `OPTIMALITY_GAP` of the bound."""
    tries: int
    """Number of combinations of columns that sizes were solved for."""

    def __str__(self) -> str:
        return f"{self.grid}: {counts_in_words(self.along, self.counts)}"


@dataclass(frozen=True, eq=False)
class Retargeted:
    """A facade for another width or height."""

    variation: Variation
    """Source and layout of its nodes, before sizes are solved for."""
    resized: Resized
    """The facade itself."""
    choices: tuple[Repetition, ...]
    """Repetitions; none for an axis without repeatable columns."""


def retarget(
    facade: Facade,
    *,
    width: float | None = None,
    height: float | None = None,
    grids: Sequence[str] | None = None,
    weights: Weights = "default",
    build: Build = Repeats.variation,
    most_tries: int = 100,
    locks: Sequence[Wish] = (),
) -> Retargeted:
    """The facade for another width or height, with columns and rows repeated or removed for the least deformation.

    Deformation is the energy of sizes, plus, for each kind of column, the squared difference of its number from its
    share of the new size, so that no kind replaces the others only because it fits. Columns are chosen first, then
    rows; one of several grids is repeated. Copies are next to their originals; their position does not affect the
    deformation.

    Args:
        facade: a facade with grids.
        width: target width, metres; free when left out.
        height: target height, metres; free when left out.
        grids: names of grids whose columns and rows may be repeated; all by default.
        weights: weights of deviations.
        build: makes the facade of given columns; its sizes must be those of the sources.
        most_tries: largest number of combinations to solve for along each axis.
        locks: locked properties, also of copies, except positions. One of equal columns with a locked part stays. With
            a lock of an aspect ratio, nothing is proven.

    Raises:
        FacadeError: If lengths are out of range, or grids are unknown.
    """
    wishes = [Size(0, axis, metres) for axis, metres in ((X, width), (Y, height)) if metres is not None]
    checked(wishes, facade)
    names = [grid.name for grid in facade.grids]
    unknown = sorted(set(grids or ()) - set(names))
    if unknown:
        raise FacadeError(
            f"Unknown grid '{unknown[0]}'; expected one of: {', '.join(names) or 'none, since there is no grid'}."
        )
    variation, choices = unedited(facade), []
    for wish in wishes:
        active = [grid for grid in variation.facade.grids if grid.name in (names if grids is None else grids)]
        fixed = inherited(locks, variation)
        options = [
            repeats for grid in active if (repeats := find_repeats(variation, grid, wish.axis, fixed)) is not None
        ]
        if options:
            choice, variation = _chosen(options, facade, wish, weights, build, most_tries, locks)
            choices.append(choice)
    fixed = (*wishes, *inherited(locks, variation))
    resized = resize(variation.facade, fixed, origin_of(facade, variation), weights)
    return Retargeted(variation, resized, tuple(choices))


def stepwise(facade: Facade, wishes: Sequence[Size], grid: str, locks: Sequence[Wish] = ()) -> Variation:
    """The best variation found for a size: without proof, but with columns that `retarget` cannot repeat.

    Continues from the few least strained variations after each step, while the deformation decreases.

    Args:
        facade: a facade with the grid.
        wishes: target width, height, or both.
        grid: grid whose columns and rows are added or removed, with those of the grids that follow it.
        locks: locked properties, also of copies, except positions. No step removes the last copy of a locked part.
    """
    best = unedited(facade)
    for wish in wishes:
        best = _along(facade, best, wish, grid, locks)
    return best


def affordable(facade: Facade, grid: str, axis: int, work: int) -> int:
    """Number of facades like this one whose variations in a grid have this many leaves in total."""
    return work // _effort(facade, grid, axis)


def _chosen(
    options: Sequence[Repeats],
    facade: Facade,
    wish: Size,
    weights: Weights,
    build: Build,
    most_tries: int,
    locks: Sequence[Wish],
) -> tuple[Repetition, Variation]:
    """The best numbers of columns of one grid, and the facade with them."""
    rows = [_rows(option, facade, wish, weights, tied=False) for option in options]
    unchanged = [np.bincount(option.kind) for option in options]
    uneven = [kinds[0].unevenness(counts) for kinds, counts in zip(rows, unchanged, strict=True)]
    # Columns of the other grids do not change.
    others = [sum(uneven) - cost for cost in uneven]
    slack = OPTIMALITY_GAP**2 * len(facade.leaves)

    def best(row_kinds: Sequence[int]) -> BestCounts:
        def solve(owner: int, counts: Ints) -> float:
            try:
                candidate = build(options[owner], options[owner].spread(counts))
            except FacadeError:
                return np.inf
            fixed = [lock for lock in inherited(locks, candidate) if isinstance(lock, Size) and lock.axis == wish.axis]
            energy = least_energy(candidate.facade, origin_of(facade, candidate), [wish, *fixed], weights, row_kinds)
            return energy + rows[owner][0].unevenness(counts) + others[owner]

        boxes = [
            box
            for owner, option in enumerate(options)
            for box in _boxes(
                option,
                _rows(option, facade, wish, weights, tied=SYMMETRY in row_kinds),
                others[owner] + energy_beside(option, facade, wish, weights, row_kinds),
                owner,
            )
        ]
        return best_counts(boxes, solve, unchanged[0], OPTIMALITY_GAP, slack, most_tries)

    # If no sizes satisfy symmetry, it is dropped; if no sizes satisfy alignment either, it is dropped too.
    result = best((WISH, ALIGNMENT, SYMMETRY))
    for row_kinds in ((WISH, ALIGNMENT), (WISH,)):
        result = result if np.isfinite(result.cost) else best(row_kinds)
    repeats = options[result.owner]
    columns = repeats.spread(result.counts)
    choice = Repetition(
        grid=repeats.grid,
        along=wish.axis,
        columns=columns,
        counts=tuple(np.bincount(columns, minlength=len(repeats.kind)).tolist()),
        deformation=result.cost,
        bound=result.bound,
        proven=result.cost * (1.0 - OPTIMALITY_GAP) - slack <= result.bound < np.inf
        and not any(isinstance(lock, Aspect) for lock in locks),
        tries=result.tries,
    )
    return choice, build(repeats, columns)


def _rows(repeats: Repeats, facade: Facade, wish: Size, weights: Weights, *, tied: bool) -> list[SpringRows]:
    """The bands as rows of springs, once for each possible first kind, since the first column has no gap.

    Args:
        repeats: repetition of the columns.
        facade: facade of the original sizes.
        wish: target of the whole facade.
        weights: weights of deviations.
        tied: whether parts that are like a locked one change with it.
    """
    before, along, bands = repeats.before, wish.axis, repeats.bands
    leaf, target = before.facade.leaves, before.target[:, along]
    weight = leaf_weights(before.target[leaf], facade.size[0], weights)[:, along]
    spring = springs(before.facade, along, target, weight, _locked_sizes(repeats, tied=tied))
    # Targets do not depend on locks; nor does the give of a strip, which is a bound without those inside it.
    free = springs(before.facade, along, target, weight)
    occurs, columns = np.bincount(repeats.kind), np.unique(repeats.kind, return_index=True)[1].tolist()
    units = [[(*band.gaps[column], *band.columns[column]) for column in columns] for band in bands]
    margins = [(*band.before, *band.after) for band in bands]
    # Cost of losing a leaf's whole size, summed over the leaves of each subtree.
    whole = np.zeros(1 + len(before.facade))
    whole[1 + leaf] = np.square(weight * target[leaf])
    whole = np.cumsum(whole)
    price = EVENNESS_DEVIATION**2 * _sums(whole[before.facade.end] - whole[:-1], units).sum(axis=0) / occurs

    def rows(first: int) -> SpringRows:
        gaps = [band.gaps[first] for band in bands]
        length, give, rest = (
            _sums(values, [margins])[0] - _sums(values, [gaps])[0]
            for values in (spring.length, spring.give, spring.rest)
        )
        return SpringRows(
            length=_sums(spring.length, units),
            give=_sums(spring.give, units),
            rest=_sums(spring.rest, units).sum(axis=0),
            fixed_length=length,
            fixed_give=give,
            fixed_rest=float(rest.sum()),
            size=wish.metres,
            share=occurs * wish.metres / facade.size[0, along],
            price=price,
            strips=Strips(
                length=_sums(free.length, units),
                fixed_length=_sums(free.length, [margins])[0] - _sums(free.length, [gaps])[0],
                stiffness=float((1.0 / free.give[list(repeats.strips)]).sum()),
                whole=float(before.facade.size[0, along]),
            ),
        )

    return [rows(first) for first in columns]


def _locked_sizes(repeats: Repeats, *, tied: bool) -> dict[int, float]:
    """Sizes of nodes that follow from locks, metres: of locked nodes, and of those that are like one if they are tied.

    Only parts that are like a locked one without others between them are tied to it in every repetition.
    """
    facade, size = repeats.before.facade, repeats.before.target[:, repeats.along]
    sizes: dict[int, float] = {}
    for lock in repeats.locks:
        if not isinstance(lock, Size) or lock.axis != repeats.along or lock.node in sizes:
            continue
        sizes[lock.node] = lock.metres
        for grid in facade.grids if tied else ():
            if lock.node in grid.node:
                small, large = (
                    np.minimum(size[grid.node], size[lock.node]),
                    np.maximum(size[grid.node], size[lock.node]),
                )
                similar = (facade.label[grid.node] == facade.label[lock.node]) & (
                    large <= (1.0 + SIMILAR_SIZE_TOLERANCE) * small
                )
                ratio = size[grid.node[similar]] / size[lock.node]
                sizes |= dict(zip(grid.node[similar].tolist(), (lock.metres * ratio).tolist(), strict=True))
    return sizes


def _sums(values: Floats, groups: Sequence[Sequence[Sequence[int]]]) -> Floats:
    """Sums of nodes' values for each group of nodes in each row of groups."""
    return np.array([[values[list(nodes)].sum() for nodes in row] for row in groups])


def _boxes(repeats: Repeats, rows: Sequence[SpringRows], others: float, owner: int) -> list[Box]:
    """All counts of columns, one box for each possible first kind.

    Args:
        repeats: repetition of the columns.
        rows: rows of springs for each possible first kind.
        others: added to each cost: energy of other grids and of the parts beside the bands.
        owner: index of the grid.
    """
    kinds, boxes = np.arange(len(rows)), []
    for first, spring_rows in enumerate(rows):
        least = repeats.least(first)
        fitting = np.ceil(2.0 * spring_rows.size / spring_rows.length.min(axis=0)).astype(np.int64)
        most = np.where(kinds < first, 0, np.maximum(fitting, least))
        if (least <= most).all():
            boxes.append(Box(replace(spring_rows, fixed_rest=spring_rows.fixed_rest + others), least, most, owner))
    return boxes


def _along(facade: Facade, start: Variation, wish: Size, grid: str, locks: Sequence[Wish]) -> Variation:
    also = tuple(dict.fromkeys((*following(facade, grid), *aligned(facade, grid, wish.axis))))
    step = 1 if wish.metres > facade.size[0, wish.axis] else -1

    def cost(variation: Variation) -> tuple[bool, float]:
        solved = resize(variation.facade, [wish, *inherited(locks, variation)], origin_of(facade, variation))
        return bool(solved.conflict), sum(solved.energy)

    best, least, beam, worse, work = start, cost(start), (start,), 0, _MAX_LEAVES
    for _ in range(MOST_STEPS):
        beam = beam[: affordable(beam[0].facade, grid, wish.axis, work)]
        if not beam:
            break
        work -= len(beam) * _effort(beam[0].facade, grid, wish.axis)
        variations = sequences(facade, grid, wish.axis, step, also=also, start=beam)
        candidates = [
            candidate for candidate in variations if not candidate.missing and not lost(facade, locks, candidate)
        ]
        beam = tuple(sorted(candidates, key=strain)[:_BEAM_WIDTH])
        costs = [cost(candidate) for candidate in beam]
        worse = 0 if costs and min(costs) < least else worse + 1
        if costs and not worse:
            least = min(costs)
            best = beam[costs.index(least)]
        if not beam or worse > _MAX_WORSE_STEPS:
            break
    return best


def _effort(facade: Facade, grid: str, axis: int) -> int:
    """Approximate number of leaves of all variations of a facade."""
    return len(facade.leaves) * sum(1 for _ in edits(facade, (grid,), axis))
