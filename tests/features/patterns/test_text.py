"""Patterns as text."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import UsageError
from grammarlab.features.patterns.pattern import Below, Pattern
from grammarlab.features.patterns.pattern_text import MAX_CHARACTERS, MAX_DEPTH, parse
from tests.features.forests import patterns


@given(patterns(max_leaves=20))
def test_what_is_written_is_read_back(pattern):
    assert parse(str(pattern)) == pattern


@given(patterns())
def test_spaces_do_not_matter(pattern):
    text = str(pattern)
    assert parse(text.replace(" ", "")) == parse(text.replace(" ", " \n\t ")) == pattern


@pytest.mark.parametrize(
    ("text", "pattern"),
    [
        ("Tower", Pattern("Tower")),
        ("*", Pattern()),
        ("Wall/2:*", Pattern("Wall", 2, ())),
        ("Pane.:0", Pattern("Pane.", None, (0,))),
        ("lib.Wall:1.0", Pattern("lib.Wall", None, (1, 0))),
        ("Fenêtre", Pattern("Fenêtre")),
        ("Tower > Block@2:1", Pattern("Tower", below=(Below((Pattern("Block", branch=(1,)),), 2),))),
        ("A >> B", Pattern("A", below=(Below((Pattern("B"),), deep=True),))),
        ("A > B > C", Pattern("A", below=(Below((Pattern("B", below=(Below((Pattern("C"),)),)),)),))),
        ("A[B, >> C]", Pattern("A", below=(Below((Pattern("B"),)), Below((Pattern("C"),), deep=True)))),
        ("A[B@1 + C]", Pattern("A", below=(Below((Pattern("B"), Pattern("C")), 1),))),
    ],
)
def test_examples(text, pattern):
    assert parse(text) == pattern
    assert str(pattern) == text


def test_brackets_and_arrows_say_the_same():
    assert parse("A[B]") == parse("A > B") == parse("A[> B]")
    assert parse("A[>> B]") == parse("A >> B")
    assert parse("A[B] > C") == parse("A[B, C]")


@pytest.mark.parametrize(
    ("text", "message", "column"),
    [
        ("", "expected a symbol or *, found the end", 0),
        ("A >", "expected a symbol or *, found the end", 3),
        ("A B", "expected '>', '>>', '\\[' or the end, found 'B'", 2),
        ("A[B", "expected '\\]', ',' or '\\+', found the end", 3),
        ("A[]", "expected a symbol or *, found '\\]'", 2),
        ("A:", "a branch such as :0", 1),
        ("A:1.", "found '\\.'", 3),
        ("A@2", "expected it below another node", 0),
        ("A[B + C@1]", "only the first of adjacent siblings", 6),
        ("A:0@1", "in the order /parameters @place :branch", 3),
        ("A > $h", "found '\\$'", 4),
        ("A > 7", "found '7'", 4),
    ],
)
def test_mistakes_are_explained_with_a_caret(text, message, column):
    with pytest.raises(UsageError, match=message.replace("*", "\\*")) as error:
        parse(text)
    assert str(error.value).splitlines()[-1] == "  " + " " * column + "^"


@pytest.mark.parametrize("text", ["A > " * 2000 + "A", "A[" * 1000, "A > " * (MAX_DEPTH + 1) + "A", "(" * 100])
def test_huge_and_deep_texts_are_refused_at_once(text):
    with pytest.raises(UsageError):
        parse(text)


def test_the_deepest_allowed_text_is_read():
    text = " > ".join(["A"] * MAX_DEPTH)
    assert str(parse(text)) == text
    assert parse("A[" + ", ".join(["B"] * (MAX_CHARACTERS // 3 - 2)) + "]").symbol == "A"


@given(st.text(st.sampled_from("AB*>[]+,:@/.1 é\n"), max_size=30))
def test_any_text_is_a_pattern_or_a_usage_error(text):
    try:
        found = parse(text)
    except UsageError:
        return
    assert parse(str(found)) == found
