"""Colours of rule files agree with the words that the checker knows, in Pygments and in editors."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator
from itertools import accumulate
from pathlib import Path

import pytest
from pygments.token import Comment, Error, Keyword, Name, String, _TokenType

from docs.gen import editors
from grammarlab.language.highlighting import (
    ATTRIBUTES,
    CONSTANTS,
    CONTROL,
    DEFINITIONS,
    FUNCTIONS,
    OPERATIONS,
    SELECTORS,
    CgaLexer,
)
from grammarlab.language.syntax import builtins
from grammarlab.language.syntax.keywords import KEYWORDS
from grammarlab.language.syntax.tokens import tokenize

ROOT = Path(__file__).parents[2]
FILES = sorted((ROOT / "grammars").glob("*.cga"))
ODD = """/* a "b" // c */ version "2024.1" # d
@ Range(min=1)
attr h_ü = "x // y" + .5e3
Lot(a, b) with(c := 1) --> A.
"open"""
KINDS = {
    "attribute": (Name.Variable.Magic, ATTRIBUTES),
    "operation": (Name.Builtin, OPERATIONS),
    "function": (Name.Builtin.Pseudo, FUNCTIONS),
}


def coloured(text: str) -> dict[int, tuple[_TokenType, str]]:
    """Kind and text of each token of Pygments, by where it begins."""
    tokens = list(CgaLexer(stripnl=False, ensurenl=False).get_tokens(text))
    starts = accumulate((len(value) for _, value in tokens), initial=0)
    return {start: token for start, token in zip(starts, tokens, strict=False) if token[1]}


def names(text: str) -> Iterator[tuple[int, str]]:
    for token in tokenize(text, "x.cga").tokens:
        if token.type == "NAME":
            yield token.start, token.value


@pytest.mark.parametrize("text", [ODD, *(path.read_text(encoding="utf-8") for path in FILES[:6])])
def test_all_of_a_file_is_coloured_and_nothing_is_lost(text: str) -> None:
    tokens = coloured(text)
    assert "".join(value for _, value in tokens.values()) == text
    assert not any(kind is Error for kind, _ in tokens.values())
    comments = {comment.text for comment in tokenize(text, "x.cga").comments if comment.text.startswith(("//", "#"))}
    assert comments <= {value for kind, value in tokens.values() if kind in Comment}


@pytest.mark.parametrize("path", FILES[:8], ids=lambda path: path.stem)
def test_words_have_the_colour_of_their_table(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    tokens, seen = coloured(text), 0
    for start, name in names(text):
        for kind, words in KINDS.values():
            if name in words and tokens[start][0] not in (Name.Function, Name.Variable.Global):
                assert tokens[start] == (kind, name)
                seen += 1
    assert seen > 5


def test_the_tables_are_those_of_the_language() -> None:
    assert builtins.operations().keys() | builtins.blocks().keys() <= {*OPERATIONS, *CONTROL}
    assert builtins.functions().keys() <= {*FUNCTIONS, *OPERATIONS}
    assert builtins.attributes().keys() == {*ATTRIBUTES}
    words = {*SELECTORS, *OPERATIONS, *FUNCTIONS, *ATTRIBUTES, *CONTROL}
    assert frozenset[str]().union(*KEYWORDS.values()) <= words


def test_definitions_comments_and_texts() -> None:
    tokens = {value: kind for kind, value in coloured(ODD).values()}
    assert tokens["Lot"] is Name.Function
    assert tokens["h_ü"] is Name.Variable.Global
    assert tokens['"x // y"'] in String
    assert tokens["# d"] in Comment
    assert tokens["@ Range"] is Name.Decorator
    assert tokens["with"] is Keyword


def test_the_grammar_of_editors_is_the_generated_one() -> None:
    assert editors.FILE.read_text(encoding="utf-8") == editors.text(), "run `make reference`"
    folder = editors.FILE.parents[1]
    package = json.loads((folder / "package.json").read_text(encoding="utf-8"))["contributes"]
    (language,), (grammar,) = package["languages"], package["grammars"]
    assert (folder / grammar["path"]).resolve() == editors.FILE.resolve()
    assert grammar["scopeName"] == editors.grammar()["scopeName"]
    json.loads((folder / language["configuration"]).read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    "words", [DEFINITIONS, CONTROL, CONSTANTS, ATTRIBUTES, OPERATIONS, FUNCTIONS, SELECTORS], ids=lambda words: words[0]
)
def test_patterns_of_editors_find_whole_words_only(words: tuple[str, ...]) -> None:
    pattern = re.compile(editors.alternatives(words))
    for word in words:
        match = pattern.search(f" {word}(")
        assert match is not None
        assert match[0] == word
        assert not pattern.search(f"a.{word}(")
        assert not pattern.search(f"{word}_")
        assert not pattern.search(f"{word}.")


def test_the_package_declares_the_lexer() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    module, _, name = project["entry-points"]["pygments.lexers"]["cga"].partition(":")
    assert (CgaLexer.__module__, CgaLexer.__name__) == (module, name)
