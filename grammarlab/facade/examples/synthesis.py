"""New grids of labels in the style of examples, of any size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.examples.label_grid import MOST_CELLS, LabelGrid, Labels, joined
from grammarlab.facade.examples.labels.demands import demands_of
from grammarlab.facade.examples.labels.energy import energy
from grammarlab.facade.examples.labels.exact import least_energy
from grammarlab.facade.examples.labels.expectation import expectation_maximization
from grammarlab.facade.examples.labels.problem import MOST_COMPARED, bordered, unbordered
from grammarlab.facade.examples.labels.search import PENALTY
from grammarlab.facade.examples.labels.storeys import storey_notes, with_upper_storeys
from grammarlab.facade.examples.quality import Quality, quality_of
from grammarlab.facade.examples.wishes import Wishes

Method = Literal["exact", "em"]
NO_WISHES = Wishes()
MOST_RESULTS = 100


@dataclass(frozen=True, slots=True)
class Synthesis:
    """A new grid of labels, and its quality."""

    grid: LabelGrid
    method: Method
    energy: int
    """Number of differing labels, summed over a window at every cell, each compared with the nearest window of the
    examples at the same borders (Eq. 1 and 2, with borders), plus 9 for every cell that violates a constraint, since a
    correction increases the energy by at most 9. It applies to grids of both methods; without borders it is
    `paper_energy` plus those 9."""
    bound: int
    """Lower bound of the energy of every grid that satisfies the constraints; 0 with method em, which has no bound."""
    proven: bool
    """Whether energy and bound are equal."""
    paper_energy: int
    """E(O) of the paper's Eq. 1: windows of 3 x 3 cells inside the grid only, without borders."""
    history: tuple[int, ...]
    """With method em, the paper's energy after each iteration; else empty."""
    quality: Quality
    notes: tuple[str, ...]
    """What the example has too little for, and defaults that could not be kept, in words."""


def synthesize(
    examples: Sequence[LabelGrid],
    rows: int,
    columns: int,
    *,
    method: Method = "exact",
    wishes: Wishes = NO_WISHES,
    seed: int = 0,
    count: int = 1,
    regions: Labels | None = None,
    effort: float = 1.0,
    borders: bool = True,
) -> list[Synthesis]:
    """Grids of the same kind as the examples, best first; with method exact, all are different.

    Args:
        examples: one or more; labels of equal name are equal.
        rows: rows of the new grid, 1 or more.
        columns: columns of the new grid, 1 or more.
        method: `exact` keeps borders and wishes and bounds the energy; `em` is the paper's method, for comparison, and
            keeps neither.
        wishes: wishes for the grid.
        seed: seed of all random choices.
        count: number of grids; exact may return fewer, em returns one for each seed from the given one on.
        regions: [rows, columns] example of each cell; all examples everywhere if left out.
        effort: factor on the usual amount of work before a gap between energy and bound is accepted.
        borders: whether to compare windows at all cells, and borders with borders; if not, energies are the paper's
            E(O), and ground floor, corners and door are not kept.

    Raises:
        FacadeError: If wishes contradict each other, or sizes are out of range.
    """
    if not examples:
        raise FacadeError("examples: expected at least one, found none.")
    if rows < 1 or columns < 1 or rows * columns > MOST_CELLS:
        raise FacadeError(
            f"rows, columns: expected 1 or more, and at most {MOST_CELLS:,} cells; found {rows} x {columns}."
        )
    if not 1 <= count <= MOST_RESULTS:
        raise FacadeError(f"count: expected 1 to {MOST_RESULTS}, found {count}.")
    grids = joined(examples)
    places = _checked(regions, rows, columns, len(grids))
    plain = unbordered(grids, places)
    problem = bordered(grids, places) if borders else plain
    if rows * columns * sum(len(patches) for patches in plain.patches) > MOST_COMPARED:
        raise FacadeError(
            f"examples: {sum(len(patches) for patches in plain.patches):,} different windows are too many for "
            f"{rows} x {columns} cells; use smaller examples or fewer cells."
        )
    mapped = regions is not None
    demands = demands_of(problem.domain, grids, wishes if borders else replace(wishes, keep=False), mapped=mapped)
    starts = with_upper_storeys(grids, places) if borders else grids
    notes = storey_notes(grids, places) if borders and method == "exact" else ()
    bound = 0
    runs: list[tuple[int, Labels, tuple[int, ...]]] = []
    if method == "em":
        for turn in range(count):
            trace = expectation_maximization(plain, seed + turn)
            value = energy(problem, trace.labels) + PENALTY * demands.broken(trace.labels)
            runs.append((value, trace.labels, trace.history))
        runs.sort(key=lambda run: run[0])
    else:
        try:
            found = least_energy(problem, demands, starts, seed, count, effort)
        except FacadeError:
            if len(demands.counts) == len(wishes.counts):
                raise
            # Wishes take precedence over defaults.
            given_up = "the units of the ground floor could not all be kept with these wishes"
            demands = replace(demands_of(problem.domain, grids, replace(wishes, keep=False)), notes=(given_up,))
            found = least_energy(problem, demands, starts, seed, count, effort)
        bound = found.bound
        runs = [(value, labels, ()) for value, labels in found.grids]
    return [
        Synthesis(
            grid=LabelGrid.of(labels, grids[0].names),
            method=method,
            energy=value,
            bound=bound,
            proven=method == "exact" and value == bound,
            paper_energy=energy(plain, labels),
            history=history,
            quality=quality_of(labels, grids),
            notes=notes + demands.notes,
        )
        for value, labels, history in runs
    ]


def _checked(regions: Labels | None, rows: int, columns: int, examples: int) -> Labels:
    if regions is None:
        return np.full((rows, columns), -1, dtype=np.int64)
    found = np.asarray(regions)
    if found.shape != (rows, columns) or not np.issubdtype(found.dtype, np.integer):
        raise FacadeError(f"regions: expected {rows} x {columns} whole numbers, found {found.dtype} of {found.shape}.")
    if found.min() < 0 or found.max() >= examples:
        raise FacadeError(f"regions: expected examples 0 to {examples - 1}, found {found.min()} to {found.max()}.")
    return found.astype(np.int64)
