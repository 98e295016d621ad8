"""What holds of a facade however it is edited."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from grammarlab.errors import FacadeError
from grammarlab.facade.editing.variations import vary
from grammarlab.facade.size_locks import KINDS
from grammarlab.facade.sizes.size_wishes import Size
from grammarlab.facade.tree import X, Y, check
from grammarlab.pages.editor.desk import boxes
from grammarlab.pages.editor.document import Document, arranged, locked, opened, unlocked, varied
from tests.facade.samples import windows


def resized(document: Document, width: float, height: float) -> Document:
    return document.settled(document.sizing().resized(document.wishes(width, height)))


def test_a_side_that_is_dragged_away_and_back_leaves_the_facade_as_it_was():
    first = opened(windows(3, 4, (1.0, 1.3)))
    facade = first.facade
    there = resized(resized(first, 1.7 * facade.width, facade.height), 0.6 * facade.width, 1.4 * facade.height)
    back = resized(there, facade.width, facade.height)
    assert not np.allclose(there.facade.size, facade.size)
    assert np.abs(back.facade.size - facade.size).max() <= 1e-9 * facade.width
    assert np.abs(back.facade.position - facade.position).max() <= 1e-9 * facade.width


def test_what_is_locked_keeps_its_size_and_so_does_all_that_is_alike():
    document = opened(windows(2, 3))
    node = int(document.facade.grids[0].node[0])
    held = resized(locked(document, node, "width"), 1.5 * document.facade.width, document.facade.height)
    nodes = held.facade.grids[0].node
    assert held.facade.size[nodes, X] == pytest.approx(document.facade.size[nodes, X], abs=1e-9)
    free = resized(
        unlocked(locked(document, node, "width"), node, "width"), 1.5 * document.facade.width, document.facade.height
    )
    assert (free.facade.size[nodes, X] > document.facade.size[nodes, X] + 1e-6).all()


def test_a_locked_aspect_stays():
    document = opened(windows(2, 3))
    node = int(document.facade.grids[0].node[0])
    was = document.facade.size[node]
    now = resized(locked(document, node, "aspect"), 1.3 * document.facade.width, document.facade.height)
    assert np.divide(*now.facade.size[node]) == pytest.approx(np.divide(*was), abs=1e-6)
    assert now.facade.width == pytest.approx(1.3 * document.facade.width)


def test_a_size_that_is_given_is_met_and_locked_and_the_facade_stays_as_large():
    document = opened(windows(2, 3))
    node = int(document.facade.grids[0].node[0])
    now = arranged(document, node, {"height": 1.1})
    assert now.facade.size[node, Y] == pytest.approx(1.1, abs=1e-9)
    assert now.locks == (Size(node, Y, 1.1),)
    np.testing.assert_allclose(now.facade.size[0], document.facade.size[0], rtol=1e-14)
    assert arranged(now, node, {"height": 1.2}).locks == (Size(node, Y, 1.2),)


def test_what_contradicts_a_lock_is_named():
    document = opened(windows(2, 3))
    node = int(document.facade.grids[0].node[0])
    held = locked(locked(document, node, "width"), 0, "width")
    with pytest.raises(FacadeError, match=r"cannot all be met.*the facade is .* m wide"):
        resized(held, 2.0, document.facade.height)
    with pytest.raises(FacadeError, match="cannot all be met"):
        arranged(held, node, {"width": document.facade.width})


def test_a_variation_keeps_the_other_side_and_hands_locks_on_to_copies():
    document = opened(windows(2, 3))
    node = int(document.facade.grids[0].node[0])
    held = locked(document, node, "width")
    for variation in vary(document.facade, document.facade.grids[0].name, X).variations:
        made, solved = varied(held, variation, X)
        check(made.facade)
        assert solved.conflict == ()
        assert made.facade.height == pytest.approx(document.facade.height, abs=1e-9)
        sources = variation.source[[lock.node for lock in made.locks]].tolist()
        assert sources == [node] * int((variation.source == node).sum())
        again = resized(made, 1.2 * made.facade.width, made.facade.height)
        for lock in made.locks:
            assert again.facade.size[lock.node, X] == pytest.approx(document.facade.size[node, X], abs=1e-6)


def test_a_locked_width_of_the_whole_stays_when_a_column_comes():
    document = locked(opened(windows(2, 3)), 0, "width")
    for variation in vary(document.facade, document.facade.grids[0].name, X, removals=False).variations:
        made, _ = varied(document, variation, X)
        assert made.facade.width == pytest.approx(document.facade.width, abs=1e-9)
        assert made.locks == document.locks


def test_a_window_that_is_moved_takes_its_column_along_and_stays_there():
    document = opened(windows(3, 4))
    grid = document.facade.grids[0]
    column = grid.node[grid.column == 1]
    place = float(document.facade.position[column[0], X])
    moved = arranged(document, int(column[0]), {"left": place + 0.2})
    assert moved.facade.position[column, X] == pytest.approx(place + 0.2, abs=1e-6)
    assert moved.facade.width == pytest.approx(document.facade.width, abs=1e-9)
    wider = resized(moved, 1.2 * document.facade.width, document.facade.height)
    assert wider.facade.position[column, X] == pytest.approx(place + 0.2, abs=1e-6)


@pytest.mark.parametrize("what", KINDS)
@pytest.mark.parametrize("far", [0.0, 1e5])
def test_what_is_locked_as_it_is_changes_nothing(what: str, far: float):
    facade = windows(2, 3)
    document = opened(replace(facade, position=facade.position + far))
    held = locked(document, int(document.facade.grids[0].node[1]), what)
    again = resized(held, document.facade.width, document.facade.height)
    assert np.abs(again.facade.size - document.facade.size).max() <= 1e-9
    assert np.abs(boxes(again.facade) - boxes(document.facade)).max() <= 1e-9
