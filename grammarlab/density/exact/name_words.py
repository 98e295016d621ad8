"""Words for counts and symbols inside the names of split symbols."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence

_NUMBERS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")
_ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth")
_PARTS = re.compile(r"[^\W\d_]?[^\W\d_A-Z]+|[A-Z]+(?![^\W\d_A-Z])|\d+|[^\W\d_]")
_MAX_WORD = 24
"""Largest number of characters of the word for a symbol."""
_SIBILANTS = ("s", "x", "z", "ch", "sh")


def counted(word: str, counts: Collection[int], possible: Collection[int]) -> str:
    """Words for some of the numbers that a part can have; empty if there are none.

    Args:
        word: the part.
        counts: some of the possible numbers.
        possible: at least two numbers >= 0.

    >>> counted("storey", {3}, {0, 1, 2, 3}), counted("storey", {2, 3}, {0, 1, 2, 3}), counted("bay", {0}, {0, 1})
    ('three_storeys', 'at_least_two_storeys', 'no_bay')
    """
    some, every = sorted(counts), sorted(possible)
    if not some or len(some) == len(every):
        return ""
    low, high = some[0], some[-1]
    if low == high:
        return word if every == [0, 1] and low else number_of(word, low)
    if some == [count for count in every if low <= count <= high]:
        if high == every[-1]:
            return plural(word) if low == 1 and every[0] == 0 else f"at_least_{number_of(word, low)}"
        return f"at_most_{number_of(word, high)}" if low == every[0] else f"{_number(low)}_to_{number_of(word, high)}"
    for remainder, parity in enumerate(("even", "odd")):
        if some == [count for count in every if count % 2 == remainder]:
            return f"{parity}_{plural(word)}"
    others = [count for count in every if count not in counts]
    if len(others) == 1:
        return f"not_{number_of(word, others[0])}"
    return f"{_number(low)}_or_{number_of(word, high)}" if len(some) == 2 else ""


def number_of(word: str, count: int) -> str:
    """A number with the word for what is counted: ``three_storeys``."""
    return f"{_number(count)}_{word if count <= 1 else plural(word)}"


def place(branch: Sequence[int]) -> str:
    """The place of a branch as a word.

    Args:
        branch: index of the branch at each level, from 0.

    >>> place((1,)), place((0, 12))
    ('second', 'firstBranch13')
    """
    words = [_ORDINALS[index] if index < len(_ORDINALS) else f"branch{index + 1}" for index in branch]
    return "".join([*words[:1], *(word[:1].upper() + word[1:] for word in words[1:])])


def plural(word: str) -> str:
    """The plural of a word.

    >>> plural("storey"), plural("balcony"), plural("arch"), plural("stairs")
    ('storeys', 'balconies', 'arches', 'stairs')
    """
    if word.endswith("y") and word[-2:-1].lower() not in "aeiou":
        return f"{word[:-1]}ies"
    if word.endswith(_SIBILANTS):
        return word if word.endswith("s") else f"{word}es"
    return f"{word}s"


def short(symbol: str, inside: str) -> str:
    """A word for a symbol inside the name of another one, without the words that both begin or end with.

    >>> short("GroundFloorOffice", "GroundFloor"), short("RoofParis", "RoofOnPlain"), short("Brick.", "Wall")
    ('office', 'paris', 'brick')
    """
    parts, others = parts_of(symbol), parts_of(inside)
    begin = next(
        (i for i, (a, b) in enumerate(zip(parts, others, strict=False)) if a != b), min(len(parts), len(others))
    )
    rest = parts[begin:]
    while len(rest) > 1 and others and rest[-1] == others[-1]:
        rest = rest[:-1]
    # What remains must not begin with a digit: it would read as a number of something.
    return joined(rest if rest and not rest[0][0].isdigit() else parts)


def shared(symbols: Sequence[str]) -> str:
    """The words that all symbols have, as one word; empty if there are none.

    >>> shared(["UpperFloorsOffice", "RoofOffice"]), shared(["Wall", "Roof"])
    ('office', '')
    """
    parts = [parts_of(symbol) for symbol in symbols]
    return joined([part for part in parts[0] if all(part in other for other in parts[1:])]) if parts else ""


def parts_of(symbol: str) -> list[str]:
    """Words of a name in camel case or with underscores."""
    return _PARTS.findall(symbol)


def joined(parts: Sequence[str]) -> str:
    """Words as one word that begins with a small letter, with whole words only as far as they fit."""
    kept = [part for i, part in enumerate(parts) if i == 0 or sum(map(len, parts[: i + 1])) <= _MAX_WORD]
    first = [part.lower() if part.isupper() else part[:1].lower() + part[1:] for part in kept[:1]]
    # Small forms of some letters have signs that are not letters.
    return re.sub(r"\W", "", "".join([*first, *(part[:1].upper() + part[1:] for part in kept[1:])])[:_MAX_WORD])


def _number(count: int) -> str:
    return _NUMBERS[count] if count < len(_NUMBERS) else str(count)
