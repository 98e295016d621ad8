"""Error of a facade as a member of its own family."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from grammarlab.facade.grammar.family import write_family
from grammarlab.facade.looks import look_of
from grammarlab.facade.tree import Facade, X, Y, check, laid_out
from tests.facade.grammar.houses import house, of_columns
from tests.facade.grammar.test_family import samples


def things(label: list[str], box: np.ndarray) -> tuple[list[str], np.ndarray]:
    """All elements except walls and the cornice, which columns cut, in the order of their positions."""
    kept = [(tuple(row[1::-1].round(3)), name, row) for name, row in zip(label, box, strict=True)]
    kept = sorted(
        (each for each in kept if not look_of(each[1]).is_flexible and each[1] != "cornice"), key=lambda e: e[:2]
    )
    return [name for _, name, _ in kept], np.array([row for _, _, row in kept])


def uneven(facade: Facade, by: float) -> Facade:
    """A facade with one pier wider in all rows."""
    wanted = facade.size.copy()
    starts = facade.position[facade.leaves, X]
    second = np.unique(starts.round(6))[2]
    wanted[facade.leaves[np.isclose(starts, second) & (facade.size[facade.leaves, X] < 1.0)], X] += by
    position, size = laid_out(facade.parent, facade.axis, wanted)
    return check(replace(facade, position=position, size=size))


@pytest.mark.parametrize("by", [0.0, 0.08, 0.2])
def test_the_error_is_that_of_the_nearest_of_many_samples_of_this_size(by: float):
    facade = uneven(of_columns(["WBDW", "WBWW", "WBWW"]), by)
    widths, heights = ((side - 0.3, side + 0.3) for side in facade.size[0].tolist())
    written = write_family(facade, widths, heights)
    leaves = facade.leaves
    names, expected = things(
        [facade.name_of(leaf) for leaf in leaves.tolist()], np.hstack([facade.position, facade.size])[leaves]
    )
    misses = [np.inf]
    for sample in samples(written.text, 64):
        called, found = things([name.rstrip("0123456789") for name in sample.label], sample.box)
        if called == names:
            misses.append(
                np.abs(
                    np.hstack([found[:, :2], found[:, :2] + found[:, 2:]])
                    - np.hstack([expected[:, :2], expected[:, :2] + expected[:, 2:]])
                ).max()
            )
    assert written.error == pytest.approx(min(misses), abs=1e-6)
    assert (written.error is not None and written.error > 0.01) == (by > 0.0)


def test_ranges_that_leave_out_the_facade_itself_do_not_change_its_error():
    facade = house(columns=5, rows=4)
    width, height = facade.size[0].tolist()
    for widths, heights in (((0.7, 1.5), (0.7, 1.5)), ((1.2, 2.0), (0.7, 1.5)), ((0.7, 1.5), (1.3, 2.0))):
        wide, high = (widths[0] * width, widths[1] * width), (heights[0] * height, heights[1] * height)
        written = write_family(facade, wide, high)
        assert written.error == pytest.approx(0.0, abs=1e-9)


def test_rows_whose_walls_differ_are_compared_one_by_one():
    facade = of_columns(["WWWW"] * 4)
    wanted, gaps = facade.size.copy(), facade.children[0][[4, 6]]
    wanted[gaps, Y] *= [1.25, 0.8]
    position, size = laid_out(facade.parent, facade.axis, wanted)
    facade = check(replace(facade, position=position, size=size))
    width, height = facade.size[0].tolist()
    walls = wanted[facade.children[0][2:9:2], Y]
    moved = np.cumsum(walls - walls.mean())  # the walls of the family have their mean
    written = write_family(facade, (0.7 * width, 1.5 * width), (0.7 * height, 1.5 * height))
    assert written.error == pytest.approx(np.abs(moved).max(), abs=1e-5)
