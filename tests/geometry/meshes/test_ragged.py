import itertools

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.arrays import offsets_from_counts
from grammarlab.geometry.meshes.ragged import all_rows, any_rows, cycles, distinct_keys, max_rows, next_in_row, sum_rows

QUICK = settings(max_examples=60, deadline=None)
ragged = st.lists(st.lists(st.integers(-9, 9), max_size=5), min_size=1, max_size=6)


@QUICK
@given(ragged)
def test_reductions_of_rows_are_those_of_lists(rows):
    offsets = offsets_from_counts(np.array([len(row) for row in rows]))
    values = np.array([value for row in rows for value in row], dtype=np.int64)
    assert sum_rows(values, offsets).tolist() == [sum(row) for row in rows]
    assert sum_rows(values * 0.5, offsets).tolist() == [sum(row) / 2 for row in rows]
    assert max_rows(values * 1.0, offsets, -99.0).tolist() == [max(row, default=-99) for row in rows]
    assert any_rows(values > 0, offsets).tolist() == [any(v > 0 for v in row) for row in rows]
    assert all_rows(values > 0, offsets).tolist() == [all(v > 0 for v in row) for row in rows]


@QUICK
@given(ragged)
def test_the_successor_of_the_last_value_is_the_first(rows):
    offsets = offsets_from_counts(np.array([len(row) for row in rows]))
    places = [list(range(a, b)) for a, b in itertools.pairwise(offsets)]
    assert next_in_row(offsets).tolist() == [p for row in places for p in (row[1:] + row[:1])]


@QUICK
@given(st.lists(st.integers(-9, 9), max_size=30))
def test_distinct_numbers_equal_keys_alike_in_ascending_order(keys):
    where, number = distinct_keys(np.array(keys, dtype=np.int64))
    assert [keys[k] for k in where] == sorted(set(keys))
    assert [keys[where[k]] for k in number] == keys


@QUICK
@given(st.integers(0, 40).flatmap(lambda n: st.permutations(range(n))))
def test_cycles_follow_the_permutation_until_it_returns(permutation):
    order, offsets = cycles(np.array(permutation, dtype=np.int64))
    expected, seen = [], set()
    for start in range(len(permutation)):
        if start not in seen:
            cycle = [start]
            while permutation[cycle[-1]] != start:
                cycle.append(permutation[cycle[-1]])
            seen.update(cycle)
            expected.append(cycle)
    assert [order[a:b].tolist() for a, b in itertools.pairwise(offsets)] == expected
