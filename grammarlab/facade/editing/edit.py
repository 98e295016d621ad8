"""A facade for another size, or with more or fewer columns and rows."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import isfinite
from typing import Any

from grammarlab.errors import FacadeError, UsageError
from grammarlab.facade.editing.edit_sequences import canonical, ranked, sequences
from grammarlab.facade.editing.faults import find_faults
from grammarlab.facade.editing.grid_proposals import with_joint, with_proposals
from grammarlab.facade.editing.grids import aligned, following, grid_of, kinds, single_shops
from grammarlab.facade.editing.retarget import MOST_STEPS, Retargeted, affordable, retarget, stepwise
from grammarlab.facade.editing.slab_counts import best_slabs, changed_slabs
from grammarlab.facade.editing.springs import origin_of
from grammarlab.facade.editing.variations import Variation, inherited, lost, unedited, vary
from grammarlab.facade.editing.wall_slabs import find_elements
from grammarlab.facade.sizes.constraints import LineOrigin
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
    faults: tuple[str, ...]
    """Kinds of faults that a person sees (`faults.py`), such as openings out of line; empty for a good result."""
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
            "faults": list(self.faults),
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

    For another size alone, columns and rows of the whole facade are repeated or removed for the least deformation
    (`best_slabs`); another result keeps all of them. If both have faults that a person sees, so are those of grids
    (`retarget`), or one by one if the deformation is visible (`stepwise`). If columns or rows are given, the results
    are different variations with them: the one of least energy, and others that look different from each other
    (`ranked`). Results with fewer kinds of faults come first, then those of less energy; those with a conflict or a
    missing step come last.

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
        whole = [] if grid else _with_changed_columns(facade, wishes, locks, (columns, rows))
        good = [candidate.edited for candidate in whole if _is_good([candidate])]
        if len(good) >= most:
            return tuple(sorted(good, key=lambda edited: edited.energy)[:most])
        facade, grid = _active(facade, grid)
        return _varied(facade, wishes, locks, (columns, rows), grid, most, whole)
    return _resized(facade, wishes, locks, grid)[:most]


@dataclass(frozen=True, eq=False)
class _Candidate:
    """A result, with what is compared."""

    variation: Variation
    edited: Edited

    @property
    def key(self) -> tuple[bool, int, float]:
        """Order of results: contradictions last, then by the number of kinds of faults, then by energy.

        Of equal energies, that of the proven one is less.
        """
        energy = self.edited.energy if self.edited.proven else (1.0 + _TIE_TOLERANCE) * self.edited.energy
        return bool(self.edited.conflict), len(self.edited.faults), energy


def _resized(facade: Facade, wishes: Sequence[Size], locks: tuple[Wish, ...], grid: str) -> tuple[Edited, ...]:
    """The facade with other columns and rows, and with the same ones; those without faults first.

    Columns of the whole facade are tried first, and columns of single grids only if those have faults.
    """
    same = unedited(facade)
    plain = _Candidate(same, _solved(facade, same, wishes, locks, time.perf_counter(), in_line=True))
    if not plain.edited.energy and not plain.edited.conflict:
        return (replace(plain.edited, proven=True),)
    missing: tuple[str, ...] = ()
    whole = [] if grid else _with_whole_columns(facade, wishes, locks)
    candidates = [*whole, plain]
    if not whole or not _is_good(candidates):
        others, missing = _with_columns_of_grids(facade, wishes, locks, grid, plain)
        candidates = [*others, *candidates]
    kind = kinds(facade)
    different = {canonical(candidate.variation, kind): candidate for candidate in reversed(candidates)}
    first, *others = (
        replace(candidate.edited, missing=(*candidate.edited.missing, *missing))
        for candidate in sorted(different.values(), key=lambda candidate: candidate.key)
    )
    return (first, *(replace(edited, proven=False) for edited in others))


def _is_good(candidates: Sequence[_Candidate]) -> bool:
    """Whether one of them has neither a contradiction nor a fault."""
    return any(not candidate.edited.conflict and not candidate.edited.faults for candidate in candidates)


def _with_whole_columns(facade: Facade, wishes: Sequence[Size], locks: tuple[Wish, ...]) -> list[_Candidate]:
    """The facade with columns and rows of the whole facade repeated, if any can be.

    If that has a fault, also with shop windows that are never cut, and without those columns that cause a fault; and
    then with elements repeated that occur once.
    """
    candidates: list[_Candidate] = []
    shop_ways = (False, True) if single_shops(facade).any() else (False,)
    has_singles = any(find_elements(facade, wish.axis).is_alone.any() for wish in wishes)
    for singles, careful, shops in product((True, False) if has_singles else (True,), (False, True), shop_ways):
        start = time.perf_counter()
        variation, choices = unedited(facade), []
        try:
            _check_leaves(facade, wishes)
            for wish in wishes:
                locked = [lock.node for lock in inherited(locks, variation)]
                choice = best_slabs(
                    variation, facade, wish.axis, wish.metres, locked, careful=careful, shops=shops, singles=singles
                )
                if choice is not None:
                    choices.append(choice)
                    variation = choice.variation
        except FacadeError:  # too large, too deep, or nothing would be left
            choices = []
        if not choices and not candidates:
            break
        if not choices:  # other settings may find columns
            continue
        steps = tuple(str(choice) for choice in choices if any(count != 1 for count in choice.counts))
        edited = _solved(facade, variation, wishes, locks, start, in_line=True)
        proven = not edited.conflict and not locks and all(choice.is_proven for choice in choices)
        candidates.append(_Candidate(variation, replace(edited, steps=steps, proven=proven)))
        if _is_good(candidates):
            break
    return candidates


def _with_columns_of_grids(
    facade: Facade, wishes: Sequence[Size], locks: tuple[Wish, ...], grid: str, plain: _Candidate
) -> tuple[list[_Candidate], tuple[str, ...]]:
    """The facade with columns and rows of grids repeated, or added one by one, and why some were not tried."""
    start = time.perf_counter()
    candidates: list[_Candidate] = []
    missing: tuple[str, ...] = ()
    try:
        retargeted = _retargeted(facade, wishes, locks, [grid] if grid else None)
        steps = tuple(str(choice) for choice in retargeted.choices if any(count != 1 for count in choice.counts))
        edited = _edited(
            facade, retargeted.variation, retargeted.resized, inherited(locks, retargeted.variation), start
        )
        proven = not edited.conflict and all(choice.proven for choice in retargeted.choices)
        candidates.append(_Candidate(retargeted.variation, replace(edited, steps=steps, proven=proven)))
    except FacadeError as error:  # sizes alone always have a solution
        missing = (f"columns and rows were not chosen for this size: {error}",)
    best = (candidates or [plain])[0].edited
    # Most contradictions do not depend on the columns, and each would need an explanation.
    if facade.grids and not best.conflict and best.energy > _MIN_DEVIATION**2 * len(best.facade.leaves):
        joined, name = _active(facade, grid)
        start = time.perf_counter()
        stepped = stepwise(joined, wishes, name, locks)
        candidates.append(_Candidate(stepped, _solved(facade, stepped, wishes, locks, start)))
    return candidates, missing


def _merit(edited: Edited) -> float:
    """Energy, with each kind of fault as much as a deviation of each leaf by all of its size."""
    return edited.energy + len(edited.faults) * len(edited.facade.leaves)


def _retargeted(
    facade: Facade, wishes: Sequence[Size], locks: Sequence[Wish], grids: Sequence[str] | None
) -> Retargeted:
    metres = {wish.axis: wish.metres for wish in wishes}
    _check_leaves(facade, wishes)
    return retarget(facade, width=metres.get(X), height=metres.get(Y), grids=grids, locks=locks)


def _check_leaves(facade: Facade, wishes: Sequence[Size]) -> None:
    leaves = float(len(facade.leaves))
    for wish in wishes:
        leaves *= max(1.0, wish.metres / float(facade.size[0, wish.axis]))
    if leaves > _MAX_FACADE_LEAVES:
        raise FacadeError(f"the result would have about {leaves:,.0f} leaves; expected at most {_MAX_FACADE_LEAVES:,}.")


def _varied(
    facade: Facade,
    wishes: Sequence[Size],
    locks: tuple[Wish, ...],
    counts: tuple[int, int],
    grid: str,
    most: int,
    whole: Sequence[_Candidate],
) -> tuple[Edited, ...]:
    """Variations with additional columns and rows of a grid and of those that follow it, and of the whole facade."""
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
    results = {id(candidate.variation): candidate.edited for candidate in whole}
    for variation in variations:
        results[id(variation)] = _solved(facade, variation, wishes, locks, time.perf_counter())
    variations = (*(candidate.variation for candidate in whole), *variations)
    flawed = [bool(results[id(variation)].conflict or variation.missing) for variation in variations]
    order: list[Edited] = []
    for group in (False, True):
        members = [variation for variation, flaw in zip(variations, flawed, strict=True) if flaw == group]
        order += [
            results[id(variation)]
            for variation in ranked(members, kind, lambda variation: _merit(results[id(variation)]), most)
        ]
    best, *others = sorted(
        order[:most], key=lambda result: (bool(result.conflict or result.missing), len(result.faults), result.energy)
    )
    return (replace(best, proven=is_complete), *others)


def _with_changed_columns(
    facade: Facade, wishes: Sequence[Size], locks: tuple[Wish, ...], counts: tuple[int, int]
) -> list[_Candidate]:
    """The facade with these numbers of columns and rows of the whole facade more or fewer."""
    before: list[tuple[Variation, tuple[str, ...]]] = [(unedited(facade), ())]
    for along in (X, Y):
        if counts[along]:
            before = [
                (choice.variation, (*steps, str(choice)))
                for variation, steps in before[:_MAX_CONTINUED]
                for choice in changed_slabs(variation, along, counts[along])
            ]
    return [
        _Candidate(
            variation,
            replace(_solved(facade, variation, wishes, locks, time.perf_counter(), in_line=True), steps=steps),
        )
        for variation, steps in before[:_MAX_SOLVED]
    ]


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
    facade: Facade,
    variation: Variation,
    wishes: Sequence[Wish],
    locks: Sequence[Wish],
    start: float,
    *,
    in_line: bool = False,
) -> Edited:
    """A variation with solved sizes; locks of which no copy is left are conflicts.

    Args:
        facade: the original facade.
        variation: a variation of it.
        wishes: wishes for the variation.
        locks: locks of the original facade.
        start: start of the edit, seconds.
        in_line: whether the variation is laid out without deformation, so that its shared lines stay.
    """
    inherited_locks = inherited(locks, variation)
    origin = origin_of(facade, variation)
    if in_line:
        origin = LineOrigin(variation.facade.position, variation.target, facade.size[0], shares_lines=True)
    solved = resize(variation.facade, (*wishes, *inherited_locks), origin)
    lost_locks = tuple(
        f"{in_words(lock, facade)}, but no copy of it is left" for lock in lost(facade, locks, variation)
    )
    solved = replace(solved, conflict=(*solved.conflict, *lost_locks))
    return _edited(facade, variation, solved, inherited_locks, start)


def _edited(facade: Facade, variation: Variation, solved: Resized, locks: tuple[Wish, ...], start: float) -> Edited:
    return Edited(
        facade=solved.facade,
        energy=sum(solved.energy),
        residuals=solved.residuals,
        steps=variation.steps,
        proven=False,
        conflict=solved.conflict,
        relaxed=solved.relaxed,
        faults=find_faults(facade, variation, solved.facade).words,
        missing=variation.missing,
        locks=locks,
        seconds=time.perf_counter() - start,
    )
