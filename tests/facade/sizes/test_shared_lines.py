"""Lines that the whole facade shares."""

import numpy as np
import piqp
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.facade.sizes.constraints import LineOrigin
from grammarlab.facade.sizes.size_wishes import Position, Size
from grammarlab.facade.sizes.solve import Resized, resize
from grammarlab.facade.tree import Facade, check
from tests.facade.integers import integer_facades
from tests.facade.samples import Node, across, built, leaf, stacked

FACTORS = st.floats(0.3, 3.0)


def in_line(facade: Facade, along: int, factor: float) -> Resized:
    origin = LineOrigin(facade.position, facade.size, facade.size[0], shares_lines=True)
    return resize(facade, [Size(0, along, factor * float(facade.size[0, along]))], origin)


def sides(facade: Facade, along: int) -> np.ndarray:
    """[2N] low and high sides of all nodes."""
    low = facade.position[:, along]
    return np.concatenate([low, low + facade.size[:, along]])


@given(integer_facades(), FACTORS, st.integers(0, 1))
@settings(max_examples=40)
def test_sides_at_one_coordinate_stay_so_in_their_order_and_equal_elements_stay_equal(
    facade: Facade, factor: float, along: int
) -> None:
    resized = in_line(facade, along, factor)
    check(resized.facade)
    assert not resized.conflict, "a stretched facade meets all rows"
    old, new = np.rint(sides(facade, along)), sides(resized.facade, along)
    slack = 1e-8 * factor * facade.size[0].max()
    lowest = [new[old == value].min() for value in np.unique(old)]
    assert max(np.ptp(new[old == value]) for value in np.unique(old)) <= slack
    assert np.diff(lowest).min() > 0.0
    size = np.rint(facade.size[:, along])
    for label in {"window", "door", "cornice"} & set(facade.labels):
        nodes = np.flatnonzero(facade.label == facade.labels.index(label))
        assert max(np.ptp(resized.facade.size[nodes[size[nodes] == one], along]) for one in set(size[nodes])) <= slack


@given(integer_facades(), FACTORS, st.integers(0, 1))
@settings(max_examples=20)
def test_the_optimum_is_that_of_a_programme_over_coordinates(facade: Facade, factor: float, along: int) -> None:
    resized = in_line(facade, along, factor).facade
    leaf = facade.leaves
    low = np.rint(facade.position[leaf, along]).astype(int)
    high = np.rint(facade.position[leaf, along] + facade.size[leaf, along]).astype(int)
    coordinate = np.unique([low, high])
    # One row per leaf, and one per distance of neighbouring coordinates.
    begin = np.concatenate([np.searchsorted(coordinate, low), np.arange(len(coordinate) - 1)])
    end = np.concatenate([np.searchsorted(coordinate, high), 1 + np.arange(len(coordinate) - 1)])
    eye, target = np.eye(len(coordinate)), (coordinate[end] - coordinate[begin]).astype(float)
    difference = eye[end] - eye[begin]
    matrix = difference / target[:, None]
    rows, value = [eye[0], eye[-1]], [0.0, factor * float(facade.size[0, along])]
    for label in {"window", "door", "cornice"} & set(facade.labels):
        node = np.flatnonzero(facade.label[leaf] == facade.labels.index(label))
        for size in set(target[node]):
            alike = node[target[node] == size]
            rows += [difference[other] - difference[alike[0]] for other in alike[1:]]
            value += [0.0] * (len(alike) - 1)
    solver = piqp.DenseSolver()
    solver.settings.eps_abs = solver.settings.eps_rel = 1e-10
    ones, above = np.ones(len(target)), np.full(len(target), np.inf)
    solver.setup(
        2.0 * matrix.T @ matrix,
        -2.0 * matrix.T @ ones,
        np.array(rows),
        np.array(value),
        difference,
        1e-3 * target,
        above,
    )
    solver.solve()
    least = float(np.square(matrix @ solver.result.x - ones).sum())
    position = np.array([sides(resized, along)[np.rint(sides(facade, along)) == one][0] for one in coordinate])
    assert np.square(matrix @ position - ones).sum() == pytest.approx(least, rel=1e-6, abs=1e-8)


def test_a_sill_stays_below_its_window_though_no_part_lies_between_their_sides() -> None:
    def storey(gap: float) -> list[Node]:
        return [
            across(leaf("wall", gap - 0.1), leaf("sill", 1.2, 0.1), leaf("wall", 3.9 - gap, 0.1)),
            across(leaf("wall", gap), leaf("window", 1.0, 1.4), leaf("wall", 4.0 - gap, 1.4)),
        ]

    facade = built(stacked(leaf("wall", 5.0, 1.0), *storey(1.0), leaf("wall", 5.0, 1.0), *storey(3.0)))
    resized = in_line(facade, 0, 1.6).facade
    low, high = resized.position[:, 0], (resized.position + resized.size)[:, 0]
    sills, openings = (
        [node for node in facade.leaves.tolist() if facade.name_of(node) == name] for name in ("sill", "window")
    )
    for sill, window in zip(sills, openings, strict=True):
        left, right = low[window] - low[sill], high[sill] - high[window]
        assert 0.1 <= left <= 0.2
        assert 0.1 <= right <= 0.2


def test_a_wish_against_the_lines_is_met_and_named() -> None:
    row = [leaf("wall"), leaf("window"), leaf("wall"), leaf("window"), leaf("wall")]
    facade = built(stacked(across(*row), leaf("wall", 5.0), across(*row)))
    origin = LineOrigin(facade.position, facade.size, facade.size[0], shares_lines=True)
    lower, _, upper, _ = [node for node in facade.leaves.tolist() if facade.name_of(node) == "window"]
    wishes = [Position(lower, 0, 1.5), Position(upper, 0, 1.0)]
    resized = resize(facade, wishes, origin)
    assert resized.residuals.target <= 1e-8
    assert "what stands exactly above each other stays so" in resized.conflict
    assert len(resized.conflict) == 3
