"""Outlines of crowns, the envelope, and pruning."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.arrays import Flags
from grammarlab.trees.envelope import crown_ratio, envelope_ratio, is_inside
from grammarlab.trees.growth import grow
from grammarlab.trees.parameters import COLUMN
from grammarlab.trees.skeleton import Skeleton, Stems
from tests.cases import some
from tests.trees.rows import ASPEN, random_row, row, tree_keys

PRUNED = {"prune_width": 0.4, "prune_width_peak": 0.6, "prune_power_low": 0.6, "length_1": 0.4, "curve_0_v": 0.0}


@pytest.mark.parametrize(
    ("shape", "values"),
    [
        (0, [0.2, 0.6, 1.0]),
        (1, [0.2, 1.0, 0.2]),
        (2, [0.2, 0.2 + 0.8 * np.sqrt(0.5), 1.0]),
        (3, [1.0, 1.0, 1.0]),
        (4, [0.5, 0.75, 1.0]),
        (5, [0.0, 0.5 / 0.7, 0.0]),
        (6, [1.0, 0.6, 0.2]),
        (7, [0.5, 0.5 + 0.25 / 0.7, 0.5]),
        (8, [0.0, 1.0, 0.0]),
    ],
)
def test_outlines_at_the_top_in_the_middle_and_at_the_lowest_branch(shape: int, values: list[float]):
    rows, tree = row(shape=shape)[None], np.zeros(3, int)
    np.testing.assert_allclose(crown_ratio(rows, tree, np.array([0.0, 0.5, 1.0])), values, atol=1e-12)


def test_flames_are_widest_at_seven_tenths():
    tree = np.zeros(1, int)
    for shape in (5, 7):
        np.testing.assert_allclose(crown_ratio(row(shape=shape)[None], tree, np.array([0.7])), [1.0])


@pytest.mark.parametrize("peak", [0.0, 0.3, 0.5, 1.0])
@pytest.mark.parametrize("power", [0.3, 1.0, 4.0])
def test_the_envelope_is_1_at_its_peak_falls_to_both_sides_and_is_continuous(peak: float, power: float):
    rows = row(prune_width_peak=peak, prune_power_low=power, prune_power_high=power)[None]
    share = np.linspace(0.0, 1.0, 100_001)
    ratio = envelope_ratio(rows, np.zeros(len(share), int), share)
    assert ratio.max() == pytest.approx(1.0, abs=1e-9)
    assert share[np.argmax(ratio)] == pytest.approx(1.0 - peak, abs=1e-4)
    rise, fall = np.diff(ratio[share <= 1.0 - peak + 1e-9]), np.diff(ratio[share >= 1.0 - peak - 1e-9])
    assert (rise >= 0).all()
    assert (fall <= 0).all()
    inner = (share[1:] > 0.01) & (share[1:] < 0.99)
    assert np.abs(np.diff(ratio))[inner].max() < 0.01


def test_nothing_is_above_or_below_the_envelope():
    ratio = envelope_ratio(row()[None], np.zeros(2, int), np.array([-0.01, 1.01]))
    np.testing.assert_array_equal(ratio, [0.0, 0.0])


def aspen(**named: float) -> Skeleton:
    return grow(row(**ASPEN | PRUNED | {"levels": 2, "leaves": 0} | named)[None], tree_keys(1))


def inside(skeleton: Skeleton, stems: Stems, scale: float = 1.0) -> Flags:
    """[N] whether nodes are in the envelope; of stems at a scale about the place where they begin."""
    first = np.repeat(stems.node_offsets[:-1], stems.num_nodes)
    points = stems.points[first] + scale * (stems.points - stems.points[first])
    tree = np.repeat(stems.tree, stems.num_nodes)
    return is_inside(skeleton.rows, tree, skeleton.scale, skeleton.scale, points)


@pytest.mark.parametrize("seed", some(range(60)))
def test_everything_but_the_trunk_is_in_the_envelope_if_its_share_is_1(seed: int):
    values = random_row(seed)
    for name, value in {"prune_ratio": 1.0, "wind_speed": 0.0, "z_scale": 1.0, "z_scale_v": 0.0}.items():
        values[COLUMN[name]] = value
    skeleton = grow(values[None], tree_keys(1))
    for stems in skeleton.levels[1:]:
        assert inside(skeleton, stems).all()


def test_a_pruned_stem_is_as_long_as_the_envelope_permits():
    free, pruned = aspen(), aspen(prune_ratio=1.0)
    share = pruned.levels[1].length / free.levels[1].length
    shortened = np.repeat(share < 1.0, pruned.levels[1].num_nodes)
    assert 0.2 < np.mean(share < 1.0) < 1.0
    assert inside(pruned, pruned.levels[1]).all()
    longer = np.all(inside(pruned, pruned.levels[1], 1.0001).reshape(len(share), -1), axis=1)
    assert not longer[share < 1.0].any()
    # Their draws are the same: only the scale changes.
    np.testing.assert_array_equal(pruned.levels[1].frames[shortened], free.levels[1].frames[shortened])


@pytest.mark.parametrize("ratio", [0.25, 0.5, 0.9])
def test_a_share_of_pruning_is_between_both_lengths(ratio: float):
    free, partly, fully = aspen(), aspen(prune_ratio=ratio), aspen(prune_ratio=1.0)
    expected = (1.0 - ratio) * free.levels[1].length + ratio * fully.levels[1].length
    np.testing.assert_allclose(partly.levels[1].length, expected)


def test_clones_are_pruned_with_their_stem():
    skeleton = aspen(prune_ratio=1.0, seg_splits_1=0.4, split_angle_1=40.0)
    stems = skeleton.levels[1]
    clones = stems.is_clone
    assert clones.any()
    np.testing.assert_array_equal(stems.length[clones], stems.length[stems.source[clones]])
    assert inside(skeleton, stems).all()


def test_an_envelope_of_no_width_prunes_all_branches():
    assert len(aspen(prune_ratio=1.0, prune_width=0.0, curve_0=30.0).levels) == 1
