"""Merged triangles against brute force, on scenes built by hand and at random."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from grammarlab.arrays import offsets_from_counts
from grammarlab.errors import DerivationError
from grammarlab.scene import Scene, TriangleBatch, placement, triangles
from grammarlab.scene.instances import require_proper, scene_of_model
from grammarlab.scene.shading import shaded_meshes
from grammarlab.scene.triangles import count_triangles
from tests.scene import brute_force
from tests.scene.buildings import BOX, UPRIGHT, house, scene_of, street


def random_scene(seed: int, num_models: int, num_instances: int, thin: bool = False) -> Scene:
    """Shapes of any size and direction, models and materials in any order within their models."""
    rng = np.random.default_rng(seed)
    size = 10.0 ** rng.uniform(-1, 1, (num_instances, 3))
    if thin:
        size[rng.random(size.shape) < 0.2] = 0.0
    return replace(
        scene_of([[] for _ in range(num_models)]),
        model=np.sort(rng.integers(0, num_models, num_instances)).astype(np.int32),
        mesh=rng.integers(0, 5, num_instances).astype(np.int32),
        material=rng.integers(0, 6, num_instances).astype(np.int32),
        position=rng.normal(0, 10, (num_instances, 3)),
        size=size,
        frame=rng.integers(0, 12, num_instances).astype(np.int32),
        frames=Rotation.random(12, rng=rng).as_matrix(),
        texture_map=rng.integers(-1, 3, num_instances).astype(np.int32),
        texture_maps=rng.normal(0, 1, (3, 2, 4)),
    )


def area_vectors(batch: TriangleBatch) -> np.ndarray:
    a, b, c = (batch.vertices[batch.triangles[:, i]].astype(float) for i in range(3))
    return 0.5 * np.cross(b - a, c - a)


def group_areas(batch: TriangleBatch) -> dict[tuple[int, int], float]:
    area = np.linalg.norm(area_vectors(batch), axis=1)
    keys = zip(batch.group_model.tolist(), batch.group_material.tolist(), strict=True)
    ends = batch.group_triangles
    return {key: float(area[ends[g] : ends[g + 1]].sum()) for g, key in enumerate(keys)}


recipes = st.tuples(st.integers(0, 2**32), st.integers(1, 4), st.integers(1, 60), st.booleans())
"""Arguments of `random_scene`: short to print, unlike scenes."""
few = settings(max_examples=25)


@few
@given(recipes)
def test_each_material_of_each_model_has_the_area_of_its_shapes(recipe):
    scene = random_scene(*recipe)
    scene = replace(scene, mesh=scene.mesh % 4)  # the sphere has too many faces for brute force
    found, expected = group_areas(triangles(scene)), brute_force.areas(scene)
    assert list(found) == sorted(expected)
    for key, area in expected.items():
        assert found[key] == pytest.approx(area, rel=1e-3, abs=1e-3)


@few
@given(recipes)
def test_rows_are_ordered_by_model_then_material_and_cover_everything(recipe):
    scene = random_scene(*recipe)
    batch = triangles(scene)
    groups = list(zip(batch.group_model.tolist(), batch.group_material.tolist(), strict=True))
    assert groups == sorted(set(groups))
    for ends, column in ((batch.group_vertices, batch.vertices), (batch.group_triangles, batch.triangles)):
        assert (ends[0], ends[-1]) == (0, len(column))
        assert (np.diff(ends) > 0).all()
    first = np.repeat(batch.group_vertices[:-1], np.diff(batch.group_triangles))[:, None]
    last = np.repeat(batch.group_vertices[1:], np.diff(batch.group_triangles))[:, None]
    assert ((batch.triangles >= first) & (batch.triangles < last)).all()
    counts = [len(batch.model(index).triangles) for index in range(scene.num_models)]
    assert batch.triangles_per_model().tolist() == count_triangles(scene).tolist() == counts


@few
@given(recipes)
def test_a_slice_of_one_model_is_that_model_merged_alone(recipe):
    scene = random_scene(*recipe)
    batch = triangles(scene)
    for index in range(scene.num_models):
        part, alone = batch.model(index), triangles(scene_of_model(scene, index))
        assert np.array_equal(part.triangles, alone.triangles)
        assert np.array_equal(part.group_material, alone.group_material)
        assert np.array_equal(part.group_vertices, alone.group_vertices)
        assert np.array_equal(part.texture_map, alone.texture_map)
        assert part.vertices.tobytes() == alone.vertices.tobytes()
        assert part.normals.tobytes() == alone.normals.tobytes()


@few
@given(recipes)
def test_normals_are_unit_vectors_also_of_shapes_without_thickness(recipe):
    scene = random_scene(*recipe)
    assert np.allclose(np.linalg.norm(triangles(scene).normals, axis=1), 1.0, atol=1e-5)


@few
@given(recipes)
def test_flat_shading_normals_are_those_of_the_winding(recipe):
    scene = random_scene(*recipe)
    batch = triangles(scene, crease_angle=0.0)
    vectors = area_vectors(batch)
    length = np.linalg.norm(vectors, axis=1)
    clear = length > 1e-2
    for corner in range(3):
        normals = batch.normals[batch.triangles[:, corner]]
        turn = np.einsum("ij,ij->i", vectors, normals)[clear] / length[clear]
        assert (turn > 0.99).all()


@pytest.mark.parametrize("crease_angle", [0.0, 0.5])
@few
@given(recipe=recipes)
def test_placing_mesh_by_mesh_equals_placing_by_gather_to_the_last_bit(crease_angle, recipe):
    scene = random_scene(*recipe)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(placement, "MANY_INSTANCES", 1)
        patch.setattr(placement, "BLOCK_VALUES", 500)
        columns = triangles(scene, crease_angle)
        patch.setattr(placement, "MOST_TEMPLATES", 0)
        gather = triangles(scene, crease_angle)
        patch.setattr(placement, "REST_VERTICES", 20)
        blocks = triangles(scene, crease_angle)
    for name in ("triangles", "vertices", "normals"):
        assert getattr(columns, name).tobytes() == getattr(gather, name).tobytes() == getattr(blocks, name).tobytes()


@few
@given(recipes, st.integers(0, 5))
def test_values_of_vertices_are_those_of_the_mesh_for_every_instance(recipe, num_templates):
    scene = random_scene(*recipe)
    shaded = shaded_meshes(scene, np.arange(len(scene.meshes)), 0.5)
    values = np.random.default_rng(recipe[0]).normal(0, 1, (len(shaded.points), 2))
    values[::3] = np.nan
    mesh = scene.mesh.astype(np.int64)
    offsets = offsets_from_counts(np.diff(shaded.mesh_vertices)[mesh])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(placement, "MANY_INSTANCES", 1)
        patch.setattr(placement, "MOST_TEMPLATES", num_templates)
        patch.setattr(placement, "REST_VERTICES", 20)
        repeated = placement.repeated_values(values, shaded, mesh, offsets)
    rows = [np.zeros(0, int), *(np.arange(*shaded.mesh_vertices[index : index + 2]) for index in mesh)]
    assert repeated.tobytes() == values[np.concatenate(rows)].astype(np.float32).tobytes()


def test_solids_keep_their_volume_so_nothing_is_inside_out():
    scene = scene_of([[(mesh, 0, (3, 2, 1), (2, 3, 4), UPRIGHT)] for mesh in (0, 2, 3, 4)])
    batch = triangles(scene)
    for index, share in enumerate((1.0, 16 * np.sin(np.pi / 16) / 4, 0.5, np.pi / 6)):
        part = batch.model(index)
        a, b, c = (part.vertices[part.triangles[:, i]].astype(float) for i in range(3))
        volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
        assert volume == pytest.approx(24 * share, rel=2e-2)


def test_bounds_are_those_of_the_placed_points():
    scene = street()
    batch = triangles(scene)
    for index in range(3):
        vertices = batch.model(index).vertices
        found = [vertices.min(axis=0), vertices.max(axis=0)]
        assert np.allclose(found, brute_force.bounds(scene, index), atol=1e-5)


def test_round_walls_are_smooth_and_boxes_are_flat():
    scene = scene_of([[(BOX, 0, (0, 0, 0), (1, 2, 3), UPRIGHT)], [(4, 0, (0, 0, 0), (2, 2, 2), UPRIGHT)]])
    batch = triangles(scene)
    assert len(batch.model(0).vertices) == 24
    ball = batch.model(1)
    assert len(ball.vertices) == 15 * 32 + 2
    assert np.einsum("ij,ij->i", ball.normals, ball.vertices - 1.0).min() > 0.99


def test_a_very_thin_pole_keeps_the_normals_of_its_ends():
    batch = triangles(scene_of([[(2, 0, (0, 0, 0), (1e-4, 1e3, 1e-4), UPRIGHT)]]))
    up = np.abs(batch.normals[:, 1]) > 0.5
    assert up.sum() == 64
    assert np.allclose(np.sign(batch.normals[up, 1]), np.where(batch.vertices[up, 1] > 500, 1, -1))


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e12])
@pytest.mark.parametrize(("column", "name"), [("position", "position"), ("size", "size"), ("frames", "rotation")])
def test_numbers_that_are_not_metres_are_refused_with_their_model(column, name, value):
    scene = scene_of([house(), house()])
    values = getattr(scene, column).copy()
    values[-1].flat[0] = value
    with pytest.raises(DerivationError, match=rf"model 1 .*{name}"):
        triangles(replace(scene, **{column: values}))


def test_a_mesh_with_a_point_that_is_no_number_is_refused():
    scene = scene_of([house()])
    points = scene.meshes.points.copy()
    points[3, 1] = np.nan
    with pytest.raises(DerivationError, match="finite"):
        triangles(replace(scene, meshes=scene.meshes.with_points(points)))


def test_a_material_with_a_colour_that_is_no_number_is_refused():
    scene = scene_of([house()])
    channels = scene.materials.channels.copy()
    channels[2, 0] = np.nan
    with pytest.raises(DerivationError, match="material"):
        triangles(replace(scene, materials=replace(scene.materials, channels=channels)))


def test_a_negative_size_is_refused():
    scene = scene_of([house()])
    with pytest.raises(DerivationError, match="negative size"):
        triangles(replace(scene, size=-scene.size))


@pytest.mark.parametrize("axes", [np.diag([1.0, 1.0, -1.0]), np.diag([2.0, 0.5, 1.0]), np.zeros((3, 3))])
def test_axes_that_are_no_rotation_are_refused(axes):
    with pytest.raises(DerivationError, match=r"model 0 .*rotation"):
        require_proper(scene_of([[(BOX, 0, (0, 0, 0), (1, 1, 1), axes)]]))


def test_a_scene_of_nothing_has_no_triangles():
    batch = triangles(scene_of([[], []]))
    assert batch.triangles.shape == batch.vertices.shape == (0, 3)
    assert batch.triangles_per_model().tolist() == count_triangles(scene_of([[], []])).tolist() == [0, 0]
    assert len(batch.model(1).triangles) == 0


def test_the_model_of_a_batch_must_exist():
    with pytest.raises(IndexError, match="model 3 of a batch of 3"):
        triangles(street()).model(3)


@few
@given(recipes, st.data())
def test_chosen_groups_keep_their_triangles(recipe, data):
    scene = random_scene(*recipe)
    batch = triangles(scene)
    groups = np.array(sorted(data.draw(st.sets(st.integers(0, len(batch.group_model) - 1)))), dtype=np.int64)
    part = batch.of_groups(groups)
    everything, areas = group_areas(batch), group_areas(part)
    keys = list(everything)
    assert list(areas) == [keys[group] for group in groups]
    assert all(areas[key] == everything[key] for key in areas)
    assert part.model_groups[-1] == len(groups)
    spans = [slice(*batch.group_triangles[group : group + 2]) for group in groups]
    np.testing.assert_array_equal(
        part.texture_map, np.concatenate([batch.texture_map[:0], *(batch.texture_map[span] for span in spans)])
    )
