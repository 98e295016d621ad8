"""Connected components of graphs."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.arrays import connected


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
