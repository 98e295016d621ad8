"""Errors keep what they carry on the way from one process to another."""

from __future__ import annotations

import pickle

import pytest

from grammarlab.errors import BudgetError, DerivationError, Finding, GrammarlabError, LanguageError, Location

PLACE = Location(3, 7, 2, "lot.cga")
ERRORS = [
    LanguageError((Finding("error", "unknown-name", "nothing is called 'x' here", PLACE, "try y"),), "a\nb\nLot --> x"),
    DerivationError("expected a number", PLACE, "try float(...)"),
    BudgetError("too many shapes", None, "raise the budget"),
    GrammarlabError("plain"),
]


@pytest.mark.parametrize("error", ERRORS, ids=lambda error: type(error).__name__)
def test_a_pickled_error_says_the_same(error):
    copy = pickle.loads(pickle.dumps(error))  # noqa: S301  # our own bytes
    assert type(copy) is type(error)
    assert str(copy) == str(error)
    assert vars(copy) == vars(error)
