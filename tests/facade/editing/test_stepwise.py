"""Columns that are added and removed one by one."""

import pytest

from grammarlab.facade.editing.retarget import stepwise
from grammarlab.facade.editing.variations import inherited, lost
from grammarlab.facade.sizes.size_wishes import Size
from grammarlab.facade.tree import X
from tests.facade.samples import windows


@pytest.mark.parametrize("factor", [0.3, 0.6])
def test_no_step_removes_the_last_copy_of_a_locked_part(factor: float) -> None:
    facade = windows(2, 4, (1.2, 0.8))
    node = int(facade.grids[0].places()[0, 1])
    locks = [Size(node, X, 3.0 * float(facade.size[node, X]))]
    found = stepwise(facade, [Size(0, X, factor * facade.width)], "window", locks)
    assert found.edits
    assert not lost(facade, locks, found)
    assert inherited(locks, found)
