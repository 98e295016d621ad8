"""Words of a pattern that fit into a canvas (paper 003, section 5.1)."""

from __future__ import annotations

import math
from collections import Counter as Counts
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

from grammarlab.errors import FacadeError
from grammarlab.layers.design import Counter, Design, Word
from grammarlab.layers.patterns import LayerPattern, Power, Reflection, Values, expand

MOST_LETTERS = 400
"""Largest number of letters of a word."""
MOST_WORDS = 10_000
"""Largest number of words of a pattern on one canvas."""
MOST_CHOICES = 256
"""Largest number of combinations of a pattern's alternatives."""
STRETCH = 3.0
"""Largest factor by which all sizes of a word may grow or shrink together."""


@dataclass(frozen=True, slots=True)
class Instance:
    """A word of a pattern with its counters and choices."""

    counters: tuple[tuple[str, int], ...]
    """Values of the pattern's counters, by name."""
    choices: tuple[int, ...]
    word: Word
    size: float
    """Total size of all letters with a size, metres."""
    counts: Mapping[str, int]
    """Number of occurrences of each symbol with a size."""
    unsized: bool
    """Whether a letter takes the remaining length."""
    loose: bool
    """Whether a letter without a size is not transparent."""
    transparent: bool
    """Whether a letter is transparent."""
    opaque: Mapping[str, int]
    """Number of occurrences of each symbol that hides the layers below."""


Range = tuple[int, int]


def counter_ranges(
    design: Design, names: Sequence[str], canvas: Mapping[str, float], stretch: float = STRETCH
) -> dict[str, Range]:
    """The least and largest value of each counter for which all of its patterns fit.

    Args:
        design: the design.
        names: names of patterns.
        canvas: length of the canvas along each pattern, metres; the longer side for a pattern along both axes.
        stretch: largest ratio of the lengths of a word and its canvas.

    Raises:
        FacadeError: If a counter has no bound, or words have too many letters.
    """
    used = {name: design.patterns[name].counters() for name in names}
    least = {name: _least(design, design.counters[name], names) for counters in used.values() for name in counters}
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
                f"the counter {counter} has no bound: its repeated part in {where} has no size. Give a symbol in it a "
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
                ((term, factor),) = node.count.terms
                if term == counter.name and factor > 0:
                    low = max(low, -(node.count.constant // factor))
    return low


def _largest(
    design: Design, name: str, counter: str, least: Mapping[str, int], limit: float, most: int | None
) -> int | None:
    """The largest number for which a pattern has words within a limit; None if their size does not depend on it."""
    bounds = [
        _largest_of(design, name, counter, least, limit, most, choices) for choices in choices_of(design.patterns[name])
    ]
    finite = [bound for bound in bounds if bound is not None]
    return max(finite) if finite else None


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
        instance = make_instance(design, name, {**least, counter: number}, choices)
        return math.inf if instance is None else instance.size

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
            f"the pattern {design.patterns[name].text!r} has fitting words of more than {MOST_LETTERS} letters. "
            f"Use larger symbols, a smaller canvas, or a bound: [counters] {counter} = {{ most = 50 }}."
        )
    return fits


def choices_of(pattern: LayerPattern) -> list[tuple[int, ...]]:
    """All combinations of its alternatives.

    Raises:
        FacadeError: If there are more than `MOST_CHOICES`.
    """
    options = pattern.options()
    if math.prod(options) > MOST_CHOICES:
        raise FacadeError(
            f"the pattern {pattern.text!r} has {math.prod(options):,} combinations of its alternatives: "
            f"expected at most {MOST_CHOICES:,}."
        )
    return list(product(*(range(count) for count in options)))


def make_instance(design: Design, name: str, counters: Mapping[str, int], choices: tuple[int, ...]) -> Instance | None:
    """The word of a pattern for these numbers; None if it is too long.

    Args:
        design: the design.
        name: name of the pattern.
        counters: values of at least the pattern's counters.
        choices: option of each choice.
    """
    pattern = design.patterns[name]
    values = {counter: counters[counter] for counter in pattern.counters()}
    reflections: dict[str, Reflection] = {counter: design.counters[counter].reflection for counter in values}
    slots = expand(pattern, Values(values, choices, reflections), MOST_LETTERS)
    if slots is None:
        return None
    word = design.word(slots)
    sized = Counts(letter.symbol for letter in word if letter.size is not None)
    return Instance(
        counters=tuple(values.items()),
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
        name: name of the pattern.
        ranges: ranges of its counters, see `counter_ranges`.
        longest: longest size of a word, metres.

    Raises:
        FacadeError: If there are too many.
    """
    pattern = design.patterns[name]
    counters, choices = pattern.counters(), choices_of(pattern)
    number = len(choices) * math.prod(ranges[counter][1] - ranges[counter][0] + 1 for counter in counters)
    if number > MOST_WORDS:
        widest = max(counters, key=lambda counter: ranges[counter][1] - ranges[counter][0])
        text = ", ".join(f"{counter} = {ranges[counter][0]} to {ranges[counter][1]}" for counter in counters)
        raise FacadeError(
            f"the pattern {pattern.text!r} has {number:,} words ({text}): expected at most {MOST_WORDS:,}. Bound its "
            f"counters: [counters] {widest} = {{ most = 9 }}."
        )
    fitting: list[Instance] = []
    for numbers in product(*(range(ranges[counter][0], ranges[counter][1] + 1) for counter in counters)):
        values = dict(zip(counters, numbers, strict=True))
        for chosen in choices:
            instance = make_instance(design, name, values, chosen)
            if instance is not None and instance.word and instance.size <= longest:
                fitting.append(instance)
    return fitting
