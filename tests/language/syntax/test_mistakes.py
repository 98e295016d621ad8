"""Syntax errors: each usual mistake has its own code, its place and its advice, and none hides another."""

import pytest

from grammarlab.errors import LanguageError
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax.parse import parse

MISTAKES = [
    ("Lot --> split(x) { 1 A | 2 : B }", "part-without-colon", "A", "selector : operations"),
    ("Lot --> case a > 1 : A else B", "else-without-colon", "B", "else :"),
    ("Lot --> case a > 1 A else : B", "case-without-colon", "A", "case condition :"),
    ("Lot --> case a = 1 : A else : B", "single-equals", "=", "'==' compares"),
    ("Lot --> extrude(f(a = 1))", "single-equals", "a", "'=='"),
    ("attr x == 3", "double-equals", "==", "'=' defines"),
    ("Lot -> extrude(10)", "wrong-arrow", "->", "-->"),
    ("Lot ---> extrude(10)", "wrong-arrow", "--->", "-->"),
    ("Lot --> extrude(10", "unclosed-bracket", "(", "missing ')'"),
    ("Lot --> split(x) { 1 : A", "unclosed-bracket", "{", "missing '}'"),
    ("Lot --> [ A", "unclosed-bracket", "[", "missing ']'"),
    ("Lot --> extrude(10))", "unmatched-bracket", ")", "missing '('"),
    ("Lot --> split(x { 1 : A }", "unclosed-bracket", "(", "missing ')'"),
    ('attr a = "abc', "unclosed-string", '"abc', "on one line"),
    ("/* A --> B", "unclosed-comment", "/*", "*/"),
    ("Lot --> A; B", "semicolon", ";", "delete"),
    ("Lot --> split(x) { 1 : A , 2 : B }", "comma-for-bar", ",", "| 2 : B"),
    ("attr a = f(x | y)", "bar-for-comma", "|", "f(a, b)"),
    ("Lot --> t(1 2 3)", "missing-comma", "2", ""),
    ("Lot --> 30 : A else : B", "percent-missing", "30", "30% :"),
    ("Lot --> 30% A else : B", "percent-without-colon", "30", "30% :"),
    ("Lot --> extrude(3) case a > 1 : A else : B", "late-choice", "case", "[ case … ]"),
    ("Lot --> split(x) { 1 : color(c) 30% : A else : B }", "late-choice", "30%", "another rule"),
    ("Lot --> union { case 1 > 0 : A. else : C. | B. }", "late-choice", "case", "give a rule the choice"),
    ("Lot --> subtract { A. | 30% : B. else : C. }", "late-choice", "30%", "give a rule the choice"),
    ("Lot --> union { A. case 1 > 0 : B. | C. }", "late-choice", "case", "[ case … ]"),
    ("Lot --> union { comp(f) { all : A. } | B. | C. }", "bad-inline", "|", "union { union { A | B } | C }"),
    ("Lot --> if x > 3 A", "foreign-word", ">", "case condition"),
    ("Lot --> A & B", "unknown-character", "&", "&&"),
    ("attr a = b ? 1 : 2", "unknown-character", "?", "case condition"),
    ("attr a = “b”", "unknown-character", "“", "straight quotes"),
    ("attr a = b => 2", "unknown-character", "=>", ">="),
    ('import "lib.cga"', "anonymous-import", '"lib.cga"', "import name :"),
    ("@Range(1, 2)", "dangling-annotation", ")", "before an attr"),
    ("Lot extrude(3)", "no-definition", "extrude", ""),
    ("{ A }", "no-definition", "{", "Rule -->"),
    ("Lot --> x = 3 A", "misplaced-equals", "=", "with (x := 1)"),
    ("Lot --> split(x) { 2*~1 : A }", "misplaced-tilde", "~", "~2*x"),
    ("f(1, x) = 2", "bad-parameter", "1", "Name(a, b)"),
    ("attr a = f({1, 2})", "misplaced-braces", "1", "[1, 2, 3]"),
    ("attr a = 1e999", "number-too-large", "1e999", ""),
    ("attr a = b[1][2][3]", "bad-index", "3", "row, column"),
]


@pytest.mark.parametrize(("text", "code", "place", "advice"), MISTAKES)
def test_usual_mistakes_are_recognised(text, code, place, advice):
    (finding, *_) = [finding for finding in parse(text).findings if finding.code == code]
    start = finding.location.column - 1
    assert finding.severity == "error"
    assert text[start:].startswith(place)
    assert finding.location.length >= min(len(place), 2) or len(place) == 1
    assert advice in finding.hint


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("attr a = 3 +", "an expression"),
        ("attr a 3", "'='"),
        ("Lot --> a | b", "the end of the definition"),
        ("x = 3 4", "an operator or the end of the definition"),
        ("Lot --> (a)", "an operation or a symbol"),
        ("@Range(min=max=2) attr a = 1", "',' or ')'"),
    ],
)
def test_other_mistakes_name_what_was_expected_in_words(text, expected):
    (finding,) = parse(text).findings
    assert expected in finding.message


def test_one_file_reports_the_errors_of_all_its_definitions():
    text = """attr a == 1
Lot --> split(x) { 1 A }
Good --> A
f(x) = case x > 1 : 1 else 2
Open --> comp(f) { top : A
Wall --> t(1 2)
Last -> B;
"""
    parsed = parse(text)
    assert [(finding.location.line, finding.code) for finding in parsed.findings] == [
        (1, "double-equals"),
        (2, "part-without-colon"),
        (4, "else-without-colon"),
        (5, "unclosed-bracket"),
        (6, "missing-comma"),
        (7, "wrong-arrow"),
        (7, "semicolon"),
    ]
    assert [getattr(node, "name", None) for node in parsed.tree.definitions] == ["Good", "Last"]


def test_an_error_shows_the_line_and_a_caret_under_the_place():
    with pytest.raises(LanguageError) as caught:
        Grammar.parse("Lot -->\n\tsplit(x) { 1 A }", "town.cga")
    assert str(caught.value).splitlines() == [
        "town.cga:2:15: error: expected ':' between a part's head and its operations, found 'A' [part-without-colon]",
        "  split(x) { 1 A }",
        "               ^",
        "  hint: each part is written size : operations, or selector : operations",
    ]
