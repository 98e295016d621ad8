"""Errors keep what they carry on the way from one process to another."""

from __future__ import annotations

import pickle

import pytest

from grammarlab.errors import (
    BudgetError,
    DerivationError,
    Finding,
    GrammarlabError,
    LanguageError,
    Location,
    XmlError,
    shown,
)

PLACE = Location(3, 7, 2, "lot.cga")
ERRORS = [
    LanguageError((Finding("error", "unknown-name", "nothing is called 'x' here", PLACE, "try y"),), "a\nb\nLot --> x"),
    DerivationError("expected a number", PLACE, "try float(...)"),
    BudgetError("too many shapes", None, "raise the budget"),
    XmlError("expected a tag", 2, 3, 4),
    GrammarlabError("plain"),
]


@pytest.mark.parametrize("error", ERRORS, ids=lambda error: type(error).__name__)
def test_a_pickled_error_says_the_same(error):
    copy = pickle.loads(pickle.dumps(error))  # noqa: S301  # our own bytes
    assert type(copy) is type(error)
    assert str(copy) == str(error)
    assert vars(copy) == vars(error)


def test_of_a_very_long_line_the_place_is_shown():
    text = "x" * 100_000 + "HERE" + "y" * 100_000
    shown = Finding("error", "c", "m", Location(1, 100_001, 4)).render([text]).splitlines()
    start = shown[2].index("^")
    assert shown[1][start : start + 4] == "HERE"
    assert max(map(len, shown)) < 300


@pytest.mark.parametrize("indent", ["", "    ", 14 * "\t", "\t \t"])
def test_places_are_shown_without_indentation(indent: str):
    line = f"{indent}| ~1 :\tHERE B"
    finding = Finding("error", "c", "m", Location(2, line.index("HERE") + 1, 4))
    _, code, caret = finding.render(["A", line]).splitlines()
    assert code == "  | ~1 :\tHERE B"
    assert caret.expandtabs() == " " * code.expandtabs().index("HERE") + "^^^^"
    # A place within the indentation is shown where the line begins.
    assert Finding("error", "c", "m", Location(1)).render([f"{indent}A"]).splitlines()[2] == "  ^"


def test_a_foreign_value_is_shown_in_at_most_one_short_line() -> None:
    deep: list = []
    for _ in range(100_000):
        deep = [deep]
    found = [shown(each) for each in (None, True, 2.5, "a\nb", 10**4000, "x" * 10**6, {"a": deep}, deep, b"\n" * 99)]
    assert found[:5] == ["nothing", "True", "2.5", r"'a\nb'", "an integer of 13288 bits"]
    assert all(len(each) <= 61 and each.isprintable() for each in found)
