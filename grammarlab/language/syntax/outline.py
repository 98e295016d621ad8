"""Beginnings and ends of the definitions of a rule file.

CGA has no token that ends a definition: in ``A --> B C(x) --> D`` only the second arrow shows that ``C(x)`` starts a
rule. This look-ahead is unbounded, so it is done here, over tokens, before the parser reads one definition at a time.
The same pass reports brackets that do not match, and assigns words their types by place (``attr`` before a name, ``%``
before a colon). It bounds the depth of the syntax tree from above, so that a hostile file ends in a finding.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from grammarlab.errors import Finding, Location
from grammarlab.language.syntax.tokens import Token, TokenStream

_OPERAND_ENDS = frozenset({"NAME", "NUMBER", "RPAR", "RBRACKET", "BOOLEAN"})
_OPERATORS = frozenset({"OPERATOR", "SIGN"})
MAX_DEPTH = 240
"""Largest depth of a tree. It keeps passes over the tree below Python's recursion limit of 1,000 frames: a level of
brackets takes up to four frames, an operator in a chain one."""
_BRACKET_DEPTH, _CHOICE_DEPTH = 4, 2
"""Frames of passes over a level of brackets, and over a level of choices."""
_OPENERS = {"_LPAR": "(", "_LBRACE": "{", "_LBRACKET": "["}
_PARTNERS = {"RPAR": "_LPAR", "CLOSE": "_LBRACE", "RBRACKET": "_LBRACKET"}
_CLOSERS = {"_LPAR": ")", "_LBRACE": "}", "_LBRACKET": "]"}
_KEYWORDS = {
    "attr": ("ATTRIBUTE", ("NAME",)),
    "const": ("ATTRIBUTE", ("NAME",)),
    "import": ("IMPORT", ("NAME", "STRING")),
    "style": ("STYLE", ("NAME",)),
    "version": ("_VERSION", ("STRING", "NUMBER")),
}
"""Words that begin a definition, with the token types that must follow."""
_UNFINISHED = frozenset({"_EQUALS", "OPERATOR", "SIGN", "PREFIX", "_COMMA", "CARET", "_ASSIGN"})
"""Token types after which a definition cannot begin, because another token must follow."""


@dataclass(frozen=True, slots=True)
class Chunk:
    """Tokens of one definition."""

    tokens: tuple[Token, ...]
    damaged: bool = False
    """Whether a finding already reports its brackets as unmatched."""


@dataclass(frozen=True, slots=True)
class Outline:
    chunks: tuple[Chunk, ...]
    findings: tuple[Finding, ...]


def outline(words: TokenStream) -> Outline:
    """Splits the tokens of a rule file into definitions."""
    scan = _Scan(words.tokens)
    scan.run()
    return Outline(tuple(scan.chunks()), tuple(scan.findings))


class _Scan:
    """One pass over the tokens."""

    def __init__(self, tokens: tuple[Token, ...]) -> None:
        self.tokens = list(tokens)
        self.findings: list[Finding] = []
        self.partner: dict[int, int] = {}
        """Index of the opening bracket, by index of the closing one."""
        self.open: list[int] = []
        self.dropped: set[int] = set()
        self.damage: set[int] = set()
        """Indices of tokens whose definition has a bracket finding."""
        self.heads: set[int] = set()
        """Index of the beginning of the current definition, without its annotations."""
        self.annotation_ends: dict[int, int] = {}
        """Index of the ``@``, by index past the annotation."""
        self.chances: set[int] = set()
        """Index of the beginning of the percentage of an ``N% :`` branch."""
        self.in_condition = False
        self.depth_given: set[int] = set()
        """Opening braces of splitAndSetbackPerimeter whose current part already has its depth."""
        self.nesting = _Nesting()

    def run(self) -> None:
        for index, token in enumerate(self.tokens):
            step = _STEPS.get(token.type)
            if step is not None:
                step(self, index, token)
                self.nesting.follow(token.type, len(self.open))
                if self.nesting.depth > MAX_DEPTH:
                    # The rest is unreliable: skip it instead of reporting every bracket in it.
                    self.findings.append(_too_deep(token.location))
                    self.damage.add(index)
                    del self.tokens[index + 1 :]
                    return
        self._close_all(len(self.tokens))

    # Brackets

    def _opening(self, index: int, token: Token) -> None:
        self.open.append(index)

    def _opening_brace(self, index: int, token: Token) -> None:
        self.open.append(index)
        name = self.partner.get(index - 1, 0) - 1
        if name >= 0 and self.tokens[name].value == "scatter":
            self.tokens[name] = self.tokens[name]._replace(type="SCATTER")

    def _closing(self, index: int, token: Token) -> None:
        opening = _PARTNERS[token.type]
        if not any(self.tokens[i].type == opening for i in self.open):
            message = f"found '{token.value}' without an open '{_OPENERS[opening]}' before it"
            hint = f"delete it, or add the missing '{_OPENERS[opening]}'"
            self.findings.append(Finding("error", "unmatched-bracket", message, token.location, hint))
            self.dropped.add(index)
            self.damage.add(index)
            return
        while self.tokens[self.open[-1]].type != opening:
            self._report_unclosed(self.open.pop(), f"before '{token.value}' in line {token.location.line}")
        self.partner[index] = self.open.pop()

    def _report_unclosed(self, index: int, where: str) -> None:
        token = self.tokens[index]
        closer = _CLOSERS[token.type]
        message = f"this '{token.value}' is never closed: expected '{closer}' {where}"
        self.findings.append(
            Finding("error", "unclosed-bracket", message, token.location, f"add the missing '{closer}'")
        )
        self.damage.add(index)

    def _close_all(self, index: int) -> None:
        """Report every open bracket, because a definition begins at `index`, or the file ends."""
        if not self.open:
            return
        end = index == len(self.tokens)
        where = "before the end of the file" if end else f"before line {self.tokens[index].location.line}"
        self._report_unclosed(self.open[-1], where)
        self.open.clear()

    # Beginnings

    def _first_on_line(self, index: int) -> bool:
        return index == 0 or self.tokens[index - 1].location.line < self.tokens[index].location.line

    def _arrow(self, index: int, token: Token) -> None:
        head = self._head_before(index)
        if head is None:
            return
        if self.open:
            before = self.tokens[head - 1].type if head else ""
            if self.tokens[self.open[-1]].type == "_LPAR" and before in ("_COMMA", "_LPAR"):
                return  # an extension rule redefined inside an import
            self._close_all(head)
        self._begin(head)

    def _equals(self, index: int, token: Token) -> None:
        if self.open or self.in_condition:
            return
        head = self._head_before(index)
        if head is None:
            return
        before = self.tokens[head - 1].type if head else ""
        # The body of a rule or of a branch may be empty: after an arrow or a colon the line break decides.
        goes_on = before in ("_ARROW", "_COLON") and not self._first_on_line(head)
        if not goes_on and before not in _UNFINISHED | {"ATTRIBUTE", "_AT"}:
            self._begin(head)

    def _begin(self, head: int) -> None:
        self.in_condition = False
        self.nesting.restart()
        if head and self.tokens[head - 1].value in ("start", "extension") and not self._first_on_line(head):
            self.tokens[head - 1] = self.tokens[head - 1]._replace(type="MODIFIER")
            head -= 1
        self.heads.add(head)

    def _head_before(self, index: int) -> int | None:
        """Index of the name in ``name``, ``name(a, b)``, ``name(a, b) with (c := 1)`` that ends before `index`."""
        before = index - 1
        for _ in range(2):
            if before in self.partner and self.tokens[before].type == "RPAR":
                opening = self.partner[before]
                before = opening - 1
                if before >= 0 and self.tokens[before].value == "with" and self.tokens[opening + 2].type == "_ASSIGN":
                    self.tokens[before] = self.tokens[before]._replace(type="_WITH")
                    before -= 1
                    continue
            break
        if before < 0 or self.tokens[before].type != "NAME":
            return None
        return before

    def _name(self, index: int, token: Token) -> None:
        following = self.tokens[index + 1] if index + 1 < len(self.tokens) else None
        word = token.value
        if word in _KEYWORDS:
            kind, followers = _KEYWORDS[word]
            if following is not None and following.type in followers and not self._is_annotation_name(index):
                if self.open:
                    if not self._first_on_line(index):
                        return
                    self._close_all(index)
                self.tokens[index] = token._replace(type=kind)
                self.in_condition = False
                self.nesting.restart()
                self.heads.add(index)
        elif word == "case":
            self.tokens[index] = token._replace(type="CASE")
            self.in_condition = not self.open
            self.nesting.branch(self._follows_sign(index))
        elif word == "else":
            self.tokens[index] = token._replace(type="_ELSE")
            self.nesting.otherwise()
        elif word in ("true", "false"):
            self.tokens[index] = token._replace(type="BOOLEAN")
        elif word == "extends" and index >= 2 and self.tokens[index - 2].type == "STYLE":
            self.tokens[index] = token._replace(type="_EXTENDS")
        elif word in ("inline", "union", "subtract", "intersect"):
            self._inline(index, token)

    def _is_annotation_name(self, index: int) -> bool:
        return index > 0 and self.tokens[index - 1].type == "_AT"

    def _inline(self, index: int, token: Token) -> None:
        """Join ``inline`` and ``inline(strategy)`` into one token; a space is between the words of its value."""
        shape = [t.type for t in self.tokens[index + 1 : index + 5]]
        if shape[:1] in (["NAME"], ["_LBRACE"]):
            self.tokens[index] = token._replace(type="INLINE")
        elif shape in (["_LPAR", "NAME", "RPAR", "NAME"], ["_LPAR", "NAME", "RPAR", "_LBRACE"]):
            self.tokens[index] = token._replace(type="INLINE", value=f"{token.value} {self.tokens[index + 2].value}")
            self.dropped.update((index + 1, index + 2, index + 3))

    def _annotation_start(self, index: int, token: Token) -> None:
        if self.open:
            if not self._first_on_line(index):
                return
            self._close_all(index)
        self.in_condition = False
        self.nesting.restart()
        self.annotation_ends[index + 2] = index

    # Tokens whose type depends on their place

    def _colon(self, index: int, token: Token) -> None:
        if not self.open:
            self.in_condition = False
        if index and self.tokens[index - 1].value == "%" and index - 1 not in self.dropped:
            self.dropped.add(index - 1)
            start = _expression_start(self.tokens, self.partner, index - 2)
            self.chances.add(start)
            self.nesting.branch(self._follows_sign(start))
        elif self.open and self.open[-1] not in self.depth_given and self._parts_have_depths(self.open[-1]):
            self.depth_given.add(self.open[-1])
            self.tokens[index] = token._replace(type="_DEPTH")

    def _bar(self, index: int, token: Token) -> None:
        if self.open:
            self.depth_given.discard(self.open[-1])

    def _follows_sign(self, index: int) -> bool:
        """Whether a choice that begins at `index` is inside another one, or at the start of a body."""
        return index > 0 and self.tokens[index - 1].type in _UNFINISHED | {"_ARROW", "_COLON"}

    def _parts_have_depths(self, opening: int) -> bool:
        """Whether the brace at `opening` is the first of a splitAndSetbackPerimeter."""
        closing = opening - 1
        if self.tokens[opening].type != "_LBRACE" or closing not in self.partner:
            return False
        return self.tokens[self.partner[closing] - 1].value == "splitAndSetbackPerimeter"

    def _star(self, index: int, token: Token) -> None:
        """Join ``}`` and ``*`` into one token: repeated braces."""
        if token.value == "*" and index and self.tokens[index - 1].type == "CLOSE":
            closing = self.tokens[index - 1]
            self.tokens[index - 1] = closing._replace(value="}*", end=token.end)
            self.tokens[index] = token._replace(type="STAR")  # not an operator if a percentage follows
            self.dropped.add(index)

    def _caret(self, index: int, token: Token) -> None:
        """Join ``Shape^2``, the handle annotation's name for an ancestor, into one name."""
        if 0 < index < len(self.tokens) - 1:
            name, number = self.tokens[index - 1], self.tokens[index + 1]
            if name.type == "NAME" and number.type == "NUMBER":
                value = f"{name.value}^{number.value}"
                self.tokens[index - 1] = name._replace(value=value, end=number.end)
                self.dropped.update((index, index + 1))

    def _sign(self, index: int, token: Token) -> None:
        """Join ``x-``, the handle annotation's name for a direction, into one name."""
        following = self.tokens[index + 1].type if index + 1 < len(self.tokens) else ""
        before = self.tokens[index - 1] if index else token
        if before.type == "NAME" and before.value in ("x", "y", "z") and following in ("RPAR", "_COMMA"):
            self.tokens[index - 1] = before._replace(value=before.value + token.value, end=token.end)
            self.dropped.add(index)

    def _semicolon(self, index: int, token: Token) -> None:
        if not self.open or self.tokens[self.open[-1]].type != "_LBRACKET":
            message = "CGA has no ';': definitions and operations follow one another without a separator"
            self.findings.append(Finding("error", "semicolon", message, token.location, "delete it"))
            self.dropped.add(index)

    def _pass(self, index: int, token: Token) -> None:
        """No action except counting the nesting."""

    # Result

    def chunks(self) -> list[Chunk]:
        starts = sorted(self._with_annotations(head) for head in self.heads)
        if self.tokens and (not starts or starts[0] > 0):
            starts.insert(0, 0)
        ends = [*starts[1:], len(self.tokens)][: len(starts)]
        chunks = [self._chunk(start, end) for start, end in zip(starts, ends, strict=True)]
        return [chunk for chunk in chunks if chunk.tokens]

    def _chunk(self, start: int, end: int) -> Chunk:
        damaged = bool(self.damage) and any(start <= index < end for index in self.damage)
        return Chunk(tuple(self._words(start, end)), damaged)

    def _with_annotations(self, head: int) -> int:
        """Index of the first annotation of the definition that begins at `head`."""
        start = head
        while True:
            begin = self.annotation_ends.get(start)
            if begin is None and start - 1 in self.partner:
                begin = self.annotation_ends.get(self.partner[start - 1])
            if begin is None:
                return start
            start = begin

    def _words(self, start: int, end: int) -> list[Token]:
        if not self.dropped and not self.chances:
            return self.tokens[start:end]
        result: list[Token] = []
        for index in range(start, end):
            if index in self.chances:
                result.append(self.tokens[index]._replace(type="CHANCE"))
            if index not in self.dropped:
                result.append(self.tokens[index])
        return result


_STEPS = {
    "NAME": _Scan._name,
    "_LPAR": _Scan._opening,
    "_LBRACE": _Scan._opening_brace,
    "_LBRACKET": _Scan._opening,
    "RPAR": _Scan._closing,
    "CLOSE": _Scan._closing,
    "RBRACKET": _Scan._closing,
    "_ARROW": _Scan._arrow,
    "_EQUALS": _Scan._equals,
    "_COLON": _Scan._colon,
    "_BAR": _Scan._bar,
    "_COMMA": _Scan._pass,
    "SIGN": _Scan._sign,
    "PREFIX": _Scan._pass,
    "OPERATOR": _Scan._star,
    "_AT": _Scan._annotation_start,
    "CARET": _Scan._caret,
    "_SEMICOLON": _Scan._semicolon,
}


class _Nesting:
    """Nesting of the tokens of a definition. Its depth is an upper bound, exact up to a small factor."""

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Reset at the beginning of a definition."""
        self._levels = [_OpenBracket()]
        self._outer = 0
        """Depth of all levels except the innermost."""

    @property
    def depth(self) -> int:
        return self._outer + self._levels[-1].depth

    def follow(self, kind: str, brackets: int) -> None:
        """Add a token.

        Args:
            kind: type of the token.
            brackets: number of open brackets after it.
        """
        while len(self._levels) <= brackets:
            self._outer += _BRACKET_DEPTH + self._levels[-1].depth
            self._levels.append(_OpenBracket())
        while len(self._levels) > brackets + 1:
            self._levels.pop()
            self._outer -= _BRACKET_DEPTH + self._levels[-1].depth
        level = self._levels[-1]
        if kind in ("OPERATOR", "SIGN", "PREFIX"):
            level.operators += 1
        elif kind in ("_COMMA", "_BAR", "_SEMICOLON"):
            level.operators = 0
            level.choices.clear()
        elif kind in ("_COLON", "_EQUALS", "_ARROW"):
            level.operators = 0

    def branch(self, nested: bool) -> None:
        """Add a ``case`` or ``N%``; `nested` if it is the first of its choice."""
        level = self._levels[-1]
        level.operators = 0
        if nested:
            level.choices.append(False)
        else:
            self._drop_complete(level)

    def otherwise(self) -> None:
        """Add an ``else``: the last branch of the innermost choice without one."""
        level = self._levels[-1]
        level.operators = 0
        self._drop_complete(level)
        if level.choices:
            level.choices[-1] = True

    @staticmethod
    def _drop_complete(level: _OpenBracket) -> None:
        while level.choices and level.choices[-1]:
            level.choices.pop()


@dataclass(slots=True)
class _OpenBracket:
    """Open choices and operators between two brackets."""

    operators: int = 0
    """Operators since the last separator of expressions: a chain of n operators is a tree of depth n."""
    choices: list[bool] = field(default_factory=list)
    """Choices around the last branch; True if their ``else`` was read and they are complete."""

    @property
    def depth(self) -> int:
        return self.operators + _CHOICE_DEPTH * len(self.choices)


def _too_deep(location: Location) -> Finding:
    """Finding for a definition that exceeds `MAX_DEPTH`."""
    return Finding(
        "error",
        "too-deep",
        f"nested too deeply: expected at most {MAX_DEPTH // _BRACKET_DEPTH} brackets or {MAX_DEPTH} operators deep",
        location,
        "move inner parts into separate rules or functions; the file was not read further",
    )


def _expression_start(tokens: Sequence[Token], partner: Mapping[int, int], index: int) -> int:
    """Index of the first token of the expression whose last token is at `index`.

    No token separates a percentage from the operation before it: in ``A (b)% : C`` only the space shows that the
    percentage is ``(b)`` and not ``A(b)``.

    Args:
        tokens: the tokens of the file.
        partner: index of the opening bracket by index of the closing one.
        index: index of the first token, at least -1.
    """
    while True:
        index = max(_operand_start(tokens, partner, index), 0)
        while index and _is_prefix_sign(tokens, index - 1):
            index -= 1
        if index == 0 or tokens[index - 1].type not in _OPERATORS:
            return index
        index -= 2


def _operand_start(tokens: Sequence[Token], partner: Mapping[int, int], index: int) -> int:
    """Step over ``name``, ``name(...)``, ``(...)``, ``[...]`` and ``name[...][...]``."""
    while index in partner and tokens[index].type in ("RPAR", "RBRACKET"):
        bracket = tokens[index].type
        index = partner[index]
        before = tokens[index - 1] if index else None
        if before is None or before.end != tokens[index].start:
            return index
        if before.type == "NAME":
            return index - 1
        if bracket == "RPAR" or before.type not in ("RPAR", "RBRACKET"):
            return index
        index -= 1
    return index


def _is_prefix_sign(tokens: Sequence[Token], index: int) -> bool:
    if tokens[index].type == "PREFIX":
        return True
    return tokens[index].type == "SIGN" and (index == 0 or tokens[index - 1].type not in _OPERAND_ENDS)
