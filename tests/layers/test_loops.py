"""The shortest descriptions of words, against all of them."""

import random
from functools import cache

import pytest

from grammarlab.layers.axis_patterns import cost_of, shortest
from tests.cases import some


@cache
def least(word: str, loop: int) -> int:
    """Cost of the cheapest description, over all first runs."""
    if not word:
        return 0
    found = [1 + least(word[1:], loop)]
    for length in range(1, len(word) // 2 + 1):
        for times in range(2, len(word) // length + 1):
            if word[: length * times] == word[:length] * times:
                found.append(length + loop + least(word[length * times :], loop))
    return min(found)


@pytest.mark.parametrize("seed", some(range(60)))
def test_no_description_is_shorter(seed: int) -> None:
    rng = random.Random(seed)
    unit = "".join(rng.choice("abc") for _ in range(rng.randint(1, 4)))
    word = "".join(rng.choice(["a", "b", unit, unit * 2]) for _ in range(rng.randint(0, 6)))[:18]
    for loop in (0, 1, 3):
        prices = [1] * len(word)
        runs = shortest(word, prices, loop)
        assert "".join(word[run.start : run.start + run.length] * run.times for run in runs) == word
        assert cost_of(runs, prices, loop) == least(word, loop)


def test_letters_stand_before_loops() -> None:
    runs = shortest("ABABABA", [1] * 7)
    assert [(run.start, run.length, run.times) for run in runs] == [(0, 1, 1), (1, 2, 3)]
    assert shortest("", []) == ()


def test_dear_letters_are_repeated_first() -> None:
    """In both descriptions one `x` is single; `y` occurs once."""
    runs = shortest("xyxyx", [1, 9, 1, 9, 1])
    assert cost_of(runs, [1, 9, 1, 9, 1]) == 12
