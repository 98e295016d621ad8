"""Conditions and formulas over the fields of parcels."""

from __future__ import annotations

from decimal import Decimal

import numpy as np
import pyarrow as pa
import pytest

from grammarlab.city.plan_fields import PlanFields, check_condition
from grammarlab.errors import UsageError

FIELDS = PlanFields(
    pa.table(
        {
            "use": pa.array(["shop", None, "park's"]),
            "kind": pa.array(["a", "b", "a"]).dictionary_encode(),
            "Land use": ["x", "y", "z"],
            "2020": [1, 2, 3],
            "floors": [1, None, 3],
            "text": ["3", "x", "4,5"],
            "public": [True, False, True],
            "maybe": [True, None, False],
            "price": [Decimal("1.5"), Decimal("2.5"), None],
            "min": [7, 8, 9],
            "area": [0, 0, 0],
            "shape": [[1], [2], [3]],
        }
    ),
    {"area": np.array([100.0, 200.0, np.nan])},
)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("use == 'shop'", [1, 0, 0]),
        ('use != "shop"', [0, 1, 1]),
        ("use == \"park's\" or 'shop' == use", [1, 0, 1]),
        ("use == ''", [0, 1, 0]),
        ("kind == 'a' and area > 50", [1, 0, 0]),
        ("not kind == 'a'", [0, 1, 0]),
        ("Land_use != 'y' and _2020 >= 1", [1, 0, 1]),
        ("floors >= 2", [0, 0, 1]),
        ("floors != 3", [1, 1, 0]),
        ("text > 3.5", [0, 0, 1]),
        ("text == 'x'", [0, 1, 0]),
        ("floors == '3'", [0, 0, 1]),
        ("public", [1, 0, 1]),
        ("maybe == 1", [1, 0, 0]),
        ("price * 2 == 3", [1, 0, 0]),
        ("min_ == 8", [0, 1, 0]),
        ("area < 150", [1, 0, 0]),
        ("150 < area < 250", [0, 1, 0]),
        ("1", [1, 1, 1]),
        ("choose(floors > 2, 1, area > 150, 1, 0)", [0, 1, 1]),
    ],
)
def test_conditions(text: str, expected: list[int]):
    assert FIELDS.holds(text).tolist() == [bool(value) for value in expected]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("us == 3", "did you mean use"),
        ("us == 'x'", "unknown field 'us'; did you mean use"),
        ("use > 3", "has texts such as 'shop'"),
        ("floors = 3", "write =="),
        ("$floors > 1", "expected names of fields"),
        ("{Block} > 1", "expected names of fields"),
        ("shape > 1", "expected numbers, flags or texts, found list"),
        ("", "expected an expression"),
    ],
)
def test_mistakes_in_conditions(text: str, message: str):
    with pytest.raises(UsageError, match=message):
        FIELDS.holds(text)


def test_formulas_have_no_value_without_a_number_that_they_read():
    values, is_given = FIELDS.formula("3 * floors + area / 100")
    assert is_given.tolist() == [True, False, False]
    assert values[0] == 4.0
    values, is_given = FIELDS.formula("choose(floors > 0, 3 * floors, 9)")
    assert (values.tolist(), is_given.tolist()) == ([3.0, 9.0, 9.0], [True, True, True])


def test_a_name_alone_is_the_field_itself():
    for name, kind, is_given in (
        ("use", object, [True, False, True]),
        ("public", np.bool_, [True, True, True]),
        ("floors", np.float64, [True, False, True]),
        ("_2020", np.float64, [True, True, True]),
    ):
        values, flags = FIELDS.formula(name)
        assert (values.dtype, flags.tolist()) == (np.dtype(kind), is_given)


def test_values_of_a_field_are_compared_by_their_kind():
    for name, value, expected in (
        ("use", "shop", [1, 0, 0]),
        ("floors", 3, [0, 0, 1]),
        ("floors", "3", [0, 0, 1]),
        ("text", 3, [1, 0, 0]),
        ("public", True, [1, 0, 1]),
        ("public", "x", [0, 0, 0]),
    ):
        assert FIELDS.equal(name, value).tolist() == [bool(flag) for flag in expected]


def test_conditions_are_checked_without_fields():
    check_condition("us == 'x' and aera > 3 or not (b < 2)")
    with pytest.raises(UsageError, match="found the end"):
        check_condition("area > ")
