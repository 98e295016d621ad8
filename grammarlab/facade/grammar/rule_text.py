"""Pieces of CGA text for all grammars of facades."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from grammarlab.facade.grammar.bands import repeated_runs
from grammarlab.facade.looks import THICKNESS, look_of

AROUND = "Around"
"""Symbol of the wall around an outline in the box of a leaf."""
RESERVED = {"Lot", "Facade", "NIL", AROUND}

_MOST_DECIMALS = 6
"""Most decimals of a percentage."""
_LARGEST_CHANGE = 0.25
"""Largest relative change of a probability by rounding: a facade says little about how often its columns repeat."""
_ROUNDING = 1e-9
"""Error of a sum of probabilities, in percent."""


def number(value: float, digits: int) -> str:
    """A number with at most this many decimals.

    >>> number(1.20000001, 3), number(-0.0, 3), number(2.0, 9)
    ('1.2', '0', '2')
    """
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".") if digits else f"{value:.0f}"
    return "0" if text in ("-0", "") else text


def round_percentages(probabilities: Sequence[float]) -> list[str]:
    """Percentages with as few decimals as leave each within a quarter of its value; they add up to 100.

    What is left by rounding down goes to the largest remainders, and to the last of equal ones. None is 0: what is
    rarer than a millionth of a percent becomes that.

    Args:
        probabilities: [N] probabilities, above 0, with sum 1.

    >>> round_percentages([1 / 11] * 11)[::5], round_percentages([0.996, 0.004]), round_percentages([0.5, 0.5])
    (['9', '9', '10'], ['99.6', '0.4'], ['50', '50'])
    """
    shares = np.asarray(probabilities, dtype=np.float64) / np.sum(probabilities)
    decimals = 0
    while True:
        whole = 100 * 10**decimals
        parts = np.floor(shares * whole + _ROUNDING)
        if decimals == _MOST_DECIMALS:
            parts = np.maximum(parts, 1.0)
            parts[parts.argmax()] += min(0.0, whole - parts.sum())
        missing = round(whole - parts.sum())
        order = np.lexsort((-np.arange(len(parts)), parts - shares * whole))
        parts[order[:missing]] += 1.0
        is_near = (np.abs(parts - shares * whole) <= _LARGEST_CHANGE * shares * whole).all()
        if is_near or decimals == _MOST_DECIMALS:
            return [number(part / 10**decimals, decimals) for part in parts.tolist()]
        decimals += 1


def rule_name(label: str) -> str:
    """A rule name from a label.

    >>> rule_name("shop window"), rule_name(""), rule_name("1st floor"), rule_name("Tür")
    ('ShopWindow', 'Part', 'Part1stFloor', 'TR')
    """
    words = re.findall(r"[A-Za-z0-9]+", label)
    name = "".join(word[:1].upper() + word[1:] for word in words)
    return name if name[:1].isalpha() else f"Part{name}"


class RuleNames:
    """Unique names of rules."""

    def __init__(self) -> None:
        self._used = set(RESERVED)

    def new(self, preferred: str) -> str:
        """The preferred name, or the first free one with a number appended; with letters after a number.

        >>> names = RuleNames()
        >>> [names.new(name) for name in ("Bay", "Bay", "Bay2", "Bay2")]
        ['Bay', 'Bay2', 'Bay2B', 'Bay2C']
        """
        name, count = preferred, 1
        while name in self._used:
            count += 1
            name = f"{preferred}{_letters(count) if preferred[-1].isdigit() else count}"
        self._used.add(name)
        return name


def _letters(count: int) -> str:
    """The letters of a column of a spreadsheet: A for 1, Z for 26, AA for 27."""
    count -= 1
    return (_letters(count // 26) if count >= 26 else "") + chr(ord("A") + count % 26)


def leaf_body(label: str, *, pictured: bool = False, geometry: str = "primitiveCube()", scope: str = "") -> str:
    """CGA that makes a box from a rectangle, with the thickness and colour of its label, or with its picture.

    Args:
        label: the label.
        pictured: whether it shows a picture.
        geometry: the operation that makes its geometry.
        scope: the operation that sets its size; all of the rectangle by default.
    """
    look = look_of(label)
    depth = THICKNESS + look.front
    surface = f'color("{look.color}")'
    if look.glazed:
        surface += f" set(material.metallic, {look.metallic}) set(material.roughness, {look.roughness})"
    scope = scope or f"s('1, '1, {number(depth, 3)})"
    box = f"{scope} t(0, 0, {number(-THICKNESS, 3)}) {geometry}"
    return f"{box} projectUV(0)" if pictured else f"{surface} {box}"


def front_of_box(size: str, rule: str) -> str:
    """CGA that applies a rule to the front of a box, which splits need.

    Nothing ends there halfway to the other sides, which have nothing on them.

    Args:
        size: the three sizes, with commas between them.
        rule: the rule.
    """
    return f"set(trim.vertical, false) s({size}) primitiveCube() comp(f) {{ front : {rule} }}"


def split_body(axis: str, parts: Sequence[tuple[str, str]], *, repeats: bool = True) -> str:
    """A split into parts (size, rule) with repeats for runs.

    >>> split_body("x", [("~1", "Pier"), ("2", "Bay"), ("~1", "Pier"), ("2", "Bay"), ("~1", "Pier")])
    'split(x) { { ~1 : Pier | 2 : Bay }* | ~1 : Pier }'
    """
    words = [f"{size} : {name}" for size, name in parts]
    for run in reversed(repeated_runs(words) if repeats else []):
        group = " | ".join(words[run.start : run.start + run.period])
        words[run.start : run.end] = [f"{{ {group} }}*"]
    return f"split({axis}) {{ {' | '.join(words)} }}"
