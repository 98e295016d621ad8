"""Areas, bounds and faces that another CGA runtime has measured for the same operations on the same two footprints."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.geometry.meshes import measure
from grammarlab.language.grammar import Grammar
from grammarlab.scene import realize, triangles
from tests.derivation.operations.leaves import symbols, world_meshes

RECTANGLE = np.array([[0.0, 0, 0], [0, 0, 20], [30, 0, 20], [30, 0, 0]])
L_SHAPE = np.array([[0.0, 0, 0], [0, 0, 12], [8, 0, 12], [8, 0, 22], [26, 0, 22], [26, 0, 0]])


def measured(rules: str, footprint: np.ndarray) -> tuple[int, float, list[list[float]]]:
    """Polygons, square metres, and the smallest and largest coordinates of the only model."""
    forest = derive(Grammar.parse(rules), 1, seed=0, footprint=footprint)
    batch = triangles(realize(forest))
    a, b, c = (batch.vertices[batch.triangles[:, corner]].astype(float) for corner in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    bounds = [batch.vertices.min(axis=0).tolist(), batch.vertices.max(axis=0).tolist()]
    return world_meshes(forest).num_faces, float(area), bounds


@pytest.mark.parametrize(
    ("rules", "footprint", "polygons", "area", "far_corner"),
    [
        ("Lot --> extrude(10)", RECTANGLE, 6, 2200.0, [30, 10, 20]),
        ("Lot --> extrude(10)", L_SHAPE, 8, 1944.0, [26, 10, 22]),
        ("Lot --> extrude(1) comp(f) { all : A }", RECTANGLE, 6, 1300.0, [30, 1, 20]),
        ("Lot --> extrude(1) comp(f) { all : A }", L_SHAPE, 8, 1080.0, [26, 1, 22]),
        ('Lot --> i("builtin:cube")', RECTANGLE, 6, 3700.0, [30, 25, 20]),
        ('Lot --> i("builtin:cube")', L_SHAPE, 6, 3448.0, [26, 24, 22]),
        ("Lot --> alignScopeToAxes() t(0, 0, 0)", RECTANGLE, 1, 600.0, [30, 0, 20]),
        ("Lot --> alignScopeToAxes() t(0, 0, 0)", L_SHAPE, 1, 492.0, [26, 0, 22]),
        ("Lot --> extrude(15.456175208091736)", RECTANGLE, 6, 2745.6175208091736, [30, 15.456175208091736, 20]),
        ("Lot --> extrude(15.456175208091736)", L_SHAPE, 8, 2467.7928199768066, [26, 15.456175208091736, 22]),
    ],
)
def test_simple_masses_are_as_the_other_runtime_measured_them(rules, footprint, polygons, area, far_corner):
    found = measured(rules, footprint)
    assert found[0] == polygons
    assert found[1] == pytest.approx(area, rel=1e-6)
    assert np.allclose(found[2], [[0, 0, 0], far_corner], atol=1e-5)


@pytest.mark.parametrize(
    ("rules", "low", "high", "areas"),
    [
        ("comp(f) { hip : A }", [0, 0, 0], [30, 5, 20], [1700]),
        ("comp(f) { hip : A } t(1, 0, 0)", [0, 0, 1], [30, 5, 21], [1700]),
        ("[ t(3, 0, 0) comp(f) { hip : A } ] t(0, 1, 0)", [0, 1, 0], [30, 6, 20], [1700]),
        ("comp(f) { hip : A } comp(f) { 0 : A }", [0, 0, 0], [30, 0, 20], [600]),
        ("split(x) { 0 : A }*", [0, 0, 0], [30, 5, 20], [1700]),
        ("comp(f) { 0 : split(z) { 2 : A } | 1 : split(x) { 0 : B } }", [0, 0, 0], [30, 5, 20], [1700]),
        ("comp(f) { 0 : comp(f) { hip : A } t(1, 0, 0) | 1 : t(0, 0, 1) }", [0, 0, 0], [30, 5, 20], [1700]),
        ("comp(f) { 0 : NIL | 1 : [ NIL ] t(1, 0, 0) | 3 : A }", [0, 0, 20], [30, 5, 20], [150]),
        ("split(x) { 10 : Q | ~1 : C }\nQ --> split(z) { 0 : A }", [0, 0, 0], [30, 5, 20], [1000, 1000]),
        ("split(x) { 10 : split(z) { 0 : A } | ~1 : C }", [0, 0, 10], [30, 5, 20], [1000]),
        ("NIL comp(f) { 0 : A }", [0, 0, 0], [30, 0, 20], [600]),
        ("NIL A", [0, 0, 0], [30, 5, 20], [1700]),
        ("comp(f) { 9 : A | 10 : B }", [0, 0, 0], [30, 5, 20], [100, 150]),
        ("comp(f) { -1 : A }", [0, 0, 0], [30, 5, 0], [150]),
    ],
)
def test_a_shape_is_a_leaf_where_its_rule_made_nothing(rules, low, high, areas):
    forest = derive(Grammar.parse(f"Lot --> extrude(5) {rules}"), 1, seed=0, footprint=RECTANGLE)
    meshes = world_meshes(forest)
    assert sorted(measure.areas(meshes)) == pytest.approx(areas)
    assert np.allclose([meshes.points.min(axis=0), meshes.points.max(axis=0)], [low, high])


@pytest.mark.parametrize("rules", ["[ NIL ]", "[ t(1, 0, 0) NIL ]", "[ [ NIL ] ] t(1, 0, 0)", "comp(f) { all : NIL }"])
def test_nil_hides_a_shape_wherever_it_stands(rules):
    assert len(derive(Grammar.parse(f"Lot --> extrude(5) {rules}"), 1, seed=0).leaves) == 0


def test_each_shape_of_a_batch_is_a_leaf_or_not_on_its_own():
    text = "Lot --> split(x) { ~1 : Part }*\nPart --> 50% : comp(f) { hip : A } else : comp(f) { all : B }"
    forest = derive(Grammar.parse(text), 9, seed=0, footprint=RECTANGLE)
    fruitless = forest.draws.value == 0.0
    made = np.array(symbols(forest))
    assert (made == "Part").sum() == fruitless.sum() > 0
    assert (made == "B").sum() == (~fruitless).sum() > 0


@pytest.mark.parametrize(
    ("footprint", "area", "low", "high"),
    [(RECTANGLE, 2100.0, [0, 0, 0], [30, 3, 20]), (L_SHAPE, 1428.0, [8, 0, 0], [26, 3, 22])],
)
def test_the_largest_inner_rectangle_is_the_one_that_the_other_runtime_finds(footprint, area, low, high):
    rules = "Lot --> innerRectangle(edge) { shape : A extrude(world.up, 3) comp(f) { all : B } | remainder : NIL }"
    polygons, found, bounds = measured(rules, footprint)
    assert polygons == 7
    assert found == pytest.approx(area, rel=1e-4)
    assert np.allclose(bounds, [low, high], atol=0.01)


Z_SHAPE = np.array(
    [[0.0, 0, 0], [22, 0, 0], [22, 0, -14], [38, 0, -14], [38, 0, -26], [13, 0, -26], [13, 0, -11], [0, 0, -11]]
)
PLUS = np.array(
    [
        *([0.0, 0, 0], [8, 0, 0], [8, 0, 9], [20, 0, 9], [20, 0, 0], [33, 0, 0]),
        *([33, 0, -11], [20, 0, -11], [20, 0, -22], [8, 0, -22], [8, 0, -11], [0, 0, -11]),
    ]
)


@pytest.mark.parametrize(
    ("footprint", "low", "high"),
    [
        (Z_SHAPE, [13.000027065, -25.999952851], [37.999927065, -13.999952851]),
        (PLUS, [8.000075124, -21.999915423], [19.999975124, 8.999984577]),
        (
            np.array([[0.0, 0, 0], [2000, 0, 0], [2000, 0, -900], [700, 0, -1500], [0, 0, -1100]]),
            None,
            [1974.999766667],
        ),
    ],
)
def test_sides_of_rectangles_along_edges_lie_on_the_grid_of_the_other_runtime(footprint, low, high):
    forest = derive(
        Grammar.parse("Lot --> innerRectangle(edge) { shape : A | remainder : NIL }"), 1, 0, footprint=footprint
    )
    points = world_meshes(forest).points[:, [0, 2]]
    if low is None:  # a slanted side: its size alone was measured
        assert np.ptp(points[:, 0]) == pytest.approx(high[0], abs=1e-8)
    else:
        assert [points.min(axis=0), points.max(axis=0)] == [pytest.approx(low, abs=1e-6), pytest.approx(high, abs=1e-6)]


EQUAL_ARMS = {
    "L": [(0, 0), (10, 0), (10, -3), (3, -3), (3, -10), (0, -10)],
    "plus": [
        *((4, 0), (8, 0), (8, -4), (12, -4), (12, -8), (8, -8)),
        *((8, -12), (4, -12), (4, -8), (0, -8), (0, -4), (4, -4)),
    ],
    "H": [
        *((0, 0), (4, 0), (4, -8), (9, -8), (9, 0), (13, 0)),
        *((13, -20), (9, -20), (9, -11), (4, -11), (4, -20), (0, -20)),
    ],
}


@pytest.mark.parametrize(
    ("shape", "first", "low", "high"),
    [
        ("L", 0, [0, -3], [10, 0]),
        ("L", 1, [0, -10], [3, 0]),
        ("L", 5, [0, -10], [3, 0]),
        ("plus", 0, [0, -8], [12, -4]),
        ("plus", 1, [4, -12], [8, 0]),
        ("plus", 6, [0, -8], [12, -4]),
        ("H", 0, [9, -20], [13, 0]),
        ("H", 5, [9, -20], [13, 0]),
        ("H", 6, [0, -20], [4, 0]),
        ("H", 11, [0, -20], [4, 0]),
    ],
)
def test_of_equal_arms_the_one_on_the_first_of_the_longest_edges_is_taken_as_in_the_other_runtime(
    shape, first, low, high
):
    corners = np.roll(np.array(EQUAL_ARMS[shape], float), -first, axis=0)
    footprint = np.insert(corners, 1, 0.0, axis=1)
    rules = "Lot --> innerRectangle(edge) { shape : A | remainder : NIL }"
    points = world_meshes(derive(Grammar.parse(rules), 1, 0, footprint=footprint)).points[:, [0, 2]]
    assert [points.min(axis=0), points.max(axis=0)] == [pytest.approx(low, abs=1e-3), pytest.approx(high, abs=1e-3)]


U_SHAPE = np.array(
    [[0.0, 0, 0], [0, 0, 25], [10, 0, 25], [10, 0, 12], [22, 0, 12], [22, 0, 25], [32, 0, 25], [32, 0, 0]]
)


@pytest.mark.parametrize(
    ("rules", "footprint", "outlines"),
    [
        # The first edge of the lot has a part in the first piece: the others begin after the cut.
        (
            "Lot --> rotateScope(0, 90, 0) split(z) { '0.7 : NIL | ~1 : A }",
            U_SHAPE,
            [
                [[0, 17.5], [0, 25], [10, 25], [10, 17.5]],
                [[22, 17.5], [22, 25], [32, 25], [32, 17.5]],
            ],
        ),
        # Where x is upright z keeps its direction.
        (
            (
                "Lot --> offset(-2, inside) comp(f) { all : X }\nX --> "
                "rotateScope(0, 90, 0) alignScopeToAxes(y) split(z) { '0.3 : A | ~1 : NIL }"
            ),
            RECTANGLE,
            [[[2, 2], [2, 6.8], [28, 6.8], [28, 2]]],
        ),
        # Wings that touch along a part of an edge are one outline without corners in straight lines.
        (
            (
                "Lot --> offset(-3, inside) alignScopeToAxes(y) shapeL(0.45 * scope.sz, 0.45 * scope.sx) "
                "{ shape : A | remainder : NIL }"
            ),
            L_SHAPE,
            [[[3, 3], [3, 9], [11, 9], [11, 19], [20, 19], [20, 10.2], [23, 10.2], [23, 3]]],
        ),
    ],
)
def test_pieces_have_the_corners_of_the_other_runtime_in_its_order(rules, footprint, outlines):
    meshes = world_meshes(derive(Grammar.parse(rules), 1, seed=0, footprint=footprint))
    corners = np.split(meshes.points[meshes.corner_points()], meshes.face_offsets[1:-1])
    assert len(corners) == len(outlines)
    for found, expected in zip(corners, outlines, strict=True):
        assert np.allclose(found[:, [0, 2]], expected, atol=1e-6)


@pytest.mark.parametrize(
    ("footprint", "area"),
    [
        (np.array([[0.0, 0, 0], [0, 0, 18], [26, 0, 0]]), 1037.599),
        (np.array([[0.0, 0, 0], [0, 0, 24], [30, 0, 8]]), 1308.955),
    ],
)
def test_a_gable_with_an_index_is_one_of_two_also_on_a_triangle(footprint, area):
    rules = (
        "Lot --> alignScopeToGeometry(yUp, 0, longest) extrude(9) comp(f) { bottom : NIL | top : Roof | side : A }\n"
        "Roof --> roofGable(45, 0, 0, false, 0) s('1, 5, '1) comp(f) { bottom : NIL | all : A }"
    )
    assert measured(rules, footprint)[1] == pytest.approx(area, abs=2e-3)


COURT = np.array(
    [
        [0.0, 0, 0],
        [0, 0, 26],
        [34, 0, 26],
        [34, 0, 0],
        [0, 0, 0],
        [12, 0, 9],
        [22, 0, 9],
        [22, 0, 17],
        [12, 0, 17],
        [12, 0, 9],
    ]
)
"""A rectangle with a rectangular hole, joined at its first corner."""


def starts(rules: str, footprint: np.ndarray) -> list[list[float]]:
    """The first corner (x, z) of each leaf."""
    meshes = world_meshes(derive(Grammar.parse(rules), 1, seed=0, footprint=footprint))
    first = meshes.face_offsets[meshes.mesh_faces[:-1]]
    return meshes.points[meshes.corner_points()[first]][:, [0, 2]].round(6).tolist()


def test_walls_of_holes_come_last_as_in_the_other_runtime():
    corners = [[0, 0], [0, 26], [34, 26], [34, 0], [12, 9], [22, 9], [22, 17], [12, 17]]
    assert starts("Lot --> extrude(10) comp(f) { side : A. }", COURT) == corners
    assert starts("Lot --> comp(fe) { all : A. }", COURT) == corners


@pytest.mark.parametrize(
    ("footprint", "outline"),
    [
        (RECTANGLE, [[3, 3], [3, 17], [27, 17], [27, 3], [11.4, 12.1], [11.4, 7.9], [18.6, 7.9], [18.6, 12.1]]),
        (COURT, [[3, 3], [3, 23], [31, 23], [31, 3], [9, 6], [25, 6], [25, 20], [9, 20]]),
    ],
)
def test_edges_of_wings_around_a_hole_are_numbered_as_in_the_other_runtime(footprint, outline):
    rules = (
        "Lot --> offset(-3, inside) rotateScope(0, 90, 0) alignScopeToAxes(y) "
        "shapeO(0.35 * scope.sz, 0.35 * scope.sx, 0.35 * scope.sz, 0.35 * scope.sx) { shape : A | remainder : NIL }\n"
        "A --> comp(fe) { all : B. }"
    )
    assert starts(rules, footprint) == outline


def test_a_pyramid_over_a_court_has_no_hole():
    rules = "Lot --> roofPyramid(byHeight, 4) comp(f) { bottom : NIL | all : A. }"
    slopes, area, _ = measured(rules, COURT)
    assert slopes == 4
    assert area == pytest.approx(2 * (227.035 + 231.225), abs=2e-3)


def test_wings_keep_the_corners_in_straight_lines_that_the_other_runtime_keeps():
    lot = np.array([[0.0, 0, 0], [0, 0, 9], [0, 0, 20], [13, 0, 20], [30, 0, 20], [30, 0, 0], [11, 0, 0]])
    rules = (
        "Lot --> offset(-3, inside) rotateScope(0, 90, 0) alignScopeToAxes(y) "
        "shapeL(0.35 * scope.sz, 0.35 * scope.sx) { shape : A. | remainder : NIL }"
    )
    meshes = world_meshes(derive(Grammar.parse(rules), 1, seed=0, footprint=lot))
    outline = [
        [3, 3],
        [3, 9],
        [3, 17],
        [13, 17],
        [27, 17],
        [27, 12.1],
        [13, 12.1],
        [11.4, 12.1],
        [11.4, 9],
        [11.4, 3],
        [11, 3],
    ]
    assert np.allclose(meshes.points[meshes.corner_points()][:, [0, 2]], outline)


@pytest.mark.parametrize(
    ("turn", "parts", "outline"),
    [
        (0, "'0.5 : NIL | ~1 : A.", [[17, 23], [17, 20], [9, 20], [9, 6], [17, 6], [17, 3], [3, 3], [3, 23]]),
        (90, "'0.35 : A. | ~1 : NIL", [[3, 10], [9, 10], [9, 6], [25, 6], [25, 10], [31, 10], [31, 3], [3, 3]]),
        (90, "'0.35 : NIL | ~1 : A.", [[31, 10], [25, 10], [25, 20], [9, 20], [9, 10], [3, 10], [3, 23], [31, 23]]),
    ],
)
def test_a_cut_through_a_court_leaves_one_piece_that_begins_at_the_cut(turn, parts, outline):
    rules = f"Lot --> offset(-3, inside) rotateScope(0, {turn}, 0) alignScopeToAxes(y) split(z) {{ {parts} }}"
    meshes = world_meshes(derive(Grammar.parse(rules), 1, seed=0, footprint=COURT))
    assert meshes.num_faces == 1
    assert np.allclose(meshes.points[meshes.corner_points()][:, [0, 2]], outline)
