"""Models far from the origin of the world: rules see the world, shapes are counted from nearby."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.derivation import derive
from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.forest import Forest
from grammarlab.derivation.lots import NEAR, Lots, brought_near, origins_of, shared_origin
from grammarlab.derivation.selection import join_forests, select_models
from grammarlab.language.grammar import Grammar
from grammarlab.scene import realize, triangles
from grammarlab.scene.instances import scene_of_model

PLACE = np.array([2683000.13, 0.0, -1247000.37])
LOT = np.array([[0.0, 0, 12], [20, 0, 12], [20, 0, 0], [0, 0, 0]])
STEP = np.spacing(PLACE[0])
"""Metres: how exact a number in the world is at that place."""


def forest_of(text: str, place: np.ndarray = PLACE, num: int = 1) -> Forest:
    return derive(Grammar.parse(text), num, 3, footprint=LOT + place)


def reported(text: str, place: np.ndarray = PLACE) -> dict[str, float]:
    reports = forest_of(text, place).reports
    return {reports.keys[key]: value for key, value in zip(reports.key.tolist(), reports.value.tolist(), strict=True)}


def world_positions(forest: Forest) -> np.ndarray:
    return forest.leaves.position + forest.origins[forest.nodes.model[forest.leaves.node]]


def test_rules_read_where_their_lot_is_in_the_world():
    text = """
    Lot --> t(1, 2, 3) report("x", initialShape.origin.px) report("z", initialShape.origin.pz)
            report("up", scope.elevation) report("to", convert(x, scope, world, pos, 0, 0, 0))
            report("from", convert(z, world, scope, pos, 0, 0, 0)) A
    """
    found = reported(text)
    assert found["x"] == pytest.approx(PLACE[0], abs=2 * STEP)
    assert found["z"] == pytest.approx(PLACE[2] + 12, abs=2 * STEP) or found["z"] == pytest.approx(
        PLACE[2], abs=2 * STEP
    )
    assert found["up"] == 2.0
    assert found["to"] == pytest.approx(PLACE[0] + 1, abs=2 * STEP)
    near = reported(text, np.zeros(3))
    assert found["from"] - near["from"] == pytest.approx(-PLACE[2], abs=2 * STEP)


def test_rules_move_shapes_to_places_in_the_world():
    forest = forest_of("Lot --> translate(abs, world, 2683004, 7, -1247001) A")
    assert np.abs(world_positions(forest) - [2683004, 7, -1247001]).max() < 2 * STEP
    assert np.abs(forest.leaves.position).max() < 100


def test_images_are_projected_from_the_origin_of_the_world():
    forest = forest_of('Lot --> texture("a.png") setupProjection(0, world.xz, 4, 8) projectUV(0) A')
    (rows,) = forest.texture_maps
    u, v = rows @ [1.0, 0.0, 2.0, 1.0]
    there = PLACE + np.array([1.0, 0.0, 2.0])
    assert (u, v) == pytest.approx((there[0] / 4, there[2] / 8), abs=4 * STEP)


def test_what_rules_move_far_away_has_an_origin_there():
    """One model goes east by a million metres, one up, one stays: each by itself."""
    text = """
    Lot --> 33%: translate(rel, world, 1000000.3, 0, 0) Body else: Other
    Other --> 50%: translate(rel, world, 0, 4800.7, 0) Body else: Body
    Body --> extrude(3) split(x) { ~1 : texture("a.png") setupProjection(0, scope.xy, 4, 8) projectUV(0) A }*
    """
    forest = derive(Grammar.parse(text), 12, 3, footprint=LOT)
    assert not forest.origins.any()
    scene = realize(forest)
    assert len(np.unique(scene.origins, axis=0)) == 3
    assert np.abs(scene.position).max() < 100
    order = np.argsort(forest.nodes.model[forest.leaves.node], kind="stable")
    whole = np.sort(world_positions(forest)[order], axis=0)
    np.testing.assert_allclose(np.sort(scene.position + scene.origins[scene.model], axis=0), whole, rtol=0, atol=1e-9)
    home = realize(derive(Grammar.parse(text.replace("1000000.3", "0").replace("4800.7", "0")), 12, 3, footprint=LOT))
    moved, stayed = triangles(scene), triangles(home)
    for model in range(12):
        low = home.position[home.model == model].min(axis=0) if scene.origins[model].any() else np.zeros(3)
        np.testing.assert_allclose(moved.model(model).vertices + low, stayed.model(model).vertices, atol=2e-6)
        own, other = scene_of_model(scene, model), scene_of_model(home, model)
        np.testing.assert_allclose(
            np.einsum("nai,ni->na", own.texture_maps[own.texture_map][:, :, :3], own.position)
            + own.texture_maps[own.texture_map][:, :, 3],
            np.einsum("nai,ni->na", other.texture_maps[other.texture_map][:, :, :3], other.position)
            + other.texture_maps[other.texture_map][:, :, 3],
            atol=1e-6,
        )


def test_origins_go_with_their_models():
    far, near = forest_of("Lot --> A", num=3), forest_of("Lot --> A", np.zeros(3))
    joined = join_forests([near, far])
    assert joined.origins.tolist() == [[0.0] * 3] + 3 * [far.origins[0].tolist()]
    assert select_models(joined, np.array([0, 2])).origins.tolist() == joined.origins[[0, 2]].tolist()


def test_far_and_near_lots_share_a_batch():
    """Each is where it would be alone, to the last bit."""
    text = 'Lot --> extrude(rand(3, 9)) comp(f) { side : report("x", initialShape.origin.px + scope.elevation) A }'
    program = compile_grammar(Grammar.parse(text))
    lots = Lots.concatenate([Lots.of(2, 3, footprint=LOT + place) for place in (PLACE, 0 * PLACE, -PLACE)])
    lots = lots.take(np.array([4, 0, 3, 1, 2, 5]))
    forest = derive(program, lots)
    assert forest.origins.any(axis=1).tolist() == [True, True, False, True, False, True]
    for model in range(len(lots)):
        mine, alone = select_models(forest, np.array([model])), derive(program, lots.take(np.array([model])))
        assert mine.origins.tolist() == alone.origins.tolist()
        assert mine.leaves.position.tolist() == alone.leaves.position.tolist()
        assert mine.leaves.size.tolist() == alone.leaves.size.tolist()
        assert mine.reports.value.tolist() == alone.reports.value.tolist()


places = st.tuples(*[st.floats(-2e7, 2e7, allow_subnormal=False)] * 3)


@given(st.lists(st.tuples(places, st.integers(0, 10**6), st.integers(0, 10**6)), min_size=1, max_size=4))
def test_corners_come_near_as_they_are_on_paper(lots):
    """A corner in whole hundredths of a millimetre from the lowest one is there to the last bit, or has not moved."""
    sizes = [np.array([[0, 0, 0], [w, 0, 0], [w, 0, d]]) * 1e-5 for _, w, d in lots]
    points = [np.round(size, 5) + np.array(place) for size, (place, *_) in zip(sizes, lots, strict=True)]
    origins, near = brought_near(np.concatenate(points), np.arange(0, 3 * len(lots) + 1, 3))
    for index, (corners, size) in enumerate(zip(points, sizes, strict=True)):
        alone = brought_near(corners, np.array([0, 3]))
        assert alone[0][0].tolist() == origins[index].tolist()
        assert alone[1].tolist() == near[3 * index : 3 * index + 3].tolist()
        if origins[index].any():
            assert origins[index].tolist() == corners.min(axis=0).tolist()
            np.testing.assert_array_equal(alone[1], np.round(size, 5))
        else:
            assert alone[1].tolist() == corners.tolist()


@given(places, st.tuples(*[st.floats(0, 1e4)] * 3))
def test_things_are_far_when_all_of_them_is(low, size):
    low, high = np.array([low]), np.array([low]) + np.array([size])
    is_near = bool(((low <= NEAR) & (high >= -NEAR)).all())
    assert origins_of(low, high).tolist() == ([[0.0] * 3] if is_near else low.tolist())


@given(st.lists(st.tuples(places, st.tuples(*[st.floats(0, 1e4)] * 3)), min_size=1, max_size=5))
def test_a_shared_origin_is_near_far_things_and_on_a_grid(boxes):
    low = np.array([place for place, _ in boxes])
    high = low + np.array([size for _, size in boxes])
    origin = shared_origin(low, high)
    if not origins_of(low, high).any():
        assert origin is None
        return
    assert origin is not None
    assert not (origin % 1000).any()
    extent = (high.max(axis=0) - low.min(axis=0)).max()
    assert np.abs(np.concatenate([low, high]) - origin).max() <= extent + NEAR
    if len(boxes) > 1:
        np.testing.assert_array_equal(shared_origin(low[::-1], high[::-1]), origin)
