"""Connected components of graphs, and equal rows of columns and lists."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.arrays import connected, distinct_lists, distinct_rows


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
