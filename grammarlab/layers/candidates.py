"""Compatible words of all layers: one value for each counter, each word about as long as its canvas.

A word may be longer or shorter than the canvas by a tolerance, which grows until there are enough candidates. Words
below letters that hide them may leave gaps for these, and be shorter by as much (supplement 002, section 3.2).

Equations of counters and sizes: different remainders of two patterns of one group are equally long (supplement 3.1).

All layers span the canvas. If two words have equal beginnings and ends, their remainders are equally long; this gives
an equation of counters and of sizes. It holds if no layer leaves a gap for a letter above it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, groupby

from grammarlab.errors import FacadeError
from grammarlab.facade.tree import X, Y
from grammarlab.layers.design import Design, Word
from grammarlab.layers.patterns import LayerPattern, Linear, Node, Power, Row, Sign
from grammarlab.layers.solving import Candidate
from grammarlab.layers.words import STRETCH, Instance, Range, choices_of, counter_ranges, instance, instances

_ONE = Linear(1, ())


@dataclass(frozen=True, slots=True)
class Relation:
    """An equation between sums of symbol sizes."""

    terms: tuple[tuple[str, Linear], ...]
    """Symbols, and the difference of their counts in the first and the second pattern; none is 0."""

    def __str__(self) -> str:
        """The equation, with one side for each pattern.

        >>> from grammarlab.layers.patterns import parse_pattern
        >>> print(relation(parse_pattern("A^kcC^mcA^k; c := C"), parse_pattern("A^kC^lA^k")))
        m + 2 = l
        >>> print(relation(parse_pattern("cec; c := C"), parse_pattern("A(BA)^k")))
        2C + e = (k + 1)A + k B
        """
        if len(self.terms) == 1:
            return _equation(self.terms[0][1])
        sides = [[], []]
        for symbol, count in self.terms:
            less = _is_less(count)
            text = _linear_text(Linear(0, ()).minus(count) if less else count)
            often = {"1": ""}.get(text, text if text.isdigit() else f"({text})" if " " in text else f"{text} ")
            sides[less].append(f"{often}{symbol}")
        return " = ".join(" + ".join(side) or "0" for side in sides)


def relation(first: LayerPattern, second: LayerPattern) -> Relation | None:
    """The equation of two patterns; None if they do not differ, or have choices or copies of copies."""
    if not (_is_plain(first) and _is_plain(second)):
        return None
    items = [_items(first), _items(second)]
    for end in (0, -1):
        while items[0] and items[1] and items[0][end] == items[1][end]:
            for each in items:
                each.pop(end)
    counts: dict[str, Linear] = {}
    for sign, each in zip((1, -1), items, strict=True):
        for letters, count in each:
            for letter in letters:
                counts[letter] = _plus(counts.get(letter, Linear(0, ())), count, sign)
    terms = tuple((symbol, count) for symbol, count in counts.items() if count.constant or count.terms)
    return Relation(terms) if terms else None


def _is_plain(pattern: LayerPattern) -> bool:
    """Whether the count of each symbol is linear in the counters."""
    powers = [node for node in pattern.nodes() if isinstance(node, Power)]
    copied = {
        node.symbol for power in powers for node in LayerPattern("", power.base).nodes() if isinstance(node, Sign)
    }
    inner = {
        sign.symbol
        for sign, content in pattern.contents
        for node in LayerPattern("", content).nodes()
        if isinstance(node, Power)
    }
    reflected = any(factor < 0 for power in powers for _, factor in power.count.terms)
    return not (pattern.options() or inner & copied or reflected)


def _items(pattern: LayerPattern) -> list[tuple[tuple[str, ...], Linear]]:
    """Runs of letters and the number of copies of each."""
    found: list[tuple[tuple[str, ...], Linear]] = []

    def add(node: Node, count: Linear | None) -> None:
        match node:
            case Sign():
                content = pattern.content_of(node.symbol)
                if content is not None:
                    add(content, count)
                else:
                    found.append(((node.symbol,), count or _ONE))
            case Row():
                if count is None:
                    for part in node.parts:
                        add(part, None)
                else:
                    found.append((tuple(_letters(node, pattern)), count))
            case Power():
                add(node.base, node.count)
            case _:
                raise AssertionError("patterns with choices have no relations")

    add(pattern.body, None)
    return found


def _letters(node: Node, pattern: LayerPattern) -> Sequence[str]:
    match node:
        case Sign():
            content = pattern.content_of(node.symbol)
            return [node.symbol] if content is None else _letters(content, pattern)
        case Row():
            return [letter for part in node.parts for letter in _letters(part, pattern)]
        case _:
            raise AssertionError("copies cannot be nested")


def _plus(total: Linear, count: Linear, sign: int) -> Linear:
    zero = Linear(0, ())
    return total.minus(zero.minus(count)) if sign > 0 else total.minus(count)


def _is_less(count: Linear) -> bool:
    return (count.terms[0][1] if count.terms else count.constant) < 0


def _equation(count: Linear) -> str:
    """A linear form that equals 0 as an equation, with positive factors on each side.

    >>> _equation(Linear(2, (("l", -1), ("m", 1))))
    'm + 2 = l'
    """
    left = Linear(max(count.constant, 0), tuple((name, factor) for name, factor in count.terms if factor > 0))
    right = Linear(max(-count.constant, 0), tuple((name, -factor) for name, factor in count.terms if factor < 0))
    return f"{_linear_text(left)} = {_linear_text(right)}"


def _linear_text(count: Linear) -> str:
    parts = [f"{'' if abs(factor) == 1 else abs(factor)}{name}" for name, factor in count.terms]
    signs = [factor < 0 for _, factor in count.terms]
    if count.constant or not parts:
        parts.append(str(abs(count.constant)))
        signs.append(count.constant < 0)
    text = ("-" if signs[0] else "") + parts[0]
    return text + "".join(f" {'-' if less else '+'} {part}" for less, part in zip(signs[1:], parts[1:], strict=True))


MOST = 5_000
"""Largest number of candidates within one tolerance; if there are more, only `_FEW` of the best are kept."""
_FEW = 400
"""Number of candidates kept if there are more than `MOST`."""
_LOOKED_AT = 50_000
"""Largest number of combinations, and of words in them, before the search is cut to `_FEW`."""
_PARTS = (1 / 64, 1 / 32, 1 / 16, 1 / 8, 1 / 4, 1 / 2, 1.0, STRETCH - 1.0)
"""Tolerances as fractions of the longer side of the canvas."""
_USUAL = 1 / 2
"""Largest tolerance in ordinary searches; larger ones are used only if there are no candidates."""


class NothingFitsError(FacadeError):
    """No words fit the canvas."""


@dataclass(frozen=True, slots=True)
class CandidateFit:
    """One word for each pattern, and measures of their fit."""

    counters: Mapping[str, int]
    words: Mapping[str, Instance]
    """Words by name of the pattern."""
    bound: float
    """Lower bound of the energy of each of their layouts, for any alignment."""
    gap: float
    """Largest difference of the lengths of a word and the canvas, metres."""


@dataclass(frozen=True, slots=True)
class _Row:
    """A pattern of a layer along one axis."""

    group: tuple[int, str]
    """Axis and name of the alignment group."""
    pattern: str
    above: tuple[int, ...] = ()
    """Rows of the same group above it."""
    covering: frozenset[str] = frozenset()
    """Symbols for which rows below may leave gaps."""

    @property
    def axis(self) -> int:
        """Axis of the row."""
        return self.group[0]


class FittingWords:
    """Words that fit a canvas."""

    def __init__(self, design: Design, width: float, height: float) -> None:
        """Look up the words of all patterns.

        Raises:
            FacadeError: If a counter has no bound, or there are too many words.
        """
        self.design, self.canvas = design, (width, height)
        self.rows = _rows(design)
        self._found: dict[float, tuple[list[CandidateFit], bool]] = {}
        self.covering = _covering(self.rows)
        self._known: dict[tuple[frozenset[str] | None, tuple[tuple[str, int], ...], tuple[int, ...], str], Word] = {}
        self.problem = _Problem(design, self.canvas, self.rows, 1.0 + _USUAL)

    def __call__(self, tolerance: float) -> Iterator[Candidate]:
        """Candidates with words within a tolerance of the canvas, metres, in the order of their bounds."""
        return map(self._candidate, self.within(tolerance))

    def within(self, tolerance: float) -> list[CandidateFit]:
        """Words within a tolerance of the canvas, in the order of their bounds; only a part if there are too many."""
        return self._looked_up(tolerance)[0]

    def least_of_others(self, tolerance: float) -> float:
        """Lower bound of the energy of layouts of all other words within a tolerance."""
        return math.inf if self._looked_up(tolerance)[1] else 0.0

    def _looked_up(self, tolerance: float) -> tuple[list[CandidateFit], bool]:
        if tolerance > _USUAL * max(self.canvas) and self.problem.stretch < STRETCH:
            self.problem = _Problem(self.design, self.canvas, self.rows, STRETCH)
        if tolerance not in self._found:
            found, whole = self.problem.within(tolerance)
            if self.problem.ambiguous:  # the first fit of all that have the same words: unused counters change nothing
                found = list({tuple(w.word for w in fit.words.values()): fit for fit in reversed(found)}.values())[::-1]
            self._found[tolerance] = sorted(found, key=lambda fit: (fit.bound, fit.gap)), whole
        return self._found[tolerance]

    def tolerances(self, enough: int) -> tuple[float, ...]:
        """Growing tolerances, metres; the first gives enough candidates, if enough fit well.

        Raises:
            NothingFitsError: If nothing fits; the message names the patterns that contradict each other.
        """
        longest = max(self.canvas)
        largest = max((symbol.size or 0.0 for symbol in self.design.symbols.values()), default=0.0)
        growing = [part * longest for part in _PARTS if part * longest > largest or part >= _USUAL]
        for place, tolerance in enumerate(growing):
            found, whole = self._looked_up(tolerance)
            if not whole:
                return (growing[place - 1 if place and self.within(growing[place - 1]) else place],)
            if len(found) >= enough or (found and tolerance >= _USUAL * longest):
                return tuple(each for each in growing[place:] if each <= max(tolerance, _USUAL * longest))
        raise NothingFitsError(_explained(self.design, self.canvas, self.rows))

    def _candidate(self, fit: CandidateFit) -> Candidate:
        words: dict[tuple[int, str], list[Word]] = {}
        for number, row in enumerate(self.rows):
            words.setdefault(row.group, []).append(self._word(number, fit.words[row.pattern]))
        return Candidate(fit.counters, {group: tuple(rows) for group, rows in sorted(words.items())}, fit.bound)

    def _word(self, number: int, instance: Instance) -> Word:
        """The word of a row; the lowest word of a group hides nothing."""
        covering = self.covering[number]
        key = covering, instance.counters, instance.choices, self.rows[number].pattern
        if key not in self._known:
            self._known[key] = tuple(
                replace(letter, covers=covering is None or letter.symbol in covering) for letter in instance.word
            )
        return self._known[key]


def _rows(design: Design) -> list[_Row]:
    """Patterns of the visible layers, from the topmost down."""
    rows: list[_Row] = []
    above: dict[tuple[int, str], tuple[int, ...]] = {}
    for layer in design.visible_layers:
        for axis in (X, Y):
            group = (axis, layer.groups[axis])
            rows.append(_Row(group, layer.patterns[axis], above.get(group, ()), design.covering(layer, axis)))
            above[group] = (*rows[-1].above, len(rows) - 1)
    return rows


def _covering(rows: Sequence[_Row]) -> list[frozenset[str] | None]:
    """Symbols of each row for which those below may leave gaps; None for all symbols, if no row is below.

    Adjacent layers of one pattern have the same positions: each hides what any of them hides.
    """
    found: list[frozenset[str] | None] = [None] * len(rows)
    for group in dict.fromkeys(row.group for row in rows):
        members = [number for number, row in enumerate(rows) if row.group == group]
        runs = [list(run) for _, run in groupby(members, key=lambda number: rows[number].pattern)]
        for run in runs[:-1]:
            shown = frozenset[str]().union(*(rows[number].covering for number in run))
            found = [shown if number in run else each for number, each in enumerate(found)]
    return found


class _Problem:
    """Words of all patterns up to a length, and the rules for their combination."""

    def __init__(self, design: Design, canvas: tuple[float, float], rows: Sequence[_Row], stretch: float) -> None:
        self.design, self.canvas, self.rows, self.stretch = design, canvas, rows, stretch
        self.names = tuple(dict.fromkeys(row.pattern for row in rows))
        length = {name: max(canvas[row.axis] for row in rows if row.pattern == name) for name in self.names}
        try:
            self.ranges = counter_ranges(design, self.names, length, stretch)
        except FacadeError:
            self.ranges = counter_ranges(design, self.names, length)
        self.words = {name: instances(design, name, self.ranges, STRETCH * length[name]) for name in self.names}
        self.groups = {
            group: [row for row in rows if row.group == group] for group in dict.fromkeys(r.group for r in rows)
        }
        self.ambiguous = any(len({each.word for each in words}) < len(words) for words in self.words.values())
        self.shared = self._shared()
        self._known: dict[tuple[tuple[int, str], tuple[int, ...]], tuple[float, float]] = {}
        self._looked = 0

    def _shared(self) -> list[list[tuple[int, str]]]:
        """Groups that share symbols."""
        found: list[tuple[set[str], list[tuple[int, str]]]] = []
        for group in dict.fromkeys(row.group for row in self.rows):
            symbols = {each for row in self.rows if row.group == group for each in self._sized(row)}
            groups = [group]
            for other in [other for other in found if other[0] & symbols]:
                found.remove(other)
                symbols, groups = symbols | other[0], groups + other[1]
            found.append((symbols, groups))
        return [groups for _, groups in found]

    def _sized(self, row: _Row) -> Iterator[str]:
        symbols = self.design.symbols
        return (each for each in self.design.patterns[row.pattern].symbols() if symbols[each].size is not None)

    def within(self, tolerance: float) -> tuple[list[CandidateFit], bool]:
        """Words within a tolerance of their canvas, and whether these are all."""
        found: list[CandidateFit] = []
        before = self._looked
        for number, chosen in enumerate(self._joined(tolerance)):
            if max(number, self._looked - before) > _LOOKED_AT or len(found) > MOST:
                fits = (self._fit(some, tolerance) for some in self._few(tolerance))
                return [fit for fit in fits if fit is not None] or found[:MOST], False
            fit = self._fit(chosen, tolerance)
            if fit is not None:
                found.append(fit)
        return found, True

    def _few(self, tolerance: float) -> list[dict[str, Instance]]:
        """A part of many combinations: those whose words fit the canvas best, pattern by pattern (beam search)."""
        far = {
            name: {
                id(each): max(abs(self.canvas[row.axis] - each.size) for row in self.rows if row.pattern == name)
                for each in self.words[name]
                if self.fits(name, each, tolerance)
            }
            for name in self.names
        }
        # Patterns that share counters follow each other, so that contradictions are found early.
        order = sorted(self.names, key=lambda name: (self.design.patterns[name].counters(), len(far[name])))
        beam: list[tuple[float, dict[str, int], dict[str, Instance]]] = [(0.0, {}, {})]
        for name in order:
            longer = [
                (
                    missed + far[name][id(each)] ** 2 * (not each.unsized),
                    {**counters, **dict(each.counters)},
                    chosen,
                    each,
                )
                for missed, counters, chosen in beam
                for each in self.words[name]
                if id(each) in far[name] and all(counters.get(key, value) == value for key, value in each.counters)
            ]
            longer.sort(key=lambda one: one[0])
            beam = [(missed, counters, {**chosen, name: each}) for missed, counters, chosen, each in longer[:_FEW]]
        return [chosen for _, _, chosen in beam]

    def _joined(self, tolerance: float) -> Iterator[dict[str, Instance]]:
        """One word per pattern, with one value per counter, no word too long and none too short to be extended."""
        words = {name: [each for each in self.words[name] if self.fits(name, each, tolerance)] for name in self.names}
        order = sorted(self.names, key=lambda name: len(words[name]))
        yield from _join(order, words, {}, {})

    def fits(self, name: str, instance: Instance, tolerance: float) -> bool:
        """Whether a word of a pattern can be part of a candidate within a tolerance."""
        return all(
            instance.size <= self.canvas[row.axis] + tolerance
            and (row.above or self._short(row, instance, math.inf) <= tolerance)
            for row in self.rows
            if row.pattern == name
        )

    def _short(self, row: _Row, instance: Instance, hidden: float) -> float:
        """Missing length of a word that leaves gaps for these letters above it, metres."""
        if instance.unsized or not instance.size:
            return 0.0
        canvas = self.canvas[row.axis]
        short = max(0.0, canvas - instance.size - (hidden if row.above else 0.0))
        return short if short <= canvas - canvas / STRETCH + 1e-9 else math.inf

    def _hidden(self, row: _Row, chosen: Mapping[str, Instance]) -> dict[str, int]:
        """Number of occurrences of each symbol for which a row may leave gaps."""
        counts: dict[str, int] = {}
        for above in (self.rows[number] for number in row.above):
            for name, often in chosen[above.pattern].opaque.items():
                if name in above.covering:
                    counts[name] = counts.get(name, 0) + often
        return counts

    def _fit(self, chosen: Mapping[str, Instance], tolerance: float) -> CandidateFit | None:
        gaps, bounds = 0.0, dict[tuple[int, str], float]()
        for group, rows in self.groups.items():
            key = group, tuple(id(chosen[row.pattern]) for row in rows)
            if key not in self._known:
                missed = [self._missed(row, chosen) for row in rows]
                self._looked += len(rows)
                self._known[key] = max(gap for gap, _ in missed), max(bound for _, bound in missed)
            gap, bounds[group] = self._known[key]
            if gap > tolerance:
                return None
            gaps = max(gaps, gap)
        counters = {name: value for name in self.names for name, value in chosen[name].counters}
        return CandidateFit(counters, chosen, sum(max(bounds[of] for of in groups) for groups in self.shared), gaps)

    def _missed(self, row: _Row, chosen: Mapping[str, Instance]) -> tuple[float, float]:
        """Difference of the lengths of a word and the canvas, metres, and a lower bound of its energy."""
        each, weight = chosen[row.pattern], self.design.weights.sizing
        gap = each.size - self.canvas[row.axis]
        if gap < 0.0:
            hidden, symbols = self._hidden(row, chosen), self.design.symbols
            gap = self._short(row, each, sum((symbols[name].size or math.inf) * n for name, n in hidden.items()))
            bound = self._short_bound(row, chosen, gap)
        else:
            bound = weight * gap**2 / (sum(often**2 for often in each.counts.values()) or 1.0)
        return gap, 0.0 if each.transparent or self.design.overhang else bound

    def _short_bound(self, row: _Row, chosen: Mapping[str, Instance], gap: float) -> float:
        """Lower bound of the energy of a word that is too short, including its gaps for letters above it.

        A part of the gap may be empty elements beside letters of other rows, with their errors of columns; larger
        symbols fill the rest. By least squares, this costs the square of the rest over the sum of the squares of the
        counts of symbols, in all of these rows.
        """
        own = chosen[row.pattern]
        others = {other.pattern for other in self.groups[row.group]} - {row.pattern}
        if not gap or any(chosen[name].loose for name in others):
            return 0.0
        counts = dict(own.counts)
        for name in others:
            for symbol, often in chosen[name].counts.items():
                counts[symbol] = counts.get(symbol, 0) + often
        squares = sum(often**2 for often in counts.values())
        weights = self.design.weights
        if not others or 2.0 * weights.sizing * gap <= weights.omega * squares:
            return weights.sizing * gap**2 / squares
        rest = weights.omega * squares / (2.0 * weights.sizing)
        return weights.omega * (gap - rest) + weights.sizing * rest**2 / squares


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
    """Patterns that contradict each other: a minimal set."""
    needed = list(range(len(rows)))
    for row in range(len(rows)):
        fewer = [each for each in needed if each != row]
        if fewer and not _possible(design, canvas, [rows[each] for each in fewer]):
            needed = fewer
    patterns = [_pattern_text(design, canvas, rows[row]) for row in needed]
    if len(patterns) == 1:
        return f"no word fits: {patterns[0]}"
    text = "these patterns contradict each other: " + "; ".join(dict.fromkeys(patterns)) + ". Counters are shared."
    equations = _equations(design, [rows[each] for each in needed])
    return f"{text} Aligned with each other, they require {' and '.join(equations)}." if equations else text


def _equations(design: Design, rows: Sequence[_Row]) -> list[str]:
    """Equations between patterns of one group, see `relations`."""
    pairs = [(one, other) for one, other in combinations(rows, 2) if one.group == other.group]
    found = (relation(design.patterns[one.pattern], design.patterns[other.pattern]) for one, other in pairs)
    return list(dict.fromkeys(str(each) for each in found if each is not None))


def _possible(design: Design, canvas: tuple[float, float], rows: Sequence[_Row]) -> bool:
    alone = [_Row(row.group, row.pattern) for row in rows]
    problem = _Problem(design, canvas, alone, STRETCH)
    return problem.within(STRETCH * max(canvas))[0] != []


def _pattern_text(design: Design, canvas: tuple[float, float], row: _Row) -> str:
    """A pattern, and the ranges of counters for which it fits alone."""
    side = canvas[row.axis]
    problem = _Problem(design, canvas, [_Row(row.group, row.pattern)], STRETCH)
    fitting = [each for each in problem.words[row.pattern] if problem.fits(row.pattern, each, STRETCH * side)]
    text = f"{row.pattern} = {design.patterns[row.pattern].text!r} over {side:g} m"
    if not fitting:
        sizes = [each.size for each in problem.words[row.pattern]]
        if not sizes:
            sizes = [_shortest(design, row.pattern, problem.ranges)]
        return f"{text}, whose closest word is {min(sizes, key=lambda size: abs(size - side)):g} m long"
    if not fitting[0].counters:
        return text
    ranges = []
    for place, (name, _) in enumerate(fitting[0].counters):
        values = [each.counters[place][1] for each in fitting]
        ranges.append(f"{name} = {min(values)}" + (f" to {max(values)}" if max(values) > min(values) else ""))
    return f"{text} with {', '.join(ranges)}"


def _shortest(design: Design, name: str, ranges: Mapping[str, Range]) -> float:
    """Length of the shortest word of a pattern, metres."""
    found = [
        instance(design, name, {counter: low + more for counter, (low, _) in ranges.items()}, choices)
        for choices in choices_of(design.patterns[name])
        for more in (0, 1)
    ]
    return min((each.size for each in found if each is not None and each.word), default=0.0)
