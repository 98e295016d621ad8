"""Words for the symbols, attributes and branches of a grammar, as people read them.

An attribute, function or rule is called what its ``@DisplayName`` says, otherwise as its identifier reads in words:
``GroundFloor`` is ``Ground floor``. An alternative of a choice is called what distinguishes it from the choice itself:
``GroundFloor → GroundFloorOffice`` is ``Ground floor → Office``. Branches that make the same symbols are called after
what only they say: a text, such as a colour or a file, the numbers of a successor, or an attribute.
"""

from __future__ import annotations

import colorsys
import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import takewhile
from pathlib import PurePosixPath

import numpy as np

from grammarlab.language.checking.percentages import constant
from grammarlab.language.syntax import printing
from grammarlab.language.syntax.builtins import blocks, operations
from grammarlab.language.syntax.syntax_tree import (
    Annotation,
    Attribute,
    Binary,
    Block,
    Boolean,
    Call,
    Case,
    Choice,
    Expression,
    Function,
    Invoke,
    Name,
    Node,
    Number,
    Rule,
    RuleFile,
    Sequence,
    Stochastic,
    String,
    alternatives,
    walk,
)

_WORD = re.compile(r"A+(?=Aa)|A?a+0*|A+0*|0+")
"""A word of the shape of an identifier: ``GroundFloor``, ``GFA_total``."""
_IDENTIFIER = r"[^\W\d]\w*(?:\.\w+)*"
_IN_FORMULA = re.compile(rf"(?<![\w.]){_IDENTIFIER}")
_LINE = r"line \d+(?: branch \d+)?"
_SHARE = r"[\d.e+-]+%"
_NAMED = re.compile(
    rf"(?<![\w.#])(?P<of>{_IDENTIFIER})(?:#(?P<draw>\d+)(?![\w.]))?"
    rf"(?:(?P<place>(?: \d+)?)(?:(?P<sign> [→=≠] | \((?=[\d.e+-]+%|line ))"
    rf"(?:(?P<branch>(?:{_SHARE}, )?(?P<line>{_LINE})\b|(?P<share>{_SHARE}))"
    rf"|(?P<one>{_IDENTIFIER})\b(?! and )\.?|(?P<number>\d+)\b)))?"
)
"""An identifier, with what is chosen there if this follows."""
_ONE = rf"(?:{_LINE}|{_IDENTIFIER}\.?|{_SHARE}|\d+)"
_LISTED = re.compile(rf"(?<![\w.#])({_IDENTIFIER}(?:#\d+| \d+)?)( [=≠] )({_ONE}(?: / {_ONE})+)")
"""Several alternatives of a choice: ``Wall = Brick / Glass``."""
_COLOR = re.compile(r"#[0-9a-fA-F]{6}")
_FILE = re.compile(r"\.[^\W\d]\w{1,3}$|\w/[^\W\d][^/]*$")
"""How texts of files end: with a suffix that begins with a letter, or a name after a folder."""
_LONGEST = 60
"""Largest number of characters of a word from a grammar."""
_MAX_LETTERS = 2
"""Largest number of characters of a text that is read together with what it is an argument of."""
_ALONE = "(alone)"
"""After the only successor of a branch that has no operations; no identifier reads so."""
_NUM_CHANNELS = 3
"""Number of shares of a colour: red, green and blue."""
_NUM_ENDS = 2
"""Number of ends of a range."""
_ABBREVIATED: Mapping[str, str] = {"s": "size", "t": "translation", "r": "rotation", "i": "asset", "NIL": "nothing"}
"""Words for operations that have no name of their own."""
_MAX_GREY = 0.12
"""Saturation below which a colour is a grey."""
_HUES = (
    *((12, "red"), (42, "orange"), (68, "yellow"), (165, "green"), (195, "turquoise"), (258, "blue")),
    *((292, "purple"), (345, "pink"), (361, "red")),
)
"""Names of hues, each below a number of degrees."""
_MAX_BEIGE = 0.35
"""Saturation below which a light orange or yellow is beige."""
_MAX_BROWN = 0.45
"""Lightness below which orange is brown."""


@dataclass(frozen=True)
class DisplayNames:
    """Words of a grammar.

    >>> from grammarlab.language.grammar import Grammar
    >>> grammar = Grammar.parse('''
    ... attr roofPitch = rand(20, 50)
    ... Lot --> extrude(9) WallColor
    ... WallColor --> 50% : WallColorOld else : WallColorOffice
    ... WallColorOld -->
    ...     60% : color("#8E4B38") Wall.
    ...     else : color("#C0C4C8") Wall.
    ... ''')
    >>> names = DisplayNames.of(grammar.tree)
    >>> names.text("WallColor = WallColorOffice, roofPitch below 30")
    'Wall color = Office, roof pitch below 30'
    >>> names.text("WallColorOld → 60%")
    'Wall color old → brown'
    >>> names.text("nFloor#2 at least 6")
    'nFloor (draw 2) at least 6'
    """

    names: Mapping[str, str]
    """Words by identifier, for those that read otherwise."""
    branches: Mapping[tuple[str, str], str]
    """Words by symbol, and line (``line 23``, or ``line 23 branch 2`` if it has several) or percentage (``45%``), for
    branches of its rules."""
    values: Mapping[tuple[str, int], str]
    """Words by attribute and number, for alternatives of random attributes."""
    attributes: frozenset[str] = frozenset()
    """Attributes and functions, whose alternatives have numbers from 0 where they have no words."""

    @classmethod
    def of(cls, tree: RuleFile) -> DisplayNames:
        """Words of a grammar with the rule files that it imports."""
        given: dict[str, str] = {}
        identifiers: dict[str, None] = {}
        branches: dict[tuple[str, str], str] = {}
        values: dict[tuple[str, int], str] = {}
        definitions = [node for node in walk(tree) if isinstance(node, Attribute | Function | Rule)]
        # Draws are numbered over all overloads of a function, so values are those of names with one definition.
        overloads = Counter(node.name for node in definitions if not isinstance(node, Rule))
        attributes = frozenset(overloads)
        for definition in definitions:
            identifiers[definition.name] = None
            given |= _given(definition.name, definition.annotations)
            if isinstance(definition, Rule):
                identifiers |= dict.fromkeys(_successors(definition))
                for key, word in _branch_words(definition.body, attributes):
                    # Rules of one name differ in their parameters, which a name of a branch does not have.
                    is_other = branches.setdefault((definition.name, key), word) != word
                    branches |= {(definition.name, key): ""} if is_other else {}
            elif (choice := _first_choice(definition.value)) and overloads[definition.name] == 1:
                values |= {(definition.name, index): word for index, word in enumerate(_words_of_values(choice))}
        split = {name: _own_words(name) for name in identifiers}
        counts = _counted(split)
        whole = {name: words if counts[words] == 1 else _qualified(name, words) for name, words in split.items()}
        counts = _counted(whole)
        split = {name: words for name, words in whole.items() if counts[words] == 1 and words != name}
        return cls(split | given, branches, values, attributes)

    def text(self, text: str) -> str:
        """A text in which words replace identifiers, such as a name of a column or a sentence of these."""
        text, *lists = _LISTED.split(text)
        return self._plain(text) + "".join(
            self._list(*lists[start : start + 3]) + self._plain(lists[start + 3]) for start in range(0, len(lists), 4)
        )

    def _list(self, of: str, sign: str, ones: str) -> str:
        """Alternatives of one choice."""
        texts = [self._plain(f"{of}{sign}{one}") for one in ones.split(" / ")]
        # Values of an attribute are told without the number of the draw.
        for before in (f"{self._plain(of)}{sign}", f"{self._plain(of.partition('#')[0])}{sign}"):
            if all(text.startswith(before) for text in texts):
                return before + " / ".join(text.removeprefix(before) for text in texts)
        return " / ".join(texts)

    def _plain(self, text: str) -> str:
        """A text without lists of alternatives. What words hold is not replaced again."""
        return _NAMED.sub(self._named, text)

    def _named(self, match: re.Match[str]) -> str:
        of, draw = match["of"], match["draw"]
        name = self.names.get(of, of)
        before = f"{name} (draw {draw})" if draw else name
        if not match["sign"]:
            return f"{before}{match['place'] or ''}"
        # The choice between the values of an attribute is the first of its draws.
        if draw == "1" and match["number"] and (word := self.values.get((of, int(match["number"])))):
            return f"{name}{match['sign']}{word}"
        before += f"{match['place']}{match['sign']}"
        if match["one"]:
            return before + _without_repeated(name, self.names.get(match["one"], match["one"]))
        if match["branch"]:
            return before + (self.branches.get((of, match["line"] or match["share"])) or match["branch"])
        number = int(match["number"])
        word = "" if draw or match["place"] else self.values.get((of, number))
        # The index of an alternative would read like its value.
        return before + (word or (f"alternative {number + 1}" if of in self.attributes else match["number"]))


def _without_repeated(of: str, one: str) -> str:
    """Words of an alternative without those that begin the words of the choice, unless these are all it is called."""
    if of == one:
        return one
    repeated = 0
    for first, second in zip(of.lower().split(), one.lower().split()[:-1], strict=False):
        if first != second:
            break
        repeated += 1
    words = one.split()[repeated:]
    return " ".join([words[0][:1].upper() + words[0][1:], *words[1:]]) if repeated else one


def color_word(color: str) -> str:
    """English word for a colour.

    Args:
        color: the colour as ``#rrggbb``.

    >>> [color_word(color) for color in ("#F28C28", "#2F6FC1", "#8E4B38", "#D0D0D0", "#FFFFFF", "#F2E8D3")]
    ['orange', 'blue', 'brown', 'light grey', 'white', 'beige']
    """
    red, green, blue = (int(color[start : start + 2], 16) / 255.0 for start in (1, 3, 5))
    hue, lightness, _ = colorsys.rgb_to_hls(red, green, blue)
    if max(red, green, blue) - min(red, green, blue) < _MAX_GREY:
        return next(word for most, word in _GREYS if lightness <= most)
    word = next(word for most, word in _HUES if 360.0 * hue < most)
    if (
        word in ("orange", "yellow")
        and max(red, green, blue) - min(red, green, blue) < _MAX_BEIGE
        and lightness > _MAX_BROWN
    ):
        return "beige"
    return "brown" if word in ("red", "orange", "yellow") and lightness < _MAX_BROWN and hue > _REDDEST else word


_GREYS = ((0.12, "black"), (0.4, "dark grey"), (0.65, "grey"), (0.9, "light grey"), (1.0, "white"))
"""Names of greys, each up to a lightness."""
_REDDEST = 8 / 360
"""Hue up to which a dark red is not brown."""


def _given(name: str, annotations: Iterable[Annotation]) -> dict[str, str]:
    """What an author calls a definition."""
    for annotation in annotations:
        if annotation.name.lower() == "displayname" and annotation.arguments:
            value = annotation.arguments[0][1]
            if isinstance(value, String) and value.value.strip() and value.value.isprintable():
                return {name: value.value.strip()[:_LONGEST]}
    return {}


def split_words(identifier: str) -> str:
    """An identifier in words: the first as it begins, the others in small letters if they are not abbreviations.

    >>> split_words("GroundFloor"), split_words("GFA_total")
    ('Ground floor', 'GFA total')
    """
    words = [identifier[start:end] for start, end in word_spans(identifier)]
    if not words:
        return identifier
    return " ".join([words[0], *(word if word.isupper() else word[:1].lower() + word[1:] for word in words[1:])])


def word_spans(text: str) -> list[tuple[int, int]]:
    """Where each word of a text or an identifier begins and ends.

    >>> [text[start:end] for text in ("GroundFloor", "GFA_total") for start, end in word_spans(text)]
    ['Ground', 'Floor', 'GFA', 'total']
    """
    return [match.span() for match in _WORD.finditer("".join(map(_kind_of, text)))]


def _kind_of(character: str) -> str:
    """``A`` for a capital, ``a`` for another letter of any alphabet, ``0`` for a digit, ``_`` for anything else."""
    if character.isupper() or character.istitle():
        return "A"
    return "0" if character.isdecimal() else "a" if character.isalnum() else "_"


def _counted(words: Mapping[str, str]) -> Counter[str]:
    """How many names have each words; a symbol and a leaf that is called after it, ``Wall`` and ``Wall.``, are one."""
    return Counter({name.removesuffix("."): each for name, each in words.items()}.values())


def _qualified(name: str, words: str) -> str:
    """The words of a name of an imported file, after the name of the import."""
    alias = name.removesuffix(".").rpartition(".")[0]
    return f"{alias} {words}" if alias else words


def _successors(rule: Rule) -> Iterator[str]:
    """Symbols that a rule makes, and the operations among them."""
    return (node.name for node in walk(rule.body) if isinstance(node, Invoke))


def words_of_branches(body: Choice, attributes: frozenset[str]) -> list[str]:
    """A word for each branch of a rule that alone says something, empty for others.

    Args:
        body: the choices of the rule.
        attributes: the attributes and functions that a branch may read.
    """
    words = _words_among_siblings(body, attributes)
    counts = Counter(words)
    return [word if counts[word] == 1 else "" for word in words]


def _words_among_siblings(body: Choice, attributes: frozenset[str]) -> list[str]:
    """A word for each branch of a rule that says something that the others do not, or those of the same choice."""
    leaves = list(alternatives(body))
    if len(leaves) < 2:
        return [""]
    words = [""] * len(leaves)
    for sayings in (_texts, _colors, _calls, partial(_attributes, attributes), _parts):
        of_leaves = [list(dict.fromkeys(sayings(leaf))) for leaf in leaves]
        counts = Counter(saying for each in of_leaves for saying in each)
        own = [[saying for saying in each if counts[saying] == 1] for each in of_leaves]
        texts = [_common(each) if isinstance(sayings, partial) else "".join(each[:1]) for each in own]
        new = _distinct(texts, list(map(_short, texts)) if sayings in (_texts, _colors) else texts)
        # Names of several attributes can begin with the same words.
        words = [word or (other if new.count(other) == 1 else "") for word, other in zip(words, new, strict=True)]
    inner = [word for branch in _branches(body) for word in _words_among_siblings(branch, attributes)]
    return [word or other for word, other in zip(words, inner, strict=True)]


def _branches(choice: Choice) -> tuple[Choice, ...]:
    return choice.branches if isinstance(choice, Case | Stochastic) else ()


def _branch_words(body: Choice, attributes: frozenset[str]) -> Iterator[tuple[str, str]]:
    """Line, and percentage if no other branch has it, of each branch of a rule that says something: a word.

    A word that several branches have, of different choices, has its line, and its number if the line has several; but
    not that of the only random one of them.
    """
    leaves, words = list(alternatives(body)), _words_among_siblings(body, attributes)
    lines = Counter(leaf.location.line for leaf in leaves)
    keys = [
        f"line {line}" + (f" branch {number}" if lines[line] > 1 else "")
        for number, line in enumerate((leaf.location.line for leaf in leaves), 1)
    ]
    drawn = {id(leaf) for node in walk(body) if isinstance(node, Stochastic) for leaf in alternatives(node)}
    num_words = Counter(words)
    num_drawn = Counter(word for word, leaf in zip(words, leaves, strict=True) if id(leaf) in drawn)
    num_here = Counter((word, leaf.location.line) for word, leaf in zip(words, leaves, strict=True))
    words = [
        f"{word} ({key if num_here[word, leaf.location.line] > 1 else f'line {leaf.location.line}'})"
        if word and (num_drawn if id(leaf) in drawn else num_words)[word] > 1
        else word
        for word, leaf, key in zip(words, leaves, keys, strict=True)
    ]
    if isinstance(body, Stochastic) and len(body.branches) == len(leaves):
        written = [share.value if isinstance(share, Number) else 0.0 for share in body.percentages]
        rest = 100.0 - sum(written)
        keys += [f"{rest if s is None else w:.3g}%" for s, w in zip(body.percentages, written, strict=True)]
    counts = Counter(keys)
    yield from ((key, word) for key, word in zip(keys, words * 2, strict=False) if word and counts[key] == 1)


def _value(node: Choice) -> str:
    """A text, truth value, name, number, range, or a sum or product of names and numbers, in words; else empty."""
    if isinstance(node, String):
        return node.value
    if isinstance(node, Boolean):
        return str(node.value).lower()
    if isinstance(node, Name):
        return _own_words(node.identifier)
    if isinstance(node, Call) and node.function == "rint":
        return _value(node.arguments[0]) if isinstance(node.arguments[0], Call) else ""
    if isinstance(node, Call) and node.function == "rand" and node.arguments:
        ends = [constant(argument) for argument in node.arguments]
        numbers = sorted(end for end in ([0.0, *ends] if len(ends) == 1 else ends) if end is not None)
        return " to ".join(map(_number, numbers)) if len(numbers) == _NUM_ENDS else ""
    if isinstance(node, Case | Stochastic | Sequence):
        return ""
    number = constant(node)
    return _sum_or_product(node) if number is None else _number(number)


def _sum_or_product(node: Expression) -> str:
    """Sums and products of names and numbers in words; empty for other values, and for long ones.

    >>> from grammarlab.language.grammar import Grammar
    >>> _sum_or_product(Grammar.parse("attr a = (storeys - 1) * floorHeight + 0.5").attributes["a"].value)
    '(storeys - 1) · floor height + 0.5'
    """
    parts = list(walk(node))
    operators = {part.operator for part in parts if isinstance(part, Binary)}
    if not all(isinstance(part, Binary | Name | Number) for part in parts) or operators - set("+-*"):
        return ""
    text = _IN_FORMULA.sub(lambda match: _own_words(match[0]), printing.expression(node)).replace("*", "·")
    return text if len(text) <= _LONGEST else ""


def _number(value: float) -> str:
    """A number with all its digits, of fractions the first six.

    >>> _number(100000.0), _number(1234567.0), _number(-0.25), _number(1 / 3), _number(0.00001)
    ('100,000', '1,234,567', '-0.25', '0.333333', '0.00001')
    """
    if value == np.rint(value):
        return f"{value:,.0f}"
    return np.format_float_positional(value, precision=6, fractional=abs(value) >= 1.0, trim="-")


def _first_choice(value: Choice) -> Stochastic | None:
    """The random choice between values that is drawn first, if there is any and this is certain."""
    if isinstance(value, Stochastic):
        return value
    choices = [node for node in walk(value) if isinstance(node, Stochastic)]
    return choices[0] if len(choices) == 1 else None


def _words_of_values(choice: Stochastic) -> list[str]:
    """A word for each of several values; none if one has no words, or two are equal."""
    values = list(map(_value, choice.branches))
    if not all(values) or len(set(values)) < len(values):
        return []
    short = [
        _short(value) if isinstance(node, String) else value
        for value, node in zip(values, choice.branches, strict=True)
    ]
    return _distinct(values, short)


def _texts(node: Node) -> Iterator[str]:
    """Texts between quotes; a text of one or two characters with the successor that it is an argument of."""
    short = {
        id(argument): _own_words(part.name)
        for part in walk(node)
        if isinstance(part, Invoke) and part.name not in operations()
        for argument in part.arguments
        if isinstance(argument, String) and len(argument.value) <= _MAX_LETTERS
    }
    for part in walk(node):
        if isinstance(part, String):
            yield " ".join(filter(None, (short.get(id(part)), part.value)))


def _colors(node: Node) -> Iterator[str]:
    """Colours that three numbers say, or numbers with a factor each for their tone."""
    for part in walk(node):
        if isinstance(part, Invoke) and part.name == "color" and len(part.arguments) == _NUM_CHANNELS:
            shares = [_share(argument) for argument in part.arguments]
            if all(0.0 <= share <= 1.0 for share in shares):
                yield "#" + "".join(f"{round(255.0 * share):02x}" for share in shares)


def _share(argument: Node) -> float:
    """The number of a share of a colour, alone or times something named; NaN for anything else."""
    if isinstance(argument, Binary) and argument.operator == "*":
        number, factor = (argument.left, argument.right)[:: -1 if isinstance(argument.left, Name) else 1]
        return _share(number) if isinstance(factor, Name) else math.nan
    return argument.value if isinstance(argument, Number) else math.nan


def _calls(node: Node) -> Iterator[str]:
    """Successors with their numbers: ``Low 2``."""
    for part in walk(node):
        if isinstance(part, Invoke) and part.name[:1].isupper():
            numbers = [_number(argument.value) for argument in part.arguments if isinstance(argument, Number)]
            if numbers:
                yield " ".join([_own_words(part.name), *numbers])


def _parts(node: Node) -> Iterator[str]:
    """Successors of a branch, whether it has one and no operations, then its operations."""
    invoked = [part.name for part in walk(node) if isinstance(part, Invoke)]
    successors = [_own_words(name) for name in invoked if name not in operations()]
    yield from successors
    if successors and isinstance(node, Sequence) and len(node.items) == 1 and isinstance(node.items[0], Invoke):
        yield f"{successors[0]} {_ALONE}"
    used = [part.name for part in walk(node) if isinstance(part, Invoke | Block)]
    yield from (_ABBREVIATED.get(name, split_words(name)) for name in used if name in operations() or name in blocks())


def _own_words(name: str) -> str:
    """Words for a name without the import that it comes from."""
    return split_words(name.removesuffix(".").rpartition(".")[2])


def _attributes(attributes: frozenset[str], node: Node) -> Iterator[str]:
    """Those of the attributes that expressions read."""
    return (
        _own_words(part.identifier) for part in walk(node) if isinstance(part, Name) and part.identifier in attributes
    )


def _common(names: list[str]) -> str:
    """The words that all names begin with, such as those of the parts of a colour; otherwise the first name."""
    shared = [
        each[0] for each in takewhile(lambda each: len(set(each)) == 1, zip(*map(str.split, names), strict=False))
    ]
    return " ".join(shared) or "".join(names[:1])


def _distinct(texts: list[str], short: list[str]) -> list[str]:
    """A word for each text: a shorter one, or the text itself if that is not unique; empty if the word is not either.

    Args:
        texts: the texts; empty for none.
        short: a shorter word for each.
    """
    counts = Counter(short)
    words = [
        (word if counts[word] == 1 else text)[:_LONGEST] if text.isprintable() else ""
        for text, word in zip(texts, short, strict=True)
    ]
    counts = Counter(words)
    return [word if counts[word] == 1 else "" for word in words]


def _short(text: str) -> str:
    """Of a colour its name, of a file its name without suffix; anything else as it is."""
    if _COLOR.fullmatch(text):
        return color_word(text)
    return split_words(PurePosixPath(text.rpartition(":")[2]).stem) or text if _FILE.search(text) else text
