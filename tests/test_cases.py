"""The five parts of a bulk of cases are all of it, and each of them is the same whenever it is tried."""

import pytest
from hypothesis import given, seed, settings
from hypothesis import strategies as st

from tests import cases
from tests.cases import PARTS, bulk, is_due, part, some


@pytest.mark.parametrize("num", [1, 4, 5, 6, 25, 300])
def test_parts_are_all_cases_and_none_is_empty(num):
    parts = [some(range(num), chosen) for chosen in range(PARTS)]
    assert {case for cases in parts for case in cases} == set(some(range(num), None)) == set(range(num))
    assert all(1 <= len(cases) <= -(-num // PARTS) for cases in parts)
    if num >= PARTS:
        assert sum(map(len, parts)) == num


@pytest.mark.parametrize("outside", [True, False])
def test_parts_of_examples_are_all_that_are_made(monkeypatch, outside):
    def tried(chosen):
        monkeypatch.setattr(cases, "PART", chosen)
        numbers = []

        def note(number):
            numbers.append(number)

        given_number = given(st.integers(0, 10**9))
        test = bulk(40)(given_number(note)) if outside else given_number(bulk(40)(note))
        seed(1)(test)()
        return numbers

    parts, whole = [tried(chosen) for chosen in range(PARTS)], tried(None)
    assert sorted(number for numbers in parts for number in numbers) == sorted(whole)
    assert [len(numbers) for numbers in parts] == [8] * PARTS


def test_a_failure_is_found_and_explained(monkeypatch):
    monkeypatch.setattr(cases, "PART", 2)

    @bulk(60, database=None)
    @given(st.integers(0, 10**9))
    def is_small(number):
        assert number < 1000

    with pytest.raises(AssertionError, match="1000 < 1000"):
        is_small()


def test_a_week_chooses_a_part_unless_one_is_asked_for():
    assert [part("", week) for week in range(1, 7)] == [1, 2, 3, 4, 0, 1]
    assert part("2", 48) == 2
    assert part("all", 48) is None
    with pytest.raises(AssertionError, match="expected all or a number below 5"):
        part("5", 48)


def test_examples_are_repeatable_unless_new_ones_are_asked_for():
    assert settings().derandomize or settings().max_examples == 1000


def test_dear_tests_are_each_in_the_runs_of_one_week_in_five():
    names = [f"test_{number}" for number in range(200)]
    turns = [[name for name in names if is_due(name, chosen)] for chosen in range(PARTS)]
    assert sorted(name for turn in turns for name in turn) == sorted(names)
    assert all(turns)
    assert all(is_due(name, None) for name in names)
