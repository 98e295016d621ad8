"""Curves, helices, attraction, and forks by error diffusion."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.arrays import Floats
from grammarlab.trees.growth import grow
from grammarlab.trees.skeleton import Stems
from tests.trees.rows import row, tree_keys


def slopes(stems: Stems) -> Floats:
    """[N] degrees between the segments of trunks and the vertical."""
    return np.degrees(np.arccos(np.clip(stems.frames[:, 1, 2], -1.0, 1.0)))


def trunk(**named: float) -> Stems:
    return grow(row(levels=1, scale=8.0, **named)[None], tree_keys(1)).levels[0]


def test_each_segment_after_the_first_turns_by_its_share():
    np.testing.assert_allclose(slopes(trunk(curve_res_0=4, curve_0=80.0)), [0, 20, 40, 60, 60], atol=1e-6)


def test_the_upper_half_of_a_stem_curves_back():
    """The lower half turns by 2 · 60° / 6 per segment, the upper one by 2 · -90° / 6."""
    stem = trunk(curve_res_0=6, curve_0=60.0, curve_back_0=-90.0)
    # The fourth segment is the first of the upper half; the last one is inclined to the other side.
    np.testing.assert_allclose(slopes(stem), [0, 20, 40, 10, 20, 50, 50], atol=1e-6)
    assert np.sign(stem.frames[[2, 5], 2, 2]).tolist() == [1.0, -1.0]


def test_the_middle_segment_of_an_odd_number_is_in_the_lower_half():
    np.testing.assert_allclose(slopes(trunk(curve_res_0=3, curve_0=60.0, curve_back_0=-30.0)), [0, 40, 20, 20])


@pytest.mark.parametrize("spread", [30.0, 300.0])
def test_random_curves_stay_within_their_spread(spread: float):
    rows = np.stack([row(levels=1, curve_res_0=5, curve_0=20.0, curve_0_v=spread)] * 500)
    frames = grow(rows, tree_keys(500)).levels[0].frames.reshape(500, 6, 3, 3)
    turns = np.degrees(np.arctan2(frames[:, :, 2, 2], frames[:, :, 1, 2]))
    turns = (np.diff(turns[:, :5], axis=1) + 180.0) % 360.0 - 180.0
    assert np.abs(turns - 4.0).max() <= spread / 5 + 1e-9
    assert np.abs(turns - 4.0).max() > 0.98 * spread / 5
    assert abs(np.mean(turns - 4.0)) < 0.05 * spread / 5


def test_a_helix_is_inclined_against_its_axis_and_closes_a_round():
    stem = trunk(curve_res_0=8, curve_0_v=-25.0)
    np.testing.assert_allclose(slopes(stem), 25.0)
    np.testing.assert_allclose(stem.points[-1], [0.0, 8.0 * np.cos(np.radians(25.0)), 0.0], atol=1e-12)
    azimuths = np.unwrap(np.arctan2(stem.frames[:8, 0, 2], stem.frames[:8, 2, 2]))
    np.testing.assert_allclose(np.diff(azimuths), np.pi / 4)


def test_a_split_base_lies_evenly_about_and_turns_back():
    """Three more stems; a split of 40° is given back by the four segments after the next."""
    stems = trunk(curve_res_0=6, base_splits=3, split_angle_0=40.0)
    assert stems.first.tolist() == [0, 1, 1, 1]
    assert stems.source.tolist() == [-1, 0, 0, 0]
    starts = stems.node_offsets[:-1] + 1 - stems.first
    azimuths = np.degrees(np.arctan2(stems.frames[starts, 0, 2], stems.frames[starts, 2, 2]))
    np.testing.assert_allclose(np.sort(azimuths % 360.0 % 359.999999), [0.0, 90.0, 180.0, 270.0], atol=1e-6)
    for start in starts:
        np.testing.assert_allclose(slopes(stems)[start : start + 6], [40, 30, 20, 10, 0, 0], atol=1e-5)


def test_a_fork_opens_to_both_sides_and_a_clone_spreads_by_20_to_110_degrees():
    rows = np.stack([row(levels=1, curve_res_0=2, seg_splits_0=1.0, split_angle_0=30.0)] * 400)
    stems = grow(rows, tree_keys(400)).levels[0]
    assert len(stems) == 800
    clones = np.flatnonzero(stems.is_clone)
    trunks = stems.source[clones]
    directions = [stems.frames[stems.node_offsets[rows + 1] - 1, :, 2] for rows in (trunks, clones)]
    for direction in directions:
        np.testing.assert_allclose(direction[:, 1], np.cos(np.radians(30.0)))
    azimuths = [np.degrees(np.arctan2(direction[:, 0], direction[:, 2])) for direction in directions]
    np.testing.assert_allclose(np.abs(azimuths[0]), 180.0)
    spread = np.abs(azimuths[1])
    assert (spread.min() >= 20.0) & (spread.min() < 21.0)
    assert (spread.max() <= 110.0) & (spread.max() > 105.0)
    # 20 + 90 u², whose mean is 50.
    assert np.mean(spread) == pytest.approx(50.0, abs=4.0)
    assert np.mean(azimuths[1] > 0.0) == pytest.approx(0.5, abs=0.1)


def test_a_stem_that_declines_more_than_the_split_angle_forks_about_the_vertical_only():
    """Segments turn by 60°. The first fork is at an upright segment; at the second one, stems are at 30° and 90°."""
    stems = trunk(curve_res_0=3, curve_0=180.0, seg_splits_0=1.0, split_angle_0=30.0)
    assert stems.source.tolist() == [-1, 0, 0, 1]
    middle = stems.node_offsets[:2] + 1 - stems.first[:2]
    np.testing.assert_allclose(slopes(stems)[middle], [30.0, 90.0])
    # The first fork is given back by the last segment: 30° + 60° + 30° and 90° + 60° - 30°.
    np.testing.assert_allclose(slopes(stems)[stems.node_offsets[1:] - 1], 120.0)


def test_attraction_raises_branches_to_the_vertical_and_never_beyond():
    for attraction in (0.5, 3.0, 20.0):
        named = {"levels": 3, "branches_1": 8, "branches_2": 5, "curve_res_2": 12, "down_angle_2": 60.0}
        skeleton = grow(row(attraction_up=attraction, shape=3, **named)[None], tree_keys(1))
        twigs = skeleton.levels[2]
        slope = slopes(twigs).reshape(-1, 13)[:, :12]
        assert (np.diff(slope, axis=1) <= 1e-6).all()
        assert (slope[:, -1] < slope[:, 0]).all()


def test_negative_attraction_lowers_branches_to_the_vertical_and_never_beyond():
    named = {"levels": 3, "branches_1": 8, "branches_2": 5, "curve_res_2": 12, "down_angle_2": 60.0}
    skeleton = grow(row(attraction_up=-20.0, shape=3, **named)[None], tree_keys(1))
    slope = slopes(skeleton.levels[2]).reshape(-1, 13)[:, :12]
    assert (np.diff(slope, axis=1) >= -1e-5).all()


def test_attraction_leaves_the_trunk_and_its_branches_alone():
    named = {"levels": 2, "branches_1": 8, "curve_0": 40.0, "curve_res_1": 5}
    pulled, free = (grow(row(attraction_up=up, **named)[None], tree_keys(1)) for up in (5.0, 0.0))
    for level in range(2):
        np.testing.assert_array_equal(pulled.levels[level].points, free.levels[level].points)


@pytest.mark.parametrize("rate", [0.05, 0.3, 0.5, 1.0, 1.7])
def test_the_clones_of_a_level_are_the_rate_by_the_segments_that_may_split(rate: float):
    """floor(K s + ½) clones after K segments; a segment may split unless it is the last one of its stem."""
    named = {"levels": 2, "branches_1": 9, "curve_res_1": 4, "seg_splits_1": rate}
    stems = grow(row(**named)[None], tree_keys(1)).levels[1]
    segments = int((stems.num_nodes - 2).sum())
    assert int(stems.is_clone.sum()) == int(np.floor(segments * rate + 0.5))


def test_splits_worked_by_hand():
    """A rate of .5, five segments: they are visited in the order 0, 1 | 0, 1 | … and every second one splits.

    Visit 0 has floor(1) - floor(.5) = 1 clone, visit 1 none, and so on. Segment 0: the trunk splits (stem 1). Segment
    1: not the trunk, but stem 1 (stem 2). Segment 2: stems 0, 1, 2: not 0 (visit 3), but 1 (visit 4 gives stem 3), not
    2. Segment 3: stem 0 (visit 6 gives stem 4), not 1, stem 2 (stem 5), not 3.
    """
    stems = grow(row(levels=1, curve_res_0=5, seg_splits_0=0.5)[None], tree_keys(1)).levels[0]
    expected = []
    visit, alive = 0, [(-1, 0)]
    for segment in range(4):
        for stem in range(len(alive)):
            if visit % 2 == 0:
                expected.append((stem, segment + 1))
            visit += 1
        alive = [(-1, 0), *expected]
    assert list(zip(stems.source.tolist(), stems.first.tolist(), strict=True)) == [(-1, 0), *expected]


def test_splits_of_a_tree_do_not_depend_on_its_batch():
    rows = np.stack([row(levels=1, curve_res_0=5, seg_splits_0=rate) for rate in (0.3, 0.0, 0.7, 0.3)])
    stems = grow(rows, tree_keys(4)).levels[0]
    sizes = np.bincount(stems.tree)
    assert sizes[0] == sizes[3]
    assert sizes[1] == 1
    for tree in range(4):
        alone = grow(rows[[tree]], tree_keys(4)[[tree]]).levels[0]
        np.testing.assert_array_equal(alone.first, stems.first[stems.tree == tree])


def test_a_stem_of_one_segment_does_not_split():
    assert len(grow(row(levels=1, curve_res_0=1, seg_splits_0=4.0, base_splits=5)[None], tree_keys(1)).levels[0]) == 1
