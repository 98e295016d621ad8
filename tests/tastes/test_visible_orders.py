"""Orders of alternatives that a person sees: by lightness and by numbers, and no others."""

from __future__ import annotations

import pytest

from grammarlab.language.grammar import Grammar
from grammarlab.tastes.visible_orders import visible_orders

CASES = {
    "lightness": ('color("#808080") B', 'color("#000000") B', 'color("#ffffff") B', [[1, 0, 2]]),
    "hues": (
        "color(1, 0, 0) B",
        "color(0, 1, 0) B",
        "color(0, 0, 1) B",
        [[2, 0, 1]],
    ),
    "sizes": ("s('1, 2 * h, '1) B", "s('1, h, '1) B", "s('1, 3 * h - 1, '1) B", [[1, 0, 2]]),
    "arguments": ("B(2)", "B(1)", "B(7)", [[1, 0, 2]]),
    "the second of two": ("s(1, 1, 1) t(0, 5, 0) B", "s(1, 1, 1) t(0, 3, 0) B", "s(1, 1, 1) t(0, 9, 0) B", [[1, 0, 2]]),
    "minus": ("B(-h)", "B(-9)", "B(-1)", [[1, 0, 2]]),
    "quotients": ("B(h / 2)", "B(h / 4)", "B(h / 1)", [[1, 0, 2]]),
    "a quotient by zero": ("B(h / 0)", "B(1)", "B(2)", []),
    "the order of the text": ("B(1)", "B(2)", "B(3)", []),
    "its reverse": ("B(3)", "B(2)", "B(1)", []),
    "one lacks it": ("B(3)", "C(1)", "B(2)", []),
    "two alike": ("B(2)", "B(1)", "B(2)", []),
    "a value that is not known": ("B(geometry.area)", "B(1)", "B(2)", []),
    "a value that depends on itself": ("B(loop)", "B(1)", "B(2)", []),
}


@pytest.mark.parametrize("name", CASES)
def test_orders_are_by_what_differs_among_all_alternatives(name):
    first, second, third, expected = CASES[name]
    rules = f"attr h = rand(2, 4)\nattr loop = loop + 1\nLot --> A\nA --> 40% : {first} 30% : {second} else : {third}"
    listed = visible_orders(Grammar.parse(rules)).get("A", ())
    assert [[branch for (branch,) in order] for order in listed] == expected


@pytest.mark.parametrize(("length", "expected"), [(20, [[2, 0, 1]]), (300, [])])
def test_attributes_of_attributes_have_values_up_to_a_depth(length, expected):
    chain = "".join(f"attr a{i} = a{i - 1} + 1\n" for i in range(1, length))
    rules = f"attr a0 = rand(1, 2)\n{chain}Lot --> A\nA --> 40% : B(2) 30% : B(a{length - 1}) else : B(1)"
    listed = visible_orders(Grammar.parse(rules)).get("A", ())
    assert [[branch for (branch,) in order] for order in listed] == expected
