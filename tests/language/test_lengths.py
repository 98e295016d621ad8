"""Lengths as people write them."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.language.attribute_values import length


@pytest.mark.parametrize(
    ("text", "metres"),
    [
        ("12", 12),
        ("12 m", 12),
        ("12.5m", 12.5),
        (" 7,5 ", 7.5),
        ("7,25 m", 7.25),
        ("-3 metres", -3),
        ("250 cm", 2.5),
        ("0.4 km", 400),
        ("1500 mm", 1.5),
        ("40 ft", 12.192),
        ("40'", 12.192),
        ("6'4\"", 1.9304),
        ("6 ft 4 in", 1.9304),
        ("10 in", 0.254),
        ("3 ft.", 0.9144),
    ],
)
def test_units_are_converted_to_metres(text, metres):
    assert length(text) == pytest.approx(metres, abs=1e-12)


@pytest.mark.parametrize(
    "text",
    ["", "m", "tall", "about 12", "12-15", "12;15", "1,200", "1,200 m", "12 storeys", "12 km/h", "1_000", "9" * 100],
)
def test_other_texts_are_no_lengths(text):
    assert length(text) is None


@given(st.text(max_size=80))
def test_any_text_is_a_length_or_not(text):
    value = length(text)
    assert value is None or math.isfinite(value)


@given(st.integers(-(10**6), 10**6), st.integers(0, 99))
def test_a_comma_is_a_decimal_point(whole, hundredths):
    assert length(f"{whole},{hundredths:02d} m") == float(f"{whole}.{hundredths:02d}")
