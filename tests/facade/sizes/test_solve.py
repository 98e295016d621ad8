from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
import piqp
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse

from grammarlab.arrays import Floats
from grammarlab.errors import FacadeError
from grammarlab.facade.editing.variations import vary
from grammarlab.facade.grid import Grid
from grammarlab.facade.sizes.constraints import LineOrigin, leaf_weights
from grammarlab.facade.sizes.size_wishes import Aspect, Position, Size, height, width
from grammarlab.facade.sizes.solve import Resized, prepare, resize
from grammarlab.facade.tree import LEAF, Facade, X, Y, check, plain
from tests.facade.sized import Paper, paper, sized, storeys

clarabel: Any = import_module("clarabel")  # has no types
FACTORS = st.floats(0.3, 3.0)


def of_paper(facade: Facade, along: int, target: float | None) -> Paper:
    weight = leaf_weights(facade.size[facade.leaves], facade.size[0], "default")[:, along]
    return paper(facade, along, weight, target)


def by_clarabel(one: Paper) -> Floats:
    num = len(one.start)
    quadratic, linear = sparse.diags_array(2.0 * one.weight**2, format="csc"), -2.0 * one.weight**2 * one.start
    rows = sparse.csc_matrix(np.vstack([one.rows, -np.eye(num)]))
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-10
    cones = [clarabel.ZeroConeT(len(one.value)), clarabel.NonnegativeConeT(num)]
    value = np.concatenate([one.value, -one.least])
    return np.array(
        clarabel.DefaultSolver(sparse.csc_matrix(quadratic), linear, rows, value, cones, settings).solve().x
    )


def by_piqp(one: Paper) -> Floats:
    solver = piqp.DenseSolver()
    solver.settings.eps_abs = solver.settings.eps_rel = 1e-10
    quadratic, linear = np.diag(2.0 * one.weight**2), -2.0 * one.weight**2 * one.start
    above = np.full(len(one.start), np.inf)
    solver.setup(quadratic, linear, one.rows, one.value, None, None, None, one.least, above)
    solver.solve()
    return np.array(solver.result.x)


def by_conditions(one: Paper) -> Floats:
    """The optimum under the equations alone: the nearest point of an affine space."""
    scaled = one.rows / one.weight
    step = np.linalg.lstsq(scaled, one.value - one.rows @ one.start, rcond=1e-11)[0]
    return one.start + step / one.weight


def assert_whole(resized: Resized) -> None:
    check(resized.facade)
    assert resized.residuals.decomposition <= 1e-9
    areas = resized.facade.size[resized.facade.leaves].prod(axis=1)
    assert np.isclose(areas.sum(), resized.facade.width * resized.facade.height, rtol=1e-9)


@given(sized(), FACTORS, st.integers(0, 1))
def test_the_optimum_is_that_of_independent_solvers_of_the_papers_formulation(
    facade: Facade, factor: float, along: int
) -> None:
    target = factor * facade.size[0, along]
    found = resize(facade, [Size(0, along, target)])
    assert_whole(found)
    assert found.energy[1 - along] == 0.0
    np.testing.assert_array_equal(found.facade.size[:, 1 - along], facade.size[:, 1 - along])
    one = of_paper(facade, along, target)
    x = found.facade.size[facade.leaves, along]
    if found.conflict:
        # The reference solver finds no sizes either.
        for theirs in (by_clarabel(one), by_piqp(one)):
            missed = max(np.abs(one.rows @ theirs - one.value).max(), (one.least - theirs).max())
            assert not missed <= 1e-7 * facade.size[0].max()
        return
    assert max(found.residuals.alignment, found.residuals.symmetry, found.residuals.target) <= 1e-6
    assert np.abs(one.rows @ x - one.value).max() <= 1e-6
    assert one.energy(x) == pytest.approx(found.energy[along], rel=1e-9)
    free = by_conditions(one)
    if (free >= one.least).all():
        np.testing.assert_allclose(x, free, atol=1e-7)
    for theirs in (by_clarabel(one), by_piqp(one)):
        assert one.energy(x) == pytest.approx(one.energy(theirs), rel=1e-6, abs=1e-9)
        assert one.energy(x) <= one.energy(theirs) * (1.0 + 1e-6) + 1e-9


@given(sized())
def test_sizes_that_are_wished_for_already_stay_to_the_last_bit(facade: Facade) -> None:
    found = resize(facade, [width(facade.width), height(facade.height)])
    np.testing.assert_array_equal(found.facade.size, facade.size)
    np.testing.assert_array_equal(found.facade.position, facade.position)
    assert found.energy == (0.0, 0.0)
    assert not found.conflict


@given(sized(grids=0), FACTORS)
def test_without_grids_the_optimum_is_in_closed_form(facade: Facade, factor: float) -> None:
    found = resize(facade, [width(factor * facade.width)])
    free = by_conditions(of_paper(facade, X, factor * facade.width))
    if (free > 0.01 * facade.size[facade.leaves, X]).all():
        np.testing.assert_allclose(found.facade.size[facade.leaves, X], free, rtol=1e-7)


@given(sized(), st.floats(0.5, 2.0))
def test_solving_again_for_other_metres_is_solving_anew(facade: Facade, factor: float) -> None:
    ready = prepare(facade, [width(facade.width * 1.1)])
    ready.resized([width(facade.width * 1.1)])
    wishes = [width(factor * facade.width)]
    again, anew = ready.resized(wishes).facade, resize(facade, wishes).facade
    np.testing.assert_array_equal(again.size, anew.size)


@given(sized(), st.data())
@settings(max_examples=50)
def test_any_wishes_end_with_a_facade_and_with_what_gave_way(facade: Facade, data: st.DataObject) -> None:
    lengths = st.floats(0.05, 1.5)
    wishes = []
    for node in data.draw(st.lists(st.integers(0, len(facade) - 1), max_size=4)):
        along = data.draw(st.integers(0, 1))
        metres = data.draw(lengths) * facade.size[node, along]
        kinds = [Size(node, along, metres), Position(node, along, facade.position[node, along] * data.draw(lengths))]
        wishes.append(data.draw(st.sampled_from([*kinds, Aspect(node, 0.5, 0.7)])))
    found = resize(facade, wishes)
    assert_whole(found)
    missed = max(found.residuals.alignment, found.residuals.symmetry, found.residuals.target)
    assert bool(found.conflict) == bool(found.relaxed) == (missed > 1e-6 * facade.size[0].max())


def row_of(*widths: float, names: tuple[str, ...] | None = None) -> Facade:
    num = len(widths)
    left = np.concatenate([[0.0], np.cumsum(widths)[:-1]])
    position = np.stack([np.append(0.0, left), np.zeros(num + 1)], axis=1)
    size = np.stack([np.append(sum(widths), widths), np.ones(num + 1)], axis=1)
    parent, axis = np.array([-1] + [0] * num), np.array([X] + [LEAF] * num, dtype=np.int8)
    return plain(parent, axis, position, size, ["", *(names or ("wall",) * num)])


def test_large_leaves_give_more_by_default_and_the_papers_weights_are_one_for_all_small_ones() -> None:
    facade = row_of(0.5, 1.0, 2.0, *[1.0] * 20)
    gave = resize(facade, [width(20.0)]).facade.size[1:, X] - facade.size[1:, X]
    np.testing.assert_allclose(gave / gave[1], np.square(facade.size[1:, X]), rtol=1e-9)
    gave = resize(facade, [width(20.0)], weights="paper").facade.size[1:, X] - facade.size[1:, X]
    np.testing.assert_allclose(gave, gave[0], rtol=1e-9)
    wide = row_of(1.0, 9.0)
    gave = resize(wide, [width(20.0)], weights="paper").facade.size[1:, X] - wide.size[1:, X]
    np.testing.assert_allclose(gave[1] / gave[0], (10.0 / (10.0 / 9.0)) ** 2, rtol=1e-9)


def test_windows_stay_alike_and_aligned() -> None:
    facade = storeys(7, 4)
    found = resize(facade, [width(1.3 * facade.width), height(1.5 * facade.height)])
    assert_whole(found)
    windows = facade.grids[0]
    for column in range(7):
        node = windows.node[windows.column == column]
        assert np.ptp(found.facade.position[node, X]) <= 1e-9
    for row in range(4):
        assert np.ptp(found.facade.position[windows.node[windows.row == row], Y]) <= 1e-9
    for size in np.unique(facade.size[windows.node, X].round(6)):
        node = windows.node[np.isclose(facade.size[windows.node, X], size)]
        assert np.ptp(found.facade.size[node, X]) <= 1e-9


def test_parts_that_would_become_negative_keep_a_little_of_their_size() -> None:
    facade = storeys(20, 3)
    found = resize(facade, [width(0.2 * facade.width)])
    assert_whole(found)
    assert not found.conflict
    leaf = facade.leaves
    assert (found.facade.size[leaf, X] >= 0.999e-3 * facade.size[leaf, X]).all()
    assert np.isclose(found.facade.size[leaf, X], 1e-3 * facade.size[leaf, X]).any()


def test_far_too_narrow_a_facade_is_explained() -> None:
    facade = storeys(5, 2)
    found = resize(facade, [width(1e-4 * facade.width)])
    assert_whole(found)
    assert found.conflict == (f"the facade is {1e-4 * facade.width:g} m wide",)


def test_wishes_in_conflict_are_named_and_no_others() -> None:
    facade = row_of(1.0, 2.0, 3.0, 4.0)
    found = resize(facade, [width(10.0), Size(1, X, 6.0), Size(2, X, 5.0), Size(0, Y, 2.0), Position(4, X, 6.5)])
    assert found.conflict == (
        "wall (node 1) is 6 m wide",
        "wall (node 2) is 5 m wide",
        "the left edge of wall (node 4) is 6.5 m from that of the facade",
    )
    assert found.facade.height == pytest.approx(2.0)
    assert found.residuals.target == pytest.approx(4.5, abs=0.1)


def test_symmetry_gives_way_before_alignment_and_alignment_before_wishes() -> None:
    facade = storeys(2, 2, widths=(1.0,))
    one, other = facade.grids[0].node[facade.grids[0].row == 0]
    unlike = resize(facade, [Size(int(one), X, 1.0), Size(int(other), X, 1.5)])
    assert unlike.residuals.symmetry == pytest.approx(0.5)
    assert max(unlike.residuals.alignment, unlike.residuals.target) <= 1e-6
    assert unlike.conflict[-1] == "what is alike in grid 'windows' keeps its widths alike"
    apart = resize(facade, [Position(int(one), X, 1.0), Position(int(facade.grids[0].places()[1, 0]), X, 1.5)])
    assert apart.residuals.alignment == pytest.approx(0.5)
    assert apart.residuals.target <= 1e-6
    assert "columns of grid 'windows' stay aligned" in apart.conflict[-1]


def test_an_over_constrained_facade_has_an_answer() -> None:
    """Hundreds of windows that should be equal, at distances larger than the room for them."""
    facade = storeys(30, 10, widths=(1.0,))
    wishes = [width(20.0), *(Size(int(node), X, 1.0) for node in facade.grids[0].places()[0])]
    found = resize(facade, wishes)
    assert_whole(found)
    assert found.facade.width == pytest.approx(20.0, abs=11.0)
    assert found.conflict
    assert found.residuals.target > 1.0


def test_an_aspect_is_solved_for_along_both_axes_at_once() -> None:
    facade = storeys(3, 2)
    node = int(facade.grids[0].node[0])
    ratio = facade.size[node, X] / facade.size[node, Y]
    found = resize(facade, [Aspect(node, 1.5 * ratio, 2.0 * ratio)])
    assert_whole(found)
    assert found.residuals.target <= 1e-9
    assert min(found.energy) > 0.0
    grown = found.facade.size[node] / facade.size[node]
    assert grown[X] > 1.0 > grown[Y]
    assert resize(facade, [Aspect(node, 0.5 * ratio, 2.0 * ratio)]).energy == (0.0, 0.0)


def test_what_was_inserted_gets_the_sizes_it_came_with() -> None:
    """A new layout of a tree: its windows are stretched, and their targets are the old sizes."""
    facade = storeys(4, 3)
    stretched = resize(facade, [width(2.0 * facade.width)]).facade
    back = resize(stretched, [], LineOrigin(facade.position, facade.size, facade.size[0]))
    np.testing.assert_allclose(back.facade.size, facade.size, atol=1e-9)
    assert max(back.energy) <= 1e-15


@pytest.mark.parametrize("along", [X, Y])
def test_every_variation_of_a_grid_is_solved_for_any_size(along: int) -> None:
    facade = storeys(4, 3)
    found = vary(facade, "windows", along).variations
    assert len(found) > 6
    for each in found:
        came_from = LineOrigin(facade.position[each.source], each.target, facade.size[0])
        natural = resize(each.facade, [], came_from)
        assert max(natural.energy) <= 1e-12
        fitted = resize(each.facade, [width(facade.width), height(facade.height)], came_from)
        for solved in (natural, fitted):
            assert_whole(solved)
            assert not solved.conflict
            assert max(solved.residuals.alignment, solved.residuals.symmetry, solved.residuals.target) <= 1e-6


@pytest.mark.parametrize(
    ("wish", "says"),
    [
        (Size(99, X, 1.0), "node 99: expected 0 to 3"),
        (Size(0, X, 0.0), "the facade is 0 m wide: expected a length above 0"),
        (Size(0, Y, -1.0), "expected a length above 0"),
        (Size(0, X, 1e9), "at most 6000 m"),
        (Size(0, X, np.nan), "expected a length"),
        (Size(0, 2, 1.0), "axis 2"),
        (Position(1, X, -1.0), "of at least 0"),
        (Aspect(1, 0.0, 1.0), "expected a range above 0"),
        (Aspect(1, 2.0, 1.0), "smaller number first"),
        (Aspect(1, 1.0, np.inf), "expected a range"),
    ],
)
def test_wishes_without_meaning_are_refused(wish, says) -> None:
    with pytest.raises(FacadeError, match=says):
        resize(row_of(1.0, 2.0, 3.0), [wish])


def test_a_facade_of_one_leaf_and_a_size_without_wishes() -> None:
    one = plain(np.array([-1]), np.array([LEAF], dtype=np.int8), np.zeros((1, 2)), np.array([[3.0, 2.0]]), ["wall"])
    assert resize(one, [width(5.0)]).facade.size.tolist() == [[5.0, 2.0]]
    assert resize(replace(one, grids=(Grid("one", np.array([0]), np.array([0]), np.array([0])),)), []).energy == (
        0.0,
        0.0,
    )


def test_kilometres_and_millimetres_are_solved_alike() -> None:
    facade = storeys(5, 3)
    plainly = resize(facade, [width(20.0)]).facade.size
    for factor in (1e-3, 1e6):
        scaled = replace(facade, position=factor * facade.position, size=factor * facade.size)
        np.testing.assert_allclose(resize(scaled, [width(20.0 * factor)]).facade.size, factor * plainly, rtol=1e-7)


def test_other_wishes_than_prepared_for_are_refused() -> None:
    ready = prepare(row_of(1.0, 2.0), [width(5.0)])
    with pytest.raises(FacadeError, match="prepared"):
        ready.resized([height(5.0)])
