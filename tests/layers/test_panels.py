"""Panels of solved layouts, compared with a test of each point."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.facade.grammar.exact_grammar import EXACT, write_exact
from grammarlab.facade.looks import THICKNESS, look_of
from grammarlab.facade.tree import X, Y, check
from grammarlab.layers.design import Shape
from grammarlab.layers.panels import Panel, Panels, flattened, rectangles, relief
from grammarlab.runs.facade.layer_files import SolvedLayout, solve_design
from tests.layers.samples import design, residential


@st.composite
def panels(draw: st.DrawFn) -> Panels:
    """Boxes of up to four layers on a grid of up to six by five lines, in arbitrary order."""
    columns, rows = draw(st.integers(1, 6)), draw(st.integers(1, 5))
    lines = (np.linspace(0.0, 1.5 * columns, columns + 1), np.linspace(0.0, 2.0 * rows, rows + 1))
    found = []
    for number in range(draw(st.integers(0, 8))):
        left, bottom = draw(st.integers(0, columns - 1)), draw(st.integers(0, rows - 1))
        right, top = draw(st.integers(left + 1, columns)), draw(st.integers(bottom + 1, rows))
        shape = Shape(f"thing {number}")
        found.append(Panel(0, (str(number), ""), shape, (left, bottom, right, top), draw(st.booleans())))
    return Panels(lines, tuple(found))


@settings(max_examples=60, deadline=None)
@given(some=panels())
def test_at_each_place_the_topmost_panel_is_seen(some: Panels) -> None:
    facade = check(flattened(some))
    assert facade.width == some.lines[X][-1]
    assert facade.height == some.lines[Y][-1]
    for leaf in facade.leaves.tolist():
        low, high = facade.position[leaf], facade.position[leaf] + facade.size[leaf]
        for column in range(len(some.lines[X]) - 1):
            for row in range(len(some.lines[Y]) - 1):
                middle = np.array([some.lines[X][column : column + 2].mean(), some.lines[Y][row : row + 2].mean()])
                if (low < middle).all() and (middle < high).all():
                    over = [each for each in some.panels if _covers(each, column, row)]
                    assert facade.name_of(leaf) == (over[0].shape.label if over else "outside")


def _covers(panel: Panel, column: int, row: int) -> bool:
    left, bottom, right, top = panel.lines
    return left <= column < right and bottom <= row < top


@settings(max_examples=60, deadline=None)
@given(
    shown=st.integers(1, 6).flatmap(
        lambda n: st.lists(st.lists(st.booleans(), min_size=n, max_size=n), min_size=1, max_size=5)
    )
)
def test_rectangles_cover_what_is_shown_and_nothing_twice(shown: list[list[bool]]) -> None:
    cells = np.array(shown)
    covered = np.zeros(cells.shape, dtype=int)
    for left, bottom, right, top in rectangles(cells, (0, 0, cells.shape[1], cells.shape[0])):
        covered[bottom:top, left:right] += 1
    assert (covered == cells).all()


@settings(max_examples=30, deadline=None)
@given(some=panels())
def test_solids_are_hidden_by_opaque_ones_only(some: Panels) -> None:
    for number, boxes in enumerate(some.visible_rectangles()):
        for left, bottom, right, top in boxes:
            for column in range(left, right):
                for row in range(bottom, top):
                    above = some.panels[:number]
                    assert not any(each.opaque and _covers(each, column, row) for each in above)
    for number, panel in enumerate(some.panels):
        if not any(each.opaque for each in some.panels[:number]):
            assert some.visible_rectangles()[number] == [panel.lines]


@pytest.fixture(scope="module")
def house() -> SolvedLayout:
    return solve_design(residential())[0]


def test_the_house_has_its_cells(house: SolvedLayout) -> None:
    """5 by 2 cells, of which two are behind columns and one behind a door, and a roof over all."""
    labels = [house.facade.name_of(leaf) for leaf in house.facade.leaves.tolist()]
    assert sorted(set(labels) - {"wall"}) == ["column", "door", "roof", "shop window", "window"]
    assert sorted(label for label in labels if label != "wall") == sorted(
        ["window"] * 2 + ["shop window"] * 2 + ["column"] * 2 + ["door", "roof"]
    )
    assert "outside" not in house.facade.labels


def test_no_place_of_the_house_has_nothing_solid(house: SolvedLayout) -> None:
    opaque = [panel.lines for panel in house.panels.panels if panel.opaque]
    across, up = house.panels.lines
    boxes = [shapely.box(across[left], up[bottom], across[right], up[top]) for left, bottom, right, top in opaque]
    assert shapely.union_all(boxes).area == pytest.approx(6.0 * 4.5, rel=1e-9)


def test_the_relief_of_the_house(house: SolvedLayout) -> None:
    scene = relief(house.design, house.panels)
    assert scene.size[:, 2].max() == pytest.approx(THICKNESS + look_of("column").front)
    columns = [panel for panel in house.panels.panels if panel.shape.label == "column"]
    assert len(columns) == 2
    cells = [(left, bottom) for left, bottom, _, _ in (column.lines for column in columns)]
    for column, row in cells:
        over = [panel.shape.label for panel in house.panels.panels if _covers(panel, column, row)]
        assert over == ["column", "wall"], "columns hide no wall"
    solid = [
        panel.shape.label
        for panel, seen in zip(house.panels.panels, house.panels.visible_rectangles(), strict=True)
        if seen
    ]
    assert solid.count("wall") == 5 + 2 + 2 + 1, "walls, and frames of windows and of the door"
    assert len(scene) >= len(solid)


@pytest.mark.parametrize("scale", [0.1, 1.0, 20.0])
def test_a_shape_with_an_inset_is_in_its_place_and_its_frame_fills_the_rest(scale: float) -> None:
    """For any size of the cell, however small."""
    made = design({"wall": "AB"}, "A = 1.0\nB = 2.0", 3.0)
    inset = (0.2 * scale, 0.5 * scale, 0.3 * scale, 0.25 * scale)
    shapes = {("A", "Y"): Shape("wall"), ("B", "Y"): Shape("window", inset=inset, frame="brick")}
    solved = solve_design(replace(made, shapes=shapes))[0]
    low, high = {}, {}
    area = {"wall": 0.0, "window": 0.0, "brick": 0.0}
    for leaf in solved.facade.leaves.tolist():
        name, size = solved.facade.name_of(leaf), solved.facade.size[leaf]
        low[name], high[name] = solved.facade.position[leaf], solved.facade.position[leaf] + size
        area[name] += size.prod()
    assert sum(area.values()) == pytest.approx(9.0)
    assert area["wall"] == pytest.approx(3.0)
    assert area["window"] >= 6.0 * 0.4**2 - 1e-9
    assert low["window"][X] > 1.0
    assert high["window"][X] < 3.0
    if scale <= 1.0:
        assert low["window"] == pytest.approx([1.0 + inset[0], inset[1]])
        assert high["window"] == pytest.approx([3.0 - inset[2], 3.0 - inset[3]])


def test_depths_of_shapes_and_layers_add_up() -> None:
    plain = solve_design(residential())[0]
    deep = solve_design(
        residential(
            {'label = "roof" }': 'label = "roof", depth = 0.2 }', 'name = "roof"\n': 'name = "roof"\ndepth = 0.3\n'}
        )
    )[0]
    roofs = [relief(each.design, each.panels).size[:, 2][_of(each, "roof")] for each in (plain, deep)]
    assert roofs[1] == pytest.approx(roofs[0] + 0.5)


def _of(solved: SolvedLayout, label: str) -> np.ndarray:
    scene = relief(solved.design, solved.panels)
    number = [panel.shape.label for panel in solved.panels.panels].index(label)
    left, bottom, _, _ = solved.panels.panels[number].lines
    low = np.array([solved.panels.lines[X][left], solved.panels.lines[Y][bottom]])
    return np.flatnonzero((np.abs(scene.position[:, :2] - low) < 1e-9).all(axis=1))


def test_rules_of_the_house_give_it_back(house: SolvedLayout) -> None:
    assert write_exact(house.facade).error <= EXACT
