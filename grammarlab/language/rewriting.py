"""Edits of rule files: changed definitions are rewritten, everything else keeps its text, comments and order.

A rule may be replaced by copies under other names, with renamed successors, new percentages, and branches that are
left out or repeated.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias, TypeVar

from grammarlab.errors import Location
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax.outline import outline
from grammarlab.language.syntax.syntax_tree import Attribute, Case, Choice, Rule, Stochastic, Style
from grammarlab.language.syntax.tokens import LINE_END, NOT_LINE_END, Token, tokenize

T = TypeVar("T")
Path: TypeAlias = tuple[int, ...]
"""Path in the choices of a rule: the number of the branch at each level, from the top."""

_LEAST_ELSE = 1e-3
"""Smallest probability of an ``else``; since it is the rest to 100, a less probable one would lose digits."""
_HEADS = frozenset({"CASE", "CHANCE", "_ELSE"})
_OPENING = frozenset({"_LPAR", "_LBRACE", "_LBRACKET"})
_CLOSING = frozenset({"RPAR", "CLOSE", "RBRACKET"})
_LINE_END = re.compile(LINE_END)
_LINE_COMMENT = re.compile(rf"(?:(?!{LINE_END})\s)*(?://|#){NOT_LINE_END}*")
_FUSED = re.compile(r"[\w.][\w.([]|[)\]]\[")
"""Ends of two texts that would be read as one word, or as a name and its arguments."""
_EMPTY = ("-->", ":")
"""Ends of rules without operations: what follows on their line may be read as these."""
_FINISH = "case true : NIL else : NIL"
"""Ends percentages without ``else`` inside ``case true``: these sum to anything, so no ``else`` of theirs means the
same."""
_WIDTH = 120


class _Edit(NamedTuple):
    """A change of one range of the text."""

    start: int
    end: int
    text: str
    above: bool = False
    """Whether an empty line separates it from the text before."""
    below: bool = False
    """Whether an empty line separates it from the text behind."""
    is_open: bool = False
    """Whether a line end must follow: it ends with a line comment or without operations, or took the line end before
    it away."""


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
        edits: list[_Edit] = []
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
            edits.insert(0, _Edit(first, first, "".join(f"{attribute}\n\n" for attribute in new_attributes)))
        return _assembled(self.text, edits)

    def _rule(self, number: int, rule: Rule, copies: Sequence[RuleCopy]) -> _Edit:
        start, end = self.spans[number][0], _end_with_comment(self.text, self.spans[number][1])
        if not copies:
            begin = self._begin_with_comments(number)
            before = self.text[:begin].rstrip()
            is_open = bool(before) and (_has_line_end(self.text[begin:start]) or before.endswith(_EMPTY))
            return _Edit(begin, end, "", is_open=is_open)
        writer = _Writer(self.text, rule, self._tokens(number), self._offset)
        marked = any(copy.start for copy in copies)
        text = "\n\n".join(writer.copy(copy, marked) for copy in copies)
        # A comment above a rule is not read as one about the rule before it.
        is_apart = bool(copies[0].comment) and not self._is_below_comment(number)
        return _Edit(start, end, text, is_apart, len(copies) > 1, writer.is_open(copies[-1]))

    def _is_below_comment(self, number: int) -> bool:
        """Whether a comment about a definition is directly above it."""
        return self._begin_about(number)[0] < self.spans[number][0]

    def _value(self, number: int, value: str) -> _Edit:
        """Edit that changes the value of an attribute."""
        name = self._offset(self.definitions[number].location)
        equals = next(token for token in self._tokens(number) if token.start > name and token.type == "_EQUALS")
        return _Edit(equals.end, self.spans[number][1], value)

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
        start, above = self._begin_about(number)
        line = bisect_right(self.line_starts, start)
        start = self.line_starts[line - 1]
        if line > 1 and not self.text[self.line_starts[line - 2] : start].strip():
            start = self.line_starts[line - 2]
        return max(start - min(start, 1), above)

    def _begin_about(self, number: int) -> tuple[int, int]:
        """Offset of a definition or of the first comment about it, and the end of the words and comments before."""
        start = self.spans[number][0]
        above = self.spans[number - 1][1] if number else 0
        words = tokenize(self.text[above:start])
        line_above = bisect_right(self.line_starts, above)
        # Only the version may be in between; it belongs to no definition.
        floor = above + max((word.end for word in words.tokens), default=0)
        for comment in reversed(words.comments):
            line = line_above + comment.location.line - 1
            begin = (above if line == line_above else self.line_starts[line - 1]) + comment.location.column - 1
            end = begin + len(comment.text)
            # Comments at the top belong to the file, comments beside a definition to that definition.
            is_about = comment.alone and line > line_above and begin >= floor
            if not is_about or len(_LINE_END.findall(self.text, end, start)) > 1:
                return start, max(floor, end)
            start = begin
        return start, floor


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
        self.openings: dict[Path, str] = {}
        """Comment behind the arrow or colon before each choice, on its line."""
        self.gaps: dict[Path, str] = {}
        """White space and comments behind it."""
        self.ends: dict[Path, Sequence[Token]] = {}
        """Words of the operations of each branch without further choices."""
        self.colons: dict[Path, int] = {}
        """Offset of the end of the colon or arrow before these."""
        self.unfinished: set[Path] = set()
        """Choices by percentages without ``else``, of which any percentage or ``else`` behind them would be a part."""
        self._cut(rule.body, arrow + 1, ())
        first = next((token for token in tokens[arrow + 1 :] if token.location.line > self.arrow.location.line), None)
        before = text[: first.start].rpartition("\n")[2] if first is not None else ""
        self.indent = before if before and not before.strip() else "    "

    def copy(self, copy: RuleCopy, one_start: bool) -> str:
        """Text of a copy; with ``one_start``, only marked copies are start rules."""
        comment = f"// {copy.comment}\n" if copy.comment else ""
        if copy.name != self.rule.name:
            head = copy.name + self.text[self.name.end : self.arrow.end]
        else:
            head = self._unmarked() if one_start else self.text[self.tokens[0].start : self.arrow.end]
        if one_start and copy.start:
            head = f"@StartRule\n{head}"
        if copy.body is None:
            last = self.tokens[-1].end
            return comment + head + self.text[self.arrow.end : _end_with_comment(self.text, last)]
        text = self._body(copy.body, self.indent, ())
        if isinstance(copy.body, Text):
            text = self._gap(copy.body, head, text) + text
        return comment + head + text

    def is_open(self, copy: RuleCopy) -> bool:
        """Whether a line end must follow a copy: it ends with a comment, or its body has become empty."""
        last = self.tokens[-1]
        if copy.body is None:
            return _end_with_comment(self.text, last.end) > last.end
        is_empty = isinstance(copy.body, Text) and not self.ends[copy.body.path]
        return self._is_open(copy.body) or (is_empty and not last.value.endswith(_EMPTY))

    def _is_open(self, body: Body) -> bool:
        """Whether the text of a body ends with a line comment."""
        if isinstance(body, Text):
            last = self._last(body.path)
            return _end_with_comment(self.text, last) > last
        if isinstance(body, Same):
            return not body.closed and self._is_open(body.branches[-1])
        return self._is_open(body.branches[-1][1])

    def _last(self, path: Path) -> int:
        """Offset of the end of the operations of a branch, or of its colon if it has none."""
        return self.ends[path][-1].end if self.ends[path] else self.colons[path]

    def _unmarked(self) -> str:
        """The head of the rule without the mark of a start rule."""
        start, end = self.tokens[0].start, self.arrow.end
        cuts: list[tuple[int, int, str]] = []
        head = [token for token in self.tokens if token.end <= end]
        for at, name, behind in zip(head, head[1:], head[2:], strict=False):
            is_mark = at.type == "_AT" and name.value.lower() == "startrule"
            if is_mark or (at.type == "MODIFIER" and at.value == "start"):
                last = name.end if is_mark else at.end
                following = behind.start if is_mark else name.start
                space = following if not self.text[last:following].strip() else last
                cuts.append((at.start - start, space - start, ""))
        return edited(self.text[start:end], cuts)

    def _gap(self, body: Text, head: str, text: str) -> str:
        """Text between the head of a rule and its only sequence of operations."""
        if not body.path:
            return self.text[self.arrow.end : self.ends[()][0].start] if self.ends[()] else ""
        remarks = self._remarks((), body.path, set(), self.indent) + self._remark_behind(body.path, self.indent)
        if remarks:
            return f"{remarks}\n{self.indent}"
        flat = "\n" not in text and len(head.rpartition("\n")[2]) + 1 + len(text) <= _WIDTH
        return " " if flat else f"\n{self.indent}"

    def _cut(self, choice: Choice, index: int, path: Path) -> int:
        """Find the heads and ends of a choice that begins at a token; returns the index past it."""
        if not isinstance(choice, Case | Stochastic):
            end = self._next(index, _HEADS)
            self.ends[path] = self.tokens[index:end]
            self.colons[path] = self.tokens[index - 1].end
            return end
        self.openings[path] = self._comment_behind(self.tokens[index - 1].end)
        if isinstance(choice, Stochastic) and choice.percentages[-1] is not None:
            self.unfinished.add(path)
        for i, branch in enumerate(choice.branches):
            colon = self._next(index, frozenset({"_COLON"}))
            before, head, behind = self.tokens[index - 1], self.tokens[index], self.tokens[colon]
            self.heads[*path, i] = self.text[head.start : behind.end]
            # A comment behind the operations of the branch before belongs to these.
            self.leads[*path, i] = self.text[_end_with_comment(self.text, before.end) : head.start]
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

    def _comment_behind(self, end: int) -> str:
        """The line comment behind a word, with the space before it."""
        return self.text[end : _end_with_comment(self.text, end)]

    def _body(self, body: Body, indent: str, outer: Path) -> str:
        """Text of a body; of choices with what is before the first branch.

        Args:
            body: the body.
            indent: white space before its branches, where these are on new lines.
            outer: the branch whose head is before it; the comments on the way from there are before its own.
        """
        if isinstance(body, Text):
            return self._operations(body)
        if isinstance(body, Same):
            places = [(*body.path, i) for i in range(len(body.branches))]
            heads, bodies = [self.heads[place] for place in places], list(body.branches)
            leads = self._own_leads(places, indent, outer)
        elif isinstance(body, Conditions):
            bodies, places = [branch for _, branch in body.branches], [outer] * len(body.branches)
            heads = [*(f"case {condition} :" for condition, _ in body.branches[:-1]), "else :"]
            leads = [f"\n{indent}"] * len(bodies)
        else:
            bodies = [branch for _, branch in body.branches]
            heads = _percentages([probability for probability, _ in body.branches])
            places = [self._place(branch, outer) for branch in bodies]
            leads = self._own_leads(places, indent, outer) if self._is_one(places) else []
            leads = leads or self._new_leads(places, indent, outer)
        texts = [self._inner(inner, indent, place) for inner, place in zip(bodies, places, strict=True)]
        is_open = [self._is_open(inner) for inner in bodies]
        if isinstance(body, Same) and body.closed:
            heads, leads, texts, is_open = (
                [*heads, "else :"],
                [*leads, leads[-1]],
                [*texts, " NIL"],
                [*is_open, False],
            )
        for i, (inner, head) in enumerate(zip(bodies, heads[1:], strict=False)):
            if self._is_unfinished(inner) and not head.startswith("case"):
                texts[i] = f" case true :{texts[i]}\n{indent}{_FINISH}"
                is_open[i] = False
        written, follows_comment = "", False
        for lead, head, text, is_commented in zip(leads, heads, texts, is_open, strict=True):
            written = _joined(written, lead + head, follows_comment, f"\n{indent}") + text
            follows_comment = is_commented
        return written

    def _is_unfinished(self, body: Body) -> bool:
        """Whether a percentage or ``else`` behind a body would be read as a part of it."""
        if isinstance(body, Text):
            return False
        if isinstance(body, Same):
            return body.path in self.unfinished or (not body.closed and self._is_unfinished(body.branches[-1]))
        return self._is_unfinished(body.branches[-1][1])

    def _place(self, body: Body, outer: Path) -> Path:
        """The branch or choice that a body is made from; the one around it for a new choice."""
        return body.path if isinstance(body, Text | Same) else outer

    def _is_one(self, places: Sequence[Path]) -> bool:
        """Whether these are some branches of one choice, in its order."""
        is_one = len({place[:-1] for place in places}) == 1
        return is_one and list(places) == sorted(set(places)) and all(place in self.leads for place in places)

    def _own_leads(self, places: Sequence[Path], indent: str, outer: Path) -> list[str]:
        """What is before the heads of some branches of one choice, as it is in the text."""
        choice = places[0][:-1]
        before, opening = self._remarks(outer, choice, set(), indent), self.openings[choice]
        before += f"\n{indent}{opening.strip()}" if before and opening else opening
        first, *others = [self.leads[place] for place in places]
        return [_joined(before, first, bool(before), f"\n{indent}"), *others]

    def _new_leads(self, places: Sequence[Path], indent: str, outer: Path) -> list[str]:
        """What is before the heads of branches of several choices, or in a new order: the comments, once."""
        written: set[Path] = set()
        return [f"{self._remarks(outer, place, written, indent)}\n{indent}" for place in places]

    def _remarks(self, outer: Path, inner: Path, written: set[Path], indent: str) -> str:
        """The comments before the heads from one branch, without its own, to one inside it, each on a new line.

        Args:
            outer: the one branch.
            inner: the other one.
            written: branches whose comments are written; those on the way are added.
            indent: white space before each line.
        """
        remarks = ""
        for depth in range(len(outer) + 1, len(inner) + 1):
            if inner[:depth] not in written:
                written.add(inner[:depth])
                choice = inner[: depth - 1]
                opening = "" if (*choice, -1) in written else self.openings[choice].strip()
                written.add((*choice, -1))
                remarks += "".join(f"\n{indent}{text}" for text in (opening, self.leads[inner[:depth]].strip()) if text)
        return remarks

    def _remark_behind(self, path: Path, indent: str) -> str:
        """The comments between the head of a branch and its operations, on a new line."""
        remark = self.gaps.get(path, "").strip() if self.ends[path] else ""
        return f"\n{indent}{remark}" if remark else ""

    def _inner(self, body: Body, indent: str, outer: Path) -> str:
        """Text behind the head of a branch."""
        deeper = indent + ("\t" if "\t" in self.indent else "    ")
        text = self._body(body, deeper, outer)
        if not isinstance(body, Text):
            return text
        if not self.ends[body.path]:
            text = f" [ ]{text}"
        if body.path == outer:
            return self.gaps.get(body.path, " ") + text if self.ends[body.path] else text
        remarks = self._remarks(outer, body.path, set(), deeper) + self._remark_behind(body.path, deeper)
        return f"{remarks}\n{deeper}{text.lstrip()}" if remarks else f" {text.lstrip()}"

    def _operations(self, text: Text) -> str:
        """Text of operations with the line comment behind them; only that if there are none."""
        tokens = self.ends[text.path]
        if not tokens:
            return self._comment_behind(self.colons[text.path])
        names = {self.offset(location): name for location, name in text.names.items()}
        start, end = tokens[0].start, _end_with_comment(self.text, tokens[-1].end)
        edits = [
            (token.start - start, token.end - start, names[token.start]) for token in tokens if token.start in names
        ]
        return edited(self.text[start:end], edits)


def _joined(before: str, text: str, is_open: bool, line_end: str) -> str:
    """Two texts, one behind the other, so that their words and comments stay what they are.

    Args:
        before: the first text.
        text: the second text.
        is_open: whether the first one ends with a line comment, or must be followed by a line end for another reason.
        line_end: what to insert if it is missing.
    """
    if is_open and not _has_line_end(text[: len(text) - len(text.lstrip())]):
        return before + line_end + text.lstrip()
    return f"{before} {text}" if _FUSED.fullmatch(before[-1:] + text[:1]) else before + text


def _has_line_end(text: str) -> bool:
    return _LINE_END.search(text) is not None


def _assembled(text: str, edits: Sequence[_Edit]) -> str:
    """Text with all edits; they do not overlap."""
    result = _Result()
    offset = 0
    for edit in sorted(edits, key=lambda edit: edit[:2]):
        result.add(text[offset : edit.start])
        result.is_apart |= edit.above
        result.add(edit.text)
        result.is_apart |= edit.below
        result.is_open |= edit.is_open
        offset = max(offset, edit.end)
    result.add(text[offset:])
    return "".join((*result.pieces, result.space))


class _Result:
    """A text made of pieces."""

    def __init__(self) -> None:
        self.pieces: list[str] = []
        self.space = ""
        """White space at the end, behind the pieces."""
        self.is_apart = False
        """Whether an empty line must follow, if text does."""
        self.is_open = False
        """Whether a line end must follow, if text does."""

    def add(self, piece: str) -> None:
        """Add a piece, with the space that is missing before it."""
        words = piece.strip()
        if not words:
            self.space += piece
            return
        begin = piece.index(words)
        space = self.space + piece[:begin]
        if self.is_apart and self.pieces:
            missing = 2 - len(_LINE_END.findall(space))
            space = space.rstrip(" \t") + "\n" * missing if missing > 0 else space
        before = self.pieces[-1][-1:] if self.pieces else ""
        self.pieces.append(_joined(before, space + words, self.is_open, "\n")[len(before) :])
        self.space, self.is_apart, self.is_open = piece[begin + len(words) :], False, False


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
