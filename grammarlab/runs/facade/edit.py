"""A facade for another size, or with more or fewer columns and rows."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isfinite
from typing import Any

from grammarlab.errors import FacadeError, UsageError
from grammarlab.facade.grids.editing import aligned, following, grid_of
from grammarlab.facade.grids.joint import with_joint
from grammarlab.facade.grids.kinds import kinds
from grammarlab.facade.grids.proposals import with_proposals
from grammarlab.facade.retargeting.energy import origin_of
from grammarlab.facade.retargeting.retarget import Retargeted, retarget
from grammarlab.facade.retargeting.stepwise import MOST_STEPS, affordable, stepwise
from grammarlab.facade.sizes.solve import Residuals, Resized, resize
from grammarlab.facade.sizes.wishes import Size, Wish, checked
from grammarlab.facade.tree import Facade, X, Y
from grammarlab.facade.variations.inheriting import inherited
from grammarlab.facade.variations.ranking import ranked
from grammarlab.facade.variations.sequences import canonical, sequences
from grammarlab.facade.variations.single import Variation, unedited, vary

_KEPT, _WORK = 40, 60_000
"""Variations that are gone on from after each step at most, and leaves of all that come of them."""
_SOLVED = 200
"""Variations whose sizes are solved for."""
_VISIBLE = 0.1
"""Part by which sizes deviate on average when other ways to repeat columns are looked for."""
_LEAVES = 10_000
"""Leaves of a facade whose columns and rows are chosen by its size; that takes up to 100 solutions."""


@dataclass(frozen=True, eq=False)
class Edited:
    """One result of an edit."""

    facade: Facade
    energy: float
    """Sum of both axes; 0 where no leaf deviates from what it comes from."""
    residuals: Residuals
    steps: tuple[str, ...]
    """In words; none where only sizes differ."""
    proven: bool
    """Whether no other columns and rows deform less, of those that do what was asked for."""
    conflict: tuple[str, ...]
    """Wishes and grids that contradict each other."""
    relaxed: tuple[str, ...]
    """What gave way, and by how much."""
    missing: tuple[str, ...]
    """What the steps could not do."""
    locks: tuple[Wish, ...]
    """What stays as it is when the result is edited again."""
    seconds: float
    """That it took to choose columns and rows, or to solve for sizes where these were given."""

    def as_dict(self) -> dict[str, Any]:
        """For `--json`."""
        return {
            "width": self.facade.width,
            "height": self.facade.height,
            "leaves": len(self.facade.leaves),
            "energy": self.energy if isfinite(self.energy) else None,
            "residuals": {key: each if isfinite(each) else None for key, each in self.residuals.as_dict().items()},
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
    """What a facade may become, the best first.

    For another size alone, columns and rows are repeated or left out as deforms the facade least (`retarget`), or
    one by one where that deforms it visibly (`stepwise`); another result keeps all of them. Where columns or rows are
    given, these are the different variations that have them: the one of least energy, then always one that looks
    different from all before it (`ranked`). Results without a conflict come first.

    Args:
        facade: the facade; grids are proposed where it has none.
        width: metres; as wide as its columns make it when left out.
        height: metres; likewise.
        columns: how many more, at most `MOST_STEPS`; fewer if below 0.
        rows: likewise.
        grid: name of the grid whose columns and rows; by default all for another size, else that of most elements.
        most: how many results.
        locks: what stays as it is, and in copies; places do where no columns and rows change. A width or height that is
            asked for goes before a lock of the whole facade.

    Raises:
        UsageError: when nothing is wished for, lengths are not above 0, or for too many columns or rows.
        FacadeError: for lengths that no facade can have, a grid that there is not, and columns and rows that cannot be
            added or removed.

    >>> import grammarlab as gl
    >>> arcade = gl.load_facade(gl.examples_folder() / "facades" / "arcade.json")
    >>> [edited.facade.width for edited in gl.edit_facade(arcade, width=31.5, most=1)]
    [31.5]
    """
    if width is None and height is None and not columns and not rows:
        raise UsageError("nothing to do: give --width, --height, --columns or --rows.")
    if max(abs(columns), abs(rows)) > MOST_STEPS:
        raise UsageError(f"--columns and --rows: expected at most {MOST_STEPS} more or fewer.")
    for name, metres in (("--width", width), ("--height", height)):
        if metres is not None and not (isfinite(metres) and metres > 0.0):
            raise UsageError(f"{name}: expected metres above 0, found {metres:g}.")
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
    """The facade with other columns and rows, and with the same."""
    start = time.perf_counter()
    plain = _edited(unedited(facade), resize(facade, (*wishes, *locks)), locks, time.perf_counter() - start)
    start = time.perf_counter()
    found = [(unedited(facade), plain)]
    try:
        made = _retargeted(facade, wishes, locks, [grid] if grid else None)
        steps = tuple(str(choice) for choice in made.choices if any(count != 1 for count in choice.counts))
        proven = all(choice.proven for choice in made.choices)
        seconds = time.perf_counter() - start
        held = inherited(locks, made.variation)
        found.insert(0, (made.variation, _edited(made.variation, made.resized, held, seconds, steps, proven)))
    except FacadeError as error:  # sizes alone always have an answer
        found = [(unedited(facade), replace(plain, missing=(f"no columns or rows were repeated: {error}",)))]
    best = found[0][1]
    start = time.perf_counter()
    # What contradicts each other mostly does so with any columns, and each of them would have to be explained.
    if facade.grids and not best.conflict and best.energy > _VISIBLE**2 * len(best.facade.leaves):
        joined, name = _active(facade, grid)
        each = stepwise(joined, wishes, name, locks)
        held = inherited(locks, each)
        solved = resize(each.facade, (*wishes, *held), origin_of(facade, each))
        found.append((each, _edited(each, solved, held, time.perf_counter() - start, each.steps)))
    kind = kinds(facade)
    different = {canonical(variation, kind): result for variation, result in reversed(found)}
    first, *others = sorted(different.values(), key=lambda each: (bool(each.conflict), each.energy))
    return (first, *(replace(each, proven=False) for each in others))


def _retargeted(
    facade: Facade, wishes: Sequence[Size], locks: Sequence[Wish], grids: Sequence[str] | None
) -> Retargeted:
    metres = {each.axis: each.metres for each in wishes}
    leaves = len(facade.leaves)
    for axis, size in metres.items():
        leaves *= max(1.0, size / float(facade.size[0, axis]))
    if leaves > _LEAVES:
        raise FacadeError(f"the result would have about {leaves:,.0f} leaves; expected at most {_LEAVES:,}.")
    return retarget(facade, width=metres.get(X), height=metres.get(Y), grids=grids, locks=locks)


def _varied(
    facade: Facade,
    wishes: Sequence[Size],
    locks: tuple[Wish, ...],
    counts: tuple[int, int],
    grid: str,
    most: int,
) -> tuple[Edited, ...]:
    """Variations with so many more columns and rows of a grid and of those that go with it."""
    kind = kinds(facade)
    found, whole = (unedited(facade),), True
    for axis in (X, Y):
        also = tuple(dict.fromkeys((*following(facade, grid), *aligned(facade, grid, axis))))
        for _ in range(abs(counts[axis])):
            kept = min(max(affordable(found[0].facade, grid, axis, _WORK), 1), _KEPT)
            whole = whole and len(found) <= kept
            before = found if len(found) <= kept else ranked(found, kind, different=kept)[:kept]
            step = 1 if counts[axis] > 0 else -1
            found = sequences(facade, grid, axis, step, also=also, start=before)
            if not found:
                raise FacadeError(_why_not(before[0], grid, axis, step))
    whole = whole and len(found) <= _SOLVED
    found = found if len(found) <= _SOLVED else ranked(found, kind, different=_SOLVED // 2)[:_SOLVED]
    results: dict[int, Edited] = {}
    for each in found:
        start = time.perf_counter()
        held = inherited(locks, each)
        solved = resize(each.facade, (*wishes, *held), origin_of(facade, each))
        results[id(each)] = _edited(each, solved, held, time.perf_counter() - start, each.steps)
    flawed = [bool(results[id(each)].conflict or each.missing) for each in found]
    order: list[Edited] = []
    for group in (False, True):
        members = [each for each, flaw in zip(found, flawed, strict=True) if flaw == group]
        order += [results[id(each)] for each in ranked(members, kind, lambda each: results[id(each)].energy, most)]
    return (replace(order[0], proven=whole), *order[1:most])


def _why_not(before: Variation, grid: str, axis: int, step: int) -> str:
    """Why no column or row of a grid can be added or removed."""
    name = "column" if axis == X else "row"
    tried = vary(before, grid, axis, also=(), insertions=step > 0, removals=step < 0).discarded
    reason = tried[0] if tried else f"it has one {name}"
    return f"Grid '{grid}': no {name} can be {'added' if step > 0 else 'removed'}: {reason}"


def _active(facade: Facade, grid: str) -> tuple[Facade, str]:
    """The facade and the name of the grid that is edited: the largest with all that continue it if none is named."""
    if grid:
        return facade, grid
    if not facade.grids:
        raise FacadeError(
            "The facade has no grid, and none can be proposed: nothing in it comes twice. Give --width or --height."
        )
    facade = with_joint(facade)
    return facade, max(facade.grids, key=lambda grid: len(grid.node)).name


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
