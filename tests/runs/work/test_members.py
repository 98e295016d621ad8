"""Values of strangers' files are used only if they have the expected types."""

import math

import pytest

from grammarlab.errors import AssetError
from grammarlab.runs.work.json_members import member, numbers, plain_values, texts


def test_a_member_of_another_type_is_named_with_its_position():
    with pytest.raises(AssetError, match=r"^grammar\.name: expected a text, found an object of 1\.$"):
        member({"name": {"a": 1}}, "name", str, "grammar")
    with pytest.raises(AssetError, match=r"^grammar: expected an object, found nothing\.$"):
        member(None, "name", str, "grammar")
    with pytest.raises(AssetError, match=r"^grammar\.name is missing\.$"):
        member({}, "name", str, "grammar")
    with pytest.raises(AssetError, match=r"^files\.a: expected a text, found 3\.$"):
        texts({"files": {"a": 3}}, "files")


@pytest.mark.parametrize(
    ("value", "kind"), [(True, int), (1, bool), (1.0, int), ("1", int), ([], dict), ({}, list), ("\ud800", str)]
)
def test_types_are_not_confused(value, kind):
    with pytest.raises(AssetError, match="expected"):
        member({"a": value}, "a", kind)


@pytest.mark.parametrize("value", [math.inf, math.nan, 10**4000, [1], None, {}, "\ud800"])
def test_plain_values_are_texts_finite_numbers_and_booleans(value):
    with pytest.raises(AssetError, match=r"^attributes\.b: expected a text"):
        plain_values({"a": 1.5, "b": value}, "attributes")


@pytest.mark.parametrize("value", ["123", [1, 2], [1, 2, "3"], [1, 2, True], [1, 2, math.inf], [1, 2, 10**4000]])
def test_numbers_are_finite_and_as_many_as_expected(value):
    with pytest.raises(AssetError, match="expected"):
        numbers(value, 3, "corner")
