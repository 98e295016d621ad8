"""Joint solution of counters, alignments and sizes: the layouts of least energy.

Alignment groups: the words of layers that are aligned with each other.

Alignments of words on demand: the best, the next best, and so on, each searched for once.
"""

from __future__ import annotations

import bisect
import heapq
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.layers.alignment.align import Aligned, Alignment, Element, align, problem_of
from grammarlab.layers.alignment.pairs import PairProblem
from grammarlab.layers.alignment_equations import SizeEquations, demands, demands_alone, least_error
from grammarlab.layers.design import Weights, Word
from grammarlab.layers.symbol_sizes import SymbolSizes, size_letters

Group = tuple[int, str]
"""An axis, 0 for x and 1 for y, and the name of an alignment group on it."""


def sharing_groups(words: Mapping[Group, tuple[Word, ...]]) -> dict[Group, int]:
    """For each group, the number of groups of several words that share symbols with it, directly or through others.

    Their size errors are one and the same, so that each group may count only its share.
    """
    parts: list[tuple[set[Group], set[str]]] = []
    for group, rows in words.items():
        groups, symbols = {group}, {letter.symbol for word in rows for letter in word if letter.size is not None}
        apart = []
        for part in parts:
            if part[1].isdisjoint(symbols):
                apart.append(part)
            else:
                groups, symbols = groups | part[0], symbols | part[1]
        parts = [*apart, (groups, symbols)]
    return {
        group: max(sum(len(set(words[other])) > 1 for other in groups), 1) for groups, _ in parts for group in groups
    }


@dataclass
class SearchBudget:
    """Remaining steps of searches."""

    left: int
    stop: Callable[[], bool] = lambda: False
    """Whether the caller has cancelled the search."""

    @property
    def is_spent(self) -> bool:
        """Whether searches have to end now."""
        return self.left <= 0 or self.stop()


@dataclass
class Shelf:
    """Alignments of the same words."""

    words: tuple[Word, ...]
    canvas: float
    weights: Weights
    tolerance: float
    budget: SearchBudget
    sizing: float
    """Weight of strains in the energy."""
    gaps: bool
    known: Aligned = field(default_factory=lambda: Aligned((), 0.0, done=False))
    asked: int = 0
    """Number of alignments that have been requested from searches."""
    cutoff: float = -math.inf
    """Largest energy of the last search."""
    demanded: dict[tuple[tuple[Element, ...], ...], SizeEquations] = field(default_factory=dict)

    @property
    def varied(self) -> bool:
        """Whether the words differ: alignments of equal words all look the same."""
        return any(word != self.words[0] for word in self.words)

    def at(self, place: int, cutoff: float) -> Alignment | None:
        """The alignment of this rank in energy; None if its energy is above the cutoff or effort ran out."""
        missing = place >= len(self.known.best) and not self.sure(place, cutoff)
        if missing and not self.budget.is_spent:
            self._search(max(place + 1, 2 * place), max(cutoff, self.cutoff))
        if place < len(self.known.best) and self.energy(place) <= cutoff:
            return self.known.best[place]
        return None

    def demands(self, place: int) -> SizeEquations:
        """Size equations of a known alignment."""
        cells = self.known.best[place].cells
        if cells not in self.demanded:
            self.demanded[cells] = demands(self.known.best[place], self.canvas, gaps=self.gaps)
        return self.demanded[cells]

    def energy(self, place: int) -> float:
        """Lower bound of the energy of a layout with this alignment."""
        found = self.known.best[place]
        return found.energy + self.sizing * found.strain

    def sure(self, place: int, cutoff: float) -> bool:
        """Whether it is certain that there is no alignment at this place."""
        exhausted = self.known.done and len(self.known.best) < self.asked and cutoff <= self.cutoff
        return place < len(self.known.best) or exhausted

    @cached_property
    def _problem(self) -> PairProblem:
        return problem_of(
            self.words, self.canvas, self.weights, tolerance=self.tolerance, sizing=self.sizing, gaps=self.gaps,
            finest=True,
        )  # fmt: skip

    def _search(self, count: int, cutoff: float) -> None:
        found = align(
            self.words, self.canvas, self.weights, count,
            tolerance=self.tolerance, effort=max(self.budget.left // 4, 1_000), cutoff=cutoff,
            sizing=self.sizing, gaps=self.gaps, problem=self._problem,
        )  # fmt: skip
        self.budget.left -= found.steps
        if found.done or len(found.best) >= len(self.known.best):
            self.known, self.asked, self.cutoff = found, count, cutoff


_PARTS = (1 / 8, 1 / 4, 1 / 2)
"""Fractions of the tolerance to try after effort ran out."""
_GROWTH = 2.0
"""Growth factor of the cap on energies."""
_LAST = 20_000
"""Steps if effort ran out before the first layout."""
_MOST_HURRIED = 8
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


@dataclass(frozen=True)
class Candidate:
    """A word for each layer and axis."""

    counters: Mapping[str, int]
    words: Mapping[Group, tuple[Word, ...]]
    """Words of each group, from its top layer down."""
    bound: float = 0.0
    """Lower bound of the energy of its layouts."""


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


Candidates = Callable[[float], Iterable[Candidate]]
"""Function from a tolerance, metres, to all candidates whose words fit the canvas within it."""


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
        gaps: see `size_letters`.
        others: function of a tolerance: lower bound of the energy of layouts that `candidates` leaves out.
        effort: steps of all searches with one tolerance, see `align`; layouts of a search that used them up may be
            unproven.
        stop: ends all searches as soon as it returns true; the result is then arbitrary.

    Raises:
        FacadeError: If effort ran out before the first layout.
    """
    tired = False
    for tolerance in tolerances:
        if tired and tolerance < max(tolerances):  # a larger tolerance gives a layout sooner
            continue
        given = tuple(candidates(tolerance))
        budget = SearchBudget(effort // 2, stop)
        whole = _Branches(
            candidates=given,
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
        for part in _PARTS if whole.budget.is_spent else ():
            narrow = _Branches(
                candidates=given,
                canvas=canvas,
                weights=weights,
                count=count,
                tolerance=part * tolerance,
                gaps=gaps,
                budget=SearchBudget(effort // 8, stop),
            )
            found = narrow.layouts()
            if len(found) > len(best):
                best = [whole.judged(layout) for layout in found]
        if not best and not stop() and whole.budget.left <= 0:
            tired, best = True, whole.hurried()
        if best or stop():
            return best
    if tired:
        raise FacadeError(
            f"no layout of these layers was found in {effort:,} steps, but one may exist. Put layers that need "
            "not be aligned into separate alignment groups, or give them fewer different patterns."
        )
    return []


Places = tuple[int, ...]
"""Rank of the alignment of each group of a candidate."""


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
    shelves: dict[tuple[int, tuple[Word, ...], int], Shelf] = field(default_factory=dict)
    opened: dict[int, _Opened] = field(default_factory=dict)
    sized: dict[tuple[int, Places], SymbolSizes | None] = field(default_factory=dict)
    best: list[tuple[float, int, Places]] = field(default_factory=list)
    seen: dict[tuple[int, bytes], tuple[float, Places]] = field(default_factory=dict)
    """Keys of the looks in `best`: layouts that look the same are merged."""
    heap: list[tuple[float, int, Places]] = field(default_factory=list)
    cap: float = 0.0
    unsure: float = math.inf
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
        return [self._layout(*each) for each in self.best]

    @property
    def bound(self) -> float:
        """Lower bound of the energy of layouts that are not in `best`."""
        return min(self.unsure, self.heap[0][0] if self.heap else math.inf, self.cap, self.others)

    @property
    def threshold(self) -> float:
        """Largest energy of a layout among the best."""
        return min(self.best[-1][0], self.cap) if len(self.best) == self.count else self.cap

    def _within(self, cap: float) -> None:
        self.cap, self.best, self.seen, self.unsure = cap, [], {}, math.inf
        self.heap = [(candidate.bound, number, ()) for number, candidate in enumerate(self.candidates)]
        heapq.heapify(self.heap)
        while self.heap and self.heap[0][0] <= self.threshold:
            if self.budget.is_spent:
                break
            bound, number, places = heapq.heappop(self.heap)
            self.budget.left -= _STEPS_OF_BRANCH
            if number not in self.opened:
                self.budget.left -= _STEPS_OF_OPENING
                self.opened[number] = self._open(number)
                if self.opened[number].floor > bound:
                    heapq.heappush(self.heap, (self.opened[number].floor, number, ()))
                    continue
            if places:
                self._next(number, places)
            else:
                self._first(number)

    def _open(self, number: int) -> _Opened:
        words = self.candidates[number].words
        sharing = sharing_groups(words)
        shelves = []
        for group, rows in words.items():
            key = group[0], rows, sharing[group]
            if key not in self.shelves:
                share = self.weights.sizing / sharing[group]
                self.shelves[key] = Shelf(
                    words=rows,
                    canvas=self.canvas[group[0]],
                    weights=self.weights,
                    tolerance=self.tolerance,
                    budget=self.budget,
                    sizing=share,
                    gaps=self.gaps,
                )
            shelves.append(self.shelves[key])
        alone = [] if self.gaps else [demands_alone(each.words[0], each.canvas) for each in shelves if not each.varied]
        floor = self.weights.sizing * least_error([each for each in alone if each is not None])
        return _Opened(tuple(words), tuple(shelves), floor)

    def _take(self, shelf: Shelf, place: int, rest: float) -> Alignment | None:
        """An alignment of a group whose energy, with the bounds of the rest, is within the cap."""
        cutoff = self.threshold - rest
        found = shelf.at(place, cutoff)
        if found is None and not shelf.sure(place, cutoff):
            self.unsure = min(self.unsure, rest + shelf.known.bound)
        return found

    def _first(self, number: int) -> None:
        """The best alignment of each group of a candidate."""
        bound, opened = 0.0, self.opened[number]
        for shelf in opened.shelves:
            if self._take(shelf, 0, bound) is None:
                return
            bound += shelf.energy(0)
        same = [each.demands(0) for each in opened.shelves if not each.varied]
        opened.floor = max(opened.floor, self.weights.sizing * least_error(same))
        self._push(number, (0,) * len(opened.shelves))

    def _next(self, number: int, places: Places) -> None:
        """The next best alignment of each group in turn; groups before the last changed one are fixed.

        All alignments of layers with one word look the same.
        """
        opened = self.opened[number]
        bound = opened.bound(places)
        last = max((at for at, place in enumerate(places) if place), default=0)
        for at in range(last, len(places)):
            shelf = opened.shelves[at]
            rest = bound - shelf.energy(places[at])
            if shelf.varied and self._take(shelf, places[at] + 1, rest) is not None:
                self._push(number, (*places[:at], places[at] + 1, *places[at + 1 :]))

    def _push(self, number: int, places: Places) -> None:
        opened = self.opened[number]
        aligned = opened.aligned(places)
        bound = opened.bound(places)
        paid = sum(each.energy for each in aligned)
        # Bounds that differ between alignments of one candidate would not hold for later ones.
        heapq.heappush(self.heap, (max(bound, paid + opened.floor), number, places))
        if max(bound, paid + opened.floor) > self.threshold:
            return
        self.budget.left -= _STEPS_OF_DEMANDS
        demands = [shelf.demands(place) for shelf, place in zip(opened.shelves, places, strict=True)]
        if paid + self.weights.sizing * least_error(demands) > self.threshold:
            return
        key = number, places
        if key not in self.sized:
            canvases = [self.canvas[axis] for axis, _ in opened.groups]
            self.sized[key] = size_letters(list(zip(aligned, canvases, strict=True)), gaps=self.gaps)
            self.budget.left -= _STEPS_OF_SIZES
        sizing = self.sized[key]
        if sizing is None:
            return
        energy = paid + self.weights.sizing * sizing.error
        if energy <= self.threshold:
            self._keep(energy, number, places, _look(aligned, sizing))

    def _keep(self, energy: float, number: int, places: Places, look: bytes) -> None:
        """Adds a layout to the best, unless one that looks the same is better."""
        twin = self.seen.get((number, look))
        if twin is not None:
            if twin[0] <= energy:
                return
            self.best.remove((twin[0], number, twin[1]))
        self.seen[number, look] = energy, places
        bisect.insort(self.best, (energy, number, places))
        for worst in self.best[self.count :]:
            self.seen = {key: kept for key, kept in self.seen.items() if kept != (worst[0], worst[2])}
        del self.best[self.count :]

    def hurried(self) -> list[Layout]:
        """Layouts of the first candidates that have one, at any energy."""
        bound, order = self.bound, sorted(range(len(self.candidates)), key=self._missing)
        self.cap = math.inf
        for number in order[:_MOST_HURRIED]:
            self.budget.left, self.heap = _LAST, []
            self.opened.setdefault(number, self._open(number))
            self._first(number)
            while self.heap and not self.best and not self.budget.is_spent:
                self._next(number, heapq.heappop(self.heap)[2])
            if self.best:
                break
        self.unsure = min(self.unsure, bound)
        return [self._layout(*each) for each in self.best]

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

    def _layout(self, energy: float, number: int, places: Places) -> Layout:
        sizing, opened = self.sized[number, places], self.opened[number]
        if sizing is None:
            raise AssertionError("Only layouts with sizes are among the best.")
        return Layout(
            candidate=self.candidates[number],
            alignments=dict(zip(opened.groups, opened.aligned(places), strict=True)),
            sizing=sizing,
            energy=energy,
            bound=min(self.bound, energy),
            proven=self.bound >= energy,
            tolerance=self.tolerance,
        )


@dataclass
class _Opened:
    """A candidate with alignments in progress."""

    groups: tuple[Group, ...]
    shelves: tuple[Shelf, ...]
    floor: float = 0.0
    """Lower bound of the energy of sizes, for all alignments."""

    def aligned(self, places: Places) -> list[Alignment]:
        return [shelf.known.best[place] for shelf, place in zip(self.shelves, places, strict=True)]

    def bound(self, places: Places) -> float:
        """Lower bound of the energy of alignments and of their size changes."""
        return sum(shelf.energy(place) for shelf, place in zip(self.shelves, places, strict=True))


def _look(aligned: Sequence[Alignment], sizing: SymbolSizes) -> bytes:
    """Key of the positions of all visible letters, rounded to 1e-7 of the canvas."""
    places = [
        np.stack([lower[seen], upper[seen]]) / placed.ends[-1]
        for alignment, placed in zip(aligned, sizing.placed, strict=True)
        for word, lower, upper in zip(alignment.words, placed.lower, placed.upper, strict=True)
        for seen in ([at for at, letter in enumerate(word) if not letter.transparent],)
    ]
    return b"".join(np.round(place, 7).astype(np.float32).tobytes() for place in places)
