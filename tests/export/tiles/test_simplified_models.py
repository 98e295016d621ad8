"""Simplified models keep boxes, courts and colours, whatever else is in the batch."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from grammarlab.assets.srgb import linear_from_srgb
from grammarlab.derivation.derive import derive
from grammarlab.export.tiles.facets import facets
from grammarlab.export.tiles.planes import planes, split_by_gaps
from grammarlab.export.tiles.simplified_models import simplified
from grammarlab.language.grammar import Grammar
from grammarlab.scene import Scene, realize, triangles
from grammarlab.scene.joined import of_models
from grammarlab.scene.layout import model_bounds
from grammarlab.scene.triangles import count_triangles
from tests.export.tiles.quarter import houses
from tests.scene.buildings import BOX, FRAME, GLASS, QUAD, SPHERE, STONE, TILE, TURNED, UPRIGHT, Row, scene_of

GRAMMARS = Path(__file__).parents[3] / "grammars"


def derived(name: str, num: int) -> Scene:
    grammar = Grammar.parse((GRAMMARS / f"{name}.cga").read_text(encoding="utf-8"))
    return realize(derive(grammar, num, seed=3, assets=GRAMMARS / "assets"))


@pytest.fixture(scope="module", params=["building", "skyscraper", "houses"])
def models(request) -> Scene:
    return houses(list(range(8))) if request.param == "houses" else derived(request.param, 12)


def test_budgets_and_boxes_are_kept(models):
    low, high = model_bounds(triangles(models))
    for most, scene in zip((300, 30), simplified(models, (300, 30)), strict=True):
        assert count_triangles(scene).max() <= most
        assert count_triangles(scene).min() > 0
        new_low, new_high = model_bounds(triangles(scene))
        tolerance = 0.02 * (high - low)
        assert (np.abs(new_low - low) <= tolerance).all()
        assert (np.abs(new_high - high) <= tolerance).all()


def test_a_model_is_the_same_alone_and_in_a_batch(models):
    together = simplified(models)
    for number in (0, 5):
        alone = simplified(of_models(models, np.array([number])))
        for scene, part in zip(together, alone, strict=True):
            batch, single = triangles(of_models(scene, np.array([number]))), triangles(part)
            np.testing.assert_array_equal(batch.vertices, single.vertices)
            np.testing.assert_array_equal(batch.triangles, single.triangles)
            color, other_color = (x.materials.color[x.material_of_triangle()] for x in (batch, single))
            np.testing.assert_array_equal(color, other_color)


def test_the_input_is_untouched(models):
    before = models.position.copy(), models.meshes.points.copy(), models.material.copy()
    simplified(models)
    for old, new in zip(before, (models.position, models.meshes.points, models.material), strict=True):
        np.testing.assert_array_equal(old, new)


def test_a_box_stays_a_box_of_its_colour():
    scene = scene_of([[(BOX, STONE, (1, 2, 3), (10, 20, 8), TURNED)]])
    for part in simplified(scene):
        batch = triangles(part)
        corners = batch.vertices[batch.triangles].astype(float)
        area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
        # The bottom is covered by the top.
        assert area.sum() == pytest.approx(2 * 20 * (10 + 8) + 10 * 8)
        np.testing.assert_allclose(part.materials.color, scene.materials.color[[STONE]], atol=0.01)


def test_a_wall_with_windows_has_their_mean_colour():
    rows: list[Row] = [(QUAD, STONE, (0, 0, 0), (20, 10, 0), UPRIGHT)]
    rows += [(QUAD, GLASS, (1 + 2 * column, 2, 0.04), (1, 2, 0), UPRIGHT) for column in range(9)]
    scene = scene_of([rows])
    plain = simplified(scene)[0]
    assert len(plain) == 1
    light = linear_from_srgb(scene.materials.color)
    mean = (200 * light[STONE] + 18 * light[GLASS]) / 218
    np.testing.assert_allclose(linear_from_srgb(plain.materials.color[0]), mean, atol=0.02)


def test_a_court_stays_open():
    """Four wings around a court of 10 by 10 metres: nothing covers its middle."""
    wings: list[Row] = [
        (BOX, STONE, (0, 0, 0), (30, 12, 10), UPRIGHT),
        (BOX, STONE, (0, 0, 20), (30, 12, 10), UPRIGHT),
        (BOX, STONE, (0, 0, 10), (10, 12, 10), UPRIGHT),
        (BOX, STONE, (20, 0, 10), (10, 12, 10), UPRIGHT),
    ]
    batch = triangles(simplified(scene_of([wings]))[0])
    corners = batch.vertices[batch.triangles][:, :, [0, 2]].astype(float) - 15.0
    (x, z), (next_x, next_z) = (np.moveaxis(ring, 2, 0) for ring in (corners, np.roll(corners, -1, axis=1)))
    turns = x * next_z - next_x * z
    is_around = (turns > 0).all(axis=1) | (turns < 0).all(axis=1)
    assert not (is_around & (np.abs(turns.sum(axis=1)) > 1.0)).any()


def test_floors_inside_are_left_out():
    rows: list[Row] = [(BOX, STONE, (0, 3 * floor, 0), (12, 3, 9), UPRIGHT) for floor in range(6)]
    batch = triangles(simplified(scene_of([rows]))[0])
    heights = batch.vertices[batch.triangles][:, :, 1]
    level = heights.max(axis=1) - heights.min(axis=1) < 1e-6
    np.testing.assert_allclose(heights[level], 18.0)


def test_round_shapes_become_hulls_inside_them():
    scene = scene_of([[(SPHERE, TILE, (0, 0, 0), (10, 10, 10), UPRIGHT)]])
    plain = simplified(scene)[0]
    assert np.linalg.norm(triangles(plain).vertices - 5.0, axis=1).max() < 5.01
    assert 20 < count_triangles(plain)[0] < 50


def test_models_without_shapes_stay_empty():
    scene = scene_of([[], [(BOX, FRAME, (0, 0, 0), (0.2, 0.2, 0.2), UPRIGHT)], []])
    for part in simplified(scene):
        assert part.num_models == 3
        assert count_triangles(part)[[0, 2]].tolist() == [0, 0]
    assert all(len(part) == 0 for part in simplified(scene_of([[]])))


def test_facets_are_the_large_faces_of_the_scene():
    scene = scene_of([[(BOX, STONE, (0, 0, 0), (10, 20, 8), TURNED), (QUAD, GLASS, (0, 0, 0), (0.2, 0.2, 0), UPRIGHT)]])
    faces = facets(scene)
    areas = np.sort(np.linalg.norm(faces.vector, axis=1))
    np.testing.assert_allclose(areas, [80, 80, 160, 160, 200, 200])
    np.testing.assert_allclose(faces.vector.sum(axis=0), 0.0, atol=1e-9)


def test_planes_hold_every_facet_once_and_lie_near_them():
    faces = facets(houses([0, 1, 2]))
    walls = planes(faces)
    assert len(walls.facets) == len(faces)
    assert walls.wall_facets[-1] == len(faces)
    np.testing.assert_allclose(np.sort(walls.area), np.sort(np.linalg.norm(faces.vector, axis=1)))
    identity = np.einsum("wij,wkj->wik", walls.axes, walls.axes)
    np.testing.assert_allclose(identity, np.broadcast_to(np.eye(3), identity.shape), atol=1e-9)
    wall = np.repeat(walls.wall_of_facet(), np.diff(walls.facets.offsets))
    distance = np.einsum("pi,pi->p", walls.facets.points, walls.axes[wall, 2]) - walls.depth[wall]
    assert np.abs(distance).max() < 1.6


def test_runs_of_intervals_are_those_of_a_loop():
    generator = np.random.default_rng(0)
    group = np.sort(generator.integers(0, 4, 60))
    low = generator.integers(0, 300, 60)
    high = low + generator.integers(0, 6, 60)
    number = split_by_gaps(group, low, high, 5)
    for one in range(60):
        for other in range(60):
            if group[one] != group[other]:
                assert number[one] != number[other]
                continue
            start, end = sorted((one, other), key=lambda row: low[row])
            inside = [row for row in range(60) if group[row] == group[start]]
            reach = high[start]
            while grown := max((high[row] for row in inside if low[row] <= reach + 5), default=reach):
                if grown == reach:
                    break
                reach = grown
            assert (number[start] == number[end]) == (low[end] <= reach + 5)
