"""Joint solution of counters, alignments and sizes: the layouts of least energy.

Layers of one alignment group are aligned with each other. Alignments of the same words are searched for on demand, the
best first, and each only once.
"""

from __future__ import annotations

import bisect
import heapq
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain

import numpy as np

from grammarlab.arrays import connected
from grammarlab.errors import FacadeError
from grammarlab.layers.alignment.align import Aligned, Alignment, Element, align, problem_of
from grammarlab.layers.alignment.pairs import PairProblem
from grammarlab.layers.alignment_equations import SizeEquations, demands, demands_alone, least_error
from grammarlab.layers.design import Weights, Word
from grammarlab.layers.symbol_sizes import SymbolSizes, size_letters

Group = tuple[int, str]
"""An axis, 0 for x and 1 for y, and the name of an alignment group on it."""
_Ranks = tuple[int, ...]
"""Rank of the alignment of each group of a candidate."""
_TOLERANCE_SHARES = (1 / 8, 1 / 4, 1 / 2)
"""Fractions of the tolerance to try after effort ran out."""
_GROWTH = 2.0
"""Growth factor of the cap on energies."""
_LAST_EFFORT = 20_000
"""Steps if effort ran out before the first layout."""
_MAX_HURRIED = 8
"""Number of candidates to try in that case."""
_STEPS_OF_SIZES = 300
"""Cost of solving for sizes, in steps of effort, approximately."""
_STEPS_OF_DEMANDS = 100
"""Cost of bounding an alignment, in steps of effort."""
_STEPS_OF_OPENING = 50
"""Cost of opening a candidate, in steps of effort."""
_STEPS_OF_BRANCH = 3
"""Cost of a branch, in steps of effort."""
_MOST_ENERGY = 4.0
"""Largest cap, in metres of error per metre of the canvas; above it, there is no cap."""


class StepsSpentError(FacadeError):
    """Effort ran out before the first layout."""


@dataclass
class SearchBudget:
    """Remaining steps of searches."""

    remaining: int
    stop: Callable[[], bool] = lambda: False
    """Whether the caller has cancelled the search."""

    @property
    def is_spent(self) -> bool:
        """Whether searches have to end now."""
        return self.remaining <= 0 or self.stop()


@dataclass(frozen=True)
class Candidate:
    """A word for each layer and axis."""

    counters: Mapping[str, int]
    words: Mapping[Group, tuple[Word, ...]]
    """Words of each group, from its top layer down."""
    bound: float = 0.0
    """Lower bound of the energy of its layouts."""


Candidates = Callable[[float], Iterable[Candidate]]
"""Function from a tolerance, metres, to all candidates whose words fit the canvas within it."""


@dataclass(frozen=True)
class Layout:
    """A candidate with alignments and sizes."""

    candidate: Candidate
    alignments: Mapping[Group, Alignment]
    sizing: SymbolSizes
    energy: float
    bound: float
    """Lower bound of the energy of all layouts that are not before this one in the list, within `tolerance`."""
    proven: bool
    tolerance: float
    """The tolerance mu, metres."""

    @property
    def groups(self) -> tuple[Group, ...]:
        """Groups in the order of `sizing.placed`."""
        return tuple(self.alignments)


def solve(
    candidates: Candidates,
    canvas: tuple[float, float],
    weights: Weights,
    count: int = 1,
    *,
    tolerances: Sequence[float],
    gaps: bool = False,
    others: Callable[[float], float] = lambda _: math.inf,
    effort: int = 500_000,
    stop: Callable[[], bool] = lambda: False,
) -> list[Layout]:
    """The best different layouts, best first; empty if even the last tolerance has none.

    Args:
        candidates: function of a tolerance, see `Candidates`.
        canvas: width and height, metres.
        weights: weights of the energy.
        count: largest number of layouts.
        tolerances: metres, growing; the first one with a layout is searched completely.
        gaps: whether elements with letters that are not opaque keep their size, see `size_letters`.
        others: function of a tolerance: lower bound of the energy of layouts that `candidates` leaves out.
        effort: largest number of steps of all searches with one tolerance, see `align`; layouts of a search that used
            them up may be unproven.
        stop: ends all searches as soon as it returns true; the result is then arbitrary.

    Raises:
        StepsSpentError: If effort ran out before the first layout.
    """
    exhausted = False
    for tolerance in tolerances:
        if exhausted and tolerance < max(tolerances):  # a larger tolerance gives a layout sooner
            continue
        fitting = tuple(candidates(tolerance))
        budget = SearchBudget(effort // 2, stop)
        whole = _Branches(
            candidates=fitting,
            canvas=canvas,
            weights=weights,
            count=count,
            tolerance=tolerance,
            gaps=gaps,
            budget=budget,
            others=others(tolerance),
        )
        best = whole.layouts()
        # Layouts within a fraction of the tolerance are found sooner.
        for part in _TOLERANCE_SHARES if whole.budget.is_spent else ():
            narrow = _Branches(
                candidates=fitting,
                canvas=canvas,
                weights=weights,
                count=count,
                tolerance=part * tolerance,
                gaps=gaps,
                budget=SearchBudget(effort // 8, stop),
            )
            narrow_layouts = narrow.layouts()
            if len(narrow_layouts) > len(best):
                best = [whole.judged(layout) for layout in narrow_layouts]
        if not best and not stop() and whole.budget.remaining <= 0:
            exhausted, best = True, whole.hurried()
        if best or stop():
            return best
    if exhausted:
        raise StepsSpentError(
            f"no layout of these layers was found in {effort:,} steps, but one may exist. Put layers that need "
            "not be aligned into separate alignment groups, or give them fewer different patterns."
        )
    return []


@dataclass
class _Branches:
    """Candidates and their alignments, branch and bound over lower bounds of the energy.

    Branches whose bound exceeds a cap are cut; while there are too few layouts within the cap, it grows. So candidates
    that fit badly are dropped early.
    """

    candidates: tuple[Candidate, ...]
    canvas: tuple[float, float]
    weights: Weights
    count: int
    tolerance: float
    gaps: bool
    budget: SearchBudget
    others: float = math.inf
    """Lower bound of the energy of other candidates."""
    shelves: dict[tuple[int, tuple[Word, ...], int], _Shelf] = field(default_factory=dict)
    opened: dict[int, _Opened] = field(default_factory=dict)
    sized: dict[tuple[int, _Ranks], SymbolSizes | None] = field(default_factory=dict)
    best: list[tuple[float, int, _Ranks]] = field(default_factory=list)
    looks: dict[tuple[int, bytes], tuple[float, _Ranks]] = field(default_factory=dict)
    """Keys of the looks in `best`: layouts that look the same are merged."""
    heap: list[tuple[float, int, _Ranks]] = field(default_factory=list)
    cap: float = 0.0
    unsearched_bound: float = math.inf
    """Lower bound of the energy of branches that effort did not suffice to search."""

    def layouts(self) -> list[Layout]:
        longest = max(self.canvas)
        caps = [self.weights.omega * longest / 50.0 + 3.0 * self.weights.merge]
        while caps[-1] < _MOST_ENERGY * longest * (self.weights.omega + self.weights.merge / longest):
            caps.append(caps[-1] * _GROWTH)
        for cap in (*caps, math.inf):
            self._within(cap)
            if len(self.best) == self.count or self.budget.is_spent:
                break
        return [self._layout(*entry) for entry in self.best]

    @property
    def bound(self) -> float:
        """Lower bound of the energy of layouts that are not in `best`."""
        return min(self.unsearched_bound, self.heap[0][0] if self.heap else math.inf, self.cap, self.others)

    @property
    def threshold(self) -> float:
        """Largest energy of a layout among the best."""
        return min(self.best[-1][0], self.cap) if len(self.best) == self.count else self.cap

    def _within(self, cap: float) -> None:
        self.cap, self.best, self.looks, self.unsearched_bound = cap, [], {}, math.inf
        self.heap = [(candidate.bound, number, ()) for number, candidate in enumerate(self.candidates)]
        heapq.heapify(self.heap)
        while self.heap and self.heap[0][0] <= self.threshold:
            if self.budget.is_spent:
                break
            bound, number, ranks = heapq.heappop(self.heap)
            self.budget.remaining -= _STEPS_OF_BRANCH
            if number not in self.opened:
                self.budget.remaining -= _STEPS_OF_OPENING
                self.opened[number] = self._open(number)
                if self.opened[number].floor > bound:
                    heapq.heappush(self.heap, (self.opened[number].floor, number, ()))
                    continue
            if ranks:
                self._next(number, ranks)
            else:
                self._first(number)

    def _open(self, number: int) -> _Opened:
        words = self.candidates[number].words
        sharing = _sharing_groups(words)
        shelves = []
        for group, rows in words.items():
            key = group[0], rows, sharing[group]
            if key not in self.shelves:
                share = self.weights.sizing / sharing[group]
                self.shelves[key] = _Shelf(
                    words=rows,
                    canvas=self.canvas[group[0]],
                    weights=self.weights,
                    tolerance=self.tolerance,
                    budget=self.budget,
                    sizing=share,
                    gaps=self.gaps,
                )
            shelves.append(self.shelves[key])
        alone = (
            []
            if self.gaps
            else [demands_alone(shelf.words[0], shelf.canvas) for shelf in shelves if not shelf.is_varied]
        )
        floor = self.weights.sizing * least_error([equations for equations in alone if equations is not None])
        return _Opened(tuple(words), tuple(shelves), floor)

    def _take(self, shelf: _Shelf, rank: int, rest: float) -> Alignment | None:
        """An alignment of a group whose energy, with the bounds of the rest, is within the cap."""
        cutoff = self.threshold - rest
        alignment = shelf.alignment(rank, cutoff)
        if alignment is None and not shelf.is_decided(rank, cutoff):
            self.unsearched_bound = min(self.unsearched_bound, rest + shelf.aligned.bound)
        return alignment

    def _first(self, number: int) -> None:
        """The best alignment of each group of a candidate."""
        bound, opened = 0.0, self.opened[number]
        for shelf in opened.shelves:
            if self._take(shelf, 0, bound) is None:
                return
            bound += shelf.energy(0)
        same = [shelf.demands(0) for shelf in opened.shelves if not shelf.is_varied]
        opened.floor = max(opened.floor, self.weights.sizing * least_error(same))
        self._push(number, (0,) * len(opened.shelves))

    def _next(self, number: int, ranks: _Ranks) -> None:
        """The next best alignment of each group in turn; groups before the last changed one are fixed.

        All alignments of layers with one word look the same.
        """
        opened = self.opened[number]
        bound = opened.bound(ranks)
        last = max((index for index, rank in enumerate(ranks) if rank), default=0)
        for index in range(last, len(ranks)):
            shelf = opened.shelves[index]
            rest = bound - shelf.energy(ranks[index])
            if shelf.is_varied and self._take(shelf, ranks[index] + 1, rest) is not None:
                self._push(number, (*ranks[:index], ranks[index] + 1, *ranks[index + 1 :]))

    def _push(self, number: int, ranks: _Ranks) -> None:
        opened = self.opened[number]
        aligned = opened.aligned(ranks)
        bound = opened.bound(ranks)
        paid = sum(alignment.energy for alignment in aligned)
        # Bounds that differ between alignments of one candidate would not hold for later ones.
        heapq.heappush(self.heap, (max(bound, paid + opened.floor), number, ranks))
        if max(bound, paid + opened.floor) > self.threshold:
            return
        self.budget.remaining -= _STEPS_OF_DEMANDS
        systems = [shelf.demands(rank) for shelf, rank in zip(opened.shelves, ranks, strict=True)]
        if paid + self.weights.sizing * least_error(systems) > self.threshold:
            return
        key = number, ranks
        if key not in self.sized:
            canvases = [self.canvas[axis] for axis, _ in opened.groups]
            self.sized[key] = size_letters(list(zip(aligned, canvases, strict=True)), gaps=self.gaps)
            self.budget.remaining -= _STEPS_OF_SIZES
        sizing = self.sized[key]
        if sizing is None:
            return
        energy = paid + self.weights.sizing * sizing.error
        if energy <= self.threshold:
            self._insert(energy, number, ranks, _look(aligned, sizing))

    def _insert(self, energy: float, number: int, ranks: _Ranks, look: bytes) -> None:
        """Adds a layout to the best, unless one that looks the same is better."""
        twin = self.looks.get((number, look))
        if twin is not None:
            if twin[0] <= energy:
                return
            self.best.remove((twin[0], number, twin[1]))
        self.looks[number, look] = energy, ranks
        bisect.insort(self.best, (energy, number, ranks))
        for worst in self.best[self.count :]:
            self.looks = {key: entry for key, entry in self.looks.items() if entry != (worst[0], worst[2])}
        del self.best[self.count :]

    def hurried(self) -> list[Layout]:
        """Layouts of the first candidates that have one, at any energy."""
        bound, order = self.bound, sorted(range(len(self.candidates)), key=self._missing)
        self.cap = math.inf
        for number in order[:_MAX_HURRIED]:
            self.budget.remaining, self.heap = _LAST_EFFORT, []
            self.opened.setdefault(number, self._open(number))
            self._first(number)
            while self.heap and not self.best and not self.budget.is_spent:
                self._next(number, heapq.heappop(self.heap)[2])
            if self.best:
                break
        self.unsearched_bound = min(self.unsearched_bound, bound)
        return [self._layout(*entry) for entry in self.best]

    def _missing(self, number: int) -> float:
        """Differences of a candidate's longest words from their canvases, metres, summed."""
        words = self.candidates[number].words
        longest = {
            group: max(sum(letter.size or 0.0 for letter in word) for word in rows) for group, rows in words.items()
        }
        return sum(abs(self.canvas[group[0]] - size) for group, size in longest.items() if size)

    def judged(self, layout: Layout) -> Layout:
        """A layout of another search, with the bounds of this one."""
        bound = min(self.bound, layout.energy)
        return replace(layout, bound=bound, proven=bound == layout.energy, tolerance=self.tolerance)

    def _layout(self, energy: float, number: int, ranks: _Ranks) -> Layout:
        sizing, opened = self.sized[number, ranks], self.opened[number]
        if sizing is None:
            raise AssertionError("Only layouts with sizes are among the best.")
        return Layout(
            candidate=self.candidates[number],
            alignments=dict(zip(opened.groups, opened.aligned(ranks), strict=True)),
            sizing=sizing,
            energy=energy,
            bound=min(self.bound, energy),
            proven=self.bound >= energy,
            tolerance=self.tolerance,
        )


@dataclass
class _Shelf:
    """Alignments of the same words."""

    words: tuple[Word, ...]
    canvas: float
    weights: Weights
    tolerance: float
    budget: SearchBudget
    sizing: float
    """Weight of strains in the energy."""
    gaps: bool
    aligned: Aligned = field(default_factory=lambda: Aligned((), 0.0, done=False))
    num_requested: int = 0
    """Number of alignments that have been requested from searches."""
    cutoff: float = -math.inf
    """Largest energy of the last search."""
    equations: dict[tuple[tuple[Element, ...], ...], SizeEquations] = field(default_factory=dict)

    @property
    def is_varied(self) -> bool:
        """Whether the words differ: alignments of equal words all look the same."""
        return any(word != self.words[0] for word in self.words)

    def alignment(self, rank: int, cutoff: float) -> Alignment | None:
        """The alignment of this rank in energy; None if its energy is above the cutoff or effort ran out."""
        missing = rank >= len(self.aligned.best) and not self.is_decided(rank, cutoff)
        if missing and not self.budget.is_spent:
            self._search(max(rank + 1, 2 * rank), max(cutoff, self.cutoff))
        if rank < len(self.aligned.best) and self.energy(rank) <= cutoff:
            return self.aligned.best[rank]
        return None

    def demands(self, rank: int) -> SizeEquations:
        """Size equations of a known alignment."""
        cells = self.aligned.best[rank].cells
        if cells not in self.equations:
            self.equations[cells] = demands(self.aligned.best[rank], self.canvas, gaps=self.gaps)
        return self.equations[cells]

    def energy(self, rank: int) -> float:
        """Lower bound of the energy of a layout with this alignment."""
        alignment = self.aligned.best[rank]
        return alignment.energy + self.sizing * alignment.strain

    def is_decided(self, rank: int, cutoff: float) -> bool:
        """Whether it is certain that there is no alignment of this rank."""
        exhausted = self.aligned.done and len(self.aligned.best) < self.num_requested and cutoff <= self.cutoff
        return rank < len(self.aligned.best) or exhausted

    @cached_property
    def _problem(self) -> PairProblem:
        return problem_of(
            self.words, self.canvas, self.weights, tolerance=self.tolerance, sizing=self.sizing, gaps=self.gaps,
            finest=True,
        )  # fmt: skip

    def _search(self, count: int, cutoff: float) -> None:
        result = align(
            self.words, self.canvas, self.weights, count,
            tolerance=self.tolerance, effort=max(self.budget.remaining // 4, 1_000), cutoff=cutoff,
            sizing=self.sizing, gaps=self.gaps, problem=self._problem,
        )  # fmt: skip
        self.budget.remaining -= result.steps
        if result.done or len(result.best) >= len(self.aligned.best):
            self.aligned, self.num_requested, self.cutoff = result, count, cutoff


@dataclass
class _Opened:
    """A candidate with alignments in progress."""

    groups: tuple[Group, ...]
    shelves: tuple[_Shelf, ...]
    floor: float = 0.0
    """Lower bound of the energy of sizes, for all alignments."""

    def aligned(self, ranks: _Ranks) -> list[Alignment]:
        return [shelf.aligned.best[rank] for shelf, rank in zip(self.shelves, ranks, strict=True)]

    def bound(self, ranks: _Ranks) -> float:
        """Lower bound of the energy of alignments and of their size changes."""
        return sum(shelf.energy(rank) for shelf, rank in zip(self.shelves, ranks, strict=True))


def _sharing_groups(words: Mapping[Group, tuple[Word, ...]]) -> dict[Group, int]:
    """For each group, the number of groups of several words that share symbols with it, directly or through others.

    Their size errors are one and the same, so that each group may count only its share.
    """
    symbols = [
        {letter.symbol for word in rows for letter in word if letter.size is not None} for rows in words.values()
    ]
    number = {symbol: len(words) + rank for rank, symbol in enumerate(dict.fromkeys(chain.from_iterable(symbols)))}
    edges = np.array(
        [(group, number[symbol]) for group, members in enumerate(symbols) for symbol in members], dtype=np.int64
    )
    part = connected(len(words) + len(number), *edges.reshape(-1, 2).T)[: len(words)]
    several = [len(set(rows)) > 1 for rows in words.values()]
    counts = np.bincount(part, weights=several, minlength=1).astype(np.int64)
    return {group: max(int(counts[component]), 1) for group, component in zip(words, part.tolist(), strict=True)}


def _look(aligned: Sequence[Alignment], sizing: SymbolSizes) -> bytes:
    """Key of the positions of all visible letters, rounded to 1e-7 of the canvas."""
    spans = [
        np.stack([lower[visible], upper[visible]]) / placed.ends[-1]
        for alignment, placed in zip(aligned, sizing.placed, strict=True)
        for word, lower, upper in zip(alignment.words, placed.lower, placed.upper, strict=True)
        for visible in ([index for index, letter in enumerate(word) if not letter.transparent],)
    ]
    return b"".join(np.round(span, 7).astype(np.float32).tobytes() for span in spans)
