"""Patterns as text."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.layers.patterns import MOST_CHARACTERS, PatternError, Values, expand, parse_pattern


def word(text: str, *choices: int, **counters: int) -> str:
    """The word of a pattern, with primes on mirrored letters."""
    slots = expand(parse_pattern(text), Values(counters, choices, {}), 1_000)
    assert slots is not None
    return "".join(slot.symbol + ("'" if slot.mirrored else "") for slot in slots)


@pytest.mark.parametrize(
    ("text", "counters", "expected"),
    [
        ("A(BA)^k", {"k": 2}, "ABABA"),
        ("A (B A)^{k}", {"k": 0}, "A"),
        ("A^3", {}, "AAA"),
        ("yB^mA^{m-1}By", {"m": 2}, "yBBABy"),
        ("A^{2k + 1}", {"k": 2}, "AAAAA"),
        ("A^{2*k-m}", {"k": 2, "m": 1}, "AAA"),
        ("x^m; m := A", {"m": 1}, None),
        ("xm; m := A(BA)^k", {"k": 1}, "xABA"),
        ("m x m; m := AB", {}, "ABxAB"),
        ("GY(zS)^pz^bv; z := Z", {"p": 2, "b": 1}, "GYZSZSZv"),
        ("(mX)^p; m := A^k", {"p": 2, "k": 2}, "AAXAAX"),
        ("AB^-k", {"k": 1}, "ABB'"),
        ("(((A)))", {}, "A"),
        ("Δ'πβ", {}, "Δ'πβ"),
    ],
)
def test_words_of_patterns(text: str, counters: dict[str, int], expected: str | None) -> None:
    if expected is None:
        with pytest.raises(PatternError, match="does not occur"):
            parse_pattern(text)
    else:
        assert word(text, **counters) == expected


def test_alternatives_are_chosen_once_for_all_copies() -> None:
    pattern = parse_pattern("A(B|CD)^2(E|F)")
    assert pattern.options() == (2, 2)
    assert [word("A(B|CD)^2(E|F)", *each) for each in [(0, 0), (1, 1)]] == ["ABBE", "ACDCDF"]


def test_letters_of_control_patterns_are_placeholders_and_their_contents_are_not() -> None:
    slots = expand(parse_pattern("cec; c := C"), Values({}, (), {}), 10)
    assert slots is not None
    assert [(slot.symbol, slot.placeholder) for slot in slots] == [("C", False), ("e", True), ("C", False)]


def test_names_of_several_letters_stand_in_braces() -> None:
    pattern = parse_pattern("{end wall}({window}{end  wall})^{floors - 1}")
    assert pattern.symbols() == ("end wall", "window")
    assert pattern.counters() == ("floors",)


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        ("", 0, "found the end"),
        ("A(B", 3, r"expected '\)'"),
        ("A)", 1, r"found '\)'"),
        ("^k", 0, "found"),
        ("A^", 1, "found"),
        ("A^{}", 1, "number of copies"),
        ("A^{k+}", 1, "number of copies"),
        ("A^{2 3}", 1, "number of copies"),
        ("A^{9999999}", 1, "at most"),
        ("A2", 1, "found '2'"),
        ("{}A", 0, "begins with a letter"),
        ("((A)^k B)^m", 4, "copies of copies"),
        ("A|(B|C)", 3, "choice inside a choice"),
        ("cec; c := ce", 10, "content inside a content"),
        ("cec; c := C; c := D", 13, "given twice"),
        ("cec; d := D", 5, "does not occur"),
        ("A||B", 2, "found"),
        ("(" * 100 + "A" + ")" * 100, 40, "at most 40 deep"),
        ("A" * (MOST_CHARACTERS + 1), 0, "characters"),
    ],
)
def test_mistakes_have_places(text: str, place: int, message: str) -> None:
    with pytest.raises(PatternError) as caught:
        parse_pattern(text)
    assert caught.value.position == place
    assert re.search(message, caught.value.message)


@given(st.text(alphabet="AB(){}^|;:=k-+2 \n", max_size=24))
def test_any_text_is_a_pattern_or_a_mistake_in_it(text: str) -> None:
    error, pattern = None, None
    try:
        pattern = parse_pattern(text)
    except PatternError as caught:
        error = caught
    assert (pattern.text == text) if pattern else error is not None and 0 <= error.position <= len(text)


def test_words_that_are_too_long_are_not_made() -> None:
    assert expand(parse_pattern("A^{100000}"), Values({}, (), {}), 1_000) is None
