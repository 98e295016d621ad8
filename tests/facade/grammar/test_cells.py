import itertools

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.facade.grammar.bands import bands
from grammarlab.facade.grammar.contents import Cell, cell_of, nodes_between
from grammarlab.facade.tree import LEAF, Facade
from tests.facade.strategies import trees


def boxes(cell: Cell, low: np.ndarray, high: np.ndarray) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """The elements of a cell with the corners of their boxes, for a cell that fills a rectangle."""
    if cell.axis == LEAF:
        return [(cell.label, low, high)]
    found, at = [], low[cell.axis]
    for size, part in cell.parts:
        first, last = low.copy(), high.copy()
        first[cell.axis], last[cell.axis] = at, at + size
        found += boxes(part, first, last)
        at += size
    return found


@settings(max_examples=60)
@given(trees(), st.lists(st.floats(0.0, 1.0), min_size=4, max_size=4))
def test_a_cell_is_what_stands_there(facade: Facade, corners: list[float]) -> None:
    sides = np.array(corners).reshape(2, 2) * facade.size[0]
    low, high = sides.min(axis=0), sides.max(axis=0)
    if (high - low < 1e-3).any():
        return
    nodes = nodes_between(facade, 1, low[1], high[1], 1e-9)
    found = boxes(cell_of(facade, nodes, low.tolist(), high.tolist(), [1e-9, 1e-9]), low, high)
    for point in np.random.default_rng(0).uniform(low, high, (40, 2)):
        here = [label for label, first, last in found if (first <= point).all() and (point < last).all()]
        ends = facade.position[facade.leaves] + facade.size[facade.leaves]
        inside = (facade.position[facade.leaves] <= point).all(axis=1) & (point < ends).all(axis=1)
        assert here == [facade.name_of(leaf) for leaf in facade.leaves[inside].tolist()]


@given(trees())
def test_bands_fill_the_facade_and_cut_no_window(facade: Facade) -> None:
    for axis in (0, 1):
        found = bands(facade, axis)
        assert np.isclose(sum(band.size for band in found), facade.size[0, axis])
        assert all(one.end == other.start for one, other in itertools.pairwise(found))
        for leaf in facade.leaves.tolist():
            if facade.name_of(leaf) == "window":
                low = facade.position[leaf, axis]
                high = low + facade.size[leaf, axis]
                assert all(not low + 1e-5 < band.end < high - 1e-5 for band in found)
