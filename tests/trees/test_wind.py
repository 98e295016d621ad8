"""Trees in the wind."""

from __future__ import annotations

import numpy as np

from grammarlab.trees.growth import grow
from grammarlab.trees.skeleton import Skeleton
from tests.trees.rows import ASPEN, row, tree_keys


def windy(speed: float, direction: float = 0.0) -> Skeleton:
    return grow(row(**ASPEN | {"wind_speed": speed, "wind_direction": direction})[None], tree_keys(1))


def test_wind_changes_the_pose_only():
    calm, storm = windy(0.0), windy(25.0)
    for before, after in zip(calm.levels, storm.levels, strict=True):
        for name in ("length", "radius", "offset", "key", "along"):
            np.testing.assert_array_equal(getattr(after, name), getattr(before, name))
        assert not np.array_equal(after.points, before.points)
        steps = [np.linalg.norm(np.diff(stems.points, axis=0), axis=1) for stems in (before, after)]
        inner = np.setdiff1d(np.arange(len(before.points) - 1), before.node_offsets[1:] - 1)
        np.testing.assert_allclose(steps[1][inner], steps[0][inner])


def test_a_crown_leans_further_to_the_lee_in_more_wind():
    leans = [windy(speed).leaves.position[:, 0].mean() for speed in (0.0, 5.0, 10.0, 20.0, 40.0)]
    assert (np.diff(leans) > 0.0).all()


def test_the_direction_of_the_wind_is_about_the_vertical_from_x():
    shifts = []
    for direction in (0.0, 90.0, 180.0, 270.0):
        shift = (windy(20.0, direction).leaves.position - windy(0.0).leaves.position).mean(axis=0)
        shifts.append(np.degrees(np.arctan2(-shift[2], shift[0])) % 360.0)
    np.testing.assert_allclose((np.array(shifts) - [0, 90, 180, 270] + 180.0) % 360.0, 180.0, atol=12.0)


def test_no_wind_bends_a_stem_beyond_its_direction():
    storm = windy(60.0)
    twigs = storm.levels[2].frames[:, :, 2]
    assert (twigs[:, 0] > -0.2).mean() > 0.95
    trunk = storm.levels[0]
    assert (np.diff(trunk.points[:, 0]) > -1e-9).all()


def test_the_tip_of_a_trunk_is_inclined_like_a_cantilever():
    """p L³ / (6 E I): 30 · .5 · 1.2 kg/m³ (20 m/s)² on 2 r, E = 8 GPa, length by radius 50: .0477 rad."""
    skeleton = grow(row(levels=1, ratio=0.02, curve_res_0=40, wind_speed=20.0)[None], tree_keys(1))
    slope = np.arcsin(skeleton.levels[0].frames[-1, 0, 2])
    load_by_diameter = 30.0 * 0.5 * 1.2 * 20.0**2
    expected = 2.0 * load_by_diameter * 50.0**3 / (6.0 * 8e9 * np.pi / 4.0)
    np.testing.assert_allclose(slope, expected, rtol=1e-3)
