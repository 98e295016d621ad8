"""Pieces of CGA text for all grammars of facades."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from grammarlab.facade.grammar.bands import repeated_runs
from grammarlab.facade.looks import THICKNESS, look_of
from grammarlab.language.formatting import WIDTH

AROUND = "Around"
"""Symbol of the wall around an outline in the box of a leaf."""
RESERVED = {"Lot", "Facade", "NIL", AROUND}

_NAME = re.compile(r"(?:^|(?<=: )|(?<=\) ))[A-Za-z]\w*(?= [|}]|$)")
"""The name of a rule as all that a part consists of, or as the end of its operations."""
_INDENT = 8
"""Characters before a part that has its own line."""
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


def nested(rules: Mapping[str, str], movable: Iterable[str]) -> dict[str, str]:
    """Rules without those that are used once: their bodies replace their names where the line has room for them.

    No rule gets more lines by that.

    Args:
        rules: bodies by name; names are used after their rules.
        movable: names of rules that may be replaced.

    >>> nested({"Pane": "split(x) { 1 : Glass | 1 : Glass }", "Bay": "split(y) { 1 : Pane | ~1 : Wall }"}, ["Pane"])
    {'Bay': 'split(y) { 1 : split(x) { 1 : Glass | 1 : Glass } | ~1 : Wall }'}
    """
    result: dict[str, str] = {}
    uses = Counter(name for body in rules.values() for name in _NAME.findall(body))
    once = {name for name in movable if uses[name] == 1}
    for name, body in rules.items():
        inner = {part: result[part] for part in _NAME.findall(body) if part in once and part in result}
        ways = [_on_line(head, body, inner) for head in (name, "")] + [_on_lines(body, inner)]
        heights = [
            _height(name, way) + sum(_height(part, inner[part]) for part in inner.keys() & _NAME.findall(way))
            for way in ways
        ]
        _, _, result[name] = min(zip(heights, (-len(way) for way in ways), ways, strict=True))
        for part in inner.keys() - _NAME.findall(result[name]):
            del result[part]
    return result


def renamed(body: str, names: Mapping[str, str]) -> str:
    """A body with other names, or other bodies, in the place of names."""
    return _NAME.sub(lambda match: names.get(match[0], match[0]), body)


def top_down(rules: Mapping[str, str], starts: Iterable[str]) -> dict[str, str]:
    """Rules in the order in which a reader meets their names, those without parts last.

    Args:
        rules: bodies by name.
        starts: names that are not used by other rules.

    >>> list(top_down({"Glass": "NIL", "Pane": "split(x) { 1 : Glass }", "Bay": "split(y) { 1 : Pane }"}, ["Bay"]))
    ['Bay', 'Pane', 'Glass']
    """
    order: dict[str, None] = {}
    waiting = list(starts)[::-1]
    while waiting:
        name = waiting.pop()
        if name not in order:
            order[name] = None
            waiting += [part for part in reversed(_NAME.findall(rules[name])) if part in rules]
    return {name: rules[name] for name in sorted(order, key=lambda name: not _NAME.search(rules[name]))}


def _on_line(name: str, body: str, inner: Mapping[str, str]) -> str:
    """A body with as many inner bodies as `_is_line` allows."""
    if _is_line(name, body):
        for part in inner:
            longer = renamed(body, {part: inner[part]})
            body = longer if _is_line(name, longer) else body
    return body


def _on_lines(body: str, inner: Mapping[str, str]) -> str:
    """A body with those inner bodies for which a line of their own has room; with any one if it has no parts."""
    if "split(" not in body:
        return renamed(body, inner)
    pairs = [(segment, renamed(segment, inner)) for segment in _segments(body)]
    return " ".join(longer if len(longer) + _INDENT <= WIDTH else segment for segment, longer in pairs)


def _is_line(name: str, body: str) -> bool:
    """Whether a rule fits on one line; with no name, its last operation on a line below the others."""
    setup, opening, split = body.partition("split(")
    line = f"{name} --> {body}" if name else f"    {opening}{split or setup}"
    return len(line) <= WIDTH


def _height(name: str, body: str) -> int:
    """Number of lines of a rule."""
    if _is_line(name, body):
        return 1
    has_setup = not body.startswith("split(") and "split(" in body
    return 2 + has_setup if _is_line("", body) else 1 + sum(segment != "|" for segment in _segments(body))


def _segments(body: str) -> list[str]:
    """A body as its start up to the outermost split, the parts of that with bars between them, and its end.

    >>> _segments("split(y) { 1 : split(x) { ~1 : Glass } | { 1 : Bay | 2 : Pier }* }")
    ['split(y) {', '1 : split(x) { ~1 : Glass }', '|', '{ 1 : Bay | 2 : Pier }*', '}']
    """
    segments: list[list[str]] = [[]]
    depth = 0
    for word in body.split(" "):
        depth += (word == "{") - word.startswith("}")
        if (word, depth) == ("{", 1):
            segments[-1].append(word)
            segments.append([])
        elif (word, depth) == ("|", 1) or (word.startswith("}") and not depth):
            segments += [[word], []]
        else:
            segments[-1].append(word)
    return [" ".join(words) for words in segments if words]
