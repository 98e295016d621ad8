"""New grids of labels in the style of examples, of any size, and their similarity to the examples in numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.synthesis.label_grid import MOST_CELLS, LabelGrid, Labels, Wishes, joined
from grammarlab.synthesis.labels.demands import demands_of
from grammarlab.synthesis.labels.exact import least_energy
from grammarlab.synthesis.labels.grid_search import PENALTY, expectation_maximization
from grammarlab.synthesis.labels.ground_floor import storey_notes, with_upper_storeys
from grammarlab.synthesis.labels.problem import MOST_COMPARED, bordered, energy, unbordered

Method = Literal["exact", "em"]
"""Methods of synthesis, see `synthesize`."""
NO_WISHES = Wishes()
_MOST_RESULTS = 100
"""Largest number of grids of one call."""
_WINDOW = 3
"""Rows and columns of a window."""


@dataclass(frozen=True, slots=True)
class Quality:
    """Similarity of a grid and its examples; each value from 0 to 1."""

    patch_similarity: float
    """Bidirectional: mean share of equal cells of a window and the nearest one of the other side, from the grid to the
    examples and from the examples to the grid; 1 if each has every window of the other."""
    cooccurrence: float
    """Total variation distance of pairs of adjacent labels, horizontal and vertical; 0 for equal frequencies."""
    histogram: float
    """Total variation distance of the labels; 0 for equal frequencies."""
    novelty: float
    """Share of the grid's windows that are in no example."""


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
    """Missing storeys of the example, and defaults that could not be kept, in words."""


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
    if not 1 <= count <= _MOST_RESULTS:
        raise FacadeError(f"count: expected 1 to {_MOST_RESULTS}, found {count}.")
    grids = joined(examples)
    example_map = _checked(regions, rows, columns, len(grids))
    plain = unbordered(grids, example_map)
    problem = bordered(grids, example_map) if borders else plain
    if rows * columns * sum(len(patches) for patches in plain.patches) > MOST_COMPARED:
        raise FacadeError(
            f"examples: {sum(len(patches) for patches in plain.patches):,} different windows are too many for "
            f"{rows} x {columns} cells; use smaller examples or fewer cells."
        )
    mapped = regions is not None
    demands = demands_of(problem.domain, grids, wishes if borders else replace(wishes, keep=False), mapped=mapped)
    starts = with_upper_storeys(grids, example_map) if borders else grids
    notes = storey_notes(grids, example_map) if borders and method == "exact" else ()
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
            bounded = least_energy(problem, demands, starts, seed, count, effort)
        except FacadeError:
            if len(demands.counts) == len(wishes.counts):
                raise
            # Wishes take precedence over defaults.
            given_up = "the units of the ground floor could not all be kept with these wishes"
            demands = replace(demands_of(problem.domain, grids, replace(wishes, keep=False)), notes=(given_up,))
            bounded = least_energy(problem, demands, starts, seed, count, effort)
        bound = bounded.bound
        runs = [(value, labels, ()) for value, labels in bounded.grids]
    return [
        Synthesis(
            grid=LabelGrid.from_labels(labels, grids[0].names),
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


def quality_of(grid: Labels, examples: Sequence[LabelGrid]) -> Quality:
    """The quality of a grid.

    Windows have 3 rows and 3 columns, or fewer if a grid has fewer. Holes match any label.

    Args:
        grid: [rows, columns] labels.
        examples: examples with the same numbering of labels.
    """
    height = min(_WINDOW, grid.shape[0], *(example.rows for example in examples))
    width = min(_WINDOW, grid.shape[1], *(example.columns for example in examples))
    windows = np.unique(_windows(grid, height, width), axis=0, return_counts=True)
    example_windows = np.unique(
        np.concatenate([_windows(e.labels, height, width) for e in examples]), axis=0, return_counts=True
    )
    differ = _differences(windows[0], example_windows[0])
    forth = float(np.average(differ.min(axis=1), weights=windows[1]))
    back = float(np.average(differ.min(axis=0), weights=example_windows[1]))
    return Quality(
        patch_similarity=1.0 - (forth + back) / (2 * height * width),
        cooccurrence=_distance([grid], [example.labels for example in examples], pairs=True),
        histogram=_distance([grid], [example.labels for example in examples], pairs=False),
        novelty=float(np.average(differ.min(axis=1) > 0, weights=windows[1])),
    )


def _checked(regions: Labels | None, rows: int, columns: int, examples: int) -> Labels:
    if regions is None:
        return np.full((rows, columns), -1, dtype=np.int64)
    values = np.asarray(regions)
    if values.shape != (rows, columns) or not np.issubdtype(values.dtype, np.integer):
        raise FacadeError(
            f"regions: expected {rows} x {columns} whole numbers, found {values.dtype} of {values.shape}."
        )
    if values.min() < 0 or values.max() >= examples:
        raise FacadeError(f"regions: expected examples 0 to {examples - 1}, found {values.min()} to {values.max()}.")
    return values.astype(np.int64)


def _windows(labels: Labels, height: int, width: int) -> Labels:
    """The windows of a grid, [windows, height * width]."""
    views = np.lib.stride_tricks.sliding_window_view(labels, (height, width))
    return views.reshape(-1, height * width)


def _differences(a: Labels, b: Labels) -> Labels:
    """[len(a), len(b)] number of differing labels."""
    count = np.zeros((len(a), len(b)), dtype=np.int64)
    for label_a, label_b in zip(a.T, b.T, strict=True):
        count += (label_a[:, None] != label_b) & (label_a[:, None] >= 0) & (label_b >= 0)
    return count


def _distance(a: Sequence[Labels], b: Sequence[Labels], pairs: bool) -> float:
    """Total variation distance of labels, or of pairs of neighbours, with horizontal and vertical pairs apart."""
    tables = []
    for grids in (a, b):
        keys: dict[tuple[int, ...], float] = {}
        for labels in grids:
            for key in _keys(labels, pairs):
                keys[key] = keys.get(key, 0.0) + 1.0
        total = sum(keys.values())
        tables.append({key: frequency / total for key, frequency in keys.items()})
    mine, theirs = tables
    if not mine or not theirs:  # a single cell has no neighbours
        return float(bool(mine) != bool(theirs))
    return sum(abs(mine.get(key, 0.0) - theirs.get(key, 0.0)) for key in {*mine, *theirs}) / 2.0


def _keys(labels: Labels, pairs: bool) -> list[tuple[int, ...]]:
    if not pairs:
        return [(label,) for label in labels[labels >= 0].tolist()]
    keys = []
    for axis in (0, 1):
        view = labels if axis else labels.T
        first, second = view[:, :-1].ravel(), view[:, 1:].ravel()
        is_known = (first >= 0) & (second >= 0)
        keys += [(axis, *pair) for pair in zip(first[is_known].tolist(), second[is_known].tolist(), strict=True)]
    return keys
