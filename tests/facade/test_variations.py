from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import FacadeError
from grammarlab.facade.grid import Grid
from grammarlab.facade.grids import grid_of, with_grid
from grammarlab.facade.kinds import kinds, types
from grammarlab.facade.tree import LEAF, Facade, X, Y, check
from grammarlab.facade.variations import (
    Edit,
    Variation,
    applied,
    canonical,
    distinct,
    edits,
    sequences,
    unedited,
    vary,
)
from tests.facade.gridded import gridded, same_topology, transposed
from tests.facade.samples import across, built, door_over_two_rows, leaf, stacked, windows

axes = st.sampled_from([X, Y])


def lines(grid: Grid, axis: int) -> np.ndarray:
    return grid.places().T if axis == X else grid.places()


def names(facade: Facade, nodes: np.ndarray) -> list[str]:
    return [facade.name_of(node) if node >= 0 else "-" for node in nodes.tolist()]


def line_names(facade: Facade, grid: str, axis: int) -> list[list[str]]:
    return [names(facade, line) for line in lines(grid_of(facade, grid), axis)]


def same_facade(one: Facade, other: Facade) -> None:
    assert same_topology(one, other)
    assert np.allclose(one.position, other.position, rtol=0, atol=1e-9 * one.size[0].max())
    assert np.allclose(one.size, other.size, rtol=1e-9)
    assert np.array_equal(one.label, other.label)
    assert [(g.name, g.node.tolist(), g.row.tolist(), g.column.tolist()) for g in one.grids] == [
        (g.name, g.node.tolist(), g.row.tolist(), g.column.tolist()) for g in other.grids
    ]


@given(gridded(), axes)
def test_each_variation_is_a_facade_with_one_line_more_or_less_and_other_grids_as_they_were(
    facade: Facade, axis: int
) -> None:
    before = grid_of(facade, "one")
    other = grid_of(facade, "two")
    for variation in vary(facade, "one", axis, also=[]).found:
        check(variation.facade)
        areas = variation.facade.size[variation.facade.leaves].prod(axis=1)
        assert np.isclose(areas.sum(), variation.facade.width * variation.facade.height)
        (edit,) = variation.edits
        after = grid_of(variation.facade, "one")
        old, new = lines(before, axis), lines(after, axis)
        if edit.place is None:
            assert len(new) <= len(old) - 1
            continue
        assert len(new) == len(old) + 1
        kept = np.delete(new, edit.place, axis=0)
        assert np.array_equal(np.where(kept < 0, -1, variation.source[kept]), old)
        line = new[edit.place]
        assert np.array_equal(variation.source[line[line >= 0]], old[edit.line][line >= 0])
        assert variation.missing or ((line < 0) == (old[edit.line] < 0)).all()
        same = grid_of(variation.facade, "two")
        assert variation.source[same.node].tolist() == other.node.tolist()
        assert (same.row.tolist(), same.column.tolist()) == (other.row.tolist(), other.column.tolist())


@given(gridded(), axes)
def test_new_elements_stand_between_their_anchors(facade: Facade, axis: int) -> None:
    for variation in vary(facade, "one", axis, also=[], removals=False).found:
        middle = variation.facade.position[:, axis] + variation.facade.size[:, axis] / 2
        (edit,) = variation.edits
        new = lines(grid_of(variation.facade, "one"), axis)
        for cross in range(new.shape[1]):
            near = [new[at, cross] for at in (edit.place - 1, edit.place, edit.place + 1) if 0 <= at < len(new)]
            if new[edit.place, cross] >= 0:
                along = np.diff(middle[near]) if axis == X else -np.diff(middle[near])
                assert (along > 0).all()


@given(gridded(), axes)
def test_what_is_inserted_and_removed_leaves_no_trace(facade: Facade, axis: int) -> None:
    start = unedited(facade)
    for edit in edits(facade, ["one"], axis):
        if edit.place is None:
            continue
        try:
            more = applied(start, edit)
        except FacadeError:
            continue
        less = applied(more, Edit(("one",), axis, edit.place))
        same_facade(less.facade, facade)
        assert less.source.tolist() == list(range(len(facade)))


@given(gridded())
def test_rows_are_columns_of_the_facade_turned_about_its_diagonal(facade: Facade) -> None:
    def forms(start: Facade, axis: int) -> Counter[bytes]:
        kind = np.arange(len(start))
        found = vary(start, "one", axis, also=[]).found
        return Counter(
            canonical(
                replace(each, facade=replace(each.facade, axis=np.abs(each.facade.axis - turn)), shown=shown), kind
            )
            for each in found
            for turn, shown in [(0 if axis == X else 1, each.shown if axis == X else each.shown[:, [1, 0, 3, 2]])]
            for each in [
                replace(each, facade=replace(each.facade, axis=np.where(each.facade.axis < 0, 7, each.facade.axis)))
            ]
        )

    turned = transposed(facade)
    assert {len(vary(facade, "one", Y, also=[]).found)} == {len(vary(turned, "one", X, also=[]).found)}
    del forms
