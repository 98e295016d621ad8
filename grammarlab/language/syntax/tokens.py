"""Tokenizer of rule files: from text to tokens and comments.

Every character of the text is in a token, a comment or white space. Characters that CGA does not have are reported
and, if their meaning is obvious (``->`` for ``-->``), repaired so that the rest of the file can be read.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import NamedTuple

from grammarlab.errors import Finding, Location

LINE_END = r"\r\n|[\n\r\x0b\x0c\x1c-\x1e\x85\u2028\u2029]"
"""Line ends of `str.splitlines`, so that findings count and show the same lines."""

NOT_LINE_END = r"[^\n\r\x0b\x0c\x1c-\x1e\x85\u2028\u2029]"
_IDENTIFIER = r"[^\W\d]\w*"

_PATTERNS = (
    ("LINE_END", LINE_END),
    ("SPACE", r"[^\S\n\r\x0b\x0c\x1c-\x1e\x85\u2028\u2029]+"),
    ("COMMENT", rf"(?://|\#){NOT_LINE_END}*|/\*(?s:.*?)(?:\*/|\Z)"),
    # A dot may end a symbol (``Roof.``) unless it begins an element-wise operator (``a.+b``).
    ("NAME", rf"{_IDENTIFIER}(?:\.{_IDENTIFIER})*(?:\.(?=-->)|\.(?![-+*%<>!]|/(?![/*])|==|&&|\|\|))?"),
    ("NUMBER", r"(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?"),
    ("STRING", r'"(?:\\.|[^"\\\n\r\x0b\x0c\x1c-\x1e\x85\u2028\u2029])*"?'),
    ("_ARROW", r"-->"),
    ("_EQUALS_COLON", r"=:"),
    ("_ASSIGN", r":="),
    ("OPERATOR", r"\.?(?:&&|\|\||==|!=|<=|>=|[*/%<>])"),
    ("WRONG_ARROW", r"-{1,8}>|[–—]-?>|→"),
    ("FAT_ARROW", r"=>"),
    ("MEMBER", rf"\.{_IDENTIFIER}(?:\.{_IDENTIFIER})*"),
    ("SIGN", r"\.?[-+]"),
    ("PREFIX", r"\.?!|['~]"),
    ("_LPAR", r"\("),
    ("RPAR", r"\)"),
    ("_LBRACE", r"\{"),
    ("CLOSE", r"\}"),
    ("_LBRACKET", r"\["),
    ("RBRACKET", r"\]"),
    ("_COMMA", r","),
    ("_BAR", r"\|"),
    ("_COLON", r":"),
    ("_SEMICOLON", r";"),
    ("_EQUALS", r"="),
    ("_AT", r"@"),
    ("CARET", r"\^"),
    ("UNKNOWN", r"."),
)
_SCANNER = re.compile("|".join(f"(?P<{name}>{pattern})" for name, pattern in _PATTERNS), re.DOTALL)


MAX_WORDS = 250_000
"""Largest number of words, signs and spaces of a file; the largest known rule files have a fifth of it."""
MAX_FINDINGS = 100
"""Number of errors after which reading stops."""


class Token(NamedTuple):
    """A word or sign of a rule file."""

    type: str
    value: str
    location: Location
    start: int
    """Offset of the first character in the text."""
    end: int
    """Offset past the last character."""


@dataclass(frozen=True, slots=True)
class Comment:
    """A comment, kept for the formatter."""

    text: str
    """Text with its marks: ``// like this``."""
    location: Location
    alone: bool
    """Whether only white space precedes it on its line."""


@dataclass(frozen=True, slots=True)
class TokenStream:
    """Tokens, comments and findings of a rule file."""

    tokens: tuple[Token, ...]
    comments: tuple[Comment, ...]
    findings: tuple[Finding, ...]


def tokenize(text: str, file: str = "<text>") -> TokenStream:
    """Tokens, comments and lexical errors of a rule file.

    Args:
        text: the whole rule file.
        file: name of the file, for locations.
    """
    tokens: list[Token] = []
    comments: list[Comment] = []
    findings: list[Finding] = []
    line, line_start, line_has_token = 1, 0, False
    for count, match in enumerate(_SCANNER.finditer(text)):
        kind = match.lastgroup
        if count >= MAX_WORDS or len(findings) >= MAX_FINDINGS:
            findings.append(_stopped(Location(line, match.start() - line_start + 1, 1, file)))
            break
        if kind == "SPACE":
            continue
        start, end = match.span()
        if kind == "LINE_END":
            line, line_start, line_has_token = line + 1, end, False
            continue
        value = match[0]
        if kind == "COMMENT":
            location = Location(line, start - line_start + 1, len(value.splitlines()[0]), file)
            comments.append(Comment(value, location, not line_has_token))
            if value.startswith("/*"):
                if not value.endswith("*/") or len(value) < 4:
                    findings.append(_unclosed_comment(location))
                breaks = list(re.finditer(LINE_END, value))
                if breaks:
                    line, line_start, line_has_token = line + len(breaks), start + breaks[-1].end(), False
            continue
        line_has_token = True
        token = Token(kind or "UNKNOWN", value, Location(line, start - line_start + 1, end - start, file), start, end)
        if kind in _REPAIRS:
            repaired, finding = _REPAIRS[kind](token)
            findings += finding
            if repaired is not None:
                tokens.append(repaired)
        else:
            tokens.append(token)
    return TokenStream(tuple(tokens), tuple(comments), tuple(findings))


def _stopped(location: Location) -> Finding:
    message = f"the file has too many words or too many errors: expected at most {MAX_WORDS:,} and {MAX_FINDINGS}"
    return Finding("error", "file-too-large", message, location, "it was not read further")


def _unclosed_comment(location: Location) -> Finding:
    return Finding(
        "error",
        "unclosed-comment",
        "this comment never ends: expected '*/' before the end of the file",
        location,
        "write '*/' where the comment ends, or '//' for a comment of one line",
    )


def _check_string(token: Token) -> tuple[Token | None, list[Finding]]:
    if len(token.value) > 1 and token.value.endswith('"') and not _ends_escaped(token.value):
        return token, []
    message = "this string never ends: expected '\"' before the end of the line"
    hint = 'write "..." on one line; a quote inside a string is written \\"'
    return token, [Finding("error", "unclosed-string", message, token.location, hint)]


def _ends_escaped(value: str) -> bool:
    body = value[1:-1]
    return (len(body) - len(body.rstrip("\\"))) % 2 == 1


def _wrong_arrow(token: Token) -> tuple[Token | None, list[Finding]]:
    message = f"expected '-->' between a rule's name and its body, found '{token.value}'"
    finding = Finding("error", "wrong-arrow", message, token.location, "write '-->'")
    return token._replace(type="_ARROW"), [finding]


_STAND_INS = {"&": ("OPERATOR", "&&"), "≤": ("OPERATOR", "<="), "≥": ("OPERATOR", ">="), "≠": ("OPERATOR", "!=")}


_HINTS = (
    ("“”„«»‘’`", 'write straight quotes: "..."'),
    ("?", "a choice is written case condition : a else : b, in parentheses inside an expression"),
    ("$", "a name begins with a letter or '_'"),
    ("\\", "a definition continues over line ends without a sign"),
)
"""Replacement for a character."""


def _unknown(token: Token) -> tuple[Token | None, list[Finding]]:
    if token.value in _STAND_INS:
        kind, replacement = _STAND_INS[token.value]
        message = f"CGA has no sign '{token.value}'"
        finding = Finding("error", "unknown-character", message, token.location, f"write '{replacement}'")
        return token._replace(type=kind, value=replacement), [finding]
    if token.value == "\ufeff":
        return None, []
    character = token.value if token.value.isprintable() else f"U+{ord(token.value):04X}"
    hint = next((hint for characters, hint in _HINTS if token.value in characters), "")
    message = f"the character '{character}' has no meaning in CGA"
    return None, [Finding("error", "unknown-character", message, token.location, hint)]


def _fat_arrow(token: Token) -> tuple[Token | None, list[Finding]]:
    hint = "write '>=' to compare, '-->' between a rule's name and its body"
    finding = Finding("error", "unknown-character", "CGA has no sign '=>'", token.location, hint)
    return token._replace(type="OPERATOR", value=">="), [finding]


_REPAIRS = {"FAT_ARROW": _fat_arrow, "STRING": _check_string, "WRONG_ARROW": _wrong_arrow, "UNKNOWN": _unknown}
