"""Built-in functions: the same for a constant, for a column, and as Python has them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.errors import DerivationError
from grammarlab.language.grammar import Grammar


def reported(expression: str, attributes: str = "", num_models: int = 1) -> list[float]:
    """The value of an expression for each model."""
    grammar = Grammar.parse(f'{attributes}\nLot --> report("value", {expression})')
    return derive(grammar, num_models, seed=1, footprint=(3.0, 4.0)).reports.value.tolist()


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("1 + 2 * 3", 7),
        ("1 + (case 1 > 2 : 5 else : 7)", 8),
        ("(1 + 2) * 3", 9),
        ("-5 % 3", -2),
        ("7 / 2", 3.5),
        ("2 < 3 && !(1 == 2) || false", 1),
        ("sin(30)", 0.5),
        ("atan2(1, 1)", 45),
        ("pow(2, 10)", 1024),
        ("rint(2.6) + floor(-1.5) + ceil(1.2)", 3),
        ("max(1, min(5, 3))", 3),
        ("clamp(7, 0, 5)", 5),
        ("sqrt(2) * sqrt(2)", 2),
        ("ln(exp(3))", 3),
        ("abs(-2.5)", 2.5),
        ('len("abc" + 12)', 5),
        ('find("abcabc", "b", 1)', 4),
        ('count("abcabc", "bc")', 2),
        ('float(substring("a12b", 1, 3))', 12),
        ('len(replace("aXbX", "X", "--"))', 6),
        ('float(listItem("3;4;5;", 1))', 4),
        ('listSize("3;4;5;") + listIndex("a;b;", "b")', 4),
        ('len(getPrefix("a.b.c", ".")) + len(getSuffix("a.b.c", "."))', 2),
        ('bool("false")', 0),
        ('"a" + 1 == "a1"', 1),
        ("geometry.area", 12),
        ("geometry.nVertices() + geometry.nFaces", 5),
        ("scope.sx * scope.sz + scope.sy", 12),
        ("isnan(0 / 0)", 1),
    ],
)
def test_the_value_of_an_expression(expression, expected):
    assert reported(expression) == [pytest.approx(expected)]


FUNCTIONS = ["sin", "cos", "tan", "exp", "sqrt", "floor", "ceil", "rint", "abs", "ln", "atan"]


@pytest.mark.parametrize("function", FUNCTIONS)
def test_a_constant_and_a_column_give_the_same_bits(function):
    column = reported(f"{function}(x)", "attr x = 50%: 0.7 else: 3.3", 40)
    constants = {reported(f"{function}({value})")[0] for value in (0.7, 3.3)}
    assert set(column) == constants


@pytest.mark.parametrize(("power", "base"), [(0.3, 1.7), (2.5, 9.1)])
def test_powers_do_not_depend_on_the_batch(power, base):
    one = reported(f"pow(x, {power})", f"attr x = 50%: {base} else: 2", 1)
    many = reported(f"pow(x, {power})", f"attr x = 50%: {base} else: 2", 64)
    assert many[0] == one[0]


def test_text_of_a_column_is_put_together_row_by_row():
    values = reported('len("h" + x + y)', 'attr x = 50%: 7 else: 100\nattr y = 50%: "ab" else: ""', 64)
    assert set(values) == {2.0, 4.0, 6.0}


def test_a_recursive_function_ends():
    assert reported("sum(10)", "sum(n) = case n <= 0: 0 else: n + sum(n - 1)") == [55.0]


def test_an_endless_function_is_refused():
    with pytest.raises(DerivationError, match="calls itself"):
        reported("f(1)", "f(n) = f(n + 1)")


def test_attributes_that_depend_on_each_other_in_a_circle_are_refused():
    with pytest.raises(DerivationError, match="a -> b -> a"):
        reported("a", "attr a = b + 1\nattr b = a + 1")


def test_numbers_and_strings_do_not_mix():
    with pytest.raises(DerivationError, match="expects numbers"):
        reported('3 * "a"')


def test_draws_of_two_calls_of_one_function_differ():
    values = reported("f - f", "f = rand(1, 2)", 8)
    assert all(value != 0.0 and math.isfinite(value) for value in values)


def test_an_attribute_is_drawn_once_for_each_model():
    values = reported("h - h", "attr h = rand(1, 2)", 8)
    assert np.array_equal(values, np.zeros(8))
