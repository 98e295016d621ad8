"""Edits of rule files: changed definitions are rewritten, everything else keeps its text, comments and order.

A rule may be replaced by copies under other names, with renamed successors, new percentages, and branches that are
left out or repeated.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias, TypeVar

from grammarlab.errors import Location
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax.outline import outline
from grammarlab.language.syntax.syntax_tree import Attribute, Case, Choice, Rule, Stochastic, Style
from grammarlab.language.syntax.tokens import Token, tokenize

T = TypeVar("T")
Path: TypeAlias = tuple[int, ...]
"""Path in the choices of a rule: the number of the branch at each level, from the top."""

_LEAST_ELSE = 1e-3
"""Smallest probability of an ``else``; since it is the rest to 100, a less probable one would lose digits."""
_HEADS = frozenset({"CASE", "CHANCE", "_ELSE"})
_OPENING = frozenset({"_LPAR", "_LBRACE", "_LBRACKET"})
_CLOSING = frozenset({"RPAR", "CLOSE", "RBRACKET"})
_LINE_COMMENT = re.compile(r"[^\S\n]*(?://|#)[^\n]*")
_START = re.compile(r"@StartRule\b\s*|\bstart\s+(?=\w)")
_WIDTH = 120


@dataclass(frozen=True, slots=True)
class Text:
    """Operations of a branch without further choices, unchanged except for renamed successors."""

    path: Path
    names: Mapping[Location, str]
    """New names of successors by the index of the old ones."""


@dataclass(frozen=True, slots=True)
class Chances:
    """``N%`` branches with new percentages."""

    branches: tuple[tuple[float, Body], ...]
    """Branches with their probabilities: at least two, above 0, with the sum 1. See `likely_last`."""


@dataclass(frozen=True, slots=True)
class Same:
    """A choice whose branches keep their heads: conditions, or percentages."""

    path: Path
    branches: tuple[Body, ...]
    """Bodies, one per branch of the choice."""
    closed: bool = False
    """Whether to add an empty ``else`` to ``case`` branches without one: otherwise a branch that follows
    would be read as one of these."""


@dataclass(frozen=True, slots=True)
class Conditions:
    """New ``case`` branches."""

    branches: tuple[tuple[str, Body], ...]
    """Bodies with their conditions; the last becomes ``else``."""


Body: TypeAlias = Text | Chances | Same | Conditions


@dataclass(frozen=True, slots=True)
class RuleCopy:
    """A copy that replaces a rule, alone or with other copies."""

    name: str
    body: Body | None = None
    """None for the unchanged body."""
    comment: str = ""
    """Text of a comment line above it, without comment marks."""
    start: bool = False
    """Whether to mark it as a start rule."""


def rewrite(
    grammar: Grammar,
    rules: Mapping[tuple[str, int], Sequence[RuleCopy]],
    attributes: Mapping[str, str] | None = None,
    new_attributes: Sequence[str] = (),
    header: Sequence[str] = (),
) -> str:
    """Text of a rule file with some rules replaced by copies, and new values of some attributes.

    A copy under another name has no annotations and no keyword. If one copy is marked as a start rule, the others
    are not.

    Args:
        grammar: the rule file; it has no syntax errors.
        rules: the copies that replace each rule, in this order, by name and number of parameters; no copies remove it.
        attributes: text of the new value by name.
        new_attributes: definitions to insert before the first one.
        header: lines of a comment at the top of the file.
    """
    text = _Surgery(grammar).run(rules, attributes or {}, new_attributes)
    head = "".join(f"// {line}".rstrip() + "\n" for line in header)
    return f"{head}\n{text}" if head else text


def likely_last(choice: Sequence[tuple[float, T]]) -> tuple[tuple[float, T], ...]:
    """Branches of a choice, reordered so that the last one can become ``else``.

    An ``else`` is the rest to 100 %; a small rest would lose most of its digits.

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
        choice: branches with their probabilities: at least two, above 0, with the sum 1. See `likely_last`.
        indent: white space before each line.
    """
    heads = _percentages([probability for probability, _ in choice])
    return "".join(f"\n{indent}{head} {text}" for head, (_, text) in zip(heads, choice, strict=True))


def _percentages(probabilities: Sequence[float]) -> list[str]:
    return [*(f"{_percentage(100.0 * probability)}% :" for probability in probabilities[:-1]), "else :"]


def _percentage(value: float) -> str:
    """The number without rounding errors in its last digits: 5, not 5.000000000000001."""
    text = f"{value:.14g}"
    return text if abs(float(text) - value) <= 4e-16 * value else repr(value).removesuffix(".0")


class _Surgery:
    """Edits of one rule file. Only changed definitions are tokenized again."""

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
                copies = rules.get((definition.name, len(definition.parameters)))
                edit = None if copies is None or key in done else self._rule(number, definition, copies)
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
        return edited(self.text, edits)

    def _rule(self, number: int, rule: Rule, copies: Sequence[RuleCopy]) -> tuple[int, int, str]:
        start, end = self.spans[number][0], _end_with_comment(self.text, self.spans[number][1])
        if not copies:
            return self._begin_with_comments(number), end, ""
        writer = _Writer(self.text, rule, self._tokens(number), self._offset)
        marked = any(copy.start for copy in copies)
        text = "\n\n".join(writer.copy(copy, marked) for copy in copies)
        # Several rules are separated from the following text by an empty line, as from each other.
        crowded = len(copies) > 1 and self.text[end:].strip() and self.text[end : end + 2] != "\n\n"
        # A comment above a rule is not read as one about the rule before it.
        line = self.line_starts[bisect_right(self.line_starts, start) - 1]
        below = (
            copies[0].comment and start == line and self.text[:start].strip() and self.text[start - 2 : start] != "\n\n"
        )
        return start, end, ("\n" if below else "") + text + ("\n" if crowded else "")

    def _value(self, number: int, value: str) -> tuple[int, int, str]:
        """Edit that changes the value of an attribute."""
        name = self._offset(self.definitions[number].location)
        equals = next(token for token in self._tokens(number) if token.start > name and token.type == "_EQUALS")
        return equals.end, self.spans[number][1], value

    def _tokens(self, number: int) -> list[Token]:
        """Words of a definition, with offsets in the whole text."""
        start, end = self.spans[number]
        words = (token for chunk in outline(tokenize(self.text[start:end])).chunks for token in chunk.tokens)
        return [token._replace(start=token.start + start, end=token.end + start) for token in words]

    def _offset(self, location: Location) -> int:
        """Offset in the text of a line and a column."""
        return self.line_starts[location.line - 1] + location.column - 1

    def _begin_with_comments(self, number: int) -> int:
        """Offset of the beginning of a definition, including the comments directly above it and an empty line."""
        start = self.spans[number][0]
        above = self.spans[number - 1][1] if number else 0
        words = tokenize(self.text[above:start])
        line, line_above = (bisect_right(self.line_starts, offset) for offset in (start, above))
        first_line: dict[int, int] = {}
        """Comments on separate lines, by their last line."""
        for comment in words.comments:
            begin = line_above + comment.location.line - 1
            # Comments at the top belong to the file, comments beside a definition to that definition.
            if comment.alone and begin > line_above:
                first_line[begin + comment.text.count("\n")] = begin
        while line - 1 in first_line:
            line = first_line[line - 1]
        start = self.line_starts[line - 1]
        if line > 1 and not self.text[self.line_starts[line - 2] : start].strip():
            start = self.line_starts[line - 2]
        start -= min(start, 1)
        # Only the version may be in between; it belongs to no definition.
        return max(start, above + max((word.end for word in words.tokens), default=0))


class _Writer:
    """Text of one rule, cut at its choices."""

    def __init__(self, text: str, rule: Rule, tokens: Sequence[Token], offset: Callable[[Location], int]) -> None:
        self.text = text
        self.rule = rule
        self.tokens = tokens
        self.offset = offset
        """Offset in the text of a line and a column."""
        arrow = next(i for i, token in enumerate(tokens) if token.type == "_ARROW")
        self.arrow = tokens[arrow]
        self.name = next(token for token in tokens if token.start == offset(rule.location))
        self.heads: dict[Path, str] = {}
        """Text of the head of each branch."""
        self.leads: dict[Path, str] = {}
        """White space and comments before the head of each branch."""
        self.gaps: dict[Path, str] = {}
        """White space and comments behind it."""
        self.ends: dict[Path, Sequence[Token]] = {}
        """Words of the operations of each branch without further choices."""
        self._cut(rule.body, arrow + 1, ())
        first = next((token for token in tokens[arrow + 1 :] if token.location.line > self.arrow.location.line), None)
        before = text[: first.start].rpartition("\n")[2] if first is not None else ""
        self.indent = before if before and not before.strip() else "    "

    def copy(self, copy: RuleCopy, one_start: bool) -> str:
        """Text of a copy; with ``one_start``, only marked copies are start rules."""
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
        """Text between the head of a rule and its only sequence of operations."""
        if not body.path and self.ends[()]:
            return self.text[self.arrow.end : self.ends[()][0].start]
        flat = "\n" not in text and len(head.rpartition("\n")[2]) + 1 + len(text) <= _WIDTH
        return " " if flat else f"\n{self.indent}"

    def _cut(self, choice: Choice, index: int, path: Path) -> int:
        """Find the heads and ends of a choice that begins at a token; returns the index past it."""
        if not isinstance(choice, Case | Stochastic):
            end = self._next(index, _HEADS)
            self.ends[path] = self.tokens[index:end]
            return end
        for i, branch in enumerate(choice.branches):
            colon = self._next(index, frozenset({"_COLON"}))
            before, head, behind = self.tokens[index - 1], self.tokens[index], self.tokens[colon]
            self.heads[*path, i] = self.text[head.start : behind.end]
            # A comment behind the operations of the branch before belongs to these.
            begin = before.end if i == 0 else _end_with_comment(self.text, before.end)
            self.leads[*path, i] = self.text[begin : head.start]
            if colon + 1 < len(self.tokens):
                self.gaps[*path, i] = self.text[behind.end : self.tokens[colon + 1].start]
            index = self._cut(branch, colon + 1, (*path, i))
        return index

    def _next(self, start: int, kinds: frozenset[str]) -> int:
        """Index of the next token of a type outside brackets, or past the end."""
        depth = 0
        for i in range(start, len(self.tokens)):
            kind = self.tokens[i].type
            if depth == 0 and kind in kinds:
                return i
            depth += (kind in _OPENING) - (kind in _CLOSING)
        return len(self.tokens)

    def _body(self, body: Body, indent: str) -> str:
        """Text of a body; of choices with what is before the first branch."""
        if isinstance(body, Text):
            return self._operations(body)
        if isinstance(body, Chances):
            bodies = [branch for _, branch in body.branches]
            heads, places = _percentages([probability for probability, _ in body.branches]), self._places(bodies)
        elif isinstance(body, Conditions):
            bodies, places = [branch for _, branch in body.branches], None
            heads = [*(f"case {condition} :" for condition, _ in body.branches[:-1]), "else :"]
        else:
            bodies, places = list(body.branches), [(*body.path, i) for i in range(len(body.branches))]
            heads = [self.heads[place] for place in places]
        leads = [f"\n{indent}"] * len(bodies) if places is None else [self.leads[place] for place in places]
        texts = [self._inner(inner, indent) for inner in bodies]
        if isinstance(body, Same) and body.closed:
            heads, leads, texts = [*heads, "else :"], [*leads, leads[-1]], [*texts, " NIL"]
        written = ""
        for lead, head, text in zip(leads, heads, texts, strict=True):
            # What followed a comment may be left out; the next branch must not become a part of it.
            is_in_comment = "\n" not in lead and any(mark in written.rpartition("\n")[2] for mark in ("//", "#"))
            written += (f"\n{indent}" if is_in_comment else lead) + head + text
        return written

    def _places(self, bodies: Sequence[Body]) -> list[Path] | None:
        """The places of bodies, if they are some branches of one choice, in its order; None for any others."""
        places = [body.path for body in bodies if isinstance(body, Text | Same)]
        is_one = len(places) == len(bodies) and len({place[:-1] for place in places}) == 1
        return (
            places
            if is_one and places == sorted(set(places)) and all(place in self.leads for place in places)
            else None
        )

    def _inner(self, body: Body, indent: str) -> str:
        """Text behind the head of a branch."""
        text = self._body(body, indent + ("\t" if "\t" in self.indent else "    "))
        if not isinstance(body, Text):
            return text
        return self.gaps.get(body.path, " ") + text if text else " [ ]"

    def _operations(self, text: Text) -> str:
        tokens = self.ends[text.path]
        if not tokens:
            return ""
        names = {self.offset(location): name for location, name in text.names.items()}
        start, end = tokens[0].start, _end_with_comment(self.text, tokens[-1].end)
        edits = [
            (token.start - start, token.end - start, names[token.start]) for token in tokens if token.start in names
        ]
        return edited(self.text[start:end], edits)


def _end_with_comment(text: str, end: int) -> int:
    """Offset of the end of words, including a comment that follows on their line."""
    comment = _LINE_COMMENT.match(text, end)
    return comment.end() if comment else end


def edited(text: str, edits: Sequence[tuple[int, int, str]]) -> str:
    """Text with each range from start to end replaced; ranges do not overlap."""
    pieces: list[str] = []
    offset = 0
    for start, end, new in sorted(edits, key=lambda edit: edit[:2]):
        pieces += (text[offset:start], new)
        offset = max(offset, end)
    return "".join((*pieces, text[offset:]))


def _line_starts(text: str) -> list[int]:
    """Offset of the first character of each line."""
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    return starts
