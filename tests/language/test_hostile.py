"""Texts that want to do harm: a finding at worst, never anything else, and soon."""

import random
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from grammarlab.errors import LanguageError
from grammarlab.language.checking.check import check_text
from grammarlab.language.formatting import format_grammar
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax.parse import MAX_CHARACTERS, parse
from grammarlab.language.syntax.syntax_tree import walk
from tests.language.trees import PHASES, token_soup

GRAMMARS = [path.read_text(encoding="utf-8") for path in sorted((Path(__file__).parents[2] / "grammars").glob("*.cga"))]


def assert_harmless(text):
    found = check_text(text)
    lines = text.removeprefix("\ufeff").splitlines() or [""]
    for finding in found:
        assert finding.render(text.splitlines())
        assert 1 <= finding.location.line <= len(lines) + 1
        assert finding.location.column >= 1
        assert finding.location.length >= 1
    if parse(text.removeprefix("\ufeff")).findings:
        with pytest.raises(LanguageError):
            Grammar.parse(text)
        return
    grammar = Grammar.parse(text)
    assert Grammar.parse(format_grammar(grammar)).tree == grammar.tree


@settings(max_examples=200, deadline=None, phases=PHASES)
@given(token_soup)
def test_any_words_in_any_order_end_in_findings(text):
    assert_harmless(text)


@settings(max_examples=100, deadline=None, phases=PHASES)
@given(st.text(max_size=80))
@example("\ufeff")
@example("\r\r\n\x85")
@example('"')
@example('"\\')
@example("/*")
@example("%:")
@example("*")
@example("^")
@example("-->")
@example("=")
@example("with")
@example("with(=")
@example("(x)-->")
@example("}*")
@example("scatter(){")
@example("a.")
@example("@")
@example("inline(")
def test_any_characters_end_in_findings(text):
    assert_harmless(text)


@pytest.mark.parametrize("seed", range(30))
def test_shipped_grammars_with_words_lost_doubled_or_swapped_end_in_findings(seed):
    chance = random.Random(seed)
    lines = chance.choice(GRAMMARS).splitlines()
    start = chance.randrange(max(1, len(lines) - 60))
    words = "\n".join(lines[start : start + 60]).split(" ")
    for _ in range(chance.randrange(1, 12)):
        i, j = chance.randrange(len(words)), chance.randrange(len(words))
        change = chance.choice(["lose", "double", "swap", "cut"])
        if change == "lose":
            words[i] = ""
        elif change == "double":
            words[i] += " " + words[i]
        elif change == "swap":
            words[i], words[j] = words[j], words[i]
        else:
            words[i] = words[i][: chance.randrange(len(words[i]) + 1)]
    assert_harmless(" ".join(words))


@pytest.mark.parametrize(
    "text",
    [
        "(" * 100_000,
        "[" * 50_000 + "]" * 50_000,
        "A --> " + "[" * 50_000,
        "A --> comp(f) " + "{ all : " * 20_000,
        "a = " + "-" * 50_000 + "1",
        "a = " + "!" * 50_000 + "b",
        "a = " + "1 + " * 20_000 + "1",
        "a = b" + "[0]" * 20_000,
        "A --> " + "case a : " * 20_000,
        "A --> " + "5% : " * 20_000,
        "A --> " + "case a : B else : " * 20_000,
        "a = " + "(case b : " * 20_000,
        "A --> " + "inline " * 20_000,
        "a = f(" * 20_000,
    ],
    ids=lambda text: text[:24],
)
def test_deep_nesting_is_a_finding(text):
    findings = parse(text).findings
    assert {finding.code for finding in findings} & {"too-deep", "bad-index", "bad-inline"}
    assert len(findings) < 5


@pytest.mark.parametrize(
    ("unit", "opening", "closing"),
    [
        ("(", "(", ")"),
        ("[", "[", "]"),
        ("-", "-", ""),
        ("1+", "1+", ""),
        ("f(", "f(", ")"),
        ("(case b : ", "(case b : ", ")"),
    ],
)
def test_what_is_let_through_can_be_walked_compared_and_written(unit, opening, closing):
    deepest = None
    for depth in range(1, 300):
        text = "a = " + opening * depth + "1" + closing * depth
        if parse(text).findings:
            break
        deepest = text
    assert deepest is not None
    grammar = Grammar.parse(deepest)
    assert Grammar.parse(format_grammar(grammar)).tree == grammar.tree
    assert repr(grammar.tree)
    assert len(list(walk(grammar.tree))) >= 2
    check_text(deepest)


@pytest.mark.parametrize(
    "text",
    ["A" * (MAX_CHARACTERS + 1), "A --> B\n" * 100_000, "\x00" * 100_000, '"' * 100_000, ")" * 100_000, "/*" * 100_000],
    ids=["characters", "words", "unknown", "quotes", "brackets", "comments"],
)
def test_size_and_number_of_findings_are_bounded(text):
    parsed = parse(text)
    assert parsed.findings
    assert len(parsed.findings) <= 100


def test_long_flat_files_are_no_problem():
    text = (
        "Lot --> "
        + "A(1) " * 2_000
        + "\nattr a = ["
        + "1, " * 2_000
        + "1]\nB --> "
        + "case a == 1 : C " * 1_000
        + "else : D"
    )
    assert parse(text).findings == ()
    assert Grammar.parse(format_grammar(Grammar.parse(text))).tree == Grammar.parse(text).tree


def test_a_file_of_too_many_words_is_told_to_be_too_large_and_nothing_else(monkeypatch):
    monkeypatch.setattr("grammarlab.language.syntax.tokens.MAX_WORDS", 40)
    findings = parse("Lot --> split(x) { ~1 : A }\n" * 20).findings
    assert [finding.code for finding in findings] == ["file-too-large"]
