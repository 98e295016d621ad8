"""Formulas in words, with the names that a table gives to what they read.

>>> from grammarlab.features.expression import Expression
>>> first, second = ("which({Lot > Tower@0:0}, {Lot > Tower@0:1})", "which({Lot > Tower@1:0}, {Lot > Tower@1:1})")
>>> formula_words(Expression.parse(f"equal({first}, {second})").formula, FeatureNames())
'Lot › Tower (successor 1) and Lot › Tower (successor 2) alike'
>>> floors = FeatureNames({Pattern("Floor"): "floors"})
>>> formula_words(Expression.parse("({Floor} * $storey + $plinth) / $front").formula, floors)
'(floors · storey + plinth) over front'
>>> lots = (f"which({{Lot > A@{i}:1}}, {{Lot > A@{i}:0}})" for i in (0, 1))
>>> pale = FeatureNames({Pattern("A", branch=(0,)): "A → pale"})
>>> formula_words(Expression.parse(f"ascending({', '.join(lots)})").formula, pale)
'Lot › A (successor 1) and Lot › A (successor 2) never fall in the order alternative 2, pale'
>>> alike, both = "({*[A:0 + A:0]} + {*[A:1 + A:1]})", "{*[A:* + A:*]}"
>>> formula_words(Expression.parse(f"{both} > 0 and {alike} == {both}").formula, FeatureNames())
'all adjacent A with the same choice'
>>> table = " or ".join(f"({{Roof:{number}}} and {{Plinth:{number}}})" for number in range(8))
>>> formula_words(Expression.parse(table).formula, FeatureNames())
'a relation of Roof and Plinth'
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from grammarlab.features.columns.column_names import FeatureNames, threshold_words
from grammarlab.features.patterns.pattern import (
    ZERO,
    Apply,
    Below,
    ConstantTerm,
    Draw,
    Feature,
    Formula,
    Measure,
    Pattern,
    Step,
    Threshold,
)
from grammarlab.language.dimensions import UNKNOWN, unit_of_result
from grammarlab.language.display_names import split_words, word_spans

ONE_OF = "one of these: "
"""What words for a table of several pairs begin with."""
RELATION = "a relation of "
"""What words for a statement that is too long to be read begin with; it says what the statement is about."""
COMBINATION = "a combination of "
"""What words for a number that is too long to be read begin with."""
MAX_LENGTH = 160
"""Largest number of characters of words: two lines of a page."""
MOST_NAMED = 4
"""Largest number of elements, things, branches, parts, symbols, kinds or conditions that words, a name or a comment
list."""
_ADJACENT = "adjacent"
_LEADING = frozenset(("at", "by", "for", "from", "in", "of", "on", "over", "to", "under", "with"))
"""Words that lead on to others, so that no beginning ends with them."""
_SIGNS: Mapping[str, str] = {
    "+": " + ",
    "-": " − ",
    "*": " · ",
    "/": " over ",
    "<": " below ",
    ">": " above ",
    "<=": " at most ",
    ">=": " at least ",
    "==": " equal to ",
    "!=": " not equal to ",
    "%": " modulo ",
    "and": " and ",
    "or": " or ",
}
_FORMS: Mapping[str, str] = {
    "equal": "{} alike",
    "unequal_neighbours": "no two neighbours alike among {}",
    "alternating": "{} alternate",
    "mirrored": "{} mirrored",
    "ascending": "{} never fall",
    "distinct": "number of kinds among {}",
    "changes": "changes along {}",
    "odd": "number unlike the most among {}",
    "longest_run": "longest run of equal ones among {}",
    "same_ends": "the first and the last alike among {}",
    "like_first": "number like the first among {}",
    "balance": "the first half less the second of {}",
    "least": "smallest of {}",
    "min": "smallest of {}",
    "max": "largest of {}",
    "which": "position of the first of {}",
    "choose": "choice by {}",
    "count": "number of these: {}",
}
_LIST = "of"
"""Operation of words that would be read together with those beside them: ``smallest of a and b``."""
_NEGATED: Mapping[str, str] = {"+": "-", "-": "+"}
_PRODUCTS = ("*", "/", "%")
_NUMBERS = (
    *("+", "-", "*", "/", "%", "distinct", "changes", "odd", "longest_run", "least", "min", "max", "which", "choose"),
    *("like_first", "balance", "count", "abs", "sqrt", "exp", "log", "floor", "ceil", "rint"),
)
"""Operations whose results are numbers; those of others are statements."""


class _Words(NamedTuple):
    text: str
    operation: str = ""
    """Operation that made it, if its text needs parentheses inside others."""


def formula_words(formula: Formula, names: FeatureNames) -> str:
    """A formula in words; if these are longer than `MAX_LENGTH`, only what it is about.

    Args:
        formula: the formula.
        names: words for features.
    """
    writer = _Writer(formula.steps, names)
    words: list[_Words] = []
    for step in formula.steps:
        words.append(writer.words(step, words))
    text = words[-1].text
    return text if len(text) <= MAX_LENGTH else writer.subject()


def is_statement(feature: Feature) -> bool:
    """Whether a feature is a formula that holds or not, instead of a number."""
    last = feature.steps[-1] if isinstance(feature, Formula) else None
    return isinstance(last, Apply) and last.operation not in _NUMBERS


def unit_of(feature: Feature, of_draw: Callable[[str], str]) -> str:
    """Unit of a feature, such as ``m²`` of a product of lengths; empty for plain numbers and unknown units.

    Args:
        feature: the feature.
        of_draw: unit of a draw by its name; empty for plain numbers, `UNKNOWN` for unknown units.
    """
    unit = _unit_of(feature, of_draw)
    return "" if unit == UNKNOWN else unit


def _unit_of(feature: Feature, of_draw: Callable[[str], str]) -> str:
    """Unit of a feature; `UNKNOWN` for unknown ones."""
    if isinstance(feature, Draw):
        return of_draw(feature.site) if feature.branch is None else ""
    units: list[str | None] = []
    for step in feature.steps if isinstance(feature, Formula) else ():
        if isinstance(step, ConstantTerm):
            units.append(None)
        elif isinstance(step, Measure):
            units.append(_unit_of(step.feature, of_draw))
        else:
            units.append(unit_of_result(step.operation, [units[index] for index in step.operands]))
    return (units[-1] if units else "") or ""


@dataclass(frozen=True)
class _Writer:
    steps: Sequence[Step]
    names: FeatureNames

    def words(self, step: Step, earlier: Sequence[_Words]) -> _Words:
        """Words for a step, from those of the steps before it."""
        if isinstance(step, ConstantTerm):
            return _Words(_number(step.value))
        if isinstance(step, Measure):
            return _Words(self.names[step.feature])
        phrase = self._place(step) or self._of_pairs(step, earlier) or self._of_kinds(step) or self._use(step, earlier)
        if phrase:
            return _Words(phrase, _LIST if " and " in phrase or " or " in phrase else "")
        if compared := self._comparison(step):
            return _Words(compared, ">")
        if table := self._table(step):
            return _Words(table, step.operation)
        if mixed := self._mixed(step):
            return _Words(mixed, step.operation)
        operands = [earlier[index] for index in step.operands]
        if step.operation in _SIGNS:
            return _Words(_joined(step.operation, *operands), step.operation)
        texts = [_listable(operand) for operand in operands]
        if step.operation == "followed":
            first, second, *elements = texts
            return _Words(f"alternative {first} followed by {second} among {_listed(elements)}", _LIST)
        if step.operation == "ascending" and (order := self._order(self.steps[step.operands[0]])):
            return _Words(f"{_listed(texts)} never fall in the order {order}", _LIST)
        if step.operation in _FORMS:
            things = [text.replace("number of ", "") for text in texts] if step.operation == "count" else texts
            return _Words(_FORMS[step.operation].format(_listed(things)), _LIST)
        if step.operation == "not":
            return _Words(f"not ({operands[0].text})" if operands[0].operation == "+" else f"not {texts[0]}", _LIST)
        return _Words(f"{step.operation} of {texts[0]}", _LIST)

    def subject(self) -> str:
        """What the formula is about."""
        last = self.steps[-1]
        things = list(dict.fromkeys(self._subjects(last)))
        kind = RELATION if is_statement(Formula(tuple(self.steps))) else COMBINATION
        texts = [kind + _first_of(things, most) for most in range(MOST_NAMED, 0, -1)]
        if short := next((text for text in texts if len(text) <= MAX_LENGTH), ""):
            return short
        excess = len(texts[-1]) - MAX_LENGTH
        return kind + _first_of([f"{things[0][: -excess - 1]}…", *things[1:]], 1)

    def _subjects(self, step: Step) -> Iterator[str]:
        """The places of choices and the draws that a step reads, without conditions on where draws are used."""
        if isinstance(step, Measure):
            feature = step.feature
            yield self.names.place(feature) if isinstance(feature, Pattern) else feature.site
        elif isinstance(step, Apply):
            for index in step.operands[self._is_use(step) :]:
                yield from self._subjects(self.steps[index])

    def _is_use(self, step: Apply) -> bool:
        """Whether a step is a draw where a model uses it: ``({A:1} > 0) * $h``."""
        if step.operation != "*":
            return False
        condition, draw = (self.steps[index] for index in step.operands)
        return isinstance(draw, Measure) and isinstance(draw.feature, Draw) and self._is_present(condition)

    def _is_present(self, step: Step) -> bool:
        """Whether a step says that patterns occur."""
        if not isinstance(step, Apply) or step.operation != ">" or self.steps[step.operands[1]] != ZERO:
            return False
        return bool(self._added_at(step, 0))

    def _place(self, step: Apply) -> str:
        """The place of a choice that `which` numbers by its alternatives; empty for anything else."""
        if step.operation != "which":
            return ""
        present = [self.steps[index] for index in step.operands if self.steps[index] != ZERO]
        places = [[self.names.place(pattern) for pattern in self._added(alternative)] for alternative in present]
        same = set(places[0]) if places else set[str]()
        return " or ".join(dict.fromkeys(places[0])) if same and all(set(each) <= same for each in places) else ""

    def _order(self, step: Step) -> str:
        """The alternatives of a choice from the first to the last; empty if this is the order of the text."""
        if not isinstance(step, Apply) or step.operation != "which":
            return ""
        added = [self._added(self.steps[index]) for index in step.operands]
        nodes = [_lowest(patterns[0]) for patterns in added if patterns]
        branches = [node.branch or () for node in nodes]
        if branches == sorted(branches):
            return ""
        names = (self.names[node].rpartition(" → ")[2] for node in nodes)
        return ", ".join(names)

    def _of_pairs(self, step: Apply, earlier: Sequence[_Words]) -> str:
        """Pairs of choices that are made alike: how many, how many not, all, none, by turns."""
        if step.operation == "+":
            return self._alike(step)
        if step.operation == "and" and (before := earlier[step.operands[0]].text).startswith(f"no {_ADJACENT}"):
            return f"{before.removeprefix('no ')} by turns"
        operands = [self.steps[index] for index in step.operands]
        if step.operation == "-" and (alike := self._alike(operands[1])):
            return f"exceptions to {alike}"
        if step.operation == "and" and isinstance(last := operands[1], Apply) and last.operation == "==":
            first, second = (self.steps[index] for index in last.operands)
            if alike := self._alike(first):
                return f"no {alike}" if second == ZERO else f"all {alike}"
        return ""

    def _of_kinds(self, step: Apply) -> str:
        """The share of an alternative, the number of those that occur, or of choices that are not the most frequent."""
        if step.operation == "/" and (one := self._added_at(step, 0)) and (total := self._added_at(step, 1)):
            is_share = _with_any(one[0]) == total[0] and len(one) == len(total) == 1
            return f"share of {self.names[one[0]]}" if is_share else ""
        if step.operation == "count" and all(map(self._added, (self.steps[index] for index in step.operands))):
            places = {self.names.place(one) for index in step.operands for one in self._added(self.steps[index])}
            return f"number of kinds of {places.pop()}" if len(places) == 1 else ""
        most = self.steps[step.operands[-1]]
        if step.operation == "-" and isinstance(most, Apply) and most.operation == "max":
            places = {self.names.place(one) for index in most.operands for one in self._added(self.steps[index])}
            return f"number of {places.pop()} unlike the most" if len(places) == 1 else ""
        return ""

    def _use(self, step: Apply, earlier: Sequence[_Words]) -> str:
        """A draw where a model uses it."""
        return f"{earlier[step.operands[1]].text} where used" if self._is_use(step) else ""

    def _comparison(self, step: Apply) -> str:
        """A draw compared with a number, which is a number of draws below it in steps; empty for anything else."""
        is_below = step.operation != "not"
        counted = step if is_below else self.steps[step.operands[0]]
        if not isinstance(counted, Apply) or counted.operation != ">":
            return ""
        draws, least = (self.steps[index] for index in counted.operands)
        if not isinstance(draws, Measure) or not isinstance(draws.feature, Threshold) or least != ZERO:
            return ""
        return threshold_words(draws.feature, is_below)

    def _table(self, step: Apply) -> str:
        """A table of which alternatives of two choices go together: ``Base = Shop / Bar with Roof = Flat``."""
        if step.operation not in ("and", "or"):
            return ""
        rows = list(map(self._row, self._flat("or", step)))
        if not all(map(all, rows)) or max(map(len, rows)) != 2:
            return ""
        pairs = list(map(" with ".join, rows))
        return pairs[0] if len(pairs) == 1 else f"{ONE_OF}{', or '.join(pairs)}"

    def _mixed(self, step: Apply) -> str:
        """Two sets of parts of which a model has some of both: ``(A or B) and C``; empty for anything else."""
        sides = [self._added(self.steps[index]) for index in step.operands] if step.operation == "and" else []
        if len(sides) != 2 or not all(sides) or max(map(len, sides)) == 1 or set(sides[0]) & set(sides[1]):
            return ""
        names = [[self.names[part].removeprefix("number of ").replace(" → ", " = ") for part in side] for side in sides]
        texts = [" and ".join(_either(side, most) for side in names) for most in range(MOST_NAMED, 0, -1)]
        return next((text for text in texts if len(text) <= MAX_LENGTH), texts[-1])

    def _row(self, step: Step) -> list[str]:
        """What a row of a table says of one or two choices, empty texts for anything else."""
        alternatives = self._alternatives(step)
        if alternatives or not isinstance(step, Apply) or step.operation != "and":
            return [alternatives]
        return [self._alternatives(self.steps[index]) for index in step.operands]

    def _flat(self, operation: str, step: Step) -> list[Step]:
        """The operands of a step and of those among them that have the same operation."""
        if not isinstance(step, Apply) or step.operation != operation:
            return [step]
        return [each for index in step.operands for each in self._flat(operation, self.steps[index])]

    def _alternatives(self, step: Step) -> str:
        """Which alternatives of a choice there are, or are not; empty for anything else."""
        if isinstance(step, Apply) and step.operation == "not":
            return self._alternatives(self.steps[step.operands[0]]).replace(" = ", " ≠ ")
        choices = [self._choice(each) for each in self._flat("+", step)]
        if not all(choices):
            return ""
        places, values = (
            dict.fromkeys(side) for side in zip(*(choice.split(" = ") for choice in choices), strict=True)
        )
        return f"{' or '.join(places)} = {' / '.join(values)}"

    def _choice(self, step: Step) -> str:
        """One alternative of a choice, where it is used or anywhere; empty for anything else."""
        if isinstance(step, Measure):
            name = self.names[step.feature].removeprefix("any ")
            choice = name.replace(" → ", " = ")
            return choice if choice.count(" = ") == 1 else ""
        if isinstance(step, Apply) and step.operation == "and":
            use, choice = (self.steps[index] for index in step.operands)
            return self._choice(choice) if self._is_present(use) else ""
        return ""

    def _alike(self, step: Step) -> str:
        """What a sum of patterns says that counts pairs of choices that are made alike; empty for anything else."""
        patterns = self._added(step)
        first, *others = dict.fromkeys(map(self._pair, patterns if len(patterns) > 1 else [])) or ("",)
        return f"{first} or {len(others)} others" if first and others else first

    def _pair(self, pattern: Pattern) -> str:
        """A pair of choices; empty for a pattern of anything else."""
        match pattern.below:
            case (Below(run=(_,)) as first, Below(run=(_,)) as second):
                places = [self.names.place(replace(pattern, below=(below,))) for below in (first, second)]
                return f"same choice at {places[0]} and {places[1]}"
            case (Below(run=(first, *_, last)),) if first.symbol == last.symbol:
                place = self.names.place(first)
                inner = f" at {place.removeprefix(f'{first.symbol} › ')}" if first.below else ""
                return f"{_ADJACENT} {first.symbol or 'parts'} with the same choice{inner}"
            case _:
                return ""

    def _added(self, step: Step) -> list[Pattern]:
        """Patterns that a step adds up; empty if it does anything else."""
        if isinstance(step, Measure):
            return [step.feature] if isinstance(step.feature, Pattern) else []
        if isinstance(step, ConstantTerm) or step.operation != "+":
            return []
        first, second = (self._added_at(step, index) for index in (0, 1))
        return [*first, *second] if first and second else []

    def _added_at(self, step: Apply, operand: int) -> list[Pattern]:
        return self._added(self.steps[step.operands[operand]])


def _number(value: float) -> str:
    """A number of four digits, without an exponent.

    >>> _number(0.5), _number(2.0), _number(-12034.0), _number(0.00003)
    ('0.5', '2', '-12,030', '0.00003')
    """
    rounded = float(f"{value:.4g}")
    return f"{rounded:,.0f}" if abs(rounded) >= 1e4 else np.format_float_positional(rounded, trim="-")


def _joined(operation: str, first: _Words, second: _Words) -> str:
    """Two operands with a sign between them, in parentheses where the sign binds more than theirs.

    >>> _joined("-", _Words("a − b", "-"), _Words("c − d", "-"))
    'a − b − (c − d)'
    """

    def inside(words: _Words, is_last: bool) -> str:
        binds_less = words.operation and words.operation not in _PRODUCTS
        same = words.operation == operation and operation in {"+", "*", "and", "or"}
        same |= operation in {"+", "-"} and words.operation in {"+", "-"} and not (is_last and operation == "-")
        same |= not is_last and operation == "/" and words.operation == "*"
        needs = bool(words.operation) and not same and (binds_less or operation in {"*", "/", "%"})
        return f"({words.text})" if needs else words.text

    if operation in _NEGATED and second.text.startswith("-") and _begins_negative(second, operation):
        operation, second = _NEGATED[operation], _Words(second.text.removeprefix("-"))
    return f"{inside(first, False)}{_SIGNS[operation]}{inside(second, True)}"


def _listable(words: _Words) -> str:
    """Words as one element of a list: in parentheses if they are a list themselves.

    >>> _listable(_Words("a and b", "and")), _listable(_Words("a + b", "+"))
    ('(a and b)', 'a + b')
    """
    is_list = bool(words.operation) and any(separator in words.text for separator in (" and ", " or ", ", "))
    return f"({words.text})" if is_list else words.text


def _begins_negative(words: _Words, operation: str) -> bool:
    """Whether the minus that a text begins with is the sign of all that a sum or a difference adds by it.

    >>> _begins_negative(_Words("-1 · b", "*"), "+"), _begins_negative(_Words("-1 · b below 2", "<"), "+")
    (True, False)
    """
    is_sum = operation == "+" and words.operation in ("+", "-") and _SIGNS["%"] not in words.text
    return is_sum or words.operation in ("", "*", "/")


def _lowest(pattern: Pattern) -> Pattern:
    """The lowest node of a pattern of a line of nodes."""
    while pattern.below:
        pattern = pattern.below[-1].run[-1]
    return pattern


def _with_any(pattern: Pattern) -> Pattern:
    """A pattern of a node with any branch."""
    return replace(pattern, branch=())


def _first_of(texts: Sequence[str], most: int) -> str:
    """Texts, of too many the first ones and the number of the others.

    >>> _first_of(["a", "b", "c"], 2)
    'a and 2 others'
    """
    return _listed(_shortened(texts, most))


def _either(texts: Sequence[str], most: int) -> str:
    """Texts of which one holds, in parentheses where there are several.

    >>> _either(["a", "b", "c"], 2), _either(["a"], 2)
    ('(a or 2 others)', 'a')
    """
    return f"({' or '.join(_shortened(texts, most))})" if len(texts) > 1 else texts[0]


def _shortened(texts: Sequence[str], most: int) -> Sequence[str]:
    """Texts, of too many the first ones and the number of the others."""
    if len(texts) <= most:
        return texts
    first = texts[: max(most - 1, 1)]
    num = len(texts) - len(first)
    return [*first, f"{num} other{'s' if num > 1 else ''}"]


def _listed(texts: Sequence[str]) -> str:
    """Texts in words: too many ones by the words that neighbours begin with, else from the first to the last.

    >>> _listed(["Walls", *(f"RoofOn{style}" for style in ("Brick", "Stone", "Timber", "Glass"))])
    'Walls and Roof (4)'
    """
    if len(texts) > MOST_NAMED:
        beginnings = _beginnings(texts)
        if not 1 < len(beginnings) <= MOST_NAMED:
            return f"{texts[0]} to {texts[-1]} ({len(texts)})"
        texts = beginnings
    return " and ".join([", ".join(texts[:-1]), texts[-1]] if len(texts) > 1 else texts)


def _beginnings(texts: Sequence[str]) -> list[str]:
    """The words that neighbours begin with, and how many do; nothing where these tell no thing."""
    groups: list[tuple[str, int]] = []
    for text in texts:
        same = _common(groups[-1][0], text) if groups else ""
        groups[-1:] = [(same, groups[-1][1] + 1)] if same else [*groups[-1:], (text, 1)]
    if any(text == "number" for text, _ in groups):
        return []
    # A beginning is the name of nothing that would be told in words later.
    told_once = [(split_words(text) if num > 1 and text.isidentifier() else text, num) for text, num in groups]
    return [text if num == 1 else f"{text} ({num})" for text, num in told_once]


def _common(first: str, second: str) -> str:
    """The words with which two names begin, without those that lead on."""
    begin, same = 0, ""
    for _, end in word_spans(first):
        if first[:end] != second[:end] or end not in {after for _, after in word_spans(second)}:
            break
        if first[begin:end].strip("_ ").lower() not in _LEADING:
            same = first[:end]
        begin = end
    return same
