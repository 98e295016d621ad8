"""Skeletons against the stem-by-stem oracle, and their laws."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.arrays import Floats
from grammarlab.trees.growth import grow
from grammarlab.trees.parameters import COLUMN
from grammarlab.trees.skeleton import Skeleton, Stems
from grammarlab.trees.taper import tapered
from tests.cases import some
from tests.trees.oracle import Leaf, Stem, Tree
from tests.trees.rows import ASPEN, random_row, row, tree_keys


def assert_same_stems(stems: Stems, expected: list[Stem], parents: list[Stem], tolerance: float) -> None:
    rows = {id(stem): row for row, stem in enumerate(expected)}
    parent_rows = {id(stem): row for row, stem in enumerate(parents)} | {id(None): -1}
    assert stems.key.tolist() == [stem.key for stem in expected]
    assert stems.parent.tolist() == [parent_rows[id(stem.parent)] for stem in expected]
    assert stems.source.tolist() == [-1 if stem.source is None else rows[id(stem.source)] for stem in expected]
    assert stems.first.tolist() == [stem.first for stem in expected]
    assert stems.num_nodes.tolist() == [len(stem.points) for stem in expected]
    for name in ("length", "radius", "offset"):
        np.testing.assert_allclose(
            getattr(stems, name), [getattr(stem, name) for stem in expected], rtol=1e-6, atol=tolerance
        )
    np.testing.assert_allclose(stems.points, np.concatenate([stem.points for stem in expected]), atol=tolerance)
    np.testing.assert_allclose(stems.frames, np.concatenate([stem.frames for stem in expected]), atol=1e-6)


def assert_same_leaves(skeleton: Skeleton, expected: list[Leaf], last: list[Stem], tolerance: float) -> None:
    leaves, rows = skeleton.leaves, {id(stem): row for row, stem in enumerate(last)}
    assert leaves.stem.tolist() == [rows[id(leaf.stem)] for leaf in expected]
    assert leaves.is_blossom.tolist() == [leaf.is_blossom for leaf in expected]
    if not expected:
        return
    for name, absolute in (
        ("offset", tolerance),
        ("position", tolerance),
        ("frame", 1e-6),
        ("length", 1e-9),
        ("width", 1e-9),
    ):
        values = np.array([getattr(leaf, name) for leaf in expected])
        np.testing.assert_allclose(getattr(leaves, name), values, atol=absolute)


@pytest.mark.parametrize("seed", some(range(200)))
def test_a_tree_is_that_of_the_oracle(seed: int):
    values, keys = random_row(seed), tree_keys(1, seed)
    skeleton, tree = grow(values[None], keys), Tree(values, int(keys[0]))
    # Lengths of pruned stems are found by bisection, to 2^-24.
    tolerance = tree.scale * (1e-5 if values[COLUMN["prune_ratio"]] > 0.0 else 1e-8)
    assert [len(stems) for stems in skeleton.levels] == [len(stems) for stems in tree.levels]
    for level, stems in enumerate(tree.levels):
        assert_same_stems(skeleton.levels[level], stems, tree.levels[level - 1] if level else [], tolerance)
    assert_same_leaves(skeleton, tree.leaves, tree.levels[-1], tolerance)


def of_tree(skeleton: Skeleton, tree: int) -> dict[str, Floats]:
    """All arrays of a tree of a batch, but for rows of other arrays."""
    arrays: dict[str, Floats] = {}
    for level, stems in enumerate(skeleton.levels):
        chosen = stems.tree == tree
        if not chosen.any():
            continue
        nodes = np.repeat(chosen, stems.num_nodes)
        for name in ("key", "first", "offset", "length", "radius"):
            arrays[f"{name} {level}"] = getattr(stems, name)[chosen]
        for name in ("points", "frames", "along"):
            arrays[f"{name} {level}"] = getattr(stems, name)[nodes]
    leaves = skeleton.leaves
    for name in ("level", "offset", "position", "frame", "length", "width", "is_blossom"):
        arrays[f"leaf {name}"] = getattr(leaves, name)[leaves.tree == tree]
    return arrays


def test_a_batch_equals_its_members_to_the_bit():
    rows, keys = np.stack([random_row(seed) for seed in range(30)]), tree_keys(30)
    batch = grow(rows, keys)
    for tree in range(len(rows)):
        alone, member = of_tree(grow(rows[[tree]], keys[[tree]]), 0), of_tree(batch, tree)
        assert alone.keys() == member.keys()
        for name, values in alone.items():
            np.testing.assert_array_equal(values, member[name], err_msg=f"{tree} {name}")


def test_stems_and_leaves_are_ordered_by_tree_and_point_into_their_own():
    skeleton = grow(np.stack([random_row(seed) for seed in range(30)]), tree_keys(30))
    for level, stems in enumerate(skeleton.levels):
        assert (np.diff(stems.tree) >= 0).all()
        if level > 0:
            np.testing.assert_array_equal(skeleton.levels[level - 1].tree[stems.parent], stems.tree)
        clones = stems.is_clone
        np.testing.assert_array_equal(stems.tree[stems.source[clones]], stems.tree[clones])
        np.testing.assert_array_equal(stems.length[stems.source[clones]], stems.length[clones])
        assert (stems.first[clones] > stems.first[stems.source[clones]]).all()
        assert (stems.first[~clones] == 0).all()
        assert len(np.unique(stems.key)) == len(stems)
    leaves = skeleton.leaves
    assert (np.diff(leaves.tree) >= 0).all()
    for level, stems in enumerate(skeleton.levels):
        of_level = leaves.level == level
        np.testing.assert_array_equal(stems.tree[leaves.stem[of_level]], leaves.tree[of_level])


@pytest.mark.parametrize("seed", some(range(40)))
def test_children_begin_inside_their_parent_and_are_never_thicker_than_it_there(seed: int):
    source = random_row(seed)
    source[COLUMN["wind_speed"]] *= seed % 2
    skeleton = grow(source[None], tree_keys(1))
    for level, stems in enumerate(skeleton.levels[1:], 1):
        parents, origin = skeleton.levels[level - 1], np.flatnonzero(~stems.is_clone)
        parent = stems.parent[origin]
        share = stems.offset[origin] / parents.length[parent]
        taper = np.full(len(share), source[COLUMN[f"taper_{level - 1}"]])
        room = tapered(parents.radius[parent], parents.length[parent], taper, share)
        assert (stems.radius[origin] <= room + 1e-12).all()
        assert (share > parents.along[parents.node_offsets[parent]]).all()
        for stem, on, along in zip(origin, parent, share, strict=True):
            nodes = slice(*parents.node_offsets[on : on + 2])
            axis = [np.interp(along, parents.along[nodes], parents.points[nodes, i]) for i in range(3)]
            np.testing.assert_allclose(stems.points[stems.node_offsets[stem]], axis, atol=1e-9)


@pytest.mark.parametrize("seed", some(range(20)))
def test_segments_of_a_stem_are_equally_long_and_lie_along_their_frames(seed: int):
    skeleton = grow(random_row(seed)[None], tree_keys(1))
    for stems in skeleton.levels:
        inner = np.setdiff1d(np.arange(len(stems.points)), stems.node_offsets[1:] - 1)
        steps = stems.points[inner + 1] - stems.points[inner]
        lengths = np.repeat(stems.length, stems.num_nodes)[inner] * np.diff(stems.along)[inner]
        np.testing.assert_allclose(steps, lengths[:, None] * stems.frames[inner, :, 2], atol=1e-9)
        np.testing.assert_allclose(stems.along[stems.node_offsets[1:] - 1], 1.0)


@pytest.mark.parametrize("seed", some(range(20)))
def test_a_tree_of_twice_the_scale_is_the_same_tree_of_twice_the_size(seed: int):
    source = random_row(seed)
    large = source.copy()
    large[[COLUMN[name] for name in ("scale", "scale_v", "leaf_scale", "blossom_scale")]] *= 2.0
    small_tree, large_tree = (of_tree(grow(values[None], tree_keys(1)), 0) for values in (source, large))
    for name, values in small_tree.items():
        is_size = name.split()[0] in {"offset", "length", "radius", "points"} or name.split()[-1] in {
            "offset",
            "position",
            "length",
            "width",
        }
        np.testing.assert_array_equal(large_tree[name], values * 2.0 if is_size else values)


def test_a_heading_turns_the_whole_tree_about_the_vertical():
    rows, keys = np.stack([random_row(seed) for seed in range(30)]), tree_keys(30)
    rows[:, COLUMN["wind_speed"]] = 0.0
    heading = np.linspace(0.0, 6.0, 30)
    cosine, sine = np.cos(heading), np.sin(heading)
    turn = np.zeros((30, 3, 3))
    turn[:, 0, 0], turn[:, 0, 2], turn[:, 1, 1], turn[:, 2, 0], turn[:, 2, 2] = cosine, sine, 1.0, -sine, cosine
    straight, turned = grow(rows, keys), grow(rows, keys, heading)
    for one, other in zip(straight.levels, turned.levels, strict=True):
        tree = np.repeat(one.tree, one.num_nodes)
        expected = np.einsum("nij,nj->ni", turn[tree], one.points)
        np.testing.assert_allclose(other.points, expected, atol=1e-6 * straight.scale.max())
    expected = np.einsum("nij,nj->ni", turn[straight.leaves.tree], straight.leaves.position)
    np.testing.assert_allclose(turned.leaves.position, expected, atol=1e-6 * straight.scale.max())


@pytest.mark.parametrize("seed", some(range(20)))
def test_leaf_parameters_change_no_stem(seed: int):
    source = random_row(seed)
    other = source.copy()
    columns = [index for name, index in COLUMN.items() if name.startswith(("leaf", "leaves", "blossom"))]
    other[columns] = np.where(source[columns] == 0.5, 0.25, 0.5)
    other[COLUMN["leaves"]], other[COLUMN["blossom_shape"]], other[COLUMN["leaf_shape"]] = 7, 2, 3
    before, after = (of_tree(grow(values[None], tree_keys(1)), 0) for values in (source, other))
    for name in before:
        if not name.startswith("leaf"):
            np.testing.assert_array_equal(before[name], after[name])


def test_without_spreads_and_drawn_forks_a_tree_does_not_depend_on_its_key():
    values = row(**{name: value for name, value in ASPEN.items() if not name.endswith("_v")}, base_splits=2)
    values[COLUMN["down_angle_1_v"]], values[COLUMN["curve_2_v"]] = -50.0, -20.0  # negative ones draw nothing
    skeleton = grow(np.stack([values] * 2), tree_keys(2))
    one, other = (of_tree(skeleton, tree) for tree in range(2))
    for name in one:
        if not name.startswith("key"):
            np.testing.assert_array_equal(one[name], other[name])


def test_another_spread_changes_only_what_it_names():
    spreads = ("curve_2_v", "rotate_2_v", "down_angle_2_v")
    before = grow(row(**ASPEN)[None], tree_keys(1))
    for name in spreads:
        after = grow(row(**ASPEN | {name: 17.0})[None], tree_keys(1))
        for level in range(2):
            np.testing.assert_array_equal(after.levels[level].points, before.levels[level].points)
        np.testing.assert_array_equal(after.levels[2].length, before.levels[2].length)
        assert not np.array_equal(after.levels[2].points, before.levels[2].points)


def test_one_more_child_has_the_draws_of_no_other():
    few, many = (grow(row(**ASPEN | {"branches_1": num})[None], tree_keys(1)).levels[1] for num in (20, 21))
    np.testing.assert_array_equal(many.key[:20], few.key)


def test_every_tree_has_a_trunk_whatever_its_spreads():
    rows = np.stack([row(scale=1.0, scale_v=60.0, z_scale_v=5.0, length_0=0.0, scale_0_v=5.0)] * 200)
    skeleton = grow(rows, tree_keys(200))
    assert (skeleton.scale >= 0.1).all()
    assert (skeleton.levels[0].length >= 0.01 * 0.1 * 0.1).all()
    assert (skeleton.levels[0].radius > 0.0).all()


def test_a_stretched_tree_has_a_longer_trunk_and_the_same_branches():
    plain, stretched = (
        grow(row(**ASPEN | {"z_scale": stretch, "shape": 3})[None], tree_keys(1)) for stretch in (1.0, 2.0)
    )
    np.testing.assert_allclose(stretched.levels[0].length, 2.0 * plain.levels[0].length)
    np.testing.assert_allclose(stretched.levels[1].length, plain.levels[1].length)
    np.testing.assert_allclose(stretched.levels[0].radius, plain.levels[0].radius)
    np.testing.assert_allclose(stretched.levels[1].offset, 2.0 * plain.levels[1].offset)
