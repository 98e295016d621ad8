"""Text form of tree patterns, similar to CSS selectors; ``str(pattern)`` writes it.

    node       Symbol or *, then /parameters, @place, :branch, each optional
    A > B      a B that is a child of A
    A >> B     a B anywhere below A
    A[B, C]    an A with a child B and a child C: two conditions, each counted separately
    A[B + C]   an A with a child B whose next sibling is a C
    A[>> B]    an A with a B anywhere below it

A branch is written like ``:0`` or ``:1.0``, the branch at each level of the rule's choices from 0; ``:*`` is any node
that a rule rewrote. ``@2`` is the third successor in the text of the parent's rule.

>>> parse("Tower[Block:0 >> Glass:2 + Block:1 >> Glass:0]").below[0].run[1].branch
(1,)
>>> parse("Tower > ")
Traceback (most recent call last):
    ...
grammarlab.errors.UsageError: expected a symbol or *, found the end
  Tower >
          ^
"""

from __future__ import annotations

import re
from dataclasses import replace
from typing import NamedTuple, NoReturn

from grammarlab.errors import UsageError
from grammarlab.features.patterns.pattern import Below, Pattern

MAX_CHARACTERS = 4_000
"""Largest number of characters of a text."""

MAX_DEPTH = 60
"""Largest depth of a pattern in nodes."""

_TOKEN = re.compile(
    r"(?P<space>\s+)"
    r"|(?P<symbol>[^\W\d]\w*(?:\.[^\W\d]\w*)*\.?|\*)"
    r"|(?P<mark>/\d{1,9}|@\d{1,9}|:(?:\d{1,9}(?:\.\d{1,9})*|\*))"
    r"|(?P<sign>>>|[>\[\],+])"
    r"|(?P<wrong>.)",
    re.DOTALL,
)


class _Token(NamedTuple):
    kind: str
    text: str
    start: int


def parse(text: str) -> Pattern:
    """Pattern from a text.

    Raises:
        UsageError: If the text is not a pattern; it names the expected text and its place.

    >>> import grammarlab as gl
    >>> forest = gl.derive(gl.Grammar.parse("Lot --> split(x) { { ~2 : Window }* }"), 2, seed=1)
    >>> gl.count(forest, [gl.pattern("Lot > Window")]).tolist()
    [[10.0], [10.0]]
    """
    if len(text) > MAX_CHARACTERS:
        raise UsageError(f"the pattern has {len(text):,} characters: expected at most {MAX_CHARACTERS:,}")
    return _Parser(text).pattern()


class _Parser:
    def __init__(self, text: str) -> None:
        self._text = text
        tokens = [_Token(match.lastgroup or "", match[0], match.start()) for match in _TOKEN.finditer(text)]
        self._tokens = [token for token in tokens if token.kind != "space"]
        self._tokens.append(_Token("end", "", len(text)))
        self._next = 0

    def pattern(self) -> Pattern:
        start = self._peek()
        chain, child = self._chain(0)
        if child is not None:
            self._fail("a place (@) selects a child: expected it below another node", start)
        if self._peek().kind != "end":
            self._fail(f"expected '>', '>>', '[' or the end, found {_token_text(self._peek())}")
        return chain

    def _chain(self, depth: int) -> tuple[Pattern, int | None]:
        """``A > B >> C``, and the place of its first node."""
        if depth >= MAX_DEPTH:
            self._fail(f"expected at most {MAX_DEPTH} nodes one below the other")
        node, child = self._node()
        if self._take("["):
            conditions = [self._condition(depth + 1)]
            while self._take(","):
                conditions.append(self._condition(depth + 1))
            if not self._take("]"):
                self._fail(f"expected ']', ',' or '+', found {_token_text(self._peek())}")
            node = replace(node, below=tuple(conditions))
        if self._peek().text in {">", ">>"}:
            deep = self._advance().text == ">>"
            end, below_child = self._chain(depth + 1)
            node = replace(node, below=(*node.below, Below((end,), below_child, deep)))
        return node, child

    def _condition(self, depth: int) -> Below:
        deep = self._take(">>")
        if not deep:
            self._take(">")
        first, child = self._chain(depth)
        run = [first]
        while self._take("+"):
            start = self._peek()
            sibling, other_child = self._chain(depth)
            if other_child is not None:
                self._fail("only the first of adjacent siblings can have a place (@)", start)
            run.append(sibling)
        return Below(tuple(run), child, deep)

    def _node(self) -> tuple[Pattern, int | None]:
        token = self._peek()
        if token.kind != "symbol":
            self._fail(f"expected a symbol or *, found {_token_text(token)}")
        self._advance()
        parameters = self._mark("/")
        child = self._mark("@")
        branch = self._mark(":")
        if self._peek().kind == "mark":
            self._fail(
                f"found {_token_text(self._peek())}: expected marks once each, in the order /parameters @place :branch"
            )
        return (
            Pattern(
                None if token.text == "*" else token.text,
                None if parameters is None else int(parameters),
                None if branch is None else () if branch == "*" else tuple(map(int, branch.split("."))),
            ),
            None if child is None else int(child),
        )

    def _mark(self, sign: str) -> str | None:
        return self._advance().text[1:] if self._peek().kind == "mark" and self._peek().text[0] == sign else None

    def _peek(self) -> _Token:
        return self._tokens[self._next]

    def _advance(self) -> _Token:
        self._next += 1
        return self._tokens[self._next - 1]

    def _take(self, sign: str) -> bool:
        is_match = self._peek().kind == "sign" and self._peek().text == sign
        self._next += is_match
        return is_match

    def _fail(self, message: str, token: _Token | None = None) -> NoReturn:
        """Raise an error with a caret; of a long text only a part is shown."""
        position = (token or self._peek()).start
        begin = max(0, position - 60)
        excerpt = "".join(c if c.isprintable() else " " for c in self._text[begin : position + 40])
        raise UsageError(f"{message}\n  {excerpt}\n  {' ' * (position - begin)}^")


def _token_text(token: _Token) -> str:
    if token.kind == "wrong" and token.text in ":@/":
        hints = {":": "a branch such as :0, :1.0 or :*", "@": "a place such as @2", "/": "a number such as /2"}
        return f"{token.text!r} (expected {hints[token.text]})"
    return repr(token.text) if token.text else "the end"
