"""Operations that move, size, turn and mirror shapes, and what is read of their placement."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from grammarlab.derivation import derive
from grammarlab.geometry.meshes import measure
from grammarlab.language.grammar import Grammar
from tests.derivation.operations.leaves import (
    forest_frames,
    sampled,
    symbols,
    world_meshes,
)

L_SHAPE = np.array([[0.0, 0, 12], [8, 0, 12], [8, 0, 22], [26, 0, 22], [26, 0, 0], [0, 0, 0]])
READ = " ".join(
    f'report("{kind}{axis}", {kind}{axis})'
    for kind in ("scope.t", "scope.r", "scope.s", "pivot.p", "pivot.o")
    for axis in "xyz"
)


def test_four_quarter_turns_are_exactly_none():
    forest = sampled("Lot --> r(0, 90, 0) r(0, 90, 0) r(0, 90, 0) r(0, 90, 0) A r(90, 0, 0) r(-90, 0, 0) B")
    assert np.array_equal(forest.frames[forest.leaves.frame], np.broadcast_to(np.eye(3), (2, 3, 3)))


@pytest.mark.parametrize(
    ("operations", "order", "angles"),
    [
        ("r(-10, 70, 25)", "xyz", [-10, 70, 25]),
        ("r(0, 90, 0) r(90, 0, 0)", "yx", [90, 90]),
        ("r(90, 0, 0) r(0, 90, 0)", "xy", [90, 90]),
        ("r(scopeCenter, 0, 0, 30) r(scopeCenter, 0, 20, 0) r(0, 0, 10)", "zyz", [30, 20, 10]),
        ("r(0, 40, 0) rotate(rel, pivot, 10, 0, 5)", "yxz", [40, 10, 5]),
        ("r(0, 40, 0) rotate(rel, scope, 10, 0, 5)", "xzy", [10, 5, 40]),
        ("r(10, 40, 0) rotate(abs, pivot, 20, 0, 5)", "xz", [20, 5]),
    ],
)
def test_shapes_turn_about_the_axes_of_the_pivot_first_x_then_y_then_z(operations, order, angles):
    turned = forest_frames(sampled(f"Lot --> {operations} A"))[0]
    assert np.allclose(turned, Rotation.from_euler(order, angles, degrees=True).as_matrix(), atol=1e-12)


def test_the_steps_of_a_spiral_stair_stand_where_their_number_says():
    """Every turn is about the axes of the pivot, so the last of the 90 frames is made of all the others."""
    grammar = Grammar.parse("""
        Lot --> s(1, 0.2, 0.3) Stair(90)
        Stair(n) --> case n > 0 : [ i("builtin:cube") Step. ] t(0.5, 0.2, 0) r(0, 10, 0) Stair(n - 1) else : NIL
    """)
    forest = derive(grammar, 1, 0)
    order = np.argsort(forest.leaves.position[:, 1])
    place, frame = forest.leaves.position[order], forest.leaves.frame[order]
    turns = Rotation.from_rotvec(np.outer(10 * np.arange(90), [0.0, 1.0, 0.0]), degrees=True)
    np.testing.assert_allclose(forest.frames[frame], turns.as_matrix(), atol=1e-12)
    ends = np.cumsum(turns.apply([0.5, 0.2, 0.0]), axis=0)
    np.testing.assert_allclose(place[1:] - place[0], ends[:-1], atol=1e-11)


def test_the_angles_of_a_scope_are_those_it_was_turned_by():
    forest = sampled('Lot --> r(-10, 70, 25) report("x", scope.rx) report("y", scope.ry) report("z", scope.rz) A')
    assert np.allclose(forest.reports.value, [-10, 70, 25])


PLACE = 'report("x", scope.tx) report("y", scope.ty) report("z", scope.tz)'
PIVOT = 'report("x", pivot.px) report("y", pivot.py) report("z", pivot.pz)'
ANGLES = 'report("x", scope.rx) report("y", scope.ry) report("z", scope.rz)'


@pytest.mark.parametrize(
    ("operations", "expected"),
    [
        (PLACE, [0, 0, 0]),
        (f"t(1, 2, 3) {PLACE}", [1, 2, 3]),
        (f"r(0, 90, 0) t(1, 2, 3) {PLACE}", [3, 2, -1]),
        (f"extrude(5) split(x) {{ 4 : NIL | 3 : {PLACE} A }}", [4, 0, 0]),
        (f"extrude(5) split(y) {{ 2 : NIL | 1 : {PLACE} A }}", [0, 2, 0]),
        (f"extrude(5) comp(f) {{ front : {PLACE} A }}", [0, 0, 0]),
        (f"extrude(5) comp(f) {{ front : {ANGLES} A }}", [0, 0, 0]),
        (f"extrude(5) comp(f) {{ back : t(1, 2, 3) {PLACE} A }}", [1, 2, 3]),
        (f"extrude(5) comp(f) {{ right : {PIVOT} A }}", [10, 0, 8]),
        (f"extrude(5) comp(f, noAlign) {{ right : {PLACE} A }}", [10, 0, 0]),
        (f"extrude(5) comp(f) {{ right : split(x) {{ 3 : NIL | 1 : {PLACE} A }} }}", [3, 0, 0]),
        (f"t(1, 2, 3) setPivot(xyz, 2) {PLACE}", [0, 0, 0]),
        (f"extrude(5) t(1, 2, 3) setPivot(xyz, 2) {PIVOT}", [11, 2, 11]),
        (f"r(0, 30, 0) t(1, 0, 0) alignScopeToAxes(y) {ANGLES}", [0, 0, 0]),
        (f"r(0, 30, 0) {ANGLES}", [0, 30, 0]),
        (f"t(1, 2, 3) translate(abs, pivot, 4, 5, 6) {PLACE}", [4, 5, 6]),
        (f"t(1, 2, 3) translate(abs, object, 4, 5, 6) {PLACE}", [4, 5, 6]),
        (f"t(1, 2, 3) translate(abs, scope, 4, 5, 6) {PLACE}", [5, 7, 9]),
        (f"extrude(5) comp(f) {{ right : translate(abs, pivot, 1, 2, 3) {PLACE} A }}", [1, 2, 3]),
        (f"extrude(5) comp(f) {{ right : translate(abs, object, 0, 0, 0) {PLACE} A }}", [8, 0, -10]),
    ],
)
def test_scopes_are_placed_relative_to_their_pivots(operations, expected):
    forest = sampled(f"Lot --> {operations}", footprint=(10.0, 8.0))
    assert np.allclose(forest.reports.value, expected, atol=1e-9)


def test_the_pivot_of_a_face_is_its_first_corner_wherever_its_bounding_box_begins():
    # The first edge of this footprint is the scope's x axis; the polygon reaches to the left of where that begins.
    leaning = np.array([[0.0, 0, 0], [4, 0, 0], [4, 0, -4], [-3, 0, -4]])
    forest = sampled(f"Lot --> comp(f) {{ all : {PLACE} A }}", footprint=leaning)
    assert np.allclose(forest.reports.value, [-3, 0, 0], atol=1e-9)


@pytest.mark.parametrize(
    ("before", "of_its_own"),
    [
        ("extrude(world.up, 7) r(0, 50, 0) comp(f) { front :", True),
        ("r(0, 50, 0) extrude(7) comp(f) { all :", True),
        ("r(0, 50, 0) extrude(7) comp(e) { all :", True),
        ("r(0, 50, 0) extrude(7) comp(f, noAlign) { all :", False),
        ("r(0, 50, 0) extrude(7) split(x) { 3 : Whole | ~1 :", False),
        ("r(0, 50, 0) setPivot(yzx, 3) [", True),
        ("r(10, 50, 0) alignScopeToAxes(y) [", True),
        ("r(0, 50, 0) rotateScope(0, 20, 0) [", False),
    ],
)
def test_components_and_aligned_shapes_have_a_pivot_of_their_own(before, of_its_own):
    forest = sampled(f"Lot --> {before} B r(0, 0, 30) r(20, 0, 0) A {']' if before.endswith('[') else '}'}")
    frames, names = forest_frames(forest), np.array(symbols(forest))
    turn = Rotation.from_euler("zx", [30, 20], degrees=True).as_matrix()
    untouched = frames[names == "B"]
    assert np.allclose(frames[names == "A"], untouched @ turn if of_its_own else turn @ untouched, atol=1e-12)


@pytest.mark.parametrize(
    ("size", "low", "volume"),
    [
        ("-4, 3, 2", (-4, 0, 0), -24),
        ("4, -3, 2", (0, -3, 0), -24),
        ("4, 3, -2", (0, 0, -2), -24),
        ("-4, 3, -2", (-4, 0, -2), 24),
        ("-4, -3, -2", (-4, -3, -2), -24),
        ("'-2, 3, 2", (-10, 0, 0), -60),
    ],
)
@pytest.mark.parametrize("shape", ['i("builtin:cube")', "extrude(5)", "primitiveCylinder(4)"])
def test_a_negative_size_mirrors_a_shape_about_its_origin(shape, size, low, volume):
    forest = derive(Grammar.parse(f"Lot --> {shape} s({size}) A"), 2, 1, footprint=(5.0, 5.0))
    meshes = world_meshes(forest)
    corner, far = meshes.bounds()
    assert np.allclose(corner, low)
    assert np.allclose(far - corner, np.abs(forest.leaves.size))
    assert np.allclose(measure.volumes(meshes), volume)
    assert (forest.leaves.size > 0).all()


def test_a_size_given_negatively_twice_is_the_size():
    once, twice = (
        derive(Grammar.parse(f"Lot --> extrude(3) {ops} A"), 2, 1, footprint=(5.0, 4.0))
        for ops in ("s(2, '1, '1)", "s(-2, '1, '1) t('1, 0, 0) s('-1, '1, '1) ")
    )
    assert np.allclose(once.leaves.position - twice.leaves.position, [2.0, 0.0, 0.0])
    assert np.array_equal(once.leaves.mesh, twice.leaves.mesh)
    assert np.allclose(measure.volumes(world_meshes(twice)), 24.0)


def test_primitives_of_negative_dimensions_stand_on_their_heads():
    forest = derive(Grammar.parse("Lot --> primitiveCube(-2, -3, 1) A"), 1, 1, footprint=(6.0, 4.0))
    low, high = world_meshes(forest).bounds()
    assert np.allclose(low, [2.0, -3.0, 1.5])
    assert np.allclose(high, [4.0, 0.0, 2.5])


@pytest.mark.parametrize("axis", "xyz")
@pytest.mark.parametrize("kind", ["scope.t", "scope.r", "scope.s", "pivot.p", "pivot.o"])
def test_setting_one_number_of_the_placement_changes_it_and_no_other(kind, axis):
    before = "extrude(5) r(10, 20, 30) comp(f) { right : t(1, 2, 0) s('1, '1, 1) r(5, 0, 0) t(0, 1, 2)"
    forest = sampled(f"Lot --> {before} {READ} set({kind}{axis}, 2.5) {READ} A }}", footprint=(10.0, 8.0))
    names = np.array(forest.reports.keys)[forest.reports.key]
    old, new = forest.reports.value.reshape(2, -1)
    changed = names[: len(old)] == f"{kind}{axis}"
    assert np.allclose(new[~changed], old[~changed], atol=1e-9)
    assert new[changed] == pytest.approx(2.5)


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("set(scope.tx, 3)", "translate(abs, pivot, 3, 2, 1)"),
        ("set(scope.rz, 40)", "rotate(abs, pivot, 0, 20, 40)"),
        ("set(scope.sz, 4)", "s('1, '1, 4)"),
        ("set(pivot.px, 3)", "translate(rel, object, 3, 0, 0)"),
        ("set(scope.sx, '0.5)", "s('0.5, '1, '1)"),
    ],
)
def test_setting_the_placement_is_what_the_operations_do(written, meant):
    leaves = [sampled(f"Lot --> extrude(5) t(2, 2, 1) r(0, 20, 0) {operation} A") for operation in (written, meant)]
    one, other = (world_meshes(forest).points for forest in leaves)
    assert np.allclose(one, other, atol=1e-9)


@pytest.mark.parametrize("flips", list(itertools.product(["true", "false"], repeat=3)))
def test_a_mirrored_scope_has_the_same_geometry_and_begins_at_its_other_end(flips):
    text = 'Lot --> extrude(4) {} comp(f) {{ all : A }}  A --> report("side", 0) X.'
    plain, mirrored = (
        derive(Grammar.parse(text.format(operation)), 1, 1, footprint=L_SHAPE)
        for operation in ("", f"mirrorScope({', '.join(flips)})")
    )
    assert np.allclose(np.linalg.det(mirrored.frames), 1.0)
    assert world_faces(plain) == world_faces(mirrored)


def test_a_split_of_a_mirrored_scope_begins_at_its_other_end():
    text = "Lot --> mirrorScope(p(0.5), false, false) split(x) { 3 : A | ~1 : NIL }"
    forest = derive(Grammar.parse(text), 40, 1, footprint=(10.0, 6.0))
    assert set(forest.leaves.position[:, 0].tolist()) == {0.0, 7.0}
    assert set(forest.leaves.size[:, 0].tolist()) == {3.0}


def world_faces(forest) -> set[tuple[tuple[float, ...], ...]]:
    """Corners of all faces in the world, each from its smallest on, rounded."""
    faces = set()
    for leaf in range(len(forest.leaves)):
        mesh = forest.meshes.take(forest.leaves.mesh[leaf : leaf + 1])
        points = (mesh.points * forest.leaves.size[leaf]) @ forest.frames[forest.leaves.frame[leaf]].T
        points = np.round(points + forest.leaves.position[leaf], 9) + 0.0
        for first, end in itertools.pairwise(mesh.face_offsets.tolist()):
            corners = [tuple(point) for point in points[mesh.corners[first:end]].tolist()]
            start = corners.index(min(corners))
            faces.add(tuple(corners[start:] + corners[:start]))
    return faces


@pytest.mark.parametrize("angle", [0, 10, 30, -40])
def test_a_scope_finds_the_least_box_around_its_geometry(angle):
    turned = f"Lot --> rotateScope(0, {angle}, 0) alignScopeToGeometryBBox(xz) extrude(1) A"
    forest = derive(Grammar.parse(turned), 1, 1, footprint=(10.0, 5.0))
    assert np.allclose(forest.leaves.size, [[10.0, 1.0, 5.0]])
    assert np.allclose(forest.frames[forest.leaves.frame[0]], np.eye(3))


LOT = np.array([[0, 0, 0], [0, 0, 12], [8, 0, 12], [8, 0, 22], [26, 0, 22], [26, 0, 0.0]])
SLOPE = np.array([[0, 0, 0], [0, 1.5, 20], [30, 4.5, 20], [30, 3, 0.0]])


@pytest.mark.parametrize(
    ("lot", "rule", "widths"),
    [  # from the runtime
        (LOT, "alignScopeToGeometry(yUp, any, world.lowest) A", [26.0]),
        (LOT, "alignScopeToGeometry(yUp, any, longest) A", [26.0]),
        (LOT, "alignScopeToGeometry(yUp, 0) A", [22.0]),
        (SLOPE, "extrude(1) comp(f) { side : alignScopeToGeometry(zUp, any, world.lowest) A }", [20.0562, 30.1496] * 2),
        (SLOPE, "extrude(2) comp(f) { side : alignScopeToGeometry(zUp, 0, world.lowest) A }", [20.0562, 2.0] * 2),
        (SLOPE, "extrude(6) r(20, 0, 10) alignScopeToGeometry(zUp, world.lowest, longest) A", [30.2989]),
    ],
)
def test_of_equally_low_edges_the_level_and_the_long_one_is_taken(lot, rule, widths):
    assert sampled(f"Lot --> {rule}", lot).leaves.size[:, 0] == pytest.approx(widths, abs=1e-3)
