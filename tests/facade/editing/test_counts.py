from itertools import product

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.arrays import Ints
from grammarlab.facade.editing.springs import Box, SpringRows, Strips, best_counts


@st.composite
def rows_of_springs(draw: st.DrawFn) -> SpringRows:
    randomness = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    rows, kinds = draw(st.integers(1, 3)), draw(st.integers(1, 3))
    give = randomness.uniform(0.1, 2.0, (rows, kinds))
    return SpringRows(
        length=randomness.uniform(0.5, 3.0, (rows, kinds)),
        give=give,
        rest=randomness.uniform(0.0, 0.1, kinds),
        fixed_length=randomness.uniform(-0.4, 2.0, rows),
        fixed_give=randomness.uniform(-0.05, 1.0, rows),
        fixed_rest=float(randomness.uniform(0.0, 1.0)),
        size=float(randomness.uniform(1.0, 15.0)),
        share=randomness.uniform(0.0, 4.0, kinds),
        price=10.0 ** randomness.uniform(-5.0, 0.0, kinds),
        strips=Strips(
            length=randomness.uniform(0.5, 3.0, (rows, kinds)),
            fixed_length=randomness.uniform(-0.4, 2.0, rows),
            stiffness=draw(st.sampled_from([0.0, 0.05, 1.0])),
            whole=float(randomness.uniform(1.0, 15.0)),
        ),
    )


def cost(rows: SpringRows, counts: Ints) -> float:
    return rows.energy(counts) + rows.unevenness(counts)


def every(least: Ints, most: Ints) -> list[Ints]:
    return [np.array(each) for each in product(*(range(low, high + 1) for low, high in zip(least, most, strict=True)))]


@given(rows_of_springs(), st.data())
def test_no_counts_in_a_box_cost_less_than_its_bound(rows: SpringRows, data: st.DataObject) -> None:
    kinds = len(rows.rest)
    least = np.array(data.draw(st.lists(st.integers(1, 3), min_size=kinds, max_size=kinds)))
    most = least + np.array(data.draw(st.lists(st.integers(0, 3), min_size=kinds, max_size=kinds)))
    bound = Box(rows, least, most).bound()
    costs = [cost(rows, counts) for counts in every(least, most)]
    assert bound <= min(costs) * (1.0 + 1e-9)
    halves = Box(rows, least, most).halves() if (least < most).any() else ()
    assert all(half.bound() >= bound - 1e-6 * abs(bound) - 1e-6 for half in halves)
    assert sum(len(every(half.least, half.most)) for half in halves) in {0, len(costs)}


@given(rows_of_springs(), st.floats(0.0, 1.0), st.integers(0, 2**32 - 1))
def test_the_cheapest_counts_are_found_whatever_is_added_to_the_springs(
    rows: SpringRows, more: float, seed: int
) -> None:
    """Ties between rows increase the cost of counts by amounts that the bound does not include."""
    kinds = len(rows.rest)
    least, most = np.ones(kinds, dtype=np.int64), np.full(kinds, 5)
    extra = more * np.random.default_rng(seed).random((6,) * kinds)

    def solve(_: int, counts: Ints) -> float:
        return cost(rows, counts) + float(extra[tuple(counts)])

    found = best_counts([Box(rows, least, most)], solve, least, 0.0, 1e-12, 10_000)
    assert np.isclose(found.cost, min(solve(0, counts) for counts in every(least, most)))
    assert found.cost == solve(0, found.counts)
    assert found.bound <= found.cost
    assert np.isclose(found.bound, found.cost, rtol=1e-9, atol=1e-9)


def test_the_bound_that_is_left_is_reported() -> None:
    rows = SpringRows(
        length=np.array([[1.0, 1.3]]),
        give=np.array([[1.0, 1.0]]),
        rest=np.zeros(2),
        fixed_length=np.zeros(1),
        fixed_give=np.zeros(1),
        fixed_rest=0.0,
        size=7.0,
        share=np.array([2.0, 2.0]),
        price=np.array([0.01, 0.01]),
    )
    box = Box(rows, np.array([1, 0]), np.array([9, 9]))
    found = best_counts([box], lambda _, counts: 1.0 + cost(rows, counts), np.array([1, 0]), 0.0, 0.0, 1)
    assert found.tries == 1
    assert found.bound < 1.0 < found.cost


def test_what_is_impossible_is_not_chosen() -> None:
    rows = SpringRows(
        length=np.array([[1.0]]),
        give=np.array([[1.0]]),
        rest=np.zeros(1),
        fixed_length=np.zeros(1),
        fixed_give=np.zeros(1),
        fixed_rest=0.0,
        size=3.0,
        share=np.array([3.0]),
        price=np.array([1.0]),
    )
    box = Box(rows, np.array([1]), np.array([9]))
    found = best_counts(
        [box], lambda _, counts: np.inf if counts[0] == 3 else cost(rows, counts), np.array([1]), 0.0, 0.0, 99
    )
    assert found.counts.tolist() == [4]
