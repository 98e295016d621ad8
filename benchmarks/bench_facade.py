"""Sizes of facades: once with all preparations, again while a handle is dragged, and with columns to choose.

Targets on one core: 10 ms for 1,000 leaves, 5 ms while dragging, 1 s for retargeting 300 leaves.
"""

from __future__ import annotations

import numpy as np
import piqp
import pytest
from scipy import sparse

from grammarlab.facade.editing.retarget import retarget
from grammarlab.facade.sizes.size_wishes import width
from grammarlab.facade.sizes.solve import prepare, resize
from grammarlab.facade.tree import X
from tests.facade.sized import paper, storeys

THOUSAND = storeys(20, 12)
"""972 leaves."""
THREE_HUNDRED = storeys(10, 7)
"""287 leaves."""


def test_solve_1000_leaves_with_assembly(benchmark):
    assert not benchmark(resize, THOUSAND, [width(1.3 * THOUSAND.width)]).conflict


def test_solve_1000_leaves_while_dragging(benchmark):
    ready, wishes = prepare(THOUSAND, [width(THOUSAND.width)]), [width(1.2 * THOUSAND.width)]
    ready.resized(wishes)
    assert not benchmark(ready.resized, wishes).conflict


def test_solve_1000_leaves_where_some_become_as_small_as_may_be(benchmark):
    assert not benchmark(resize, THOUSAND, [width(0.2 * THOUSAND.width)]).conflict


def test_solve_1000_leaves_in_the_papers_formulation_by_piqp(benchmark):
    """What the first one is compared with: variables are leaves, the hierarchy has rows; without their assembly."""
    one = paper(THOUSAND, X, 1.0 / THOUSAND.size[THOUSAND.leaves, X], 1.3 * THOUSAND.width)
    quadratic, rows = sparse.csc_matrix(sparse.diags_array(one.weight**2)), sparse.csc_matrix(one.rows)
    linear, most = -(one.weight**2) * one.start, np.full(len(one.start), np.inf)

    def solve():
        solver = piqp.SparseSolver()
        solver.setup(quadratic, linear, rows, one.value, None, None, None, one.least, most)
        solver.solve()
        return np.array(solver.result.x)

    assert np.abs(one.rows @ benchmark(solve) - one.value).max() < 1e-3


@pytest.mark.parametrize("factor", [0.7, 1.3, 2.0])
def test_retarget_300_leaves(benchmark, factor):
    assert benchmark(retarget, THREE_HUNDRED, width=factor * THREE_HUNDRED.width).choices[0].proven
