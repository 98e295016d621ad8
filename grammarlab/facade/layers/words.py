"""The words of a pattern that are not longer than a canvas has room for (paper 003, section 5.1)."""

from __future__ import annotations

import math
from collections import Counter as Counts
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

from grammarlab.errors import FacadeError
from grammarlab.facade.layers.designs.design import Counter, Design
from grammarlab.facade.layers.designs.patterns import LayerPattern, Power, Reflection, Values, expand
from grammarlab.facade.layers.letters import Word

MOST_LETTERS = 400
"""Of a word."""
MOST_WORDS = 10_000
"""Of a pattern, on one canvas."""
MOST_CHOICES = 256
"""Ways to choose between the alternatives of a pattern."""
STRETCH = 3.0
"""By which all sizes of a word may grow or shrink at most: other words do not fit."""


@dataclass(frozen=True, slots=True)
class Instance:
    """A word of a pattern and what gives it."""

    counters: tuple[tuple[str, int], ...]
    """The pattern's own, by name."""
    choices: tuple[int, ...]
    word: Word
    size: float
    """Metres, of all letters that have a size."""
    counts: Mapping[str, int]
    """How often each symbol that has a size occurs."""
    unsized: bool
    """Whether some letter takes what is left."""
    loose: bool
    """Whether some letter without a size is not transparent."""
    transparent: bool
    """Whether some letter is transparent."""
    opaque: Mapping[str, int]
    """How often each symbol that hides what is below occurs."""


Range = tuple[int, int]


def counter_ranges(
    design: Design, names: Sequence[str], canvas: Mapping[str, float], stretch: float = STRETCH
) -> dict[str, Range]:
    """The least and largest number of each counter that lets all of its patterns fit.

    Args:
        design: the design.
        names: patterns.
        canvas: metres along which each pattern lies; the longer for one that lies along both axes.
        stretch: how many times as long as its canvas a word may be.

    Raises:
        FacadeError: for a counter that nothing bounds, and words of too many letters.
    """
    used = {name: design.patterns[name].counters() for name in names}
    least = {name: _least(design, design.counters[name], names) for each in used.values() for name in each}
    ranges: dict[str, Range] = {}
    for counter, low in least.items():
        most = design.counters[counter].most
        bounds = [] if most is None else [most]
        for name in (name for name in names if counter in used[name]):
            bound = _largest(design, name, counter, least, stretch * canvas[name], most)
            bounds += [] if bound is None else [bound]
        if not bounds:
            where = " and ".join(f"{design.patterns[name].text!r}" for name in names if counter in used[name])
            raise FacadeError(
                f"the counter {counter} has no bound: what it repeats in {where} has no size. Give a symbol in it a "
                f"size, or bound it: [counters] {counter} = {{ most = 9 }}."
            )
        ranges[counter] = (low, max(low, min(bounds)))
    return ranges


def _least(design: Design, counter: Counter, names: Sequence[str]) -> int:
    if counter.least is not None:
        return counter.least
    low = 0
    for name in names:
        for node in design.patterns[name].nodes():
            if isinstance(node, Power) and len(node.count.terms) == 1:
                ((each, factor),) = node.count.terms
                if each == counter.name and factor > 0:
                    low = max(low, -(node.count.constant // factor))
    return low


def _largest(
    design: Design, name: str, counter: str, least: Mapping[str, int], limit: float, most: int | None
) -> int | None:
    """The largest number for which a pattern has words within a limit; None when it does not change their size."""
    bounds = [
        _largest_of(design, name, counter, least, limit, most, choices) for choices in choices_of(design.patterns[name])
    ]
    known = [bound for bound in bounds if bound is not None]
    return max(known) if known else None


def _largest_of(
    design: Design,
    name: str,
    counter: str,
    least: Mapping[str, int],
    limit: float,
    most: int | None,
    choices: tuple[int, ...],
) -> int | None:
    def size(number: int) -> float:
        found = instance(design, name, {**least, counter: number}, choices)
        return math.inf if found is None else found.size

    low = max(least[counter], 0)
    fits, step, first = low, 1, size(low)
    while (longer := size(fits + step)) <= limit:
        fits, step = fits + step, 2 * step
        if most is not None and fits >= most:
            return most
        if step > MOST_LETTERS and longer == first:
            return None
    high = fits + step
    while high - fits > 1:
        middle = (fits + high) // 2
        fits, high = (middle, high) if size(middle) <= limit else (fits, middle)
    if size(fits) == first and size(high) == math.inf and first < math.inf:
        return None
    if size(high) == math.inf and first < math.inf:
        raise FacadeError(
            f"the pattern {design.patterns[name].text!r} has words of more than {MOST_LETTERS} letters that fit. "
            f"Expected larger symbols, a smaller canvas, or a bound: [counters] {counter} = {{ most = 50 }}."
        )
    return fits


def choices_of(pattern: LayerPattern) -> list[tuple[int, ...]]:
    """All ways to choose between its alternatives.

    Raises:
        FacadeError: when there are more than `MOST_CHOICES`.
    """
    options = pattern.options()
    if math.prod(options) > MOST_CHOICES:
        raise FacadeError(
            f"the pattern {pattern.text!r} has {math.prod(options):,} ways to choose between its alternatives: "
            f"expected at most {MOST_CHOICES:,}."
        )
    return list(product(*(range(count) for count in options)))


def instance(design: Design, name: str, counters: Mapping[str, int], choices: tuple[int, ...]) -> Instance | None:
    """The word of a pattern for these numbers; None when it is too long.

    Args:
        design: the design.
        name: of the pattern.
        counters: at least the pattern's own.
        choices: option of each choice.
    """
    pattern = design.patterns[name]
    own = {each: counters[each] for each in pattern.counters()}
    reflections: dict[str, Reflection] = {each: design.counters[each].reflection for each in own}
    slots = expand(pattern, Values(own, choices, reflections), MOST_LETTERS)
    if slots is None:
        return None
    word = design.word(slots)
    sized = Counts(letter.symbol for letter in word if letter.size is not None)
    return Instance(
        counters=tuple(own.items()),
        choices=choices,
        word=word,
        size=sum(letter.size for letter in word if letter.size is not None),
        counts=dict(sized),
        unsized=any(letter.size is None for letter in word),
        loose=any(letter.size is None and not letter.transparent for letter in word),
        transparent=any(letter.transparent for letter in word),
        opaque=dict(Counts(letter.symbol for letter in word if letter.opaque)),
    )


def instances(design: Design, name: str, ranges: Mapping[str, Range], longest: float) -> list[Instance]:
    """All words of a pattern that are not empty and not too long.

    Args:
        design: the design.
        name: of the pattern.
        ranges: of its counters, as `counter_ranges` gives them.
        longest: metres.

    Raises:
        FacadeError: when there are too many.
    """
    pattern = design.patterns[name]
    counters, choices = pattern.counters(), choices_of(pattern)
    number = len(choices) * math.prod(ranges[each][1] - ranges[each][0] + 1 for each in counters)
    if number > MOST_WORDS:
        widest = max(counters, key=lambda each: ranges[each][1] - ranges[each][0])
        text = ", ".join(f"{each} = {ranges[each][0]} to {ranges[each][1]}" for each in counters)
        raise FacadeError(
            f"the pattern {pattern.text!r} has {number:,} words ({text}): expected at most {MOST_WORDS:,}. Bound its "
            f"counters: [counters] {widest} = {{ most = 9 }}."
        )
    found: list[Instance] = []
    for numbers in product(*(range(ranges[each][0], ranges[each][1] + 1) for each in counters)):
        values = dict(zip(counters, numbers, strict=True))
        for chosen in choices:
            each = instance(design, name, values, chosen)
            if each is not None and each.word and each.size <= longest:
                found.append(each)
    return found
