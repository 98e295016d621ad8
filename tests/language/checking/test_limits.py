"""What annotations allow people to enter."""

from __future__ import annotations

import pytest

from grammarlab.language.attribute_values import objection
from grammarlab.language.grammar import Grammar


@pytest.mark.parametrize(
    ("annotations", "value", "expected"),
    [
        ("@Range(min=1, max=5)", 5.0, ""),
        ("@Range(min=1, max=5)", 5.5, "expected 1 to 5, found 5.5"),
        ("@Range(-2, 2)", -3.0, "expected -2 to 2, found -3"),
        ("@Range(min=0)", -1.0, "expected at least 0, found -1"),
        ("@Range(max=3*4)", 13.0, "expected at most 12, found 13"),
        ("@Range(min=1, max=5, restricted=false)", 9.0, ""),
        ("@Range(min=low, max=5)", -9.0, ""),
        ("@Range", 9.0, ""),
        ("@Range(min=1, max=5)", "tall", ""),
        ('@Enum("low", "high")', "high", ""),
        ('@Enum("low", "high")', "tall", "expected one of low, high, found tall"),
        ('@Enum("low", "high", restricted=false)', "tall", ""),
        ("@Enum(1, 2.5, -3)", 2.5, ""),
        ("@Enum(1, 2.5, -3)", -3.0, ""),
        ("@Enum(1, 2.5, -3)", 4.0, "expected one of 1, 2.5, -3, found 4"),
        ("@Enum(valuesAttr=known)", "tall", ""),
        ("@Group(1) @Description(2)", 9.0, ""),
        ("", 9.0, ""),
    ],
)
def test_values_outside_a_range_or_an_enumeration_meet_an_objection(annotations, value, expected):
    grammar = Grammar.parse(f"{annotations} attr x = 1 Lot --> NIL")
    assert objection(grammar.attributes["x"], value) == expected
