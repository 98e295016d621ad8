from collections import Counter
from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.facade.grammar.rule_text import round_percentages
from grammarlab.facade.grammar.walks import KindSequence, Walks, WalkState, WalkStep, equal_futures, walks


def nine_decimals(values: Sequence[float]) -> list[float]:
    return [round(value, 9) for value in values]


def probabilities(found: Walks, doors: tuple[bool, ...] | None = None) -> dict[tuple[int, ...], float]:
    """Probability of each walk, given by its columns; with doors, by the rules of states with equal futures."""
    first = {state: state for state in found.steps} if doors is None else equal_futures(found, doors, nine_decimals)
    result: dict[tuple[int, ...], float] = {}

    def go(state, taken: tuple[int, ...], probability: float) -> None:
        state = first[state]
        if state in found.end:
            result[taken] = result.get(taken, 0.0) + probability * found.end[state]
        for step in found.steps[state]:
            go(step.to, (*taken, step.to.kind), probability * step.probability)

    go(found.start, (found.start.kind,), 1.0)
    return result


def columns_of(kinds: list[int], sizes: list[float], doors: list[bool]) -> KindSequence:
    return KindSequence(tuple(kinds), tuple(sizes), (True,) * len(sizes), tuple(doors))


@given(
    st.lists(st.integers(0, 2), min_size=2, max_size=6),
    st.lists(st.sampled_from([1.0, 1.5, 2.0]), min_size=3, max_size=3),
    st.lists(st.booleans(), min_size=3, max_size=3),
    st.floats(1.0, 6.0),
)
def test_walks_are_those_that_brute_force_finds(
    kinds: list[int], sizes: list[float], doors: list[bool], high: float
) -> None:
    columns = columns_of(kinds, sizes, doors)
    low = 0.5 * high
    found = walks(columns, low, high)
    pairs = Counter(pairwise(kinds))

    def allowed(walk: tuple[int, ...], pairs: Counter[tuple[int, int]]) -> bool:
        return (
            walk[0] == kinds[0]
            and walk[-1] == kinds[-1]
            and all(pairs[pair] for pair in pairwise(walk))
            and [k for k in walk if doors[k]] == [k for k in kinds if doors[k]]
        )

    def width(walk: tuple[int, ...]) -> float:
        return sum(sizes[kind] for kind in walk)

    def all_walks(pairs: Counter[tuple[int, int]]) -> dict[tuple[int, ...], float]:
        """Each with the product of the frequencies of its steps in the facade."""
        every = (walk for num in range(1, 7) for walk in product(range(3), repeat=num) if allowed(walk, pairs))
        return {walk: float(np.prod([pairs[pair] for pair in pairwise(walk)])) for walk in every}

    own, repeated = all_walks(pairs), all_walks(pairs + Counter((k, k) for k in set(kinds) if not doors[k]))
    likely = {} if found is None else probabilities(found)
    weights = own if len(likely) > 1 and set(likely) <= set(own) else repeated
    assert set(likely) <= {walk for walk in weights if low - 1e-9 <= width(walk) <= high + 1e-9}
    # All walks are found for lengths that fit completely.
    for num in range(1, 7):
        alike = [walk for walk in own if len(walk) == num]
        if all(low <= width(walk) <= high for walk in alike):
            assert set(alike) <= set(likely)
    if found is not None:
        assert np.isclose(sum(likely.values()), 1.0)
        assert found.total == len(likely)
    for num in {len(walk) for walk in likely}:
        alike = [walk for walk in likely if len(walk) == num]
        assert np.isclose(sum(likely[walk] for walk in alike), 1.0 / len({len(walk) for walk in likely}))
        shares = np.array([likely[walk] / weights[walk] for walk in alike])
        assert np.allclose(shares, shares[0])


@given(
    st.lists(st.integers(0, 3), min_size=2, max_size=7),
    st.lists(st.sampled_from([1.0, 1.5, 2.0]), min_size=4, max_size=4),
    st.lists(st.booleans(), min_size=4, max_size=4),
)
def test_states_with_equal_futures_have_one_rule_and_walks_keep_their_probabilities(
    kinds: list[int], sizes: list[float], doors: list[bool]
) -> None:
    found = walks(columns_of(kinds, sizes, doors), 2.0, 9.0)
    if found is not None:
        assert probabilities(found, tuple(doors)) == pytest.approx(probabilities(found), rel=1e-7)
        assert len(set(equal_futures(found, tuple(doors), nine_decimals).values())) <= len(found.steps)


def test_frequent_steps_are_likelier() -> None:
    found = walks(columns_of([0, 0, 0, 1, 0], [1.0, 1.0], [False, False]), 4.0, 4.0)
    assert found is not None
    likely = probabilities(found)
    assert likely[0, 0, 0, 0] == pytest.approx(8.0 / (8.0 + 2.0 + 2.0))
    assert likely[0, 1, 0, 0] == pytest.approx(2.0 / (8.0 + 2.0 + 2.0))


def test_nothing_that_stands_has_no_walks() -> None:
    assert walks(KindSequence((0,), (5.0,), (False,), (False,)), 0.0, 10.0) is None


@pytest.mark.parametrize(("one", "other", "are_equal"), [(0.996, 0.999, False), (0.501, 0.502, True)])
def test_states_are_equal_where_their_percentages_are_written_alike(
    one: float, other: float, *, are_equal: bool
) -> None:
    start, left, right, end = WalkState(0, 0, 1), WalkState(1, 0, 2), WalkState(2, 0, 2), WalkState(0, 0, 3)
    steps = {
        start: (WalkStep(0.5, -1, left), WalkStep(0.5, -1, right)),
        left: (WalkStep(one, -1, end),),
        right: (WalkStep(other, -1, end),),
        end: (),
    }
    ends = {left: 1.0 - one, right: 1.0 - other, end: 1.0}
    found = Walks(before=-1, after=-1, start=start, steps=steps, end=ends, sizes={}, total=4.0)
    first = equal_futures(found, (False,) * 3, round_percentages)
    assert (first[left] == first[right]) == are_equal


@given(st.lists(st.floats(-14.0, 0.0), min_size=1, max_size=8))
def test_percentages_add_up_to_100_and_none_is_0(exponents: list[float]) -> None:
    written = [Fraction(text) for text in round_percentages([10.0**exponent for exponent in exponents])]
    assert sum(written) == 100
    assert min(written) > 0
