"""Texture coordinates: projected, carried along, changed and measured."""

from __future__ import annotations

import math
import weakref

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.arrays import Floats
from grammarlab.derivation import compile_grammar
from grammarlab.derivation.derive import derive
from grammarlab.derivation.forest import Forest
from grammarlab.derivation.frames import FrameTable
from grammarlab.derivation.state import texture_maps
from grammarlab.derivation.state.shapes import Ids
from grammarlab.derivation.state.texture_maps import NONE, Move, Scopes, TextureMapTable
from grammarlab.errors import DerivationError
from grammarlab.language.grammar import Grammar
from tests.cases import bulk
from tests.derivation.operations.leaves import symbols

L_SHAPE = np.array([[0.0, 0, 10], [8, 0, 10], [8, 0, 6], [3, 0, 6], [3, 0, 0], [0, 0, 0]])


def points_of(forest: Forest, leaf: int) -> Floats:
    """World points of a leaf, in the order of its mesh."""
    leaves = forest.leaves
    unit = forest.meshes.take(leaves.mesh[leaf : leaf + 1]).points
    return leaves.position[leaf] + (leaves.size[leaf] * unit) @ forest.frames[leaves.frame[leaf]].T


def coordinates_of(forest: Forest, leaf: int, points: Floats) -> Floats:
    """u and v of world points by the map of a leaf."""
    rows = forest.texture_maps[forest.leaves.texture_map[leaf]]
    return np.column_stack([points, np.ones(len(points))]) @ rows.T


def leaves_called(forest: Forest, symbol: str) -> list[int]:
    symbols = forest.nodes.symbol[forest.leaves.node]
    return np.flatnonzero(symbols == forest.symbols.index(symbol)).tolist()


def reported(rules: str, num_models: int = 1, **options) -> dict[str, list[float]]:
    reports = derive(Grammar.parse(rules), num_models, 1, **options).reports
    return {key: reports.value[reports.key == place].tolist() for place, key in enumerate(reports.keys)}


# Projections and what carries them along

numbers = st.sampled_from([-2.5, -1.0, 0.5, 1.0, 3.0, 7.25])
lengths = st.one_of(numbers, numbers.map(lambda x: f"'{abs(x)}"))
angles = st.sampled_from([-90, 17, 45, 90, 180, 200])
flags = st.sampled_from(["true", "false"])
words = st.sampled_from
MOVES = st.one_of(
    st.tuples(lengths, lengths, lengths).map("t({0[0]}, {0[1]}, {0[2]})".format),
    st.tuples(lengths, lengths, lengths).map("s({0[0]}, {0[1]}, {0[2]})".format),
    st.tuples(angles, angles, angles).map("r({0[0]}, {0[1]}, {0[2]})".format),
    st.tuples(angles, angles).map("r(scopeCenter, {0[0]}, 0, {0[1]})".format),
    st.tuples(words(["rel", "abs"]), words(["scope", "pivot", "object", "world"]), numbers, numbers).map(
        "translate({0[0]}, {0[1]}, {0[2]}, {0[3]}, 1)".format
    ),
    st.tuples(words(["rel", "abs"]), words(["scope", "pivot", "object", "world"]), angles).map(
        "rotate({0[0]}, {0[1]}, {0[2]}, 20, 0)".format
    ),
    words(["x", "xz", "xyz"]).map("center({})".format),
    st.tuples(words(["scope.tx", "scope.ry", "scope.sz", "pivot.py", "pivot.oz"]), numbers).map(
        "set({0[0]}, {0[1]})".format
    ),
    st.tuples(flags, flags, flags).map("mirror({0[0]}, {0[1]}, {0[2]})".format),
    words(["reverseNormals()", "alignScopeToAxes(y)", "alignScopeToGeometry(yUp, 0, auto)", "color(1, 0, 0)"]),
)
AXES = st.sampled_from([f"{system}.{axes}" for system in ("scope", "world") for axes in ("xy", "zx", "zy", "yx")])


@given(AXES, st.lists(MOVES, max_size=5), st.sampled_from(["", "s(4, '1, '2)", "extrude(world.y, 2)"]))
@bulk(150)
def test_every_point_keeps_its_coordinates_wherever_it_is_moved(axes, moves, first):
    rules = f"""
        Lot --> r(0, 30, 0) {first} primitiveCylinder(5, 2, 3) t(1, 2, 3)
                setupProjection(0, {axes}, 2, -3, 0.5, 0.25, 0.75) projectUV(0) [ Before ] {" ".join(moves)} After
    """
    forest = derive(Grammar.parse(rules), 1, 1)
    (before,), (after,) = leaves_called(forest, "Before"), leaves_called(forest, "After")
    old, new = points_of(forest, before), points_of(forest, after)
    np.testing.assert_allclose(
        coordinates_of(forest, after, new), projected(forest, before, old, axes), rtol=1e-9, atol=1e-9
    )


@pytest.mark.parametrize("turn", ["", "r(0, 0, 90 * (split.index % 3))", "r(0, rand(90), 0)"])
@pytest.mark.parametrize(("size", "width"), [("'1", "2"), ("'rand(0.5, 1)", "2"), ("'1", "rand(1, 3)")])
def test_many_shapes_keep_their_coordinates_whatever_they_share(turn, size, width):
    """Of shapes that are moved together, some have equal gradients, axes and factors; others differ in one of them."""
    rules = f"""
        Lot --> extrude(3) comp(f) {{ side : split(x) {{ ~0.5 : Tile }}* }}
        Tile --> setupProjection(0, scope.xy, {width}, 3) projectUV(0)
                 [ Before ] t(rand(1), 0, 1) {turn} s({size}, '1, '1) After
    """
    forest = derive(Grammar.parse(rules), 3, 1)
    before, after = (scope_coordinates(forest, leaves_called(forest, name)) for name in ("Before", "After"))
    assert len(before) > 200
    np.testing.assert_allclose(after, before, rtol=1e-9, atol=1e-9)


@given(AXES, st.lists(MOVES, min_size=1, max_size=6), st.lists(st.booleans(), min_size=6, max_size=6))
@bulk(60)
def test_the_maps_of_moved_shapes_do_not_depend_on_when_they_are_read(axes, moves, reads):
    """Maps are computed when they are read, to the same bits whatever is read before."""
    steps = [f'{move} report("{number}", geometry.uMin(0))' for number, move in enumerate(moves)]
    bodies = (moves, [step if read else move for step, move, read in zip(steps, moves, reads, strict=False)], steps)
    rules = """
        Lot --> extrude(3) comp(f) {{ side = split(x) {{ ~2 : Tile }}* | top : Tile }}
        Tile --> setupProjection(0, {axes}, 2, 3) projectUV(0) [ t(rand(1), 0, 1) Other ] t(0, rand(2), 0) {moves} After
    """
    grammars = [Grammar.parse(rules.format(axes=axes, moves=" ".join(body))) for body in bodies]
    forests = [derive(grammar, 2, 1, footprint=(12.0, 9.0)) for grammar in grammars]
    maps = [forest.texture_maps[forest.leaves.texture_map] for forest in forests]
    assert len(maps[0]) > 20
    # With a small budget the maps of all moves but the last are computed before.
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(texture_maps, "_MOST_PENDING", 40)
        kept = derive(grammars[0], 2, 1, footprint=(12.0, 9.0))
    maps.append(kept.texture_maps[kept.leaves.texture_map])
    assert len({rows.tobytes() for rows in maps}) == 1


def test_moves_are_applied_once_whatever_depths_are_read(monkeypatch):
    """Of 200 shapes that are moved 1 to 200 times, each is read after its last move, while the others move on."""
    rules = """
        Lot --> comp(f) { all : setupProjection(0, scope.xy, 1, 1) projectUV(0) Tiles }
        Tiles --> split(x) { { ~0.1 : t(0, 0, rand(1)) Tile(split.index) }* }
        Tile(n) --> case n > 0 : t(0.01, 0.02, 0.03) Tile(n - 1) else : translateUV(0, 0.5, 0.5) Leaf
    """
    applied = Move.applied
    sizes: list[int] = []

    def counted(move: Move, maps: Floats, frames: FrameTable) -> Floats:
        sizes.append(len(maps))
        return applied(move, maps, frames)

    monkeypatch.setattr(Move, "applied", counted)
    assert len(derive(Grammar.parse(rules), 1, 1, footprint=(20.0, 5.0)).leaves) == 200
    assert len(sizes) == 200
    assert sum(sizes) == sum(range(201))


def test_a_read_applies_only_the_moves_that_led_to_it(monkeypatch):
    """Of two halves moved twice, the smaller one reads its maps, and nothing reads those of the other, an asset."""
    rules = """
        Lot --> comp(f) { all : setupProjection(0, scope.xy, 1, 1) projectUV(0) Tiles }
        Tiles --> split(x) { 16 : split(x) { ~0.1 : t(0, 0, rand(1)) t(0, 0, 1) Plain }* | ~1 : Shifted }
        Plain --> i("builtin:cube") deleteUV(0) Cube.
        Shifted --> split(x) { ~0.1 : t(0, 0, rand(1)) t(0, 0, 1) translateUV(0, 0.5, 0.5) Leaf. }*
    """
    applied = Move.applied
    sizes: list[int] = []

    def counted(move: Move, maps: Floats, frames: FrameTable) -> Floats:
        sizes.append(len(maps))
        return applied(move, maps, frames)

    monkeypatch.setattr(Move, "applied", counted)
    assert len(derive(Grammar.parse(rules), 1, 1, footprint=(20.0, 5.0)).leaves) == 200
    assert sizes == [40, 40]


def moves_of(number: int, count: int) -> list[Move]:
    """Moves of unit cubes [N] between random places."""
    places = np.random.default_rng(0).uniform(size=(2 * number, count, 3))
    scopes = [Scopes(place.copy(), np.ones((count, 3)), np.zeros(count, dtype=np.int32)) for place in places]
    return [Move(*pair) for pair in zip(scopes[::2], scopes[1::2], strict=True)]


def kept_of(moves: list[Move], ids: Ids, table: TextureMapTable) -> list[bool]:
    """Whether a table keeps the places before each move; the list is emptied."""
    places = []
    while moves:
        places.append(weakref.ref(moves[0].before.position))
        ids = table.moved(ids, moves.pop(0))
    return [place() is not None for place in places]


def test_what_is_kept_of_moves_is_bounded(monkeypatch):
    """Nothing where all shapes have one map, the rows of those with a map among others, and up to a budget."""
    monkeypatch.setattr(texture_maps, "_MOST_PENDING", 5 * (30 + 16))
    was_given, maps = np.zeros(30, dtype=bool), np.random.default_rng(0).normal(size=(30, 2, 4))
    table = TextureMapTable(FrameTable())
    assert kept_of(moves_of(1, 30), table.add(maps[:1], was_given[:1]).repeat(30), table) == [False]
    few = np.full(30, NONE, dtype=np.int32)
    few[[7, 9]] = table.add(maps[:2], was_given[:2])
    assert kept_of(moves_of(3, 30), few, table) == [False] * 3
    table = TextureMapTable(FrameTable())
    assert kept_of(moves_of(12, 30), table.add(maps, was_given), table) == [False] * 7 + [True] * 5


def test_numbers_out_of_range_in_maps_are_no_warnings_whenever_they_are_computed():
    rules = "Lot --> comp(f) {{ all : projectUV(0) s(1e-320, '1, '1) {read} Leaf. }}"
    late, early = (
        derive(Grammar.parse(rules.format(read=read)), 2, 1) for read in ("", 'report("u", geometry.uMin(0))')
    )
    assert len(late.texture_maps) == 1
    assert not np.isfinite(late.texture_maps).all()
    assert late.texture_maps.tobytes() == early.texture_maps.tobytes()


def test_equal_maps_of_a_forest_are_one():
    """Two projections that agree, and moves along which nothing changes, need no maps of their own."""
    rules = """
        Lot --> extrude(3) comp(f) { front : split(x) { ~1 : Tile(split.index) }* }
        Tile(i) --> setupProjection(0, world.xy, 2, 3) t(0, 0, -i) projectUV(0) Half(i)
        Half(i) --> case i % 2 == 0 : Even else : t(0, 0, i) Odd
    """
    forest = derive(Grammar.parse(rules), 3, 1)
    assert len(forest.leaves) > 20
    assert len(forest.texture_maps) == 1
    assert not forest.leaves.texture_map.any()


def scope_coordinates(forest: Forest, rows: list[int]) -> Floats:
    """[K, 4, 2] texture coordinates of the corners x, y of the unit squares of scopes."""
    corners = np.array([[x, y, 0.0] for x in (0.0, 1.0) for y in (0.0, 1.0)])
    leaves = forest.leaves
    local = corners * leaves.size[rows, None]
    points = leaves.position[rows, None] + np.einsum("kij,kcj->kci", forest.frames[leaves.frame[rows]], local)
    maps = forest.texture_maps[leaves.texture_map[rows]]
    return np.einsum("kai,kci->kca", maps[:, :, :3], points) + maps[:, None, :, 3]


def test_the_corner_of_the_image_is_at_the_offsets():
    """A facade takes the part of an image above its ground floor, as files of CityEngine's facade wizard do."""
    part = "extrude(9) comp(f) { front : setupProjection(0, scope.xy, '4, '1.5, '-2, '-0.5) projectUV(0) A } A -->"
    found = reported(f'Lot --> {part} report("u", geometry.uMin(0)) report("v", geometry.vMin(0))')
    assert (found["u"], found["v"]) == (pytest.approx([0.5]), pytest.approx([1.0 / 3.0]))


def projected(forest: Forest, leaf: int, points: Floats, axes: str) -> Floats:
    """The projection of the test above, in words of the reference."""
    system, letters = axes.split(".")
    if system == "scope":
        points = (points - forest.leaves.position[leaf]) @ forest.frames[forest.leaves.frame[leaf]]
    u, v = ("xyz".index(letter) for letter in letters)
    w = 3 - u - v
    return np.stack([(points[:, u] - 0.5 + 0.75 * points[:, w]) / 2, (points[:, v] - 0.25) / -3], axis=1)


CUTS = [
    "split(x) { '0.3 : Part | ~1 : Part }",
    "split(y) { {~0.7 : Part}* }",
    "comp(f) { all : Part }",
    "comp(f) { side = Part | top : split(z) { ~1 : Part | ~2 : Part } }",
    "comp(f) { top : offset(-0.2) Part | all : alignScopeToGeometry(zUp, 0, auto) Part }",
    "comp(f) { top : roofHip(30) comp(f) { all : Part } }",
    "comp(f) { top : setback(0.1) { all : Part | remainder : Part } }",
    "split(u, uvSpace, 0) { '0.2 : Part | ~1 : Part }",
    "split(v, unitSpace, 0) { 0.5 : Part | { ~0.4 : Part }* }",
    "comp(f) { top : extrude(2) Part }",
    "rotateScope(20, 30, 40) Part",
]


@given(st.lists(MOVES.filter(lambda move: "set(" not in move), max_size=3), st.sampled_from(CUTS))
@bulk(100)
def test_parts_have_the_coordinates_of_what_they_are_cut_from(moves, cut):
    rules = f"""
        Lot --> primitiveCylinder(5, 2, 3) setupProjection(0, scope.zy, 2, 3, 1, 0, 0.5) projectUV(0)
                {" ".join(moves)} [ Whole ] {cut}
    """
    forest = derive(Grammar.parse(rules), 1, 1)
    (whole,) = leaves_called(forest, "Whole")
    corners = points_of(forest, whole)
    known = coordinates_of(forest, whole, corners)
    # An affine function is what it is on corners that do not lie in one plane.
    affine, *_ = np.linalg.lstsq(np.column_stack([corners, np.ones(len(corners))]), known, rcond=None)
    parts = leaves_called(forest, "Part")
    assert parts
    for part in parts:
        points = points_of(forest, part)
        expected = np.column_stack([points, np.ones(len(points))]) @ affine
        np.testing.assert_allclose(coordinates_of(forest, part, points), expected, rtol=1e-6, atol=1e-6)


def test_a_projection_stays_where_it_was_set_up():
    rules = """
        Lot --> extrude(4) setupProjection(0, scope.xy, 2, 4) split(x) { ~1 : t(0, 1, 0) projectUV(0) Part }*
    """
    forest = derive(Grammar.parse(rules), 1, 1, footprint=(6.0, 3.0))
    for part in leaves_called(forest, "Part"):
        points = points_of(forest, part)
        np.testing.assert_allclose(coordinates_of(forest, part, points), points[:, :2] / [2, 4])


def test_sizes_of_textures_may_be_shares_or_about_so_large():
    rules = """
        Lot --> extrude(4) setupProjection(0, scope.xy, ~2.6, '0.5) projectUV(0)
                report("u", geometry.du(0, uvSpace)) report("v", geometry.dv(0, uvSpace))
                setupProjection(1, scope.xy, ~-90, '-1) projectUV(1)
                report("u", geometry.uMin(1)) report("v", geometry.vMin(1))
                setupProjection(2, scope.xy, 0, scope.sy - 4) projectUV(2)
                report("u", geometry.du(2, uvSpace)) report("v", geometry.dv(2, unitSpace))
    """
    assert reported(rules, footprint=(10.0, 3.0)) == {"u": [4.0, -1.0, 0.0], "v": [2.0, -1.0, 0.0]}


@pytest.mark.parametrize(
    ("corners", "coordinates"),
    [
        ([[0, 0, 0], [0, 0, 20], [30, 0, 20], [30, 0, 0]], (0.0, 50.0)),
        ([[0, 0, 0], [5, 0, 20], [32, 0, 23], [28, 0, 2]], (0.0, 55.541)),
        ([[0, 0, 0], [-3, 0, 14], [11, 0, 25], [26, 0, 16], [24, 0, 1]], (0.0, 38.972)),
        ([[0, 0, 0], [0, 6, 20], [30, 12, 20], [30, 6, 0]], (0.0, 53.15)),
    ],
)
@pytest.mark.parametrize("move", [(0.0, 0.0, 0.0), (100.0, 5.0, 200.0)])
def test_without_setup_the_projection_is_that_of_the_initial_shape_around_its_first_corner(corners, coordinates, move):
    """Measured with CityEngine's runtime: u = x - z and v = y in the axes of the initial shape."""
    top = "projectUV(0) A } A -->"
    rules = f"Lot --> extrude(9.144) comp(f) {{ top : {top} " + "".join(
        f'report("{name}", geometry.{name}(0)) ' for name in ("uMin", "uMax", "vMin", "vMax")
    )
    grammar = Grammar.parse(rules)
    found = derive(grammar, 1, 1, footprint=np.array(corners, dtype=np.float64) + move).reports.value
    assert found == pytest.approx([*coordinates, 9.144, 9.144], abs=2e-3)


# What shapes come with


@pytest.mark.parametrize("footprint", [(6.0, 3.0), L_SHAPE])
def test_an_initial_shape_is_a_straight_street(footprint):
    rules = """
        const length = geometry.du(0, unitSpace)
        Lot --> report("du", geometry.du(0, uvSpace) - 1) report("dv", geometry.dv(0, uvSpace) - 1)
                report("length", length - scope.sx) report("width", geometry.dv(0, unitSpace) - scope.sz)
                report("metres", geometry.uMax(1) - scope.sx) report("metres", geometry.vMax(2) - scope.sz)
                split(u, uvSpace, 1) { 1 : First. | ~1 : NIL }
                split(u, uvSpace, 2) { 1 : Last. | ~1 : NIL }
    """
    for key, values in reported(rules, footprint=footprint).items():
        assert values == pytest.approx([0.0] * len(values), abs=1e-12), key


def test_images_lie_by_coordinates_only_once_an_operation_made_some():
    rules = """
        Lot --> texture("wall.png") [ split(u, unitSpace, 0) { 3 : t(0, 1, 0) Given | ~1 : NIL } ] [ s(3, 1, 1) Given ]
                [ scaleUV(0, 1, 1) Made ] [ primitiveCube() Bare ] [ scaleUV(0, 1, 1) primitiveCube() Bare ]
                [ scaleUV(0, 1, 1) deleteUV(0) Bare ] [ copyUV(2, 0) Made ]
    """
    forest = derive(Grammar.parse(rules), 2, 1)
    symbols = [forest.symbols[symbol] for symbol in forest.nodes.symbol[forest.leaves.node]]
    assert {symbol: forest.leaves.texture_map[leaf] >= 0 for leaf, symbol in enumerate(symbols)} == {
        "Given": False,
        "Made": True,
        "Bare": False,
    }


def test_grammars_without_coordinates_carry_none():
    plain = compile_grammar(Grammar.parse('Lot --> texture("a.png") split(x) { ~1 : t(1, 0, 0) A }*'))
    assert plain.uv_sets == frozenset()
    assert derive(plain, 3, 1).texture_maps.shape == (0, 2, 4)


@pytest.mark.parametrize(
    ("rules", "sets"),
    [
        ("Lot --> projectUV(3) copyUV(1, 2) A", {1, 2, 3}),
        ("Lot --> report('u', geometry.uMin) A", {0}),
        ("const layer = 2  Lot --> projectUV(layer) A", set(range(10))),
        ("Lot --> split(v, unitSpace, 4) { 1 : A }", {4}),
    ],
)
def test_the_sets_that_a_grammar_mentions(rules, sets):
    assert compile_grammar(Grammar.parse(rules.replace("'", '"'))).uv_sets == sets


# Operations on coordinates

FACADE = "Lot --> r(10, 20, 30) s(7, 5, '1) primitiveQuad() s('1, 5, 3) extrude(2) comp(f) { top : Top }  Top --> "
PROJECTED = FACADE + "setupProjection(0, scope.xy, 2.5, 1.5, -1, -2) projectUV(0) "
MEASURES = {
    "du": "geometry.du(0, uvSpace)",
    "dv": "geometry.dv(0, uvSpace)",
    "metres u": "geometry.du(0, unitSpace)",
    "metres v": "geometry.dv(0, unitSpace)",
    "low u": "geometry.uMin(0)",
    "low v": "geometry.vMin(0)",
    "high u": "geometry.uMax(0)",
    "high v": "geometry.vMax(0)",
}


def measured(operations: str) -> dict[str, float]:
    reports = " ".join(f'report("{name}", {measure})' for name, measure in MEASURES.items())
    return {name: values[0] for name, values in reported(PROJECTED + operations + " " + reports).items()}


def test_extents_are_measured_in_their_unit_and_on_the_surface():
    found = measured("")
    assert found["metres u"] == pytest.approx(7.0)
    assert found["metres v"] == pytest.approx(3.0)
    assert found["du"] == pytest.approx(7.0 / 2.5)
    assert found["dv"] == pytest.approx(3.0 / 1.5)
    assert found["high u"] - found["low u"] == pytest.approx(found["du"])
    assert found["low v"] == pytest.approx(2.0 / 1.5)


@pytest.mark.parametrize(
    ("size", "repeats"),
    [("2, 1", (3.5, 3.0)), ("~2, '0.5", (4.0, 2.0)), ("0, 3", (7.0 / 2.5, 1.0)), ("-7, ~99", (1, 1))],
)
def test_tiling_scales_coordinates_from_zero_and_not_the_surface(size, repeats):
    plain, tiled = measured(""), measured(f"tileUV(0, {size})")
    assert (tiled["du"], tiled["dv"]) == pytest.approx(repeats)
    start = {"0": plain["low u"], "-": -tiled["du"]}.get(size[0], 0.0)
    assert (tiled["low u"], tiled["low v"]) == pytest.approx((start, 0.0))
    assert tiled["metres u"] == pytest.approx(plain["metres u"])
    assert tiled["metres v"] == pytest.approx(plain["metres v"])


@pytest.mark.parametrize(
    ("mode", "extents"), [("uv", (1, 1)), ("u", (1, 2)), ("v", (2.8, 1)), ("uvUniform", (1.0, 2.0 / 2.8))]
)
@pytest.mark.parametrize("kind", ["collectiveAllFaces", "separatePerFace"])
def test_normalized_coordinates_begin_at_zero(mode, extents, kind):
    found = measured(f"rotateUV(0, 0) normalizeUV(0, {mode}, {kind})")
    assert (found["du"], found["dv"]) == pytest.approx(extents)
    assert found["low u"] == pytest.approx(0.4 if mode == "v" else 0.0)
    assert found["low v"] == pytest.approx(2.0 / 1.5 if mode == "u" else 0.0)
    assert measured(f"normalizeUV(0, {mode}, {kind}) normalizeUV(0, {mode}, {kind})") == pytest.approx(found)


@pytest.mark.parametrize(
    "there_and_back",
    [
        "translateUV(0, 0.3, -7) offsetUV(0, -0.3, 7)",
        "scaleUV(0, -2, 0.25) scaleUV(0, -0.5, 4)",
        "rotateUV(0, 33) rotateUV(0, -33)",
        "rotateUV(0, 90) rotateUV(0, 270)",
        "copyUV(0, 5) deleteUV(0) copyUV(5, 0)",
        "tileUV(0, 0, 0)",
        "translateUV(1, 2, 3) scaleUV(4, 0, 0) deleteUV(2)",
    ],
)
def test_operations_that_leave_coordinates_as_they_were(there_and_back):
    assert measured(there_and_back) == pytest.approx(measured(""))


def test_coordinates_are_turned_from_u_towards_v():
    plain, turned = measured(""), measured("rotateUV(0, 90)")
    assert (turned["low u"], turned["high u"]) == pytest.approx((-plain["high v"], -plain["low v"]))
    assert (turned["low v"], turned["high v"]) == pytest.approx((plain["low u"], plain["high u"]))


def test_metres_on_a_roof_are_those_of_its_slopes():
    rules = """
        Lot --> roofHip(60) setupProjection(0, world.xz, 1, 1) projectUV(0)
                comp(f) { front : report("v", geometry.dv(0, unitSpace) / geometry.dv(0, uvSpace)) A }
    """
    assert reported(rules, footprint=(30.0, 20.0))["v"] == pytest.approx([1.0 / math.cos(math.radians(60.0))])


# Batches, draws and mistakes

DRAWING = """
attr height = rand(3, 9)
Lot --> {0} extrude(height) comp(f) {{ side : Wall | top : Roof }}
Wall --> {0} {1} split(x) {{ {{ ~rand(1, 3) : {2} Tile }}* }}
Tile --> 50% : t(rand(1), 0, 0) {2} A else : s('0.5, '1, 1) {0} B
Roof --> 30% : NIL else : roofGable(30) comp(f) {{ all : {1} A }}
"""
TEXTURED = DRAWING.format(
    'setupProjection(0, "scope.xy", 3, ~2)',
    "projectUV(0)",
    'tileUV(0, ~1, 0) normalizeUV(0, "v", "separatePerFace")',
)


def test_a_model_has_the_same_coordinates_alone_and_in_a_batch():
    batch = derive(Grammar.parse(TEXTURED), 20, 5)
    model = batch.nodes.model[batch.leaves.node]
    for index in (0, 7, 19):
        alone = derive(Grammar.parse(TEXTURED), 1, 5, first_model=index)
        maps = batch.texture_maps[batch.leaves.texture_map[model == index]]
        np.testing.assert_array_equal(maps, alone.texture_maps[alone.leaves.texture_map])


def test_operations_on_coordinates_draw_nothing_and_move_nothing():
    """Their words stand in quotes, since draws are addressed by the number of names before them in the text."""
    plain, textured = derive(Grammar.parse(DRAWING.format("", "", "")), 20, 5), derive(Grammar.parse(TEXTURED), 20, 5)
    for table in ("nodes", "draws", "leaves"):
        for name in getattr(plain, table).__slots__:
            if name != "texture_map":
                np.testing.assert_array_equal(
                    getattr(getattr(plain, table), name), getattr(getattr(textured, table), name)
                )
    np.testing.assert_array_equal(plain.frames, textured.frames)


@pytest.mark.parametrize(
    ("operation", "words"),
    [
        ("projectUV(10)", "projectUV expects a uv set from 0 to 9, found 10"),
        ("projectUV(0.5)", "projectUV expects a uv set from 0 to 9, found 0.5"),
        ("deleteUV(-1)", "deleteUV expects a uv set from 0 to 9, found -1"),
        ("deleteUV(1e99)", "deleteUV expects a uv set from 0 to 9, found 1e"),
        ("copyUV(0, 0/0)", "copyUV expects a uv set from 0 to 9, found nan"),
        ('scaleUV("0", 1, 1)', "scaleUV expects a uv set from 0 to 9, found a string"),
        ('setupProjection(0, sel("xy"), 1, 1)', "setupProjection expects a uv set, axes, a width and a height"),
        ('setupProjection(0, scope.xy, "2", 1)', "setupProjection expected a number, found a string"),
        ("translateUV(0, true && 1, 0)", "true or false"),
        ('report("u", geometry.du(12, uvSpace))', "geometry.du expects a uv set from 0 to 9, found 12"),
        ('report("u", geometry.du(0, 1))', "geometry.du expects uvSpace or unitSpace"),
        ("split(x) { ~1 : projectUV(split.index) A }*", "projectUV expects one uv set for all shapes"),
        ("split(u, uvSpace, 11) { 1 : A }", "split expects a uv set from 0 to 9, found 11"),
        ('split(u, sel("metres"), 0) { 1 : A }', "split(u, ...) expects uvSpace or unitSpace, then a uv set"),
    ],
)
def test_mistakes_are_explained(operation, words):
    with pytest.raises(DerivationError) as caught:
        derive(Grammar.parse(f"Lot --> {operation} A"), 2, 1)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    "operations",
    [
        "s(0, 0, 0) normalizeUV(0, uv, collectiveAllFaces) tileUV(0, ~1, '1) split(u, unitSpace, 0) { 1 : A | ~1 : B }",
        "scaleUV(0, 0, 0) split(v, uvSpace, 0) { 1 : A }",
        "extrude(0) setupProjection(0, scope.xy, '1, '1) projectUV(0) tileUV(0, '0, ~0)",
        "comp(e) { all : projectUV(0) tileUV(0, 1, 1) split(u, unitSpace, 0) { ~1 : A } }",
        "scatter(surface, 3, uniform) { projectUV(0) tileUV(0, 1, 1) A }",
        "setupProjection(0, world.xz, 1e-300, 1e300) projectUV(0)",
        "s(2, 0, 3) extrude(-2) t(0, 1, 0) s('1, '2, '1) tileUV(0, 1, 1)",
    ],
)
def test_degenerate_shapes_have_finite_coordinates(operations):
    forest = derive(Grammar.parse(f"Lot --> {operations} A"), 2, 1)
    assert np.isfinite(forest.texture_maps).all()


def test_a_split_along_missing_coordinates_has_no_parts_and_says_so():
    text = "Lot --> split(x) { ~1 : A }*  A --> 50% : deleteUV(0) B else : B  B --> split(u, uvSpace, 0) { ~1 : C }"
    forest = derive(Grammar.parse(text), 4, 1)
    (warning,) = forest.warnings
    assert "a shape without texture coordinates in set 0" in warning.message
    deleted = (forest.draws.value == 0.0).sum()
    assert symbols(forest).count("B") == deleted > 0, "a shape without parts is a leaf itself"
    assert symbols(forest).count("C") == len(forest.draws.value) - deleted > 0
