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

SAME = 1e-6
"""Metres that letters of layouts may differ by that look the same."""
_GROWTH = 4.0
"""Of the cap on energies."""
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
    sizing: float = 0.0
    """The part of it that sizes cost at least, whatever the alignment."""

    def sizing_bound(self, canvas: tuple[float, float]) -> float:
        """Square metres: no sizes that fit deviate less, as words that are too long have to shrink."""
        bounds = [0.0, 0.0]
        for (axis, _), words in self.words.items():
            for word in words:
                sized = [letter for letter in word if letter.size is not None and not letter.transparent]
                over = math.fsum(letter.size or 0.0 for letter in sized) - canvas[axis]
                if over > 0.0:
                    often = Counter(letter.symbol for letter in sized)
                    bounds[axis] = max(bounds[axis], over**2 / sum(each**2 for each in often.values()))
        # Both axes may be about the same symbols.
        return max(bounds)


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
    effort: int = 1_000_000,
) -> list[Layout]:
    """The best different layouts, best first; none where even the last tolerance has none.

    Args:
        candidates: of a tolerance.
        canvas: width and height, metres.
        weights: of the energy.
        count: how many.
        tolerances: metres, growing; the first with a layout is searched whole.
        gaps: see `size_letters`.
        effort: steps of all searches for alignments with one tolerance, see `align`.
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
        self.heap = []
        for number, candidate in enumerate(self.candidates):
            bound = 0.0 if self.gaps else self.weights.sizing * candidate.sizing_bound(self.canvas)
            self.heap.append((max(bound, candidate.bound), number, ()))
        heapq.heapify(self.heap)
        while self.heap and self.heap[0][0] <= self.threshold:
            bound, number, places = heapq.heappop(self.heap)
            if places:
                self._next(number, places)
            else:
                self._open(number)

    def _shelf(self, number: int, group: Group) -> Shelf:
        words = self.candidates[number].words[group]
        key = group[0], words, self._sharing(number, group)
        if key not in self.shelves:
            canvas = self.canvas[group[0]]
            share = self.weights.sizing / self._sharing(number, group)
            self.shelves[key] = Shelf(words, canvas, self.weights, self.tolerance, self.budget, share, self.gaps)
        return self.shelves[key]

    def _sharing(self, number: int, group: Group) -> int:
        """How many groups may be about the same symbols: what sizes cost at least is divided between them."""
        words = self.candidates[number].words
        symbols = {each: {letter.symbol for word in rows for letter in word} for each, rows in words.items()}
        alone = all(symbols[group].isdisjoint(other) for each, other in symbols.items() if each != group)
        return 1 if alone else len(words)

    def _take(self, number: int, group: Group, place: int, rest: float) -> Alignment | None:
        """An alignment of a group that is cheap enough beside what else is to pay."""
        shelf, cutoff = self._shelf(number, group), self.threshold - rest
        found = shelf.at(place, cutoff)
        if found is None and not shelf.sure(place, cutoff):
            self.unsure = min(self.unsure, rest + shelf.known.bound)
        return found

    def _open(self, number: int) -> None:
        """The best alignment of each group of a candidate."""
        groups = self.candidates[number].words
        # Strains take the place of what is known without an alignment: both are about the same sizes.
        bound = 0.0
        for group in groups:
            if self._take(number, group, 0, bound) is None:
                return
            bound += self._shelf(number, group).energy(0)
        self._push(bound, number, (0,) * len(groups))

    def _next(self, number: int, places: Places) -> None:
        """The next best alignment of each group in turn; groups before the last that was changed are left alone."""
        groups = tuple(self.candidates[number].words)
        last = max((at for at, place in enumerate(places) if place), default=0)
        bound = sum(self._shelf(number, group).energy(at) for group, at in zip(groups, places, strict=True))
        for at in range(last, len(groups)):
            if len(set(self.candidates[number].words[groups[at]])) == 1:
                continue  # wherever one word alone is cut, its letters stand where they stand
            shelf = self._shelf(number, groups[at])
            rest = bound - shelf.energy(places[at])
            if self._take(number, groups[at], places[at] + 1, rest) is not None:
                after = (*places[:at], places[at] + 1, *places[at + 1 :])
                self._push(rest + shelf.energy(places[at] + 1), number, after)

    def _push(self, bound: float, number: int, places: Places) -> None:
        aligned = self._aligned(number, places)
        bound = max(bound, sum(each.energy for each in aligned.values()) + self._sizes_least(number, aligned))
        heapq.heappush(self.heap, (bound, number, places))
        if bound > self.threshold:
            return
        key = number, places
        if key not in self.sized:
            self.sized[key] = size_letters(
                [(alignment, self.canvas[group[0]]) for group, alignment in aligned.items()], gaps=self.gaps
            )
        sizing = self.sized[key]
        if sizing is None:
            return
        energy = sum(each.energy for each in aligned.values()) + self.weights.sizing * sizing.error
        alike = next((each for each in self.best if each[1] == number and self._alike(each[2], places, number)), None)
        if energy <= self.threshold and (alike is None or energy < alike[0]):
            self.best = [each for each in self.best if each is not alike]
            bisect.insort(self.best, (energy, number, places))
            del self.best[self.count :]

    def _alike(self, first: Places, second: Places, number: int) -> bool:
        """Whether all letters that are seen stand in the same places."""
        sizings = self.sized[number, first], self.sized[number, second]
        for rows, *placed in zip(
            self.candidates[number].words.values(), *(each.placed for each in sizings if each), strict=True
        ):
            for row, word in enumerate(rows):
                seen = [not letter.transparent for letter in word]
                low, high = ([each.lower[row][seen] for each in placed], [each.upper[row][seen] for each in placed])
                if any(np.abs(one - other).max(initial=0.0) > SAME for one, other in (low, high)):
                    return False
        return True

    def _sizes_least(self, number: int, aligned: Mapping[Group, Alignment]) -> float:
        """What sizes cost at least: strains of groups add up where these are about different symbols."""
        strains = {group: self.weights.sizing * each.strain for group, each in aligned.items()}
        apart: list[tuple[set[str], float]] = []
        for group, strain in strains.items():
            symbols, most = {letter.symbol for word in self.candidates[number].words[group] for letter in word}, strain
            for other in [other for other in apart if other[0] & symbols]:
                apart.remove(other)
                symbols, most = symbols | other[0], max(most, other[1])
            apart.append((symbols, most))
        return max(sum(most for _, most in apart), self.candidates[number].sizing)

    def _aligned(self, number: int, places: Places) -> dict[Group, Alignment]:
        groups = self.candidates[number].words
        return {
            group: self._shelf(number, group).known.best[place] for group, place in zip(groups, places, strict=True)
        }

    def _layout(self, energy: float, number: int, places: Places) -> Layout:
        sizing = self.sized[number, places]
        if sizing is None:
            raise AssertionError("Only layouts with sizes are among the best.")
        bound = min(self.unsure, self.heap[0][0] if self.heap else math.inf, self.cap)
        return Layout(
            candidate=self.candidates[number],
            alignments=self._aligned(number, places),
            sizing=sizing,
            energy=energy,
            bound=min(bound, energy),
            proven=bound >= energy,
            tolerance=self.tolerance,
        )
