"""A facade for another width or height by one column or row after the other, wherever it stands in the tree."""

from __future__ import annotations

from collections.abc import Sequence

from grammarlab.facade.grids.editing import aligned, following
from grammarlab.facade.retargeting.energy import origin_of
from grammarlab.facade.sizes.solve import resize
from grammarlab.facade.sizes.wishes import Size, Wish
from grammarlab.facade.tree import Facade
from grammarlab.facade.variations.inheriting import inherited
from grammarlab.facade.variations.ranking import strain
from grammarlab.facade.variations.sequences import sequences
from grammarlab.facade.variations.single import Variation, edits, unedited

MOST_STEPS = 20
"""Columns or rows that come or go along one axis."""
_BEAM = 4
"""Variations that are gone on from after each step."""
_WORSE = 2
"""Steps in a row that may make things worse."""
_WORK = 150_000
"""Leaves of all variations along one axis: some seconds. Large facades are gone on from fewer, or not changed."""


def stepwise(facade: Facade, wishes: Sequence[Size], grid: str, locks: Sequence[Wish] = ()) -> Variation:
    """The best variation found for a size: no proof, but columns that `retarget` cannot repeat.

    Goes on from the few least strained variations after each step, for as long as sizes deform the facade less.

    Args:
        facade: a facade with this grid.
        wishes: its width, its height, or both.
        grid: whose columns and rows come or go, with those of the grids that go with it.
        locks: what stays as it is, and in copies, but for places.
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
        found = [each for each in sequences(facade, grid, wish.axis, step, also=also, start=beam) if not each.missing]
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
    """How many facades like this one can be varied in a grid so that their variations have so many leaves in all."""
    return work // _effort(facade, grid, axis)


def _effort(facade: Facade, grid: str, axis: int) -> int:
    """Leaves of all variations of a facade, about."""
    return len(facade.leaves) * sum(1 for _ in edits(facade, (grid,), axis))
