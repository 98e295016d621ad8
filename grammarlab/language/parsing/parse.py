"""Parser: from text to a syntax tree and findings."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, cast

from lark import Lark, UnexpectedToken
from lark import Token as LarkToken
from lark.lexer import Lexer

from grammarlab.errors import Finding, Location
from grammarlab.language.parsing.building import TreeBuilder
from grammarlab.language.parsing.fragments import MistakeError, Version
from grammarlab.language.parsing.mistakes import explain
from grammarlab.language.parsing.old_sizes import with_sizes
from grammarlab.language.parsing.outline import Chunk, outline
from grammarlab.language.parsing.tokens import MAX_FINDINGS, Comment, Token, tokenize
from grammarlab.language.syntax.tree import Definition, RuleFile

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
        file: its name, for locations.
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
    tokens = with_sizes(chunk.tokens)
    last = tokens[-1]
    end = Token("$END", "", last.location, last.end, last.end)
    state = _parser().parse_interactive()
    result: Any = None
    for position, token in enumerate((*tokens, end)):
        try:
            result = state.feed_token(cast(LarkToken, token))
        except UnexpectedToken:
            return explain(tokens, position, frozenset(state.accepts()))
        except MistakeError as mistake:
            return mistake.finding
    return result


def _reported_within(chunk: Chunk, findings: tuple[Finding, ...]) -> bool:
    """Whether a lexical finding in the definition already explains why it cannot be parsed."""
    first, last = chunk.tokens[0].location, chunk.tokens[-1].location
    return any(first <= finding.location <= last for finding in findings)


class _NoLexer(Lexer):
    """Lexer for a parser that receives tokens instead of text."""

    def __init__(self, lexer_conf: Any) -> None:
        del lexer_conf

    def lex(self, lexer_state: Any, parser_state: Any) -> Any:
        del lexer_state, parser_state
        return iter(())


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
