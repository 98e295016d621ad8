"""Values for attributes."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import UsageError
from grammarlab.language.attribute_values import fit_properties, read_attributes, usable_properties
from grammarlab.language.grammar import Grammar

GRAMMAR = Grammar.parse(
    """
    attr height = 5
    attr style = 50% : "old" else : "new"
    attr shops = false
    attr drawn = 30% : 4 else : rand(1, 2)
    attr mixed = 50% : 1 else : "one"
    const levels = 3
    Lot --> NIL
    """
)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_come_through_exactly(number):
    assert read_attributes([f"height={number!r}", f"mixed={number!r}"], GRAMMAR) == {"height": number, "mixed": number}
    assert fit_properties({"height": number}, GRAMMAR) == {"height": number}


@given(st.text(alphabet=st.characters(exclude_categories=["Cs"]), max_size=30))
def test_strings_come_through_as_they_are(text):
    assert fit_properties({"style": text}, GRAMMAR) == {"style": text}
    assert read_attributes([f'style="{text}"'], GRAMMAR) == {"style": text}


def test_the_kind_of_value_follows_the_attribute_and_else_the_text():
    texts = ["style=1900", "shops=TRUE", "height=1e1", "mixed=true", "unknown=red"]
    assert read_attributes(texts, GRAMMAR) == {
        "style": "1900",
        "shops": True,
        "height": 10.0,
        "mixed": True,
        "unknown": "red",
    }


def test_properties_take_the_kind_of_the_attribute_and_leave_constants_alone():
    properties = {"height": "12", "style": 3.0, "shops": True, "levels": 9.0, "other": 1.0}
    assert fit_properties(properties, GRAMMAR) == {"height": 12.0, "style": "3", "shops": True}


def test_properties_are_written_as_in_maps():
    properties = {"height": "12 m", "drawn": "40 ft", "style": "12 m", "shops": "yes"}
    expected = {"height": 12.0, "drawn": 12.192, "style": "12 m", "shops": True}
    assert usable_properties(properties, GRAMMAR).values == expected
    assert [usable_properties({"shops": value}, GRAMMAR).values["shops"] for value in ("no", 0.0, 1.0, "TRUE")] == [
        False,
        False,
        True,
        True,
    ]


def test_properties_that_an_attribute_cannot_take_are_named_and_others_are_used():
    usable = usable_properties({"height": "tall" * 1000, "drawn": "1,200", "shops": 2.0, "style": "old"}, GRAMMAR)
    assert usable.values == {"style": "old"}
    assert set(usable.problems) == {"height", "drawn", "shops"}
    assert "attribute 'drawn': expected a finite number, found '1,200'" in usable.problems.values()
    assert all(len(problem) < 200 for problem in usable.problems.values())
    with pytest.raises(UsageError, match="'shops': expected true or false"):
        fit_properties({"shops": "perhaps"}, GRAMMAR)


@pytest.mark.parametrize(
    "text",
    [
        "height",
        "=5",
        "height=",
        "height=tall",
        "height=inf",
        "height=1_000",
        "height=٣",
        "height=1e999",
        "shops=1",
        "height=true",
        "drawn=true",
        "drawn=tall",
    ],
)
def test_what_does_not_fit_is_refused(text):
    with pytest.raises(UsageError, match="expected"):
        read_attributes([text], GRAMMAR)


def test_a_name_may_come_once():
    with pytest.raises(UsageError, match="twice"):
        read_attributes(["height=1", "height=2"], GRAMMAR)
