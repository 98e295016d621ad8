from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import FacadeError
from grammarlab.facade.editing.repeats import Repeats, find_repeats
from grammarlab.facade.editing.retarget import EVENNESS_DEVIATION, OPTIMALITY_GAP, retarget
from grammarlab.facade.editing.springs import least_energy, origin_of
from grammarlab.facade.editing.variations import inherited, lost, unedited
from grammarlab.facade.grid import Grid
from grammarlab.facade.sizes.constraints import LineOrigin, Weights, leaf_weights
from grammarlab.facade.sizes.model import ALIGNMENT, SYMMETRY, WISH
from grammarlab.facade.sizes.size_wishes import Size, Wish
from grammarlab.facade.sizes.solve import resize
from grammarlab.facade.tree import LEAF, Facade, X, Y, check
from tests.cases import bulk, some
from tests.facade.samples import windows
from tests.facade.sized import sized, storeys


def repeats_of(facade: Facade, along: int) -> Repeats:
    found = find_repeats(unedited(facade), facade.grids[0], along)
    assert found is not None
    return found


def with_door(facade: Facade, column: int) -> Facade:
    """The lowest window of a column is a door."""
    node = facade.grids[0].places()[-1, column]
    label = facade.label.copy()
    label[node] = len(facade.labels)
    return replace(facade, label=label, labels=(*facade.labels, "door"))


def unevenness(repeats: Repeats, counts: Sequence[int], factor: float, weights: Weights = "default") -> float:
    """Price of numbers of each kind of column for a size that is this many times the original one."""
    facade, total = repeats.before.facade, 0.0
    weight = np.zeros(len(facade))
    weight[facade.leaves] = leaf_weights(facade.size[facade.leaves], facade.size[0], weights)[:, repeats.along]
    occurs = np.bincount(repeats.kind)
    for kind, count in enumerate(counts):
        first = int(np.flatnonzero(repeats.kind == kind)[0])
        parts = [part for band in repeats.bands for part in (*band.gaps[first], *band.columns[first])]
        nodes = np.concatenate([np.arange(part, facade.end[part]) for part in parts])
        price = EVENNESS_DEVIATION**2 * np.square(weight[nodes] * facade.size[nodes, repeats.along]).sum()
        total += price * (count - factor * occurs[kind]) ** 2 / occurs[kind]
    return float(total)


@pytest.mark.parametrize("along", [X, Y])
def test_every_column_once_is_the_facade_itself(along: int) -> None:
    facade = storeys(4, 3)
    num = facade.grids[0].num_columns if along == X else facade.grids[0].num_rows
    same = repeats_of(facade, along).variation(range(num))
    for column in ("parent", "axis", "label", "position", "size", "window"):
        np.testing.assert_allclose(getattr(same.facade, column), getattr(facade, column), atol=1e-12)
    for column in ("node", "row", "column"):
        np.testing.assert_array_equal(getattr(same.facade.grids[0], column), getattr(facade.grids[0], column))


@given(st.lists(st.integers(0, 3), min_size=1, max_size=9))
@bulk(30)
def test_columns_are_copies_of_their_sources_in_every_storey(columns: list[int]) -> None:
    facade = with_door(storeys(4, 3), 1)
    made = repeats_of(facade, X).variation(columns)
    check(made.facade)
    np.testing.assert_array_equal(made.source[made.facade.grids[0].places()], facade.grids[0].places()[:, columns])
    np.testing.assert_array_equal(made.facade.label, facade.label[made.source])
    left = made.facade.position[made.facade.grids[0].places(), X]
    assert (np.diff(left, axis=1) > 0).all()


def test_rows_are_copies_too() -> None:
    facade = with_door(storeys(3, 3), 1)
    made = repeats_of(facade, Y).variation([0, 1, 1, 2])
    check(made.facade)
    places = made.facade.grids[0].places()
    np.testing.assert_array_equal(made.source[places], facade.grids[0].places()[[0, 1, 1, 2]])
    assert made.facade.name_of(int(places[-1, 1])) == "door"


def test_equal_columns_are_one_kind_and_are_spread_over_their_places() -> None:
    found = repeats_of(storeys(6, 2, widths=(0.8, 1.2)), X)
    # The first one has the gap after it, which is as wide as that before the third.
    assert found.kind.tolist() == [0, 1, 2, 1, 2, 1]
    assert found.spread(np.array([1, 4, 2])) == (0, 1, 1, 2, 3, 4, 5)


def test_an_element_beside_the_bands_keeps_its_column() -> None:
    """A storey with a shop window below the second column only."""
    facade = storeys(3, 3)
    grid = facade.grids[0]
    gone = (grid.row == 2) & (grid.column != 1)
    partly = replace(facade, grids=(Grid("windows", grid.node[~gone], grid.row[~gone], grid.column[~gone]),))
    found = repeats_of(partly, X)
    assert found.required == (1,)
    made = found.variation([0, 1, 1, 2]).facade
    assert made.grids[0].places()[2].tolist().count(-1) == 3
    assert made.grids[0].places()[2, 1] >= 0
    with pytest.raises(FacadeError, match="keep them"):
        found.variation([0, 2])
    assert retarget(partly, width=0.4 * partly.width).choices[0].counts[1] >= 1


@pytest.mark.parametrize("factor", some([0.4, 0.7, 1.0, 1.35, 1.8]))
@pytest.mark.parametrize("along", [X, Y])
def test_no_other_counts_deform_less(factor: float, along: int) -> None:
    """Brute force over all numbers of each kind, each built and solved separately."""
    facade = with_door(storeys(3, 3, widths=(0.8, 1.1)), 1)
    metres = factor * facade.size[0, along]
    found = retarget(facade, **{("width", "height")[along]: metres}).choices[0]
    repeats = repeats_of(facade, along)
    kinds = int(repeats.kind.max()) + 1
    best = np.inf
    for counts in product(range(5), repeat=kinds):
        columns = repeats.spread(np.array(counts))
        try:
            made = repeats.variation(columns)
        except FacadeError:  # one storey is not a band
            assert len(columns) < 2
            continue
        origin = LineOrigin(facade.position[made.source], made.target, facade.size[0])
        solved = resize(made.facade, [Size(0, along, metres)], origin)
        assert not solved.conflict
        best = min(best, solved.energy[along] + unevenness(repeats, counts, factor))
    slack = OPTIMALITY_GAP**2 * len(facade.leaves)
    assert found.proven
    assert best * (1.0 - 1e-9) - 1e-12 <= found.deformation <= best * (1.0 + OPTIMALITY_GAP) + 2.0 * slack
    assert found.bound <= best * (1.0 + 1e-9) + 1e-12


def test_the_same_size_changes_nothing() -> None:
    facade = storeys(5, 3)
    found = retarget(facade, width=facade.width, height=facade.height)
    np.testing.assert_allclose(found.resized.facade.size, facade.size, atol=1e-9)
    assert [choice.counts for choice in found.choices] == [(1,) * 5, (1,) * 3]
    assert str(found.choices[0]) == "windows: every column once"


def test_both_axes_and_what_the_facade_consists_of() -> None:
    facade = with_door(storeys(5, 3), 2)
    found = retarget(facade, width=2.0 * facade.width, height=1.7 * facade.height)
    check(found.resized.facade)
    assert found.resized.facade.size[0] == pytest.approx([2.0 * facade.width, 1.7 * facade.height])
    assert not found.resized.conflict
    windows = found.resized.facade.grids[0]
    assert (windows.num_columns, windows.num_rows) == (sum(found.choices[0].counts), sum(found.choices[1].counts))
    assert all(choice.proven for choice in found.choices)
    assert max(found.resized.residuals.alignment, found.resized.residuals.symmetry) <= 1e-6
    np.testing.assert_array_equal(found.resized.facade.label, facade.label[found.variation.source])


@given(sized(), st.floats(0.5, 2.0), st.floats(0.5, 2.0))
@bulk(40)
def test_any_facade_is_retargeted(facade: Facade, wider: float, higher: float) -> None:
    found = retarget(facade, width=wider * facade.width, height=higher * facade.height)
    check(found.resized.facade)
    for choice in found.choices:
        assert choice.bound <= choice.deformation
    if not found.resized.conflict:
        assert found.resized.facade.width == pytest.approx(wider * facade.width)
        assert found.resized.facade.height == pytest.approx(higher * facade.height)


def test_columns_are_chosen_where_no_sizes_keep_everything_aligned_and_alike() -> None:
    """Windows that are not aligned keep their distances at any width, and walls between them are equal."""
    facade = storeys(4, 2, widths=(1.0,))
    upper, lower = facade.grids[0].places()
    node = np.concatenate([upper[:3], lower[1:]])
    order = np.argsort(node)
    askew = Grid("askew", node[order], np.repeat([0, 1], 3)[order], np.tile([0, 1, 2], 2)[order])
    wall = np.flatnonzero((facade.axis == LEAF) & (facade.axis[facade.parent] == X))
    walls = Grid("walls", wall, np.repeat([1, 0], 5), np.tile(np.arange(5), 2))
    facade = replace(facade, grids=(*facade.grids, askew, walls))
    assert resize(facade, [Size(0, X, 1.5 * facade.width)]).conflict
    found = retarget(facade, width=1.5 * facade.width, grids=["windows"])
    check(found.resized.facade)
    assert np.isfinite(found.choices[0].deformation)
    assert sum(found.choices[0].counts) == 6


def test_a_width_that_nothing_fits_ends_with_the_conflict() -> None:
    facade = storeys(3, 2)
    found = retarget(facade, width=1e-4 * facade.width)
    check(found.resized.facade)
    assert found.resized.conflict == (f"the facade is {1e-4 * facade.width:g} m wide",)
    assert not found.choices[0].proven


def test_a_grid_that_is_not_there_is_named() -> None:
    with pytest.raises(FacadeError, match="Unknown grid 'doors'; expected one of: windows"):
        retarget(storeys(2, 2), width=9.0, grids=["doors"])


@pytest.mark.parametrize("times", some([0.4, 1.0, 2.6]))
@pytest.mark.parametrize("along", [X, Y])
def test_strips_beside_bands_are_as_long_as_any_number_of_columns(times: float, along: int) -> None:
    """Such a repetition deforms nothing, and nothing deforms less."""
    facade = windows(3, 5, bays=along == Y)
    repeats = repeats_of(facade, along)
    num = round(times * len(repeats.kind))
    made = repeats.variation(repeats.spread(np.array([num])))
    for strip in repeats.strips:
        grown = made.target[made.source == strip, along]
        assert grown == pytest.approx(made.facade.size[0, along])
    assert len(repeats.strips) == (4 if along == X else 6)
    metres = made.facade.size[0, along]
    found = retarget(facade, **{("width", "height")[along]: metres})
    assert sum(found.choices[0].counts) == num
    assert found.choices[0].proven
    assert sum(found.resized.energy) == pytest.approx(0.0, abs=1e-9)


@given(
    st.lists(st.floats(0.5, 2.0), min_size=1, max_size=3), st.floats(0.2, 3.0), st.sampled_from(["default", "paper"])
)
@bulk(15)
def test_no_numbers_of_columns_beside_strips_deform_less(widths: list[float], factor: float, weights: Weights) -> None:
    facade = windows(2, len(widths), tuple(widths))
    repeats = repeats_of(facade, X)
    metres = factor * facade.width
    found = retarget(facade, width=metres, weights=weights).choices[0]
    kinds = int(repeats.kind.max()) + 1
    for counts in product(range(4), repeat=kinds):
        if any(counts):
            made = repeats.variation(repeats.spread(np.array(counts)))
            origin, held = origin_of(facade, made), (WISH, ALIGNMENT, SYMMETRY)
            energy = least_energy(made.facade, origin, [Size(0, X, metres)], weights, held)
            cost = energy + unevenness(repeats, counts, factor, weights)
            assert found.bound <= cost * (1.0 + 1e-9) + 1e-9


@st.composite
def locked(draw: st.DrawFn) -> tuple[Facade, tuple[Wish, ...]]:
    """A facade with a door, and locks of some of its nodes: half of them at their sizes, others at any."""
    columns = draw(st.integers(2, 3))
    widths = draw(st.sampled_from([(1.0,), (0.8, 1.2), (1.0, 1.08, 1.16)]))
    plain = storeys(columns, 2, widths=widths) if draw(st.booleans()) else windows(2, columns, widths)
    facade = with_door(plain, columns - 1)
    nodes = draw(st.lists(st.integers(1, len(facade) - 1), min_size=1, max_size=3, unique=True))
    factors = draw(st.lists(st.sampled_from([1.0, 1.0, 0.5, 2.0]), min_size=len(nodes), max_size=len(nodes)))
    axes = draw(st.lists(st.integers(X, Y), min_size=len(nodes), max_size=len(nodes)))
    sides = zip(nodes, axes, factors, strict=True)
    return facade, tuple(Size(node, axis, factor * float(facade.size[node, axis])) for node, axis, factor in sides)


@given(locked(), st.floats(0.3, 2.0), st.floats(0.3, 2.0))
@bulk(20)
def test_a_locked_part_is_not_left_out_to_satisfy_its_lock(
    given: tuple[Facade, tuple[Wish, ...]], wider: float, higher: float
) -> None:
    facade, locks = given
    found = retarget(facade, width=wider * facade.width, height=higher * facade.height, locks=locks)
    assert not lost(facade, locks, found.variation)
    if not found.resized.conflict:
        for lock in inherited(locks, found.variation):
            assert isinstance(lock, Size)
            assert found.resized.facade.size[lock.node, lock.axis] == pytest.approx(lock.metres, rel=1e-6)


def test_of_equal_columns_with_equal_locks_one_has_to_stay_and_of_others_each() -> None:
    facade = windows(2, 4, (1.2,))
    grid = facade.grids[0].places()
    all_alike = [Size(int(node), X, 1.2) for node in grid.ravel()]
    found = retarget(facade, width=0.3 * facade.width, locks=all_alike)
    assert len(found.choices[0].columns) == 1
    apart = [Size(int(grid[0, 1]), X, 1.2), Size(int(grid[1, 3]), X, 1.2)]
    found = retarget(facade, width=0.3 * facade.width, locks=apart)
    assert found.choices[0].counts == (0, 1, 0, 1)


def test_a_locked_gap_is_not_that_before_the_first_column() -> None:
    facade = storeys(4, 2, widths=(1.2,))
    repeats = repeats_of(facade, X)
    gap = repeats.bands[0].gaps[2][0]
    for factor in (0.2, 0.5, 0.8):
        found = retarget(facade, width=factor * facade.width, locks=[Size(gap, X, 1.0)])
        assert (found.variation.source == gap).any()


@given(locked(), st.floats(0.5, 2.0))
@bulk(15)
def test_no_numbers_of_columns_that_keep_what_is_locked_deform_less(
    given: tuple[Facade, tuple[Wish, ...]], wider: float
) -> None:
    facade, locks = given
    metres = wider * facade.width
    choice = retarget(facade, width=metres, locks=locks).choices[0]
    repeats = find_repeats(unedited(facade), facade.grids[0], X, locks)
    assert repeats is not None
    for counts in product(range(3), repeat=int(repeats.kind.max()) + 1):
        if not any(counts) or (counts < repeats.least(int(np.flatnonzero(counts)[0]))).any():
            continue
        made = repeats.variation(repeats.spread(np.array(counts)))
        assert not lost(facade, locks, made)
        sizes = [each for each in inherited(locks, made) if isinstance(each, Size) and each.axis == X]
        wishes = [Size(0, X, metres), *sizes]
        energy = least_energy(made.facade, origin_of(facade, made), wishes, "default", (WISH, ALIGNMENT, SYMMETRY))
        assert choice.bound <= (energy + unevenness(repeats, counts, wider)) * (1.0 + 1e-9) + 1e-9
