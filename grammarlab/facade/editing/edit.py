"""A facade for another size, or with more or fewer columns and rows."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isfinite
from typing import Any

from grammarlab.errors import FacadeError, UsageError
from grammarlab.facade.editing.edit_sequences import canonical, ranked, sequences
from grammarlab.facade.editing.grid_proposals import with_joint, with_proposals
from grammarlab.facade.editing.grids import aligned, following, grid_of, kinds
from grammarlab.facade.editing.retarget import MOST_STEPS, Retargeted, affordable, retarget, stepwise
from grammarlab.facade.editing.springs import origin_of
from grammarlab.facade.editing.variations import Variation, inherited, lost, unedited, vary
from grammarlab.facade.sizes.size_wishes import Size, Wish, checked, in_words
from grammarlab.facade.sizes.solve import Residuals, Resized, resize
from grammarlab.facade.tree import LONGEST, SHORTEST, Facade, X, Y

_MAX_CONTINUED, _MAX_LEAVES = 40, 60_000
"""Largest number of variations to continue from after each step, and of leaves of all their results."""
_MAX_SOLVED = 200
"""Number of variations whose sizes are solved for."""
_MIN_DEVIATION = 0.1
"""Least mean relative deviation of sizes from which other repetitions are searched."""
_TIE_TOLERANCE = 1e-9
"""Largest relative difference of equal energies."""
_MAX_FACADE_LEAVES = 10_000
"""Largest number of leaves of a facade whose columns and rows follow from its size; that takes up to 100 solutions."""


@dataclass(frozen=True, eq=False)
class Edited:
    """One result of an edit."""

    facade: Facade
    energy: float
    """Sum of both axes; 0 if no leaf deviates from its source."""
    residuals: Residuals
    steps: tuple[str, ...]
    """Steps in words; empty if only sizes differ."""
    proven: bool
    """Whether no other columns and rows deform less, among those that satisfy the request."""
    conflict: tuple[str, ...]
    """Wishes and grids that contradict each other, and locks of which no copy is left."""
    relaxed: tuple[str, ...]
    """Relaxed wishes and grids, with the largest violation in metres."""
    missing: tuple[str, ...]
    """Parts of the steps that were not possible, and the reason if columns and rows were not chosen for a size."""
    locks: tuple[Wish, ...]
    """Locks for further edits of the result."""
    seconds: float
    """Duration of the choice of columns and rows, or of solving for sizes if these were given."""

    def as_dict(self) -> dict[str, Any]:
        """Values for `--json`."""
        return {
            "width": self.facade.width,
            "height": self.facade.height,
            "leaves": len(self.facade.leaves),
            "energy": self.energy if isfinite(self.energy) else None,
            "residuals": {
                key: residual if isfinite(residual) else None for key, residual in self.residuals.as_dict().items()
            },
            "grids": [
                {"name": grid.name, "rows": grid.num_rows, "columns": grid.num_columns} for grid in self.facade.grids
            ],
            "steps": list(self.steps),
            "proven": self.proven,
            "conflict": list(self.conflict),
            "relaxed": list(self.relaxed),
            "missing": list(self.missing),
            "seconds": self.seconds,
        }


def edit(
    facade: Facade,
    *,
    width: float | None = None,
    height: float | None = None,
    columns: int = 0,
    rows: int = 0,
    grid: str = "",
    most: int = 12,
    locks: Sequence[Wish] = (),
) -> tuple[Edited, ...]:
    """Results of an edit, the best first.

    For another size alone, columns and rows are repeated or removed for the least deformation (`retarget`), or one by
    one if the deformation is visible (`stepwise`); another result keeps all of them. If columns or rows are given, the
    results are different variations with them: the one of least energy, and others that look different from each other
    (`ranked`). Results are in the order of their energy; those with a conflict or a missing step come last.

    Args:
        facade: the facade; if it has no grids, they are proposed.
        width: metres; it follows from the columns when left out.
        height: metres; it follows from the rows when left out.
        columns: number of columns to add, or to remove if negative; at most `MOST_STEPS`.
        rows: number of rows to add, or to remove if negative; at most `MOST_STEPS`.
        grid: name of the edited grid; by default all grids for another size, otherwise the one with most elements.
        most: largest number of results.
        locks: locked properties, also of copies; locked positions only apply if columns and rows do not change. A
            requested width or height takes precedence over a lock of the whole facade.

    Raises:
        UsageError: If nothing is requested, lengths are not above 0, or there are too many columns or rows.
        FacadeError: If lengths are out of range, the grid is unknown, or columns and rows cannot be added or removed.

    >>> import grammarlab as gl
    >>> arcade = gl.load_facade(gl.examples_folder() / "facades" / "arcade.json")
    >>> [round(edited.facade.width, 6) for edited in gl.edit_facade(arcade, width=31.5, most=1)]
    [31.5]
    """
    if width is None and height is None and not columns and not rows:
        raise UsageError("nothing to do: give `width=`, `height=`, `columns=` or `rows=`.")
    if max(abs(columns), abs(rows)) > MOST_STEPS:
        raise UsageError(f"`columns=` and `rows=`: expected at most {MOST_STEPS} more or fewer.")
    for name, metres in (("width", width), ("height", height)):
        if metres is not None and not SHORTEST <= metres <= LONGEST:
            expected = f"from {SHORTEST:g} to {LONGEST:,.0f}"
            raise UsageError(f"`{name}=`: expected metres above 0, {expected}, found {metres:g}.")
    facade = facade if facade.grids else with_proposals(facade)
    wishes = [Size(0, axis, size) for axis, size in ((X, width), (Y, height)) if size is not None]
    checked(wishes, facade)
    fixed = {wish.axis for wish in wishes}
    locks = tuple(lock for lock in locks if not (isinstance(lock, Size) and lock.node == 0 and lock.axis in fixed))
    checked(locks, facade)
    if grid:
        grid_of(facade, grid)
    if columns or rows:
        facade, grid = _active(facade, grid)
        return _varied(facade, wishes, locks, (columns, rows), grid, most)
    return _resized(facade, wishes, locks, grid)[:most]


def _resized(facade: Facade, wishes: Sequence[Size], locks: tuple[Wish, ...], grid: str) -> tuple[Edited, ...]:
    """The facade with other columns and rows, and with the same ones."""
    start = time.perf_counter()
    plain = _edited(unedited(facade), resize(facade, (*wishes, *locks)), locks, time.perf_counter() - start)
    start = time.perf_counter()
    candidates, missing = [(unedited(facade), plain)], ()
    try:
        retargeted = _retargeted(facade, wishes, locks, [grid] if grid else None)
        steps = tuple(str(choice) for choice in retargeted.choices if any(count != 1 for count in choice.counts))
        proven = not retargeted.resized.conflict and all(choice.proven for choice in retargeted.choices)
        seconds = time.perf_counter() - start
        inherited_locks = inherited(locks, retargeted.variation)
        candidates.insert(
            0,
            (
                retargeted.variation,
                _edited(retargeted.variation, retargeted.resized, inherited_locks, seconds, steps, proven),
            ),
        )
    except FacadeError as error:  # sizes alone always have a solution
        missing = (f"columns and rows were not chosen for this size: {error}",)
    best = candidates[0][1]
    # Most contradictions do not depend on the columns, and each would need an explanation.
    if facade.grids and not best.conflict and best.energy > _MIN_DEVIATION**2 * len(best.facade.leaves):
        joined, name = _active(facade, grid)
        start = time.perf_counter()
        stepped = stepwise(joined, wishes, name, locks)
        candidates.append((stepped, _solved(facade, stepped, wishes, locks, start)))
    kind = kinds(facade)
    different = {canonical(variation, kind): result for variation, result in reversed(candidates)}
    first, *others = (
        replace(edited, missing=(*edited.missing, *missing)) for edited in sorted(different.values(), key=_by_energy)
    )
    return (first, *(replace(edited, proven=False) for edited in others))


def _by_energy(edited: Edited) -> tuple[bool, float]:
    """Order of results for another size: by energy, of equal ones the proven one first; contradictions last."""
    return bool(edited.conflict), edited.energy if edited.proven else (1.0 + _TIE_TOLERANCE) * edited.energy


def _retargeted(
    facade: Facade, wishes: Sequence[Size], locks: Sequence[Wish], grids: Sequence[str] | None
) -> Retargeted:
    metres = {wish.axis: wish.metres for wish in wishes}
    leaves = len(facade.leaves)
    for axis, size in metres.items():
        leaves *= max(1.0, size / float(facade.size[0, axis]))
    if leaves > _MAX_FACADE_LEAVES:
        raise FacadeError(f"the result would have about {leaves:,.0f} leaves; expected at most {_MAX_FACADE_LEAVES:,}.")
    return retarget(facade, width=metres.get(X), height=metres.get(Y), grids=grids, locks=locks)


def _varied(
    facade: Facade,
    wishes: Sequence[Size],
    locks: tuple[Wish, ...],
    counts: tuple[int, int],
    grid: str,
    most: int,
) -> tuple[Edited, ...]:
    """Variations with additional columns and rows of a grid and of those that follow it."""
    kind = kinds(facade)
    variations, is_complete = (unedited(facade),), True
    for axis in (X, Y):
        also = tuple(dict.fromkeys((*following(facade, grid), *aligned(facade, grid, axis))))
        for _ in range(abs(counts[axis])):
            limit = min(max(affordable(variations[0].facade, grid, axis, _MAX_LEAVES), 1), _MAX_CONTINUED)
            is_complete = is_complete and len(variations) <= limit
            before = variations if len(variations) <= limit else ranked(variations, kind, different=limit)[:limit]
            step = 1 if counts[axis] > 0 else -1
            variations = sequences(facade, grid, axis, step, also=also, start=before)
            if not variations:
                raise FacadeError(_why_not(before[0], grid, axis, step))
    is_complete = is_complete and len(variations) <= _MAX_SOLVED
    variations = (
        variations
        if len(variations) <= _MAX_SOLVED
        else ranked(variations, kind, different=_MAX_SOLVED // 2)[:_MAX_SOLVED]
    )
    results: dict[int, Edited] = {}
    for variation in variations:
        results[id(variation)] = _solved(facade, variation, wishes, locks, time.perf_counter())
    flawed = [bool(results[id(variation)].conflict or variation.missing) for variation in variations]
    order: list[Edited] = []
    for group in (False, True):
        members = [variation for variation, flaw in zip(variations, flawed, strict=True) if flaw == group]
        order += [
            results[id(variation)]
            for variation in ranked(members, kind, lambda variation: results[id(variation)].energy, most)
        ]
    best, *others = sorted(order[:most], key=lambda result: (bool(result.conflict or result.missing), result.energy))
    return (replace(best, proven=is_complete), *others)


def _why_not(before: Variation, grid: str, axis: int, step: int) -> str:
    """Reason why no column or row of a grid can be added or removed."""
    name = "column" if axis == X else "row"
    discarded = vary(before, grid, axis, also=(), insertions=step > 0, removals=step < 0).discarded
    reason = discarded[0] if discarded else f"it has one {name}"
    return f"Grid '{grid}': no {name} can be {'added' if step > 0 else 'removed'}: {reason}"


def _active(facade: Facade, grid: str) -> tuple[Facade, str]:
    """The facade and the name of the edited grid: by default the largest, merged with all that continue it."""
    if grid:
        return facade, grid
    if not facade.grids:
        raise FacadeError(
            "The facade has no grid, and none can be proposed: no element is repeated. Use `width=` or `height=`."
        )
    facade = with_joint(facade)
    return facade, max(facade.grids, key=lambda grid: len(grid.node)).name


def _solved(
    facade: Facade, variation: Variation, wishes: Sequence[Wish], locks: Sequence[Wish], start: float
) -> Edited:
    """A variation with solved sizes; locks of which no copy is left are conflicts."""
    inherited_locks = inherited(locks, variation)
    solved = resize(variation.facade, (*wishes, *inherited_locks), origin_of(facade, variation))
    lost_locks = tuple(
        f"{in_words(lock, facade)}, but no copy of it is left" for lock in lost(facade, locks, variation)
    )
    solved = replace(solved, conflict=(*solved.conflict, *lost_locks))
    return _edited(variation, solved, inherited_locks, time.perf_counter() - start, variation.steps)


def _edited(
    variation: Variation,
    solved: Resized,
    locks: tuple[Wish, ...],
    seconds: float,
    steps: tuple[str, ...] = (),
    proven: bool = False,
) -> Edited:
    return Edited(
        facade=solved.facade,
        energy=sum(solved.energy),
        residuals=solved.residuals,
        steps=steps,
        proven=proven,
        conflict=solved.conflict,
        relaxed=solved.relaxed,
        missing=variation.missing,
        locks=locks,
        seconds=seconds,
    )
