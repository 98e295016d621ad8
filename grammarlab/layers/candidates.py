"""Compatible words of all layers: one value for each counter, each word about as long as its canvas.

A word may be longer or shorter than the canvas by a tolerance, which grows until there are enough candidates. Words
below letters that hide them may leave gaps for these, and be shorter by as much (supplement 002, section 3.2).

If no words fit, the message names patterns that contradict each other, with their relations. All layers span the
canvas: if two words have equal beginnings and ends, their remainders are equally long, which is an equation of counters
and of sizes (supplement 3.1). It holds if no layer leaves a gap for a letter above it.
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
from grammarlab.layers.words import STRETCH, Instance, Range, choices_of, counter_ranges, instances, make_instance

MOST_CANDIDATES = 5_000
"""Largest number of candidates within one tolerance; if there are more, only `_MAX_REDUCED` of the best are kept."""
_ZERO = Linear(0, ())
_ONE = Linear(1, ())
_MAX_REDUCED = 400
"""Number of candidates kept if there are more than `MOST_CANDIDATES`."""
_MAX_COMBINATIONS = 50_000
"""Largest number of combinations, and of words in them, before the search is cut to `_MAX_REDUCED`."""
_TOLERANCE_SHARES = (1 / 64, 1 / 32, 1 / 16, 1 / 8, 1 / 4, 1 / 2, 1.0, STRETCH - 1.0)
"""Tolerances as fractions of the longer side of the canvas."""
_ORDINARY_SHARE = 1 / 2
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


class FittingWords:
    """Words that fit a canvas."""

    def __init__(self, design: Design, width: float, height: float) -> None:
        """Look up the words of all patterns.

        Raises:
            FacadeError: If a counter has no bound, or there are too many words.
        """
        self.design, self.canvas = design, (width, height)
        self.rows = _rows(design)
        self._by_tolerance: dict[float, tuple[list[CandidateFit], bool]] = {}
        self.covering = _covering(self.rows)
        self._words: dict[tuple[frozenset[str] | None, tuple[tuple[str, int], ...], tuple[int, ...], str], Word] = {}
        self.problem = _Problem(design, self.canvas, self.rows, 1.0 + _ORDINARY_SHARE)

    def __call__(self, tolerance: float) -> Iterator[Candidate]:
        """Candidates with words within a tolerance of the canvas, metres, in the order of their bounds."""
        return map(self._candidate, self.within(tolerance))

    def within(self, tolerance: float) -> list[CandidateFit]:
        """Words within a tolerance of the canvas, in the order of their bounds; only a part if there are too many."""
        return self._lookup(tolerance)[0]

    def least_of_others(self, tolerance: float) -> float:
        """Lower bound of the energy of layouts of all other words within a tolerance."""
        return math.inf if self._lookup(tolerance)[1] else 0.0

    def _lookup(self, tolerance: float) -> tuple[list[CandidateFit], bool]:
        if tolerance > _ORDINARY_SHARE * max(self.canvas) and self.problem.stretch < STRETCH:
            self.problem = _Problem(self.design, self.canvas, self.rows, STRETCH)
        if tolerance not in self._by_tolerance:
            fits, complete = self.problem.within(tolerance)
            if self.problem.ambiguous:  # the first fit of all that have the same words: unused counters change nothing
                fits = list({tuple(w.word for w in fit.words.values()): fit for fit in reversed(fits)}.values())[::-1]
            self._by_tolerance[tolerance] = sorted(fits, key=lambda fit: (fit.bound, fit.gap)), complete
        return self._by_tolerance[tolerance]

    def tolerances(self, count: int) -> tuple[float, ...]:
        """Growing tolerances, metres; the first gives enough candidates, if enough fit well.

        Raises:
            NothingFitsError: If nothing fits; the message names the patterns that contradict each other.
        """
        longest = max(self.canvas)
        largest = max((symbol.size or 0.0 for symbol in self.design.symbols.values()), default=0.0)
        growing = [part * longest for part in _TOLERANCE_SHARES if part * longest > largest or part >= _ORDINARY_SHARE]
        for index, tolerance in enumerate(growing):
            fits, complete = self._lookup(tolerance)
            if not complete:
                return (growing[index - 1 if index and self.within(growing[index - 1]) else index],)
            if len(fits) >= count or (fits and tolerance >= _ORDINARY_SHARE * longest):
                return tuple(
                    larger for larger in growing[index:] if larger <= max(tolerance, _ORDINARY_SHARE * longest)
                )
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
        if key not in self._words:
            self._words[key] = tuple(
                replace(letter, covers=covering is None or letter.symbol in covering) for letter in instance.word
            )
        return self._words[key]


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
            text = _linear_text(_ZERO.minus(count) if less else count)
            factor = {"1": ""}.get(text, text if text.isdigit() else f"({text})" if " " in text else f"{text} ")
            sides[less].append(f"{factor}{symbol}")
        return " = ".join(" + ".join(side) or "0" for side in sides)


def relation(first: LayerPattern, second: LayerPattern) -> Relation | None:
    """The equation of two patterns; None if they do not differ, or have choices or copies of copies."""
    if not (_is_plain(first) and _is_plain(second)):
        return None
    items = [_items(first), _items(second)]
    for end in (0, -1):
        while items[0] and items[1] and items[0][end] == items[1][end]:
            for runs in items:
                runs.pop(end)
    counts: dict[str, Linear] = {}
    for sign, runs in zip((1, -1), items, strict=True):
        for letters, count in runs:
            for letter in letters:
                counts[letter] = _plus(counts.get(letter, _ZERO), count, sign)
    terms = tuple((symbol, count) for symbol, count in counts.items() if count.constant or count.terms)
    return Relation(terms) if terms else None


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


def _covering(rows: Sequence[_Row]) -> list[frozenset[str] | None]:
    """Symbols of each row for which those below may leave gaps; None for all symbols, if no row is below.

    Adjacent layers of one pattern have the same positions: each hides what any of them hides.
    """
    covering: list[frozenset[str] | None] = [None] * len(rows)
    for group in dict.fromkeys(row.group for row in rows):
        members = [number for number, row in enumerate(rows) if row.group == group]
        runs = [list(run) for _, run in groupby(members, key=lambda number: rows[number].pattern)]
        for run in runs[:-1]:
            symbols = frozenset[str]().union(*(rows[number].covering for number in run))
            covering = [symbols if number in run else row_symbols for number, row_symbols in enumerate(covering)]
    return covering


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
        self.ambiguous = any(len({instance.word for instance in words}) < len(words) for words in self.words.values())
        self.shared = self._shared()
        self._group_fits: dict[tuple[tuple[int, str], tuple[int, ...]], tuple[float, float]] = {}
        self._num_visited = 0

    def _shared(self) -> list[list[tuple[int, str]]]:
        """Groups that share symbols."""
        shared: list[tuple[set[str], list[tuple[int, str]]]] = []
        for group in dict.fromkeys(row.group for row in self.rows):
            symbols = {symbol for row in self.rows if row.group == group for symbol in self._sized(row)}
            groups = [group]
            for other in [other for other in shared if other[0] & symbols]:
                shared.remove(other)
                symbols, groups = symbols | other[0], groups + other[1]
            shared.append((symbols, groups))
        return [groups for _, groups in shared]

    def _sized(self, row: _Row) -> Iterator[str]:
        symbols = self.design.symbols
        return (symbol for symbol in self.design.patterns[row.pattern].symbols() if symbols[symbol].size is not None)

    def within(self, tolerance: float) -> tuple[list[CandidateFit], bool]:
        """Words within a tolerance of their canvas, and whether these are all."""
        result: list[CandidateFit] = []
        before = self._num_visited
        for number, chosen in enumerate(self._joined(tolerance)):
            if max(number, self._num_visited - before) > _MAX_COMBINATIONS or len(result) > MOST_CANDIDATES:
                fits = (self._fit(combination, tolerance) for combination in self._beam(tolerance))
                return [fit for fit in fits if fit is not None] or result[:MOST_CANDIDATES], False
            fit = self._fit(chosen, tolerance)
            if fit is not None:
                result.append(fit)
        return result, True

    def _beam(self, tolerance: float) -> list[dict[str, Instance]]:
        """A part of many combinations: those whose words fit the canvas best, pattern by pattern (beam search)."""
        distance = {
            name: {
                id(instance): max(
                    abs(self.canvas[row.axis] - instance.size) for row in self.rows if row.pattern == name
                )
                for instance in self.words[name]
                if self.fits(name, instance, tolerance)
            }
            for name in self.names
        }
        # Patterns that share counters follow each other, so that contradictions are found early.
        order = sorted(self.names, key=lambda name: (self.design.patterns[name].counters(), len(distance[name])))
        beam: list[tuple[float, dict[str, int], dict[str, Instance]]] = [(0.0, {}, {})]
        for name in order:
            extended = [
                (
                    cost + distance[name][id(instance)] ** 2 * (not instance.unsized),
                    {**counters, **dict(instance.counters)},
                    chosen,
                    instance,
                )
                for cost, counters, chosen in beam
                for instance in self.words[name]
                if id(instance) in distance[name]
                and all(counters.get(key, value) == value for key, value in instance.counters)
            ]
            extended.sort(key=lambda entry: entry[0])
            beam = [
                (cost, counters, {**chosen, name: instance})
                for cost, counters, chosen, instance in extended[:_MAX_REDUCED]
            ]
        return [chosen for _, _, chosen in beam]

    def _joined(self, tolerance: float) -> Iterator[dict[str, Instance]]:
        """One word per pattern, with one value per counter, no word too long and none too short to be extended."""
        words = {
            name: [instance for instance in self.words[name] if self.fits(name, instance, tolerance)]
            for name in self.names
        }
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
            for name, count in chosen[above.pattern].opaque.items():
                if name in above.covering:
                    counts[name] = counts.get(name, 0) + count
        return counts

    def _fit(self, chosen: Mapping[str, Instance], tolerance: float) -> CandidateFit | None:
        gaps, bounds = 0.0, dict[tuple[int, str], float]()
        for group, rows in self.groups.items():
            key = group, tuple(id(chosen[row.pattern]) for row in rows)
            if key not in self._group_fits:
                row_fits = [self._row_fit(row, chosen) for row in rows]
                self._num_visited += len(rows)
                self._group_fits[key] = max(gap for gap, _ in row_fits), max(bound for _, bound in row_fits)
            gap, bounds[group] = self._group_fits[key]
            if gap > tolerance:
                return None
            gaps = max(gaps, gap)
        counters = {name: value for name in self.names for name, value in chosen[name].counters}
        return CandidateFit(
            counters, chosen, sum(max(bounds[member] for member in groups) for groups in self.shared), gaps
        )

    def _row_fit(self, row: _Row, chosen: Mapping[str, Instance]) -> tuple[float, float]:
        """Difference of the lengths of a word and the canvas, metres, and a lower bound of its energy."""
        instance, weight = chosen[row.pattern], self.design.weights.sizing
        gap = instance.size - self.canvas[row.axis]
        if gap < 0.0:
            hidden, symbols = self._hidden(row, chosen), self.design.symbols
            gap = self._short(row, instance, sum((symbols[name].size or math.inf) * n for name, n in hidden.items()))
            bound = self._short_bound(row, chosen, gap)
        else:
            bound = weight * gap**2 / (sum(count**2 for count in instance.counts.values()) or 1.0)
        return gap, 0.0 if instance.transparent or self.design.overhang else bound

    def _short_bound(self, row: _Row, chosen: Mapping[str, Instance], gap: float) -> float:
        """Lower bound of the energy of a word that is too short, including its gaps for letters above it.

        A part of the gap may be empty elements beside letters of other rows, with their errors of columns; larger
        symbols fill the rest. By least squares, this costs the square of the rest over the sum of the squares of the
        counts of symbols, in all of these rows.
        """
        instance = chosen[row.pattern]
        others = {other.pattern for other in self.groups[row.group]} - {row.pattern}
        if not gap or any(chosen[name].loose for name in others):
            return 0.0
        counts = dict(instance.counts)
        for name in others:
            for symbol, count in chosen[name].counts.items():
                counts[symbol] = counts.get(symbol, 0) + count
        squares = sum(count**2 for count in counts.values())
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
    for instance in words[name]:
        values = dict(instance.counters)
        if all(counters.get(key, value) == value for key, value in values.items()):
            yield from _join(rest, words, {**chosen, name: instance}, {**counters, **values})


def _explained(design: Design, canvas: tuple[float, float], rows: Sequence[_Row]) -> str:
    """Patterns that contradict each other: a minimal set."""
    remaining = list(range(len(rows)))
    for row in range(len(rows)):
        fewer = [index for index in remaining if index != row]
        if fewer and not _possible(design, canvas, [rows[index] for index in fewer]):
            remaining = fewer
    patterns = [_pattern_text(design, canvas, rows[row]) for row in remaining]
    if len(patterns) == 1:
        return f"no word fits: {patterns[0]}"
    text = "these patterns contradict each other: " + "; ".join(dict.fromkeys(patterns)) + ". Counters are shared."
    equations = _equations(design, [rows[index] for index in remaining])
    return f"{text} Aligned with each other, they require {' and '.join(equations)}." if equations else text


def _possible(design: Design, canvas: tuple[float, float], rows: Sequence[_Row]) -> bool:
    alone = [_Row(row.group, row.pattern) for row in rows]
    problem = _Problem(design, canvas, alone, STRETCH)
    return problem.within(STRETCH * max(canvas))[0] != []


def _pattern_text(design: Design, canvas: tuple[float, float], row: _Row) -> str:
    """A pattern, and the ranges of counters for which it fits alone."""
    side = canvas[row.axis]
    problem = _Problem(design, canvas, [_Row(row.group, row.pattern)], STRETCH)
    fitting = [
        instance for instance in problem.words[row.pattern] if problem.fits(row.pattern, instance, STRETCH * side)
    ]
    text = f"{row.pattern} = {design.patterns[row.pattern].text!r} over {side:g} m"
    if not fitting:
        sizes = [instance.size for instance in problem.words[row.pattern]]
        if not sizes:
            sizes = [_shortest(design, row.pattern, problem.ranges)]
        return f"{text}, whose closest word is {min(sizes, key=lambda size: abs(size - side)):g} m long"
    if not fitting[0].counters:
        return text
    ranges = []
    for index, (name, _) in enumerate(fitting[0].counters):
        values = [instance.counters[index][1] for instance in fitting]
        ranges.append(f"{name} = {min(values)}" + (f" to {max(values)}" if max(values) > min(values) else ""))
    return f"{text} with {', '.join(ranges)}"


def _shortest(design: Design, name: str, ranges: Mapping[str, Range]) -> float:
    """Length of the shortest word of a pattern, metres."""
    words = [
        make_instance(design, name, {counter: low + more for counter, (low, _) in ranges.items()}, choices)
        for choices in choices_of(design.patterns[name])
        for more in (0, 1)
    ]
    return min((instance.size for instance in words if instance is not None and instance.word), default=0.0)


def _equations(design: Design, rows: Sequence[_Row]) -> list[str]:
    """Equations between patterns of one group, see `relation`."""
    pairs = [(one, other) for one, other in combinations(rows, 2) if one.group == other.group]
    relations = (relation(design.patterns[one.pattern], design.patterns[other.pattern]) for one, other in pairs)
    return list(dict.fromkeys(str(equation) for equation in relations if equation is not None))


def _equation(count: Linear) -> str:
    """A linear form that equals 0 as an equation, with positive factors on each side.

    >>> _equation(Linear(2, (("l", -1), ("m", 1))))
    'm + 2 = l'
    """
    left_side = Linear(max(count.constant, 0), tuple((name, factor) for name, factor in count.terms if factor > 0))
    right_side = Linear(max(-count.constant, 0), tuple((name, -factor) for name, factor in count.terms if factor < 0))
    return f"{_linear_text(left_side)} = {_linear_text(right_side)}"


def _linear_text(count: Linear) -> str:
    parts = [f"{'' if abs(factor) == 1 else abs(factor)}{name}" for name, factor in count.terms]
    signs = [factor < 0 for _, factor in count.terms]
    if count.constant or not parts:
        parts.append(str(abs(count.constant)))
        signs.append(count.constant < 0)
    text = ("-" if signs[0] else "") + parts[0]
    return text + "".join(f" {'-' if less else '+'} {part}" for less, part in zip(signs[1:], parts[1:], strict=True))


def _is_less(count: Linear) -> bool:
    return (count.terms[0][1] if count.terms else count.constant) < 0


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
    runs: list[tuple[tuple[str, ...], Linear]] = []

    def add(node: Node, count: Linear | None) -> None:
        match node:
            case Sign():
                content = pattern.content_of(node.symbol)
                if content is not None:
                    add(content, count)
                else:
                    runs.append(((node.symbol,), count or _ONE))
            case Row():
                if count is None:
                    for part in node.parts:
                        add(part, None)
                else:
                    runs.append((tuple(_letters(node, pattern)), count))
            case Power():
                add(node.base, node.count)
            case _:
                raise AssertionError("patterns with choices have no relations")

    add(pattern.body, None)
    return runs


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
    return total.minus(_ZERO.minus(count)) if sign > 0 else total.minus(count)
