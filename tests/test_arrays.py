"""Connected components of graphs, equal rows of columns and lists, and operations on ragged lists."""

from __future__ import annotations

from collections import Counter
from itertools import groupby

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.arrays import (
    connected,
    distinct_counts,
    distinct_hashes,
    distinct_lists,
    distinct_pairs,
    distinct_rows,
    hashed,
    index_in_row,
    narrow,
    ranked,
    row_lengths,
    runs,
    take_rows,
)


@st.composite
def graphs(draw) -> tuple[int, list[tuple[int, int]]]:
    num = draw(st.integers(0, 12))
    nodes = st.integers(0, num - 1)
    return num, draw(st.lists(st.tuples(nodes, nodes), max_size=16)) if num else []


@given(graphs())
def test_components_are_those_of_merging_sets_one_edge_at_a_time_numbered_by_their_first_nodes(graph) -> None:
    num, edges = graph
    sets = [{node} for node in range(num)]
    for one, other in edges:
        joined = next(s for s in sets if one in s) | next(s for s in sets if other in s)
        sets = [s for s in sets if not s & joined] + [joined]
    sets.sort(key=min)
    expected = [next(i for i, s in enumerate(sets) if node in s) for node in range(num)]
    one, other = np.array(edges, dtype=np.int64).reshape(-1, 2).T
    assert connected(num, one, other).tolist() == expected


@given(
    st.lists(st.tuples(st.integers(0, 2), st.sampled_from([0.0, -0.0, 0.5, 0.5 + 2.0**-53])), max_size=12),
    st.sampled_from([1, 9]),
)
def test_rows_are_equal_if_all_their_bits_are(rows, repeats) -> None:
    rows = rows * repeats
    whole, real = np.array([row[0] for row in rows], dtype=np.int32), np.array([row[1] for row in rows])
    first, number = distinct_rows(whole, np.stack([real, real], axis=1))
    bits = [(one, np.float64(other).tobytes()) for one, other in rows]
    assert number.tolist() == [list(dict.fromkeys(bits)).index(key) for key in bits]
    assert first.tolist() == [bits.index(key) for key in dict.fromkeys(bits)]


@given(st.lists(st.lists(st.integers(0, 2), max_size=3), max_size=10))
def test_lists_are_equal_if_their_values_are(lists) -> None:
    values = np.array([value for row in lists for value in row], dtype=np.int64)
    first, number = distinct_lists(values, np.array([len(row) for row in lists], dtype=np.int64))
    for i, one in enumerate(lists):
        for j, other in enumerate(lists):
            assert i == j or number[i] != number[j] or one == other
    assert [lists[i] for i in first[number].tolist()] == lists
    if len({len(row) for row in lists}) == 1:
        assert len(first) == len({tuple(row) for row in lists})


@pytest.mark.parametrize("num", [0, 1, 50, 4_001, 30_000])
@pytest.mark.parametrize("different", [1, 3, 20_000])
def test_equal_hashes_have_the_number_of_their_first_one(num, different) -> None:
    values = np.random.default_rng(num + different).integers(0, different, num)
    first, number = distinct_hashes(hashed(values))
    _, expected, inverse = np.unique(values, return_index=True, return_inverse=True)
    assert np.array_equal(first, np.sort(expected))
    assert np.array_equal(first[number], expected[inverse])


def test_hashes_that_share_a_place_of_the_table_are_told_apart() -> None:
    keys = np.arange(5_000, dtype=np.uint64).repeat(2)  # the first digits of all are zero
    first, number = distinct_hashes(keys)
    assert np.array_equal(first, np.arange(0, 10_000, 2))
    assert np.array_equal(number, np.arange(5_000).repeat(2))


@given(
    st.lists(st.tuples(st.integers(-3, 3), st.integers(0, 4)), max_size=60), st.sampled_from([1, 10**9]), st.booleans()
)
def test_pairs_are_equal_if_both_integers_are(pairs, spread, are_many) -> None:
    # Many pairs of few possible values are counted, of many possible values hashed; few are sorted.
    pairs = [(spread * first, second) for first, second in pairs] * (40 if are_many else 1)
    one, other = (np.array(column, dtype=np.int64) for column in (zip(*pairs, strict=True) if pairs else ([], [])))
    different, others, number = distinct_pairs(one, other, 5)
    assert list(zip(different.tolist(), others.tolist(), strict=True)) == sorted(set(pairs))
    assert np.array_equal(different[number], one)
    assert np.array_equal(others[number], other)


def test_pairs_whose_code_would_overflow_are_refused() -> None:
    other = np.array([1, 1])
    for first in (1 << 40, -(1 << 40)):
        with pytest.raises(OverflowError, match=r"at most 2\^62"):
            distinct_pairs(np.array([first, 0]), other, 1 << 24)
    large = np.array([(1 << 40) - 1, 1 - (1 << 40), (1 << 40) - 1])
    assert [column.tolist() for column in distinct_pairs(large, np.array([9, 9, 9]), 1 << 22)] == [
        [int(large[1]), int(large[0])],
        [9, 9],
        [1, 0, 1],
    ]


@pytest.mark.parametrize("limit", [70, 100_000])
def test_ranks_are_those_of_sorting_for_few_and_many_possible_values(limit) -> None:
    values = np.random.default_rng(1).integers(0, 70, 300)
    for found, expected in zip(ranked(values, limit), np.unique(values, return_inverse=True), strict=True):
        assert np.array_equal(found, expected)


@given(st.lists(st.lists(st.integers(0, 9), max_size=3), max_size=8), st.data())
def test_rows_are_taken_as_lists_are(lists, data) -> None:
    values = np.array([value for row in lists for value in row], dtype=np.int64)
    offsets = np.cumsum([0, *map(len, lists)])
    rows = data.draw(st.lists(st.sampled_from(range(len(lists))), max_size=9)) if lists else []
    where, taken = take_rows(offsets, np.array(rows, dtype=np.int64))
    assert [part.tolist() for part in np.split(values[where], taken[1:-1])][: len(rows)] == [lists[row] for row in rows]
    assert row_lengths(offsets).tolist() == [len(row) for row in lists]
    assert index_in_row(row_lengths(offsets)).tolist() == [index for row in lists for index in range(len(row))]


@pytest.mark.parametrize("largest", [5, 65_535, 65_536, 1 << 40])
def test_narrow_columns_have_the_same_order(largest) -> None:
    values = np.random.default_rng(2).integers(0, largest, 200, endpoint=True)
    assert np.array_equal(np.argsort(narrow(values), kind="stable"), np.argsort(values, kind="stable"))


@given(st.lists(st.tuples(st.integers(0, 2), st.integers(0, 1)), max_size=30))
def test_runs_are_the_groups_of_neighbours_that_are_equal(rows) -> None:
    columns = np.array(rows, dtype=np.int16).reshape(-1, 2).T
    starts, lengths = runs(*columns)
    assert lengths.tolist() == [len(list(group)) for _, group in groupby(rows)]
    assert starts.tolist() == (np.cumsum(lengths) - lengths).tolist()


@given(st.lists(st.tuples(st.integers(0, 20), st.integers(1, 5)), min_size=1, max_size=30), st.sampled_from([21, 500]))
def test_weights_count_a_value_as_often_as_if_it_were_repeated(weighted, limit) -> None:
    values, weights = np.array(weighted).T
    different, counts = distinct_counts(values, limit, weights)
    expected = Counter(values.repeat(weights).tolist())
    assert dict(zip(different.tolist(), counts.tolist(), strict=True)) == expected
    assert different.tolist() == sorted(expected)
