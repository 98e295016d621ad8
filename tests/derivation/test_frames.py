"""Orientations: the group of the cube, and frames that say where their axes point."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from grammarlab.derivation.frames import COMPOSE, CUBE, FrameTable, cube_index, cube_indices, euler, euler_angles

cubes = st.integers(0, 23)


def test_the_first_rotation_of_the_cube_is_none():
    assert np.array_equal(CUBE[0], np.eye(3))


def test_the_table_of_products_is_that_of_the_matrices():
    assert np.array_equal(CUBE[COMPOSE], np.einsum("aij,bjk->abik", CUBE, CUBE))


@given(cubes)
def test_every_rotation_of_the_cube_is_found_again(index):
    assert cube_index(CUBE[index]) == index
    assert cube_indices(CUBE[[index]])[0] == index


def test_a_skew_rotation_is_no_rotation_of_the_cube():
    assert cube_indices(Rotation.from_euler("y", 1e-6).as_matrix()[None])[0] == -1


@given(st.integers(0, 1000), cubes, cubes)
def test_turning_a_frame_multiplies_its_rotation(seed, first, second):
    table = FrameTable()
    base = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    frame = table.turned(table.turned(table.add(base[None]), first), second)
    assert np.allclose(table.rotations(frame)[0], base @ CUBE[first] @ CUBE[second])
    for axis in range(3):
        assert np.array_equal(table.axis(frame, axis)[0], table.rotations(frame)[0, :, axis])


def test_listed_directions_are_those_of_the_rotations():
    rng = np.random.default_rng(0)
    table = FrameTable()
    for num_bases in (3, 2, 2_800):  # the last ones are too many to list
        end = int(table.add(Rotation.random(num_bases, rng=rng).as_matrix())[-1]) + 24
        frames = rng.integers(0, end, 500).astype(np.int32)
        rotations = table.rotations(frames)
        for axis in range(3):
            assert np.array_equal(table.axis(frames, axis), rotations[:, :, axis])


@given(st.integers(0, 1000), cubes)
def test_vectors_go_to_the_world_and_back(seed, cube):
    rng = np.random.default_rng(seed)
    table = FrameTable()
    frames = table.turned(table.add(Rotation.random(5, rng=rng).as_matrix()), cube)
    vectors = rng.normal(size=(5, 3))
    assert np.allclose(table.to_local(frames, table.to_world(frames, vectors)), vectors)


def test_one_rotation_makes_one_base_for_each_different_frame():
    table = FrameTable()
    turn = Rotation.from_euler("z", 30, degrees=True).as_matrix()
    frames = table.rotated(np.array([0, 5, 0, 5], dtype=np.int32), turn)
    assert len(np.unique(frames)) == 2
    assert np.allclose(table.rotations(frames), CUBE[[0, 5, 0, 5]] @ turn)


@pytest.mark.parametrize("stacked", [False, True])
def test_a_thousand_turns_about_other_axes_are_one_turn_by_their_sum(stacked):
    """A third of the frames is turned about its own axes, as it becomes, the others about those of a fixed frame."""
    table = FrameTable()
    start = table.add(Rotation.random(2, rng=np.random.default_rng(3)).as_matrix())
    axes, first = start[[0, 0]], np.array([0, start[1]], dtype=np.int32)
    frames, itself = first, start[:1]
    turn = euler(0.0, 1.0, 0.0)
    for _ in range(1000):
        frames, itself = np.split(
            table.rotated_about(
                np.append(frames, itself), np.append(axes, itself), turn[None].repeat(3, axis=0) if stacked else turn
            ),
            [2],
        )
    about = table.rotations(axes)
    whole = euler(0.0, 1000.0, 0.0)
    turned = table.rotations(frames)
    np.testing.assert_allclose(turned, about @ whole @ about.mT @ table.rotations(first), atol=1e-12)
    np.testing.assert_allclose(turned @ turned.mT, np.eye(3)[None].repeat(2, axis=0), atol=1e-12)
    np.testing.assert_allclose(table.rotations(itself), table.rotations(start[:1]) @ whole, atol=1e-12)


def test_right_angles_about_other_axes_add_no_frames():
    table = FrameTable()
    (base,) = table.add(Rotation.random(1, rng=np.random.default_rng(3)).as_matrix())
    frames, axes = base + np.arange(24, dtype=np.int32), np.full(24, base + 7, dtype=np.int32)
    for x, y, z in ((90, 0, 0), (0, -90, 0), (0, 180, 90)):
        turned = table.rotated_about(frames, axes, euler(x, y, z))
        assert set(turned) == set(frames)
        about = table.rotations(axes)
        np.testing.assert_allclose(
            table.rotations(turned), about @ euler(x, y, z) @ about.mT @ table.rotations(frames), atol=1e-12
        )


def test_used_frames_are_renumbered_without_gaps():
    table = FrameTable()
    table.add(Rotation.random(3, rng=np.random.default_rng(1)).as_matrix())
    frames = np.array([48, 0, 48, 30], dtype=np.int32)
    rotations, places = table.used(frames)
    assert len(rotations) == 3
    assert np.array_equal(rotations[places], table.rotations(frames))


@pytest.mark.parametrize("y", [90.0, -90.0])
@pytest.mark.parametrize(("x", "z"), [(0.0, 0.0), (30.0, 0.0), (30.0, 50.0), (-170.0, 20.0)])
def test_where_two_axes_fall_together_the_last_angle_is_zero(x: float, y: float, z: float):
    noisy = euler(x, y, z) + 1e-15 * np.random.default_rng(1).standard_normal((8, 3, 3))
    angles = euler_angles(noisy)
    assert np.allclose(euler(*angles.T), euler(x, y, z), atol=1e-12)
    assert np.allclose(angles, angles[0], atol=1e-9)
    assert (angles[:, 2] == 0).all()
