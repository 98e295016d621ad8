"""Operations keep what they must keep: areas, volumes, and where the geometry is."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.geometry.footprints.footprint_text import read_footprints
from grammarlab.geometry.meshes import measure
from grammarlab.geometry.meshes.edges import joined
from grammarlab.language.grammar import Grammar
from tests.derivation.operations.leaves import (
    L_SHAPE,
    TRIANGLE,
    areas_by_symbol,
    forest_frames,
    sampled,
    symbols,
    volumes_by_symbol,
    world_meshes,
)

FOOTPRINTS = {"rectangle": ((30.0, 20.0), 600.0), "L": (L_SHAPE, 492.0), "triangle": (TRIANGLE, 54.0)}


@pytest.mark.parametrize("footprint", FOOTPRINTS)
def test_an_extrusion_is_closed_and_has_the_volume_of_a_prism(footprint):
    lot, area = FOOTPRINTS[footprint]
    forest = sampled("Lot --> extrude(7) Mass", lot)
    assert volumes_by_symbol(forest)["Mass"] == pytest.approx(7.0 * area)
    assert measure.is_closed(world_meshes(forest)).all()


@pytest.mark.parametrize("footprint", FOOTPRINTS)
@pytest.mark.parametrize("axis", "xyz")
@pytest.mark.parametrize("sizes", ["'0.3 : A | ~1 : B", "{ ~2.7 : A | 0.4 : B }*", "1 : A | { ~3 : B }* | 1.5 : A"])
def test_the_parts_of_a_split_fill_the_whole(footprint, axis, sizes):
    lot, area = FOOTPRINTS[footprint]
    forest = sampled(f"Lot --> extrude(7) split({axis}) {{ {sizes} }}", lot)
    assert sum(volumes_by_symbol(forest).values()) == pytest.approx(7.0 * area)
    assert measure.is_closed(world_meshes(forest)).all()


@pytest.mark.parametrize("footprint", FOOTPRINTS)
def test_the_faces_of_a_solid_add_up_to_its_surface(footprint):
    lot, _ = FOOTPRINTS[footprint]
    whole = areas_by_symbol(sampled("Lot --> extrude(7) Mass", lot))["Mass"]
    parts = areas_by_symbol(sampled("Lot --> extrude(7) comp(f) { top : T | bottom : B | side : S }", lot))
    assert sum(parts.values()) == pytest.approx(whole)
    assert parts["T"] == pytest.approx(parts["B"])


def test_a_component_goes_to_the_first_part_that_names_it():
    forest = sampled("Lot --> extrude(7) comp(f) { front : F | side : S | all : A }")
    assert sorted(symbols(forest)) == ["A", "A", "F", "S", "S", "S"]


def test_an_equals_sign_makes_one_shape_of_all_components():
    forest = sampled("Lot --> extrude(7) comp(f) { side = S | all : A }")
    assert sorted(symbols(forest)) == ["A", "A", "S"]
    assert areas_by_symbol(forest)["S"] == pytest.approx(2 * 7 * 50)


def test_the_frame_of_a_face_has_its_normal_as_z():
    forest = sampled("Lot --> extrude(7) comp(f) { all : A }", L_SHAPE)
    normals = measure.face_normals(world_meshes(forest))
    assert np.allclose(forest.frames[forest.leaves.frame][:, :, 2], normals)


@pytest.mark.parametrize(
    "operation",
    [
        "rotateScope(0, 90, 0)",
        "rotateScope(10, 20, 30)",
        "alignScopeToAxes(y)",
        "alignScopeToAxes()",
        "alignScopeToGeometry(yUp, 0, longest)",
        "alignScopeToGeometry(zUp, largest, 1)",
        "alignScopeToGeometry(yUp, any, world.lowest)",
        "setPivot(xyz, 2)",
        "setPivot(yzx, 5)",
        "setPivot(zxy, 7)",
    ],
)
@pytest.mark.parametrize("footprint", FOOTPRINTS)
def test_turning_the_scope_leaves_the_geometry_where_it_is(operation, footprint):
    lot, _ = FOOTPRINTS[footprint]
    before = sampled("Lot --> r(0, 33, 0) extrude(7) Mass", lot)
    after = sampled(f"Lot --> r(0, 33, 0) extrude(7) {operation} Mass", lot)
    assert np.allclose(_sorted(world_meshes(before).points), _sorted(world_meshes(after).points), atol=1e-9)
    assert volumes_by_symbol(after)["Mass"] == pytest.approx(volumes_by_symbol(before)["Mass"])
    assert np.allclose(np.linalg.det(forest_frames(after)), 1.0)


def _sorted(points):
    rounded = np.round(points, 7)
    return rounded[np.lexsort(rounded.T)]


def test_aligning_to_the_axes_makes_the_scope_upright():
    forest = sampled("Lot --> extrude(7) comp(f) { front : r(20, 0, 0) alignScopeToAxes(y) A }")
    assert np.allclose(forest_frames(forest)[:, :, 1], [0.0, 1.0, 0.0])


@pytest.mark.parametrize("flips", ["true, false, false", "true, true, false", "true, true, true"])
def test_a_mirrored_solid_still_looks_outwards(flips):
    whole = volumes_by_symbol(sampled("Lot --> extrude(7) Mass", L_SHAPE))["Mass"]
    assert volumes_by_symbol(sampled(f"Lot --> extrude(7) mirror({flips}) Mass", L_SHAPE))["Mass"] == pytest.approx(
        whole
    )


@pytest.mark.parametrize("footprint", FOOTPRINTS)
def test_reversed_normals_turn_the_volume_negative_and_back(footprint):
    lot, area = FOOTPRINTS[footprint]
    once = volumes_by_symbol(sampled("Lot --> extrude(7) reverseNormals() Mass", lot))["Mass"]
    twice = volumes_by_symbol(sampled("Lot --> extrude(7) reverseNormals() reverseNormals() Mass", lot))["Mass"]
    assert (once, twice) == (pytest.approx(-7.0 * area), pytest.approx(7.0 * area))


@pytest.mark.parametrize("footprint", FOOTPRINTS)
@pytest.mark.parametrize(
    "text",
    [
        "Lot --> offset(-1) comp(f) { inside : A | border : B }",
        "Lot --> setback(1.5) { front : A | side : B | remainder : C }",
        "Lot --> setback(1.5) { all = A | remainder : C }",
        "Lot --> innerRectangle(scope) { shape : A | remainder : B }",
        "Lot --> shapeL(2, 1) { shape : A | remainder : B }",
        "Lot --> shapeU(2, 1, 1) { shape : A | remainder : B }",
        "Lot --> shapeO(1, 1, 1, 1) { shape : A | remainder : B }",
    ],
)
def test_outlines_cut_a_lot_without_loss(footprint, text):
    lot, area = FOOTPRINTS[footprint]
    assert sum(areas_by_symbol(sampled(text, lot)).values()) == pytest.approx(area)


@pytest.mark.parametrize("footprint", FOOTPRINTS)
def test_rectangles_along_edges_differ_from_their_holes_by_at_most_a_fifth_of_a_millimetre(footprint):
    lot, area = FOOTPRINTS[footprint]
    parts = areas_by_symbol(sampled("Lot --> innerRectangle(edge) { shape : A | remainder : B }", lot))
    loss = area - sum(parts.values())
    assert abs(loss) <= 2e-4 * scope_sum(lot)


def scope_sum(lot) -> float:
    """Width and depth of a lot, in metres."""
    return float(sum(lot)) if isinstance(lot, tuple) else float(np.ptp(lot[:, [0, 2]], axis=0).sum())


ROOFS = [
    "roofHip(40)",
    "roofHip(byHeight, 3)",
    "roofGable(40)",
    "roofPyramid(40)",
    "roofShed(20)",
    "roofRidge(byHeight, 3)",
    "taper(5)",
]


@pytest.mark.parametrize("footprint", FOOTPRINTS)
@pytest.mark.parametrize("roof", ROOFS)
def test_a_roof_is_closed_and_covers_its_lot(footprint, roof):
    lot, area = FOOTPRINTS[footprint]
    forest = sampled(f"Lot --> {roof} Roof", lot)
    meshes = world_meshes(forest)
    vectors = measure.area_vectors(meshes)
    assert measure.is_closed(joined(meshes)).all()
    # As in the runtime, the sheets of roofs have points of their own.
    assert measure.is_closed(meshes).all() == roof.startswith("taper")
    assert volumes_by_symbol(forest)["Roof"] > 0.0
    assert vectors[vectors[:, 1] > 0.0, 1].sum() == pytest.approx(area)


def test_a_roof_by_height_is_that_high():
    forest = sampled("Lot --> roofGable(byHeight, 4.5) Roof", L_SHAPE)
    assert world_meshes(forest).points[:, 1].max() == pytest.approx(4.5)


def test_an_inserted_mesh_fills_the_scope():
    forest = sampled('Lot --> s(4, 6, 2) i("builtin:cylinder") Column')
    points = world_meshes(forest).points
    assert np.allclose([points.min(axis=0), points.max(axis=0)], [[0, 0, 0], [4, 6, 2]])


@pytest.mark.parametrize(
    ("size", "expected"),
    [("(3, 0, 5)", (3, 4, 5)), ("(0, 2, 0)", (2, 2, 2)), ("(0, 0, 0)", (1, 1, 1)), ("(3, 4, 5)", (3, 4, 5))],
)
def test_dimensions_of_zero_follow_the_others(size, expected):
    forest = sampled(f"Lot --> s{size} primitiveCube() Box")
    assert np.allclose(forest.leaves.size, [expected])


def test_centering_uses_the_shape_that_the_sequence_began_with():
    forest = sampled("Lot --> s('0.5, '1, '0.5) center(xz) A [ s('0.5, '1, '0.5) center(x) B ]")
    assert np.allclose(forest.leaves.position, [[7.5, 0, 5], [11.25, 0, 5]])


def test_materials_come_from_where_the_shape_was():
    forest = sampled('Lot --> color("#ff0000") A color(0, 1, 0, 0.5) B set(material.roughness, 0.25) C')
    materials = forest.materials
    assert np.allclose(materials.color[forest.leaves.material], [[1, 0, 0], [0, 1, 0], [0, 1, 0]])
    assert np.allclose(materials.opacity[forest.leaves.material], [1.0, 0.5, 0.5])
    assert np.allclose(materials.roughness[forest.leaves.material], [0.8, 0.8, 0.25])


def test_set_attributes_hold_below_and_not_beside():
    text = "attr h = 1\nLot --> [ set(h, 5) A ] B\nA --> s('1, h, '1) C\nB --> s('1, h, '1) D"
    forest = sampled(text)
    assert dict(zip(symbols(forest), forest.leaves.size[:, 1], strict=True)) == {"C": 5.0, "D": 1.0}


HOLED = "POLYGON ((0 0, 10 0, 10 10, 0 10, 0 0), (2 2, 2 5, 4 5, 4 2, 2 2), (6 6, 8 6, 7 8, 6 6))"
"""A lot of 100 square metres with a court of 6 and a triangular one of 2."""


@pytest.mark.parametrize(
    ("rule", "faces"), [("extrude(3) A", 13), ("extrude(-3) A", 13), ("roofHip(30) A", 12), ("roofPyramid(30) A", 5)]
)
def test_a_solid_over_a_lot_with_courts_is_closed_and_has_no_wall_on_the_bridge(rule, faces):
    """A pyramid covers the courts, as the other runtime measured it."""
    (lot,) = read_footprints(HOLED)
    forest = sampled(f"Lot --> {rule}", lot.polygon)
    meshes = world_meshes(forest)
    assert measure.is_closed(joined(meshes)).all()
    assert meshes.num_faces == faces
    assert areas_by_symbol(sampled("Lot --> case geometry.nHoles == 2 : A else : B", lot.polygon)) == {
        "A": pytest.approx(92.0)
    }
    if rule.startswith("extrude"):
        assert volumes_by_symbol(forest)["A"] == pytest.approx(3 * 92.0)


def test_a_cut_above_the_eaves_closes_a_roof_whose_slopes_reach_beyond_them():
    """Slopes and gables are sheets: the lines of the cut go around, though their ends belong to different sheets."""
    angle = np.radians(50.0)
    for roof in ("roofGable(50, 1, 0)", "roofGable(50)", "roofHip(50, 1)", "roofHip(50)"):
        forest = sampled(f"Lot --> {roof} split(y) {{ ~1 : comp(f) {{ world.up : Flat }} | ~1 : NIL }}", (12.0, 8.0))
        eaves = -np.sin(angle) if ", 1" in roof else 0.0
        inset = (4.0 * np.tan(angle) + eaves) / 2.0 / np.tan(angle)
        expected = (8.0 - 2 * inset) * (12.0 - 2 * inset * roof.startswith("roofHip"))
        assert areas_by_symbol(forest)["Flat"] == pytest.approx(expected)
    # Beyond the gables the lines have ends.
    open_roof = "Lot --> roofGable(50, 1, 1) split(y) { ~1 : comp(f) { world.up : Flat } | ~1 : NIL }"
    assert "Flat" not in areas_by_symbol(sampled(open_roof, (12.0, 8.0)))


@pytest.mark.parametrize("block", ["setback(2)", "extrude(2) comp(f)"])
def test_where_nothing_is_known_of_streets_the_older_selectors_pick_nothing(block):
    rest = "remainder" if block.startswith("setback") else "all"

    def areas(selector: str) -> list[float]:
        forest = sampled(f"Lot --> {block} {{ {selector} : A | {rest} : NIL }}", footprint=(10.0, 8.0))
        return measure.areas(world_meshes(forest)).tolist()

    assert areas("streetSide") == areas("noStreetSide") == []
    assert areas("object.side") != []


@pytest.mark.parametrize(
    ("written", "share"),
    [("'-0.25", -0.25), ("-'0.25", -0.25), ("+'0.25", 0.25), ("-('0.25)", -0.25), ("- -'0.25", 0.25)],
)
def test_the_sign_of_a_relative_length_may_stand_before_or_after_its_mark(written, share):
    leaves = sampled(f"Lot --> t({written}, 0, 0) A").leaves
    assert np.array_equal(leaves.position[:, 0], share * leaves.size[:, 0])


def test_a_roof_is_even_where_its_shape_says_so():
    text = 'Lot --> R({})  R(e) --> roofHip(30, 1, e) report("a", geometry.area) X'
    skew = np.array([[0.0, 0, 18], [28, 0, 20], [30, 0, 1], [2, 0, 0]])
    uneven, even = (sampled(text.format(flag), skew).reports.value[0] for flag in ("false", "true"))
    mixed = derive(Grammar.parse(text.format("p(0.5)")), 12, 5, footprint=skew)
    flags = mixed.draws.value[np.argsort(mixed.draws.node)] == 1.0
    assert 0 < flags.sum() < 12
    model = mixed.nodes.model[mixed.reports.node]
    assert np.allclose(mixed.reports.value[np.argsort(model)], np.where(flags, even, uneven))
    assert uneven != even
