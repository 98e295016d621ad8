"""A facade for another width or height by adding or removing one column or row at a time, anywhere in the tree."""

from __future__ import annotations

from collections.abc import Sequence

from grammarlab.facade.grids.editing import aligned, following
from grammarlab.facade.retargeting.energy import origin_of
from grammarlab.facade.sizes.solve import resize
from grammarlab.facade.sizes.wishes import Size, Wish
from grammarlab.facade.tree import Facade
from grammarlab.facade.variations.inheriting import inherited, lost
from grammarlab.facade.variations.ranking import strain
from grammarlab.facade.variations.sequences import sequences
from grammarlab.facade.variations.single import Variation, edits, unedited

MOST_STEPS = 20
"""Largest number of added or removed columns or rows along one axis."""
_BEAM = 4
"""Number of variations that are continued after each step."""
_WORSE = 2
"""Number of consecutive steps that may increase the deformation."""
_WORK = 150_000
"""Largest number of leaves of all variations along one axis: some seconds; large facades get fewer or none."""


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


def _along(facade: Facade, start: Variation, wish: Size, grid: str, locks: Sequence[Wish]) -> Variation:
    also = tuple(dict.fromkeys((*following(facade, grid), *aligned(facade, grid, wish.axis))))
    step = 1 if wish.metres > facade.size[0, wish.axis] else -1

    def cost(variation: Variation) -> tuple[bool, float]:
        solved = resize(variation.facade, [wish, *inherited(locks, variation)], origin_of(facade, variation))
        return bool(solved.conflict), sum(solved.energy)

    best, least, beam, worse, work = start, cost(start), (start,), 0, _WORK
    for _ in range(MOST_STEPS):
        beam = beam[: affordable(beam[0].facade, grid, wish.axis, work)]
        if not beam:
            break
        work -= len(beam) * _effort(beam[0].facade, grid, wish.axis)
        tried = sequences(facade, grid, wish.axis, step, also=also, start=beam)
        found = [each for each in tried if not each.missing and not lost(facade, locks, each)]
        beam = tuple(sorted(found, key=strain)[:_BEAM])
        costs = [cost(each) for each in beam]
        worse = 0 if costs and min(costs) < least else worse + 1
        if costs and not worse:
            least = min(costs)
            best = beam[costs.index(least)]
        if not beam or worse > _WORSE:
            break
    return best


def affordable(facade: Facade, grid: str, axis: int, work: int) -> int:
    """Number of facades like this one whose variations in a grid have this many leaves in total."""
    return work // _effort(facade, grid, axis)


def _effort(facade: Facade, grid: str, axis: int) -> int:
    """Approximate number of leaves of all variations of a facade."""
    return len(facade.leaves) * sum(1 for _ in edits(facade, (grid,), axis))
