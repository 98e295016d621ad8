"""Words of all layers that go together: one value for each counter, each word about as long as its canvas.

A word may be longer or shorter than the canvas by a tolerance, which grows until there are enough candidates. What lies
below letters that hide it may leave room for them, and be shorter by as much (supplement 002, section 3.2).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from grammarlab.errors import FacadeError
from grammarlab.facade.layers.design import Design
from grammarlab.facade.layers.letters import Word
from grammarlab.facade.layers.words import STRETCH, Instance, counter_ranges, instances
from grammarlab.facade.tree import X, Y

MOST = 5_000
"""Candidates of one tolerance."""
_PARTS = (1 / 16, 1 / 8, 1 / 4, 1 / 2, 1.0, STRETCH - 1.0)
"""Tolerances as parts of the canvas."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """One word for each layer and axis."""

    counters: Mapping[str, int]
    words: tuple[tuple[Word, ...], tuple[Word, ...]]
    """Along x and y: of each layer that is on, from the topmost down."""
    bound: float
    """Square metres: the least sum of squares by which symbols deviate from their sizes, whatever the alignment; where
    every row fills the canvas, but for what letters above it hide."""
    gap: float
    """Metres by which a word is too long or too short at most."""


@dataclass(frozen=True, slots=True)
class Candidates:
    """Candidates by ascending bound."""

    found: tuple[Candidate, ...]
    rest: float
    """Bound of all that are not listed; infinite when there are no others."""


@dataclass(frozen=True, slots=True)
class _Row:
    """A pattern of a layer along one axis."""

    axis: int
    pattern: str
    above: tuple[int, ...]
    """Rows of the same group that lie over it."""


def candidates(design: Design, width: float, height: float, enough: int = 64) -> Candidates:
    """Words that fit a canvas, the best first.

    Args:
        design: the design.
        width: metres.
        height: metres.
        enough: candidates after which the tolerance grows no more.

    Raises:
        FacadeError: when nothing fits, and which patterns contradict each other; or when there are too many.
    """
    canvas = (width, height)
    rows = _rows(design)
    problem = _Problem(design, canvas, rows, 1.0 + _PARTS[3])
    part, found = _PARTS[0], problem.within(_PARTS[0])
    if found is None:
        while found is None and part > 1e-4:
            part /= 4.0
            found = problem.within(part)
        if not found:
            raise FacadeError(
                f"more than {MOST:,} combinations of words fit {width:g} x {height:g} m: bound some of the counters "
                f"{', '.join(problem.ranges)}, such as [counters] {next(iter(problem.ranges), 'k')} = {{ most = 9 }}."
            )
        return _sorted(found, problem.floor(part))
    for wider in _PARTS[1:]:
        if len(found) >= enough:
            break
        if wider > _PARTS[3]:
            if found:
                break
            problem = _Problem(design, canvas, rows, 1.0 + wider)
        more = problem.within(wider)
        if more is None:
            break
        part, found = wider, more
    if not found:
        raise FacadeError(_explained(design, canvas, rows))
    return _sorted(found, problem.floor(part))


def _sorted(found: list[Candidate], rest: float) -> Candidates:
    return Candidates(tuple(sorted(found, key=lambda each: (each.bound, each.gap))), rest)


def _rows(design: Design) -> list[_Row]:
    """Patterns of the layers that are on, from the topmost down."""
    rows: list[_Row] = []
    above: dict[tuple[int, str], tuple[int, ...]] = {}
    for layer in design.visible_layers:
        for axis in (X, Y):
            group = (axis, layer.groups[axis])
            rows.append(_Row(axis, layer.patterns[axis], above.get(group, ())))
            above[group] = (*rows[-1].above, len(rows) - 1)
    return rows


class _Problem:
    """The words of all patterns up to a length, and how they go together."""

    def __init__(self, design: Design, canvas: tuple[float, float], rows: Sequence[_Row], stretch: float) -> None:
        self.design, self.canvas, self.rows = design, canvas, rows
        self.names = tuple(dict.fromkeys(row.pattern for row in rows))
        length = {name: max(canvas[row.axis] for row in rows if row.pattern == name) for name in self.names}
        try:
            self.ranges = counter_ranges(design, self.names, length, stretch)
        except FacadeError:
            self.ranges = counter_ranges(design, self.names, length)
        self.words = {name: instances(design, name, self.ranges, STRETCH * length[name]) for name in self.names}
        of_axis = [{symbol for row in rows if row.axis == axis for symbol in self._sized(row)} for axis in (X, Y)]
        self.apart = not of_axis[X] & of_axis[Y]
        self.smallest = min((design.symbols[each].size or math.inf for each in of_axis[X] | of_axis[Y]), default=1.0)

    def _sized(self, row: _Row) -> Iterator[str]:
        symbols = self.design.symbols
        return (each for each in self.design.patterns[row.pattern].symbols() if symbols[each].size is not None)

    def floor(self, part: float) -> float:
        """A bound of all candidates whose words miss a canvas by more than a part of it.

        A word that is too long by g has (canvas + g) / smallest letters at most; of all ways to shrink them the least
        sum of squares is g^2 over the sum of the squares of how often each symbol occurs.
        """
        if part >= _PARTS[-1]:
            return math.inf
        return min((part * self.smallest / (1.0 + part)) ** 2, min((part * side) ** 2 for side in self.canvas))

    def within(self, part: float) -> list[Candidate] | None:
        """Candidates whose words miss their canvas by a part of it at most; None when there are too many."""
        found: list[Candidate] = []
        for chosen in self._joined(part):
            candidate = self._candidate(chosen, part)
            if candidate is not None:
                found.append(candidate)
                if len(found) > MOST:
                    return None
        return found

    def _joined(self, part: float) -> Iterator[dict[str, Instance]]:
        """One word per pattern, with one value per counter, none too long and none that cannot be long enough."""
        words = {name: [each for each in self.words[name] if self._fits(name, each, part)] for name in self.names}
        order = sorted(self.names, key=lambda name: len(words[name]))
        yield from _join(order, words, {}, {})

    def _fits(self, name: str, instance: Instance, part: float) -> bool:
        rows = [row for row in self.rows if row.pattern == name]
        return all(
            instance.size <= (1.0 + part) * self.canvas[row.axis]
            and (row.above or self._short(row, instance, math.inf) <= part * self.canvas[row.axis])
            for row in rows
        )

    def _short(self, row: _Row, instance: Instance, hidden: float) -> float:
        """Metres by which a word is too short, if it may leave room for so much above it."""
        if instance.unsized or not instance.size:
            return 0.0
        canvas = self.canvas[row.axis]
        short = max(0.0, canvas - instance.size - (hidden if row.above else 0.0))
        return short if short <= canvas - canvas / STRETCH + 1e-9 else math.inf

    def _candidate(self, chosen: Mapping[str, Instance], part: float) -> Candidate | None:
        gaps, bounds = 0.0, [0.0, 0.0]
        for row in self.rows:
            each, canvas = chosen[row.pattern], self.canvas[row.axis]
            counts, gap = dict(each.counts), each.size - canvas
            if gap < 0.0:
                over = [chosen[self.rows[above].pattern] for above in row.above]
                gap = self._short(row, each, sum(other.opaque_size for other in over))
                for other in over if gap else ():
                    for symbol, often in other.opaque.items():
                        counts[symbol] = counts.get(symbol, 0) + often
            if gap > part * canvas:
                return None
            gaps = max(gaps, gap)
            if gap > 0.0:
                bounds[row.axis] = max(bounds[row.axis], gap**2 / sum(often**2 for often in counts.values()))
        counters = {name: value for name in self.names for name, value in chosen[name].counters}
        layers = range(len(self.rows) // 2)
        words = [tuple(chosen[self.rows[2 * layer + axis].pattern].word for layer in layers) for axis in (X, Y)]
        return Candidate(counters, (words[X], words[Y]), sum(bounds) if self.apart else max(bounds), gaps)


def _join(
    order: Sequence[str],
    words: Mapping[str, Sequence[Instance]],
    chosen: dict[str, Instance],
    counters: dict[str, int],
) -> Iterator[dict[str, Instance]]:
    if not order:
        yield dict(chosen)
        return
    name, *rest = order
    for each in words[name]:
        own = dict(each.counters)
        if all(counters.get(key, value) == value for key, value in own.items()):
            yield from _join(rest, words, {**chosen, name: each}, {**counters, **own})


def _explained(design: Design, canvas: tuple[float, float], rows: Sequence[_Row]) -> str:
    """Which patterns contradict each other: of those, leaving out any one would do."""
    needed = list(range(len(rows)))
    for row in range(len(rows)):
        fewer = [each for each in needed if each != row]
        if fewer and not _possible(design, canvas, [rows[each] for each in fewer]):
            needed = fewer
    told = [_told(design, canvas, rows[row]) for row in needed]
    if len(told) == 1:
        return f"no word fits {told[0]}"
    return "these patterns contradict each other: " + "; ".join(dict.fromkeys(told)) + ". Counters are the same in all."


def _possible(design: Design, canvas: tuple[float, float], rows: Sequence[_Row]) -> bool:
    alone = [_Row(row.axis, row.pattern, ()) for row in rows]
    problem = _Problem(design, canvas, alone, STRETCH)
    return problem.within(_PARTS[-1]) != []


def _told(design: Design, canvas: tuple[float, float], row: _Row) -> str:
    """A pattern, and which values of its counters let it fit alone."""
    side = canvas[row.axis]
    problem = _Problem(design, canvas, [_Row(row.axis, row.pattern, ())], STRETCH)
    fitting = [each for each in problem.words[row.pattern] if problem._fits(row.pattern, each, _PARTS[-1])]
    text = f"{row.pattern} = {design.patterns[row.pattern].text!r} over {side:g} m"
    if not fitting:
        nearest = min(problem.words[row.pattern], key=lambda each: abs(each.size - side))
        return f"{text}, whose nearest word is {nearest.size:g} m long"
    if not fitting[0].counters:
        return text
    ranges = []
    for place, (name, _) in enumerate(fitting[0].counters):
        values = [each.counters[place][1] for each in fitting]
        ranges.append(f"{name} = {min(values)}" + (f" to {max(values)}" if max(values) > min(values) else ""))
    return f"{text} with {', '.join(ranges)}"
