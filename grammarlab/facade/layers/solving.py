"""Counters, alignment and sizes together: the layouts of least energy."""

from __future__ import annotations

import bisect
import heapq
import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from grammarlab.facade.layers.alignment import Alignment
from grammarlab.facade.layers.letters import Word
from grammarlab.facade.layers.shelves import Budget, Shelf
from grammarlab.facade.layers.sizing import Sizing, size_letters
from grammarlab.facade.layers.weights import Weights

_SAME = 1e-6
"""Metres by which letters of layouts that look the same differ at most."""
_GROWTH = 4.0
"""Of the cap on energies."""
_STEPS_OF_SIZES = 300
"""Steps of effort that solving for sizes takes, about."""
_MOST_ENERGY = 4.0
"""Metres of errors for each metre of the canvas after which no cap is set."""

Group = tuple[int, str]
"""An axis, 0 for x and 1 for y, and the name of an alignment group on it."""


@dataclass(frozen=True)
class Candidate:
    """A word for each layer and axis."""

    counters: Mapping[str, int]
    words: Mapping[Group, tuple[Word, ...]]
    """Of each group, from its top layer down."""
    bound: float = 0.0
    """Energy that each of its layouts has at least, as far as is known."""


@dataclass(frozen=True)
class Layout:
    """A candidate that is aligned and sized."""

    candidate: Candidate
    alignments: Mapping[Group, Alignment]
    sizing: Sizing
    energy: float
    bound: float
    """No layout that comes after those before it in the list has less energy than this, within `tolerance`."""
    proven: bool
    tolerance: float
    """Metres, mu."""

    @property
    def groups(self) -> tuple[Group, ...]:
        """In the order of `sizing.placed`."""
        return tuple(self.alignments)


Candidates = Callable[[float], Iterable[Candidate]]
"""All candidates whose words fit the canvas within a tolerance, metres."""


def solve(
    candidates: Candidates,
    canvas: tuple[float, float],
    weights: Weights,
    count: int = 1,
    *,
    tolerances: Sequence[float],
    gaps: bool = False,
    effort: int = 500_000,
) -> list[Layout]:
    """The best different layouts, best first; none where even the last tolerance has none.

    Args:
        candidates: of a tolerance.
        canvas: width and height, metres.
        weights: of the energy.
        count: how many.
        tolerances: metres, growing; the first with a layout is searched whole.
        gaps: see `size_letters`.
        effort: steps of all searches with one tolerance, see `align`; then layouts may not be proven.
    """
    for tolerance in tolerances:
        branches = _Branches(tuple(candidates(tolerance)), canvas, weights, count, tolerance, gaps, Budget(effort))
        found = branches.layouts()
        if found:
            return found
    return []


Places = tuple[int, ...]
"""For each group of a candidate, how many of its alignments are better."""


@dataclass
class _Branches:
    """Candidates and their alignments, branched over by what they cost at least.

    All that costs more than a cap is left out; while there are too few layouts within it, it grows. So candidates
    that do not fit well are dropped before much is spent on them.
    """

    candidates: tuple[Candidate, ...]
    canvas: tuple[float, float]
    weights: Weights
    count: int
    tolerance: float
    gaps: bool
    budget: Budget
    shelves: dict[tuple[int, tuple[Word, ...], int], Shelf] = field(default_factory=dict)
    opened: dict[int, _Opened] = field(default_factory=dict)
    sized: dict[tuple[int, Places], Sizing | None] = field(default_factory=dict)
    best: list[tuple[float, int, Places]] = field(default_factory=list)
    heap: list[tuple[float, int, Places]] = field(default_factory=list)
    cap: float = 0.0
    unsure: float = math.inf
    """What effort did not suffice to look at costs at least this much."""

    def layouts(self) -> list[Layout]:
        longest = max(self.canvas)
        caps = [self.weights.omega * longest / 50.0 + 3.0 * self.weights.merge]
        while caps[-1] < _MOST_ENERGY * longest * (self.weights.omega + self.weights.merge / longest):
            caps.append(caps[-1] * _GROWTH)
        for cap in (*caps, math.inf):
            self._within(cap)
            if len(self.best) == self.count or self.budget.left <= 0:
                break
        return [self._layout(*each) for each in self.best]

    @property
    def threshold(self) -> float:
        """What layouts may cost to be among the best."""
        return min(self.best[-1][0], self.cap) if len(self.best) == self.count else self.cap

    def _within(self, cap: float) -> None:
        self.cap, self.best, self.unsure = cap, [], math.inf
        self.heap = [(candidate.bound, number, ()) for number, candidate in enumerate(self.candidates)]
        heapq.heapify(self.heap)
        while self.heap and self.heap[0][0] <= self.threshold:
            if self.budget.left <= 0 and self.best:
                break
            _, number, places = heapq.heappop(self.heap)
            if number not in self.opened:
                self.opened[number] = self._open(number)
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
                    rows, self.canvas[group[0]], self.weights, self.tolerance, self.budget, share, self.gaps
                )
            shelves.append(self.shelves[key])
        return _Opened(tuple(words), tuple(shelves))

    def _take(self, shelf: Shelf, place: int, rest: float) -> Alignment | None:
        """An alignment of a group that is cheap enough beside what else is to pay."""
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
        if opened.floor is None:
            opened.floor = self.weights.sizing * least_error(self.candidates[number].words, self.canvas, gaps=self.gaps)
        self._push(number, (0,) * len(opened.shelves))

    def _next(self, number: int, places: Places) -> None:
        """The next best alignment of each group in turn; groups before the last that was changed are left alone.

        Of layers that all have one word, alignments differ in nothing that is seen.
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
        sizes = max(opened.floor or 0.0, *(self.weights.sizing * each.strain for each in aligned))
        bound = max(opened.bound(places), sum(each.energy for each in aligned) + sizes)
        heapq.heappush(self.heap, (bound, number, places))
        if bound > self.threshold:
            return
        key = number, places
        if key not in self.sized:
            canvases = [self.canvas[axis] for axis, _ in opened.groups]
            self.sized[key] = size_letters(list(zip(aligned, canvases, strict=True)), gaps=self.gaps)
            self.budget.left -= _STEPS_OF_SIZES
        sizing = self.sized[key]
        if sizing is None:
            return
        energy = sum(each.energy for each in aligned) + self.weights.sizing * sizing.error
        like = next((each for each in self.best if each[1] == number and self._alike(number, each[2], places)), None)
        if energy <= self.threshold and (like is None or energy < like[0]):
            self.best = [each for each in self.best if each is not like]
            bisect.insort(self.best, (energy, number, places))
            del self.best[self.count :]

    def _alike(self, number: int, *layouts: Places) -> bool:
        """Whether all letters of two layouts that are seen stand in the same places."""
        placed = [found.placed for found in (self.sized[number, places] for places in layouts) if found is not None]
        for words, one, other in zip(self.candidates[number].words.values(), *placed, strict=True):
            for row, word in enumerate(words):
                seen = [not letter.transparent for letter in word]
                for each in ((one.lower[row], other.lower[row]), (one.upper[row], other.upper[row])):
                    if np.abs(each[0] - each[1])[seen].max(initial=0.0) > _SAME:
                        return False
        return True

    def _layout(self, energy: float, number: int, places: Places) -> Layout:
        sizing, opened = self.sized[number, places], self.opened[number]
        if sizing is None:
            raise AssertionError("Only layouts with sizes are among the best.")
        bound = min(self.unsure, self.heap[0][0] if self.heap else math.inf, self.cap)
        return Layout(
            candidate=self.candidates[number],
            alignments=dict(zip(opened.groups, opened.aligned(places), strict=True)),
            sizing=sizing,
            energy=energy,
            bound=min(bound, energy),
            proven=bound >= energy,
            tolerance=self.tolerance,
        )


@dataclass
class _Opened:
    """A candidate whose groups are being aligned."""

    groups: tuple[Group, ...]
    shelves: tuple[Shelf, ...]
    floor: float | None = None
    """Energy of sizes at least, whatever the alignment; None until it is asked for."""

    def aligned(self, places: Places) -> list[Alignment]:
        return [shelf.known.best[place] for shelf, place in zip(self.shelves, places, strict=True)]

    def bound(self, places: Places) -> float:
        """Energy of alignments and of the strains that they put on sizes."""
        return sum(shelf.energy(place) for shelf, place in zip(self.shelves, places, strict=True))


def sharing_groups(words: Mapping[Group, tuple[Word, ...]]) -> dict[Group, int]:
    """How many groups are about the same symbols, directly or through others: their errors of sizes are one."""
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
    return {group: len(groups) for groups, _ in parts for group in groups}


def least_error(words: Mapping[Group, tuple[Word, ...]], canvas: tuple[float, float], *, gaps: bool) -> float:
    """Square metres: sizes deviate at least so much, as words that are alone in their group fill the canvas."""
    often: list[Counter[str]] = []
    lengths, sizes = [], dict[str, float]()
    for (axis, _), rows in words.items():
        word = rows[0]
        known = all(letter.size is not None and (letter.opaque or not gaps) for letter in word)
        if known and word and len(set(rows)) == 1:
            often.append(Counter(letter.symbol for letter in word))
            lengths.append(canvas[axis])
            sizes |= {letter.symbol: letter.size or 0.0 for letter in word}
    if not often:
        return 0.0
    matrix = np.array([[each[symbol] for symbol in sizes] for each in often], dtype=np.float64)
    change = np.linalg.lstsq(matrix, np.array(lengths) - matrix @ np.array(list(sizes.values())), rcond=1e-9)[0]
    # A little less, for round-off is no bound.
    return float(np.square(change).sum()) * (1.0 - 1e-9)
