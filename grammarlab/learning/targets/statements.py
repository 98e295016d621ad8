"""Statements about designs, from the choices that they name to the words of people.

Alternatives of which one is taken are joined as choices, where statements are made: texts of a grammar can contain any
words and signs, also those that connect the parts of a sentence.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby, takewhile
from typing import NamedTuple

import numpy as np

from grammarlab.language.display_names import DisplayNames

OF_THESE = " of these: "
"""What stands before a list of things of which some number is there."""
IS, IS_NOT = "=", "≠"
"""Signs between a place and what is chosen there, or is not."""


class ChosenValue(NamedTuple):
    """What is chosen at a place, or is not."""

    place: str
    sign: str
    """`IS` or `IS_NOT`."""
    value: str

    def __str__(self) -> str:
        return " ".join(self)


class Statement(NamedTuple):
    """What holds for designs, in the identifiers of a grammar."""

    text: str
    sign: str = ""
    """What connects its parts: ``and``, ``or``; empty for a single one."""
    chosen: tuple[ChosenValue, ...] = ()
    """The choices of which one is made, if the statement says nothing else."""

    @classmethod
    def of_choice(cls, place: str, sign: str, value: str) -> Statement:
        chosen = ChosenValue(place, sign, value)
        return cls(str(chosen), "", (chosen,))


def any_of(statements: Sequence[Statement]) -> Statement:
    """That one of some statements holds."""
    are_alternatives = all(each.chosen and each.chosen[0].sign == IS for each in statements)
    chosen = [choice for each in statements for choice in each.chosen] if are_alternatives else []
    return _connected(statements, "or")._replace(chosen=tuple(chosen)) if len(statements) > 1 else statements[0]


def all_of(statements: Sequence[Statement]) -> Statement:
    """That all of some statements hold."""
    return _connected(statements, "and")


def _connected(statements: Sequence[Statement], sign: str) -> Statement:
    texts = (each.text if each.sign in ("", sign) else f"({each.text})" for each in statements)
    return Statement(f" {sign} ".join(texts), sign)


def quantity(low: float, high: float) -> str:
    """A range of a continuous number, whose bounds never occur themselves.

    >>> quantity(2.5, 7.0), quantity(1234.5, np.inf), quantity(-np.inf, 3.0)
    ('2.5 to 7', 'at least 1,234', 'at most 3')
    """
    first, last = (f"{bound:.3g}" if abs(bound) < 999.5 else f"{bound:,.0f}" for bound in (low, high))
    if np.isfinite(low + high):
        return f"{first} to {last}"
    return f"at least {first}" if np.isfinite(low) else f"at most {last}"


def whole_numbers(low: float, high: float) -> str:
    """Whole numbers between bounds; the ends themselves are given.

    >>> whole_numbers(0.5, 2.5), whole_numbers(1.5, np.inf), whole_numbers(-np.inf, 0.5)
    ('1 to 2', '2 or more', 'none')
    """
    first, last = np.ceil(low), np.ceil(high) - 1.0
    if not np.isfinite(last):
        return f"{first:.0f} or more"
    if not np.isfinite(first):
        return "none" if last == 0.0 else f"at most {last:.0f}"
    return f"{first:.0f}" if first == last else f"{first:.0f} to {last:.0f}"


def shown(statement: Statement, names: DisplayNames) -> str:
    """A statement in the words of people; alternatives name what they share only once.

    >>> names = DisplayNames({"PlainRoof": "Plain roof", "HutRoof": "Hut roof", "OldRoof": "Old roof"}, {}, {})
    >>> def either(*choices):
    ...     return shown(any_of([Statement.of_choice(place, "=", value) for place, value in choices]), names)
    >>> either(("Lot", "Tall"), ("Lot", "High 14"))
    'Lot = Tall / High 14'
    >>> either(("PlainRoof", "Attic"), ("HutRoof", "Attic"), ("OldRoof", "Attic"))
    'Plain, Hut or Old roof = Attic'
    >>> either(("A", "x or y"), ("B", "z"))
    'A = x or y or B = z'
    """
    whole = names.text(statement.text)
    parts = [_parts(choice, names) for choice in statement.chosen]
    apart = [part for part in parts if part is not None]
    if len(parts) < 2 or len(apart) < len(parts):
        return whole
    places, values = ([part[side] for part in apart] for side in (0, 1))
    if len(set(places)) == 1:
        return f"{places[0]} {IS} {' / '.join(values)}"
    return f"{_together(places)} {IS} {values[0]}" if len(set(values)) == 1 else whole


def all_shown(statements: Sequence[Statement], names: DisplayNames) -> str:
    """Statements that hold together, in the words of people; lists are in parentheses where more follows.

    >>> denied = [Statement.of_choice(place, "≠", value) for place, value in (("A", "x"), ("A", "y"), ("B", "y"))]
    >>> all_shown([Statement("2 or more of these: C, D"), *denied], DisplayNames({}, {}, {}))
    'A ≠ x / y, B ≠ y, 2 or more of these: C, D'
    """
    lists = [each for each in statements if OF_THESE in each.text]
    texts = list(_denied_once([each for each in statements if each not in lists], names))
    enclosed = [names.text(f"{each.text.replace(OF_THESE, ' of (')})") for each in lists[:-1]]
    return ", ".join([*texts, *enclosed, *(shown(each, names) for each in lists[-1:])])


def _denied_once(statements: Sequence[Statement], names: DisplayNames) -> Iterator[str]:
    """Statements, those as one that follow each other and say what is not chosen at one place."""
    for place, group in groupby(statements, _denied_place):
        same = list(group)
        parts = [_parts(each.chosen[0], names) for each in same] if place else []
        apart = [part for part in parts if part is not None]
        if len(apart) > 1 and len(apart) == len(same):
            yield f"{apart[0][0]} {IS_NOT} {' / '.join(value for _, value in apart)}"
        else:
            yield from (shown(each, names) for each in same)


def _denied_place(statement: Statement) -> str:
    """Where something is not chosen; empty for any other statement."""
    return statement.chosen[0].place if statement.chosen and statement.chosen[0].sign == IS_NOT else ""


def _parts(choice: ChosenValue, names: DisplayNames) -> tuple[str, str] | None:
    """A place and what is chosen there in the words of people; None if these are not apart."""
    place, text = names.text(choice.place), names.text(str(choice))
    before = f"{place} {choice.sign} "
    return (place, text.removeprefix(before)) if text.startswith(before) else None


def _together(places: Sequence[str]) -> str:
    """Places as a list that names the words only once with which all of them end."""
    words = [place.split() for place in places]
    most = min(map(len, words)) - 1
    ends = zip(*(reversed(each) for each in words), strict=False)
    shared = min(most, sum(1 for _ in takewhile(lambda each: len(set(each)) == 1, ends)))
    own = [" ".join(each[: len(each) - shared]) for each in words]
    return " ".join([f"{', '.join(own[:-1])} or {own[-1]}", *words[0][len(words[0]) - shared :]])


def counted_thing(name: str) -> str:
    """A summand of a number of things: ``no Door`` for ``not number of Door``."""
    if name.startswith("not ") and " → " in name:
        return name.removeprefix("not ").replace(" → ", " ≠ ")
    return name.replace("not number of ", "no ").removeprefix("number of ").replace(" → ", " = ")
