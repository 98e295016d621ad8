"""The grammar by which editors colour CGA: `python -m docs.gen.editors` writes it to `editors/vscode`.

It is a TextMate grammar, which Visual Studio Code and others read. Its words are those of the language's tables.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from pathlib import Path

from grammarlab.language import highlighting as cga

FILE = Path(__file__).parents[2] / "editors" / "vscode" / "syntaxes" / "cga.tmLanguage.json"
_GROUPS = (
    ("storage.type", cga.DEFINITIONS),
    ("keyword.control", cga.CONTROL),
    ("constant.language", cga.CONSTANTS),
    ("variable.language", cga.ATTRIBUTES),
    ("support.function.operation", cga.OPERATIONS),
    ("support.function", cga.FUNCTIONS),
    ("support.constant", cga.SELECTORS),
)
"""Names of scopes, and the words that they have."""


def grammar() -> dict[str, object]:
    """The TextMate grammar."""
    identifier = r"[A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*"
    patterns: list[dict[str, object]] = [  # ty: ignore[invalid-assignment]
        {"name": "comment.line.cga", "match": r"(?://|#).*$"},
        {"name": "comment.block.cga", "begin": r"/\*", "end": r"\*/"},
        {"name": "string.quoted.double.cga", "match": r'"(?:\\.|[^"\\])*"?'},
        {"name": "storage.modifier.annotation.cga", "match": r"@\s*\w+"},
        {
            "name": "entity.name.function.rule.cga",
            "match": rf"\b(?!with\b){identifier}(?=\s*(?:\([^(){{}}]*\)\s*)?-->)",
        },
        {
            "match": rf"\b(attr|const)\s+({identifier})",
            "captures": {"1": {"name": "storage.type.cga"}, "2": {"name": "variable.other.cga"}},
        },
        *({"name": f"{scope}.cga", "match": alternatives(words)} for scope, words in _GROUPS),
        {"name": "constant.numeric.cga", "match": r"(?<![\w.])(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?"},
        {"name": "keyword.operator.cga", "match": r"-->|[-+*/%<>=!&|:'~]"},
    ]
    return {
        "$schema": "https://raw.githubusercontent.com/martinring/tmlanguage/master/tmlanguage.json",
        "name": "CGA",
        "scopeName": "source.cga",
        "fileTypes": ["cga"],
        "patterns": patterns,
    }


def alternatives(words: Iterable[str]) -> str:
    """A pattern of whole words, longer ones first."""
    longest_first = sorted(words, key=lambda word: (-len(word), word))
    return rf"{cga.NOT_BEFORE}(?:{'|'.join(map(re.escape, longest_first))}){cga.NOT_AFTER}"


def text() -> str:
    """The file."""
    return json.dumps(grammar(), indent=2) + "\n"


if __name__ == "__main__":
    FILE.parent.mkdir(parents=True, exist_ok=True)
    FILE.write_text(text(), encoding="utf-8", newline="\n")
