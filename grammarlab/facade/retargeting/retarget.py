"""A facade for another width or height, with as many columns and rows as deform it least."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.retargeting.counts import BestCounts, Box, SpringRows, fewest
from grammarlab.facade.retargeting.energy import energy_beside, least_energy, origin_of
from grammarlab.facade.retargeting.repeats import Repeats, find_repeats
from grammarlab.facade.retargeting.springs import springs
from grammarlab.facade.sizes.axes import Weights, leaf_weights
from grammarlab.facade.sizes.model import ALIGNMENT, SYMMETRY, WISH
from grammarlab.facade.sizes.solve import Resized, resize
from grammarlab.facade.sizes.wishes import Aspect, Size, Wish, checked
from grammarlab.facade.tree import Facade, Floats, Ints, X, Y
from grammarlab.facade.variations.inheriting import inherited
from grammarlab.facade.variations.single import Variation, unedited

GAP = 1e-3
"""Part by which the deformation may be above the least one, and the part of its size by which each leaf may deviate on
top of that: less cannot be seen."""
EVENNESS = 0.1
"""Part of its size by which each leaf of a column deviates when that is as bad as one column too many or too few."""

Build = Callable[[Repeats, Sequence[int]], Variation]
"""Makes a facade with these columns, in this order, of what can be repeated."""


@dataclass(frozen=True, eq=False)
class Repetition:
    """Which columns of a grid there are along x, or which of its rows along y, counted from the bottom."""

    grid: str
    along: int
    columns: tuple[int, ...]
    """What each new column is a copy of."""
    counts: tuple[int, ...]
    """How many there are of each column that there was."""
    deformation: float
    """Energy of the sizes along this axis, and what columns cost that are more or less than their share."""
    bound: float
    """No other numbers of columns deform less than this."""
    proven: bool
    """Whether the deformation is within `GAP` of the bound."""
    tries: int
    """For how many numbers of columns sizes were solved for."""

    def __str__(self) -> str:
        name, side = ("column", "left") if self.along == X else ("row", "bottom")
        changed = [(column, count) for column, count in enumerate(self.counts) if count != 1]
        words = [
            f"{name} {column + 1} from the {side} {f'{count} times' if count else 'left out'}"
            for column, count in changed
        ]
        return f"{self.grid}: {', '.join(words) or f'every {name} once'}"


@dataclass(frozen=True, eq=False)
class Retargeted:
    """A facade for another width or height."""

    variation: Variation
    """Where its nodes come from; laid out, not solved."""
    resized: Resized
    """The facade itself."""
    choices: tuple[Repetition, ...]
    """What was repeated; none for an axis that nothing can be repeated along."""


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
    """The facade for another width or height, with columns and rows repeated or removed as deforms it least.

    Deformation is the energy of sizes, and for each kind of column the square of how many there are above or below
    their share of the new size, so that no kind crowds out the others only because it fits. Columns are chosen first,
    rows then; of several grids one. Copies stand beside what they copy; where does not change the deformation.

    Args:
        facade: a facade with grids.
        width: metres; the width stays free when left out.
        height: metres; the height stays free when left out.
        grids: names of those whose columns and rows may be repeated, by default all.
        weights: how much deviations count.
        build: makes the facade of some columns; no size of what it makes may differ from that of its source.
        most_tries: how many numbers of columns are solved for at most along each axis.
        locks: what stays as it is, and in copies, but for places. With a lock of an aspect nothing is proven.

    Raises:
        FacadeError: for lengths that no facade can have, and grids that there are not.
    """
    wishes = [Size(0, axis, metres) for axis, metres in ((X, width), (Y, height)) if metres is not None]
    checked(wishes, facade)
    names = [grid.name for grid in facade.grids]
    unknown = sorted(set(grids or ()) - set(names))
    if unknown:
        raise FacadeError(
            f"Unknown grid '{unknown[0]}'; expected one of: {', '.join(names) or 'none, there is no grid'}."
        )
    variation, choices = unedited(facade), []
    for wish in wishes:
        active = [grid for grid in variation.facade.grids if grid.name in (names if grids is None else grids)]
        options = [each for grid in active if (each := find_repeats(variation, grid, wish.axis)) is not None]
        if options:
            choice, variation = _chosen(options, facade, wish, weights, build, most_tries, locks)
            choices.append(choice)
    held = (*wishes, *inherited(locks, variation))
    resized = resize(variation.facade, held, origin_of(facade, variation), weights)
    return Retargeted(variation, resized, tuple(choices))


def _chosen(
    options: Sequence[Repeats],
    facade: Facade,
    wish: Size,
    weights: Weights,
    build: Build,
    most_tries: int,
    locks: Sequence[Wish],
) -> tuple[Repetition, Variation]:
    """The best numbers of one grid's columns, and the facade that has them."""
    rows = [_rows(each, facade, wish, weights) for each in options]
    unchanged = [np.bincount(each.kind) for each in options]
    uneven = [kinds[0].unevenness(counts) for kinds, counts in zip(rows, unchanged, strict=True)]
    # Columns of the other grids stay as they are.
    others = [sum(uneven) - each for each in uneven]
    slack = GAP**2 * len(facade.leaves)

    def best(held: Sequence[int]) -> BestCounts:
        def solve(owner: int, counts: Ints) -> float:
            try:
                made = build(options[owner], options[owner].spread(counts))
            except FacadeError:
                return np.inf
            fixed = [lock for lock in inherited(locks, made) if isinstance(lock, Size) and lock.axis == wish.axis]
            energy = least_energy(made.facade, origin_of(facade, made), [wish, *fixed], weights, held)
            return energy + rows[owner][0].unevenness(counts) + others[owner]

        boxes = [
            box
            for owner, (option, kinds) in enumerate(zip(options, rows, strict=True))
            for box in _boxes(option, kinds, others[owner] + energy_beside(option, facade, wish, weights, held), owner)
        ]
        return fewest(boxes, solve, unchanged[0], GAP, slack, most_tries)

    # Where no sizes keep all that is alike, none have to; where none keep what is aligned either, neither.
    found = best((WISH, ALIGNMENT, SYMMETRY))
    for held in ((WISH, ALIGNMENT), (WISH,)):
        found = found if np.isfinite(found.cost) else best(held)
    repeats = options[found.owner]
    columns = repeats.spread(found.counts)
    choice = Repetition(
        grid=repeats.grid,
        along=wish.axis,
        columns=columns,
        counts=tuple(np.bincount(columns, minlength=len(repeats.kind)).tolist()),
        deformation=found.cost,
        bound=found.bound,
        proven=found.cost * (1.0 - GAP) - slack <= found.bound < np.inf
        and not any(isinstance(lock, Aspect) for lock in locks),
        tries=found.tries,
    )
    return choice, build(repeats, columns)


def _rows(repeats: Repeats, facade: Facade, wish: Size, weights: Weights) -> list[SpringRows]:
    """The bands as rows of springs, once for each kind that may come first, since the first column brings no gap."""
    before, along, bands = repeats.before, wish.axis, repeats.bands
    leaf, wanted = before.facade.leaves, before.wanted[:, along]
    weight = leaf_weights(before.wanted[leaf], facade.size[0], weights)[:, along]
    spring = springs(before.facade, along, wanted, weight)
    occurs, columns = np.bincount(repeats.kind), np.unique(repeats.kind, return_index=True)[1].tolist()
    units = [[(*band.gaps[each], *band.columns[each]) for each in columns] for band in bands]
    margins = [(*band.before, *band.after) for band in bands]
    # What it would cost to lose a leaf's whole size, and that of all leaves in each subtree.
    whole = np.zeros(1 + len(before.facade))
    whole[1 + leaf] = np.square(weight * wanted[leaf])
    whole = np.cumsum(whole)
    price = EVENNESS**2 * _sums(whole[before.facade.end] - whole[:-1], units).sum(axis=0) / occurs

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
        )

    return [rows(first) for first in columns]


def _boxes(repeats: Repeats, rows: Sequence[SpringRows], others: float, owner: int) -> list[Box]:
    """All counts of columns, one box for each kind that may come first.

    Args:
        repeats: whose columns they are.
        rows: for each kind that may come first.
        others: what is added to each cost, of other grids and of what lies beside the bands.
        owner: number of the grid.
    """
    kinds = np.arange(len(rows))
    needed = np.zeros(len(rows), dtype=np.int64)
    for column in repeats.needed:
        same = np.flatnonzero(repeats.kind == repeats.kind[column])
        needed[repeats.kind[column]] = max(needed[repeats.kind[column]], 1 + np.searchsorted(same, column))
    boxes = []
    for first, each in enumerate(rows):
        least = np.maximum(needed, kinds == first)
        fitting = np.ceil(2.0 * each.size / each.length.min(axis=0)).astype(np.int64)
        most = np.where(kinds < first, 0, np.maximum(fitting, least))
        if (least <= most).all():
            boxes.append(Box(replace(each, fixed_rest=each.fixed_rest + others), least, most, owner))
    return boxes


def _sums(values: Floats, groups: Sequence[Sequence[Sequence[int]]]) -> Floats:
    """The sum of some nodes' values for each group of nodes in each row of groups."""
    return np.array([[values[list(nodes)].sum() for nodes in row] for row in groups])
