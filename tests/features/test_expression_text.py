"""Expressions written without their definitions mean the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from grammarlab.errors import UsageError
from grammarlab.evaluation.scenario import load
from grammarlab.features.expression import Expression, plain_text

PATHS = sorted((Path(__file__).parents[2] / "scenarios").rglob("*.toml"))
SCENARIOS = [path for path in PATHS if "grammar = " in path.read_text()]


@pytest.mark.parametrize("path", SCENARIOS, ids=lambda path: path.stem)
def test_a_preference_without_its_definitions_means_the_same(path: Path) -> None:
    """All operations and kinds of features occur in some shipped scenario."""
    expression = load(path).score.expression
    again = Expression.parse(plain_text(expression))
    assert set(again.features) == set(expression.features)
    random = np.random.default_rng(0)
    values = np.round(random.exponential(3.0, (500, len(expression.features))), 1)
    column_of = [expression.features.index(feature) for feature in again.features]
    np.testing.assert_array_equal(again.evaluate(values[:, column_of]), expression.evaluate(values))


def test_negative_numbers_and_powers_of_ten_are_read_again() -> None:
    expression = Expression.parse("max(-1e-9 * $a, 2 - 1e20, $a:3 % 7)")
    values = np.array([[3.0, 8.0], [-1e12, -1.0]])
    again = Expression.parse(plain_text(expression))
    assert again.features == expression.features
    np.testing.assert_array_equal(again.evaluate(values), expression.evaluate(values))


def test_definitions_that_double_the_text_end_with_a_message() -> None:
    definitions = {"a0": Expression.parse("$h + $w")}
    for number in range(20):
        definitions[f"a{number + 1}"] = Expression.parse(f"a{number} * (a{number} + 1)", definitions)
    with pytest.raises(UsageError, match="more than 20,000 characters with the definitions"):
        plain_text(definitions["a20"])
