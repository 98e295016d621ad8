"""CGA for Pygments, which colours code in documentation and notebooks; its words are those of the language's tables.

The package declares the lexer to Pygments (``pygments.lexers`` in its metadata), so that blocks of the language ``cga``
are coloured wherever grammarlab is installed. The grammar of the editors (``docs.gen.editors``) has the same words.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

from pygments.lexer import RegexLexer, bygroups, words
from pygments.token import Comment, Keyword, Name, Number, Operator, Punctuation, String, Text

from grammarlab.language.syntax.builtins import attributes, blocks, functions, operations
from grammarlab.language.syntax.keywords import KEYWORDS

DEFINITIONS = ("attr", "const", "extends", "extension", "import", "start", "style", "version")
"""Words that begin definitions."""
CONTROL = ("case", "else", "inline", "intersect", "subtract", "union", "with")
"""Words of control, and operations that are followed by a body."""
CONSTANTS = ("false", "true")
OPERATIONS = tuple(sorted({*operations(), *blocks(), "NIL"} - {*CONTROL}))
FUNCTIONS = tuple(sorted({*functions(), "comp", "sel"} - {*OPERATIONS}))
ATTRIBUTES = tuple(sorted(attributes()))
SELECTORS = tuple(sorted(frozenset[str]().union(*KEYWORDS.values()) - {*OPERATIONS, *FUNCTIONS, *ATTRIBUTES, *CONTROL}))
"""Words that arguments and heads of parts are, such as ``world.up`` and ``top``."""
IDENTIFIER = r"[^\W\d]\w*(?:\.[^\W\d]\w*)*"
"""A name, with those of imported files before it."""
NOT_BEFORE, NOT_AFTER = r"(?<![\w.])", r"(?![\w.])"
"""Around a whole word; the dot that ends a symbol belongs to it."""


class CgaLexer(RegexLexer):
    """Lexer of CGA rule files."""

    name = "CGA"
    aliases: ClassVar[Sequence[str]] = ["cga", "cga-part"]
    filenames: ClassVar[Sequence[str]] = ["*.cga"]
    tokens: ClassVar[dict[str, list[Any]]] = {
        "root": [
            (r"(?://|#).*", Comment.Single),
            (r"/\*", Comment.Multiline, "comment"),
            (r'"(?:\\.|[^"\\\n])*"?', String),
            (r"@\s*\w+", Name.Decorator),
            (rf"(?!with\b)({IDENTIFIER})(?=\s*(?:\([^(){{}}]*\)\s*)?(?:with\s*\([^{{}}]*?\)\s*)?-->)", Name.Function),
            (rf"(attr|const)(\s+)({IDENTIFIER})", bygroups(Keyword.Declaration, Text, Name.Variable.Global)),
            (words(DEFINITIONS, NOT_BEFORE, NOT_AFTER), Keyword.Declaration),
            (words(CONTROL, NOT_BEFORE, NOT_AFTER), Keyword),
            (words(CONSTANTS, NOT_BEFORE, NOT_AFTER), Keyword.Constant),
            (words(ATTRIBUTES, NOT_BEFORE, NOT_AFTER), Name.Variable.Magic),
            (words(OPERATIONS, NOT_BEFORE, NOT_AFTER), Name.Builtin),
            (words(FUNCTIONS, NOT_BEFORE, NOT_AFTER), Name.Builtin.Pseudo),
            (words(SELECTORS, NOT_BEFORE, NOT_AFTER), Name.Constant),
            (rf"{IDENTIFIER}\.?", Name),
            (r"(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?", Number),
            (r"-->|[-+*/%<>=!&|:'~^?.]", Operator),
            (r"[(){}\[\],;]", Punctuation),
            (r"\s+", Text),
        ],
        "comment": [(r"[^*]+", Comment.Multiline), (r"\*/", Comment.Multiline, "#pop"), (r"\*", Comment.Multiline)],
    }
