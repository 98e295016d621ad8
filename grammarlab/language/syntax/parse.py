"""Parser: from text to a syntax tree and findings.

Older rule files have parts of ``split`` without a size: ``split(x) { 1 : A | split(y) { ~1 : B }* }``. Such a part
takes the remaining length. Only a part that begins with a block can be distinguished from a size.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, cast

from lark import Lark, UnexpectedToken
from lark import Token as LarkToken
from lark.lexer import Lexer

from grammarlab.errors import Finding, Location
from grammarlab.language.syntax.outline import Chunk, outline
from grammarlab.language.syntax.syntax_tree import Definition, RuleFile
from grammarlab.language.syntax.tokens import MAX_FINDINGS, Comment, Token, tokenize
from grammarlab.language.syntax.tree_building import MistakeError, TreeBuilder, Version

_OPEN, _SHUT = frozenset({"_LPAR", "_LBRACE", "_LBRACKET"}), frozenset({"RPAR", "CLOSE", "RBRACKET"})
MAX_CHARACTERS = 4 * 2**20
"""Largest number of characters of a rule file."""


@dataclass(frozen=True, slots=True)
class Parsed:
    """A parsed rule file."""

    tree: RuleFile
    """Definitions without errors."""
    findings: tuple[Finding, ...]
    """Syntax errors in the order of the text; empty when the tree is the whole file."""
    comments: tuple[Comment, ...]
    broken: frozenset[str]
    """Names in definitions with errors, so that uses of these names are not reported."""


def parse(text: str, file: str = "<text>") -> Parsed:
    """Syntax tree of a rule file, and findings about text that is not CGA.

    Args:
        text: the whole rule file.
        file: name of the file, for locations.
    """
    if len(text) > MAX_CHARACTERS:
        message = f"the file has {len(text):,} characters: expected at most {MAX_CHARACTERS:,}"
        finding = Finding("error", "file-too-large", message, Location(file=file))
        return Parsed(RuleFile("", ()), (finding,), (), frozenset())
    words = tokenize(text, file)
    if any(finding.code == "file-too-large" for finding in words.findings) and len(words.findings) < MAX_FINDINGS:
        # A text that was not read to its end has false errors.
        return Parsed(RuleFile("", ()), words.findings, words.comments, frozenset())
    plan = outline(words)
    findings = [*words.findings, *plan.findings]
    version = ""
    definitions: list[Definition] = []
    spans: list[tuple[int, int]] = []
    broken: set[str] = set()
    for chunk in plan.chunks:
        node = _parse_definition(chunk)
        if isinstance(node, Finding):
            if not _reported_within(chunk, words.findings):
                findings.append(node)
        elif isinstance(node, Version):
            version = node.text
        elif node is not None:
            definitions.append(node)
            spans.append((chunk.tokens[0].start, chunk.tokens[-1].end))
            continue
        if not isinstance(node, Version):
            broken.update(token.value for token in chunk.tokens if token.type == "NAME")
    findings.sort(key=lambda finding: finding.location)
    tree = RuleFile(version, tuple(definitions), tuple(spans), location=Location(file=file))
    return Parsed(tree, tuple(findings[:MAX_FINDINGS]), words.comments, frozenset(broken))


def _parse_definition(chunk: Chunk) -> Definition | Version | Finding | None:
    """The definition, or a finding about it; None if another finding already explains the error."""
    if chunk.damaged:
        return None
    tokens = _with_sizes(chunk.tokens)
    last = tokens[-1]
    end = Token("$END", "", last.location, last.end, last.end)
    state = _parser().parse_interactive()
    result: Any = None
    for position, token in enumerate((*tokens, end)):
        try:
            result = state.feed_token(cast(LarkToken, token))
        except UnexpectedToken:
            from grammarlab.language.syntax.mistakes import explain  # noqa: PLC0415  # most files have none

            return explain(tokens, position, frozenset(state.accepts()))
        except MistakeError as mistake:
            return mistake.finding
    return result


def _with_sizes(tokens: Sequence[Token]) -> list[Token]:
    """Words of a definition, with ``~1 :`` before parts of ``split`` that have no size."""
    if not any(token.value == "split" for token in tokens):
        return list(tokens)
    partners = _partners(tokens)
    is_split = [False]
    result: list[Token] = []
    for index, token in enumerate(tokens):
        begins = index > 0 and tokens[index - 1].type in ("_LBRACE", "_BAR")
        if is_split[-1] and begins and _is_block_alone(tokens, index, partners):
            mark = Token("PREFIX", "~", token.location, token.start, token.start)
            result += [mark, mark._replace(type="NUMBER", value="1"), mark._replace(type="_COLON", value=":")]
        if token.type in _OPEN:
            is_group = token.type == "_LBRACE" and (
                _follows_split(tokens, index, partners) or (is_split[-1] and begins)
            )
            is_split.append(is_group)
        elif token.type in _SHUT and len(is_split) > 1:
            is_split.pop()
        result.append(token)
    return result


def _partners(tokens: Sequence[Token]) -> dict[int, int]:
    """Index of the matching bracket, by index of each bracket."""
    partners: dict[int, int] = {}
    stack: list[int] = []
    for index, token in enumerate(tokens):
        if token.type in _OPEN:
            stack.append(index)
        elif token.type in _SHUT and stack:
            first = stack.pop()
            partners[first], partners[index] = index, first
    return partners


def _is_block_alone(tokens: Sequence[Token], index: int, partners: dict[int, int]) -> bool:
    """Whether a whole part is an operation with a block."""
    if tokens[index].type != "NAME":
        return False
    following = index + 1
    if following < len(tokens) and tokens[following].type == "_LPAR":
        following = partners.get(following, len(tokens)) + 1
    if following >= len(tokens) or tokens[following].type != "_LBRACE":
        return False
    after = partners.get(following, len(tokens)) + 1
    return after < len(tokens) and tokens[after].type in ("_BAR", "CLOSE")


def _follows_split(tokens: Sequence[Token], index: int, partners: dict[int, int]) -> bool:
    """Whether the brace at a place opens the block of a ``split(...)``."""
    before = partners.get(index - 1, 0)
    return before > 0 and tokens[index - 1].type == "RPAR" and tokens[before - 1].value == "split"


@cache
def _parser() -> Lark:
    grammar = Path(__file__).with_name("cga.lark").read_text(encoding="utf-8")
    return Lark(
        grammar,
        parser="lalr",
        lexer=_NoLexer,
        start="definition",
        transformer=TreeBuilder(),
        maybe_placeholders=False,
    )


class _NoLexer(Lexer):
    """Lexer for a parser that receives tokens instead of text."""

    def __init__(self, lexer_conf: Any) -> None:
        del lexer_conf

    def lex(self, lexer_state: Any, parser_state: Any) -> Any:
        del lexer_state, parser_state
        return iter(())


def _reported_within(chunk: Chunk, findings: tuple[Finding, ...]) -> bool:
    """Whether a lexical finding in the definition already explains why it cannot be parsed."""
    first, last = chunk.tokens[0].location, chunk.tokens[-1].location
    return any(first <= finding.location <= last for finding in findings)
