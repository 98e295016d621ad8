"""How many cases a run tries: a fifth of the bulk in an ordinary run, all of them once a week.

Tests that take seconds, of several processes such as a browser and its server or of a learner that finds one kind of
taste in one kind of scores, take turns too (`takes_turns`): each, and each of its parameters, is in the runs of every
fifth week. What keeps a person's data is in all runs. So are laws of learning: seeds, order of answers, never worse.

Fuzzers and comparisons with solvers try many cases of one kind. An ordinary run tries a fifth of them, another one each
calendar week; `make test-all` tries all. ``GRAMMARLAB_CASES=2`` tries the fifth of that number again.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from functools import wraps
from itertools import count
from typing import Any, TypeVar
from zlib import crc32

import pytest
from hypothesis import settings

PARTS = 5
Item = TypeVar("Item")
Test = TypeVar("Test", bound=Callable[..., Any])


def part(setting: str, week: int) -> int | None:
    """The number of the part to try, or None for all.

    Args:
        setting: ``all``, the number of a part, or nothing for that of the week.
        week: number of a calendar week.
    """
    if setting == "all":
        return None
    chosen = int(setting) if setting else week % PARTS
    assert 0 <= chosen < PARTS, f"GRAMMARLAB_CASES: expected all or a number below {PARTS}, found {setting!r}"
    return chosen


PART = part(os.environ.get("GRAMMARLAB_CASES", ""), datetime.now(UTC).isocalendar().week)
"""The part that this run tries; None for all."""


def some(cases: Sequence[Item], chosen: int | None = PART) -> list[Item]:
    """Every fifth case, at least one, or all."""
    return list(cases) if chosen is None else list(cases[chosen % len(cases) :: PARTS])


def bulk(max_examples: int, **options: Any) -> Callable[[Test], Test]:
    """Settings of a property for which Hypothesis looks for counterexamples: a fifth of its examples is tried, or all.

    All examples are made, the same ones in every run, and every fifth is tried: the parts together are all of them. Not
    for properties that draw in their body, since what they draw depends on the examples before.
    """

    def limited(test: Test) -> Test:
        chosen = settings(max_examples=max_examples, deadline=None, **options)(test)
        if PART is None or not settings().derandomize:
            return chosen
        if not hasattr(chosen, "hypothesis"):
            return _every_fifth(chosen, PART)
        chosen.hypothesis.inner_test = _every_fifth(chosen.hypothesis.inner_test, PART)  # ty: ignore[missing-attribute]  # pyright: ignore[reportFunctionMemberAccess]
        return chosen

    return limited


def takes_turns(test: Test) -> Test:
    """A dear test: ordinary runs of every fifth week try it, `make test-all` always does; so does a run of it alone."""
    return pytest.mark.takes_turns(test)


def is_due(name: str, chosen: int | None = PART) -> bool:
    """Whether a test with this name that takes turns is tried."""
    return chosen is None or crc32(name.encode()) % PARTS == chosen


def _every_fifth(test: Test, chosen: int) -> Test:
    """A test that does nothing in the other calls, until it has failed: then it is called again to explain why."""
    calls, failed = count(), False

    @wraps(test)
    def tried(*arguments: Any, **named: Any) -> Any:
        nonlocal failed
        if next(calls) % PARTS != chosen and not failed:
            return None
        try:
            return test(*arguments, **named)
        except Exception:
            failed = True
            raise

    return tried  # ty: ignore[invalid-explicit-return]  # pyright: ignore[reportReturnType]
