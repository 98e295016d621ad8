"""Text surgery on rule files: what changes is written anew, everything else keeps its text, comments and order.

A rule may be replaced by copies of itself under other names, whose successors are renamed, whose percentages are
others, and in which branches are left out or stand several times.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias, TypeVar

from grammarlab.errors import Location
from grammarlab.language.grammar import Grammar
from grammarlab.language.parsing.outline import outline
from grammarlab.language.parsing.tokens import Token, tokenize
from grammarlab.language.syntax.tree import Attribute, Case, Choice, Rule, Stochastic, Style

T = TypeVar("T")
Path: TypeAlias = tuple[int, ...]
"""A place in the choices of a rule: the number of the branch at each level, from the top."""

_LEAST_ELSE = 1e-3
"""A less probable ``else`` would lose digits: it is what is left of 100."""
_HEADS = frozenset({"CASE", "CHANCE", "_ELSE"})
_OPENING = frozenset({"_LPAR", "_LBRACE", "_LBRACKET"})
_CLOSING = frozenset({"RPAR", "CLOSE", "RBRACKET"})
_LINE_COMMENT = re.compile(r"[^\S\n]*(?://|#)[^\n]*")
_START = re.compile(r"@StartRule\b\s*|\bstart\s+(?=\w)")
_WIDTH = 120


@dataclass(frozen=True, slots=True)
class Text:
    """The operations at the end of a rule's choices, as they stand, with some successors renamed."""

    path: Path
    names: Mapping[Location, str]
    """New names of successors by the place of the old ones."""


@dataclass(frozen=True, slots=True)
class Chances:
    """``N%`` branches with new percentages."""

    branches: tuple[tuple[float, Body], ...]
    """At least two, each with its probability, above 0; they sum to 1. See `likely_last`."""


@dataclass(frozen=True, slots=True)
class Same:
    """A choice that keeps the heads of its branches: conditions, or percentages."""

    path: Path
    branches: tuple[Body, ...]
    """One for each of its branches."""
    closed: bool = False
    """Whether to end ``case`` branches without ``else`` by one that makes nothing: without it, a branch that follows
    would be read as one of these."""


@dataclass(frozen=True, slots=True)
class Conditions:
    """``case`` branches that are new."""

    branches: tuple[tuple[str, Body], ...]
    """Each with its condition; the last becomes ``else``."""


Body: TypeAlias = Text | Chances | Same | Conditions


@dataclass(frozen=True, slots=True)
class RuleCopy:
    """What stands in place of a rule, or beside others made of it."""

    name: str
    body: Body | None = None
    """None for the rule as it is."""
    comment: str = ""
    """A line above it, without the marks of a comment."""
    start: bool = False
    """Whether to mark it as a rule to start with."""


def rewrite(
    grammar: Grammar,
    rules: Mapping[tuple[str, int], Sequence[RuleCopy]],
    attributes: Mapping[str, str] | None = None,
    new_attributes: Sequence[str] = (),
    header: Sequence[str] = (),
) -> str:
    """The text of a rule file with some rules replaced by copies of them, and some attributes given other values.

    A copy under another name has no annotations and no keyword. Where one copy is marked as a rule to start with, the
    others are not.

    Args:
        grammar: the rule file; it has no syntax errors.
        rules: by name and number of parameters, what stands in place of a rule, in this order; nothing removes it.
        attributes: text of the new value by name.
        new_attributes: definitions to be put in front of the first one.
        header: lines of a comment at the top of the file.
    """
    text = _Surgery(grammar).run(rules, attributes or {}, new_attributes)
    head = "".join(f"// {line}".rstrip() + "\n" for line in header)
    return f"{head}\n{text}" if head else text


def likely_last(choice: Sequence[tuple[float, T]]) -> tuple[tuple[float, T], ...]:
    """The branches of a choice, with one in the last place that ``else`` can stand for.

    An ``else`` is what is left of 100 %: where that is little, most of its digits are lost.

    Args:
        choice: branches, each with its probability.
    """
    branches = list(choice)
    if branches[-1][0] < _LEAST_ELSE:
        branches.append(branches.pop(max(range(len(branches)), key=lambda i: branches[i][0])))
    return tuple(branches)


def choice_text(choice: Sequence[tuple[float, str]], indent: str) -> str:
    """``N%`` branches, each on a new line, that are drawn with the given probabilities up to the last digits.

    Args:
        choice: at least two branches, each with its probability, above 0; they sum to 1. See `likely_last`.
        indent: white space in front of each line.
    """
    return _lines(_percentages([probability for probability, _ in choice]), [text for _, text in choice], indent)


def _percentages(probabilities: Sequence[float]) -> list[str]:
    return [*(f"{_percentage(100.0 * probability)}% :" for probability in probabilities[:-1]), "else :"]


def _percentage(value: float) -> str:
    """The number without the last digits that rounding errors make: 5, not 5.000000000000001."""
    short = f"{value:.14g}"
    return short if abs(float(short) - value) <= 4e-16 * value else repr(value).removesuffix(".0")


def _lines(heads: Sequence[str], texts: Sequence[str], indent: str) -> str:
    """Branches, each on a new line."""
    pairs = zip(heads, texts, strict=True)
    return "".join(f"\n{indent}{head}{'' if text.startswith(chr(10)) else ' '}{text}" for head, text in pairs)


class _Surgery:
    """The edits to one rule file. Only the definitions that change are read again, word by word."""

    def __init__(self, grammar: Grammar) -> None:
        self.text = grammar.text
        self.definitions = grammar.tree.definitions
        self.spans = grammar.tree.spans
        self.line_starts = _line_starts(self.text)

    def run(
        self,
        rules: Mapping[tuple[str, int], Sequence[RuleCopy]],
        attributes: Mapping[str, str],
        new_attributes: Sequence[str],
    ) -> str:
        edits: list[tuple[int, int, str]] = []
        done: set[object] = set()
        for number, definition in enumerate(self.definitions):
            if isinstance(definition, Style):
                break
            if isinstance(definition, Rule):
                key: object = (definition.name, len(definition.parameters))
                wanted = rules.get((definition.name, len(definition.parameters)))
                edit = None if wanted is None or key in done else self._rule(number, definition, wanted)
            else:
                key = getattr(definition, "name", None)
                value = attributes.get(definition.name) if isinstance(definition, Attribute) else None
                edit = None if value is None or key in done else self._value(number, value)
            if edit is not None:
                done.add(key)
                edits.append(edit)
        if new_attributes:
            first = self.spans[0][0]
            edits.append((first, first, "".join(f"{attribute}\n\n" for attribute in new_attributes)))
        return _edited(self.text, edits)

    def _rule(self, number: int, rule: Rule, copies: Sequence[RuleCopy]) -> tuple[int, int, str]:
        start, end = self.spans[number][0], _end_with_comment(self.text, self.spans[number][1])
        if not copies:
            return self._begin_with_comments(number), end, ""
        writer = _Writer(self.text, rule, self._tokens(number), self._offset)
        marked = any(copy.start for copy in copies)
        text = "\n\n".join(writer.copy(copy, marked) for copy in copies)
        # Several rules stand apart from what follows, as they do from each other.
        crowded = len(copies) > 1 and self.text[end:].strip() and self.text[end : end + 2] != "\n\n"
        return start, end, text + ("\n" if crowded else "")

    def _value(self, number: int, value: str) -> tuple[int, int, str]:
        """The edit that gives an attribute another value."""
        name = self._offset(self.definitions[number].location)
        equals = next(token for token in self._tokens(number) if token.start > name and token.type == "_EQUALS")
        return equals.end, self.spans[number][1], value

    def _tokens(self, number: int) -> list[Token]:
        """The words of a definition, with offsets in the whole text."""
        start, end = self.spans[number]
        words = (token for chunk in outline(tokenize(self.text[start:end])).chunks for token in chunk.tokens)
        return [token._replace(start=token.start + start, end=token.end + start) for token in words]

    def _offset(self, location: Location) -> int:
        """Where in the text a line and a column are."""
        return self.line_starts[location.line - 1] + location.column - 1

    def _begin_with_comments(self, number: int) -> int:
        """Where a definition begins, with the comments right above it and the empty line above those."""
        start = self.spans[number][0]
        above = self.spans[number - 1][1] if number else 0
        words = tokenize(self.text[above:start])
        line, line_above = (bisect_right(self.line_starts, offset) for offset in (start, above))
        first_line: dict[int, int] = {}
        """Of each comment that stands alone, by its last line."""
        for comment in words.comments:
            begin = line_above + comment.location.line - 1
            # What stands at the top of the file is about the file, what stands beside a definition about that.
            if comment.alone and begin > line_above:
                first_line[begin + comment.text.count("\n")] = begin
        while line - 1 in first_line:
            line = first_line[line - 1]
        start = self.line_starts[line - 1]
        if line > 1 and not self.text[self.line_starts[line - 2] : start].strip():
            start = self.line_starts[line - 2]
        start -= 2 if self.text[start - 2 : start] == "\r\n" else min(start, 1)
        # Only the version may be in between: it belongs to no definition.
        return max(start, above + max((word.end for word in words.tokens), default=0))


class _Writer:
    """The text of one rule, cut at its choices."""

    def __init__(self, text: str, rule: Rule, tokens: Sequence[Token], offset: Callable[[Location], int]) -> None:
        self.text = text
        self.rule = rule
        self.tokens = tokens
        self.offset = offset
        """Where in the text a line and a column are."""
        arrow = next(i for i, token in enumerate(tokens) if token.type == "_ARROW")
        self.arrow = tokens[arrow]
        self.name = next(token for token in tokens if token.start == offset(rule.location))
        self.heads: dict[Path, str] = {}
        """Text of the head of each branch."""
        self.ends: dict[Path, Sequence[Token]] = {}
        """Words of the operations at each end of the choices."""
        self._cut(rule.body, arrow + 1, ())
        first = next((token for token in tokens[arrow + 1 :] if token.location.line > self.arrow.location.line), None)
        before = text[: first.start].rpartition("\n")[2] if first is not None else ""
        self.indent = before if before and not before.strip() else "    "

    def copy(self, copy: RuleCopy, one_start: bool) -> str:
        """The text of a copy; ``one_start`` tells whether only marked copies are rules to start with."""
        comment = f"// {copy.comment}\n" if copy.comment else ""
        if copy.name == self.rule.name:
            head = self.text[self.tokens[0].start : self.arrow.end]
        else:
            head = copy.name + self.text[self.name.end : self.arrow.end]
        if one_start:
            head = ("@StartRule\n" if copy.start else "") + _START.sub("", head)
        if copy.body is None:
            last = self.tokens[-1].end
            return comment + head + self.text[self.arrow.end : _end_with_comment(self.text, last)]
        text = self._body(copy.body, self.indent)
        if isinstance(copy.body, Text):
            text = self._gap(copy.body, head, text) + text
        return comment + head + text

    def _gap(self, body: Text, head: str, text: str) -> str:
        """What stands between the head of a rule and its only sequence of operations."""
        if not body.path and self.ends[()]:
            return self.text[self.arrow.end : self.ends[()][0].start]
        flat = "\n" not in text and len(head.rpartition("\n")[2]) + 1 + len(text) <= _WIDTH
        return " " if flat else f"\n{self.indent}"

    def _cut(self, choice: Choice, at: int, path: Path) -> int:
        """Finds the heads and ends of a choice that begins at a token; the index past it."""
        if not isinstance(choice, Case | Stochastic):
            end = self._next(at, _HEADS)
            self.ends[path] = self.tokens[at:end]
            return end
        for i, branch in enumerate(choice.branches):
            colon = self._next(at, frozenset({"_COLON"}))
            self.heads[*path, i] = self.text[self.tokens[at].start : self.tokens[colon].end]
            at = self._cut(branch, colon + 1, (*path, i))
        return at

    def _next(self, at: int, kinds: frozenset[str]) -> int:
        """Index of the next token of some kind outside brackets, or past the end."""
        depth = 0
        for i in range(at, len(self.tokens)):
            kind = self.tokens[i].type
            if depth == 0 and kind in kinds:
                return i
            depth += (kind in _OPENING) - (kind in _CLOSING)
        return len(self.tokens)

    def _body(self, body: Body, indent: str) -> str:
        if isinstance(body, Text):
            return self._operations(body)
        if isinstance(body, Chances):
            texts = [(probability, self._inner(inner, indent)) for probability, inner in body.branches]
            return choice_text(texts, indent)
        if isinstance(body, Conditions):
            heads = [*(f"case {condition} :" for condition, _ in body.branches[:-1]), "else :"]
            return _lines(heads, [self._inner(branch, indent) for _, branch in body.branches], indent)
        heads = [self.heads[*body.path, i] for i in range(len(body.branches))]
        inner = [self._inner(branch, indent) for branch in body.branches]
        if body.closed:
            return _lines([*heads, "else :"], [*inner, "NIL"], indent)
        return _lines(heads, inner, indent)

    def _inner(self, body: Body, indent: str) -> str:
        step = "\t" if "\t" in self.indent else "    "
        return self._body(body, indent + step) or "[ ]"

    def _operations(self, text: Text) -> str:
        tokens = self.ends[text.path]
        if not tokens:
            return ""
        names = {self.offset(place): name for place, name in text.names.items()}
        start, end = tokens[0].start, _end_with_comment(self.text, tokens[-1].end)
        edits = [
            (token.start - start, token.end - start, names[token.start]) for token in tokens if token.start in names
        ]
        return _edited(self.text[start:end], edits)


def _end_with_comment(text: str, end: int) -> int:
    """Where words end, with the comment that follows on their line."""
    comment = _LINE_COMMENT.match(text, end)
    return comment.end() if comment else end


def _edited(text: str, edits: Sequence[tuple[int, int, str]]) -> str:
    """The text with each stretch from start to end replaced; stretches do not overlap."""
    pieces: list[str] = []
    at = 0
    for start, end, new in sorted(edits, key=lambda edit: edit[:2]):
        pieces += (text[at:start], new)
        at = max(at, end)
    return "".join((*pieces, text[at:]))


def _line_starts(text: str) -> list[int]:
    """Offset of the first character of each line."""
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    return starts
