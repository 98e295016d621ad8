"""Equations between pairs of patterns."""

from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.layers.candidates import relation
from grammarlab.layers.patterns import Values, expand, parse_pattern


@pytest.mark.parametrize(
    ("first", "second", "expected"),
    [
        ("A^kcC^mcA^k; c := C", "A^kC^lA^k", "m + 2 = l"),  # supplement, section 3.1
        ("cec; c := C", "A(BA)^k", "2C + e = (k + 1)A + k B"),
        ("AB", "AC", "B = C"),
        ("A^k", "A^{2k - 3}", "3 = k"),
        ("A^kB", "A^kBB", "0 = 1"),
    ],
)
def test_equations_of_pairs(first: str, second: str, expected: str) -> None:
    assert str(relation(parse_pattern(first), parse_pattern(second))) == expected


@pytest.mark.parametrize("pair", [("A", "A"), ("A|B", "A"), ("AB^-k", "A"), ("(mB)^k; m := A^l", "A")])
def test_pairs_that_say_nothing(pair: tuple[str, str]) -> None:
    assert relation(*map(parse_pattern, pair)) is None


PARTS = st.sampled_from(["A", "B^k", "(AB)^k", "C", "A^{m + 1}", "(CA)^m"])


@given(first=st.lists(PARTS, min_size=1, max_size=5), second=st.lists(PARTS, min_size=1, max_size=5))
def test_equations_hold_where_words_are_equally_long(first: list[str], second: list[str]) -> None:
    """The difference of two words, symbol by symbol, satisfies the relation for any counters."""
    patterns = [parse_pattern("".join(parts)) for parts in (first, second)]
    found = relation(*patterns)
    for k, m in product(range(3), repeat=2):
        counters = {"k": k, "m": m}
        words = [expand(pattern, Values(counters, (), {}), 100) or () for pattern in patterns]
        for symbol in "ABC":
            counts = [sum(slot.symbol == symbol for slot in word) for word in words]
            said = next((count for name, count in found.terms if name == symbol), None) if found else None
            assert counts[0] - counts[1] == (said.value(counters) if said else 0)
