"""Measures of trees agree with numbers worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.arrays import Floats
from grammarlab.trees.measures import MEASURES, measure
from grammarlab.trees.skeleton import Skeleton
from tests.trees.hand_trees import Leaf, Stem, skeleton

TRUNK = Stem((0, 0, 0), (0, 10, 0), 0.2)


def values(trees: Skeleton) -> dict[str, Floats]:
    return dict(zip(MEASURES, measure(trees).T, strict=True))


def test_a_pole_is_its_own_crown() -> None:
    pole = {name: column[0] for name, column in values(skeleton([[TRUNK]])).items()}
    assert pole == pytest.approx(
        {
            **dict.fromkeys(MEASURES, 0.0),
            "height": 10.0,
            "slenderness": 10.0 / 0.4,
            "straightness": 1.0,
            "twig_diameter": 0.4,
            "clear_stem": 10.0,
            "num_stems": 1.0,
        }
    )


def test_a_cross_of_branches_with_a_leaf_at_each_end() -> None:
    ends = [(3, 6, 0), (-3, 6, 0), (0, 6, 3), (0, 6, -3)]
    branches = [Stem((0, 5, 0), end, 0.05, parent=0, offset=5.0) for end in ends]
    leaves = [Leaf(end, 0.2, 0.1) for end in ends]
    cross = {name: column[0] for name, column in values(skeleton([[TRUNK], branches], leaves)).items()}
    angles = np.pi / 8 * np.arange(16)
    width = 6.0 * np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles))).mean()
    # The outline from above is the square of the four points, 18 m2.
    assert cross == pytest.approx(
        {
            "height": 10.0,
            "crown_width": width,
            "crown_ratio": width / 1.2,
            "slenderness": 25.0,
            "straightness": 1.0,
            "lean": 0.0,
            "lowest": 0.0,
            "child_thickness": 0.25,
            "leaf_area": 4 * 0.02 * 2 / 3,
            "leaf_area_index": 4 * 0.02 * 2 / 3 / 18.0,
            "clash": 0.0,
            "twig_diameter": 0.1,
            "leaf_size": 0.02,
            # From each side two leaves are one behind the other.
            "visible_leaves": 3.0,
            "clear_stem": 5.0,
            "num_stems": 5.0,
            "num_leaves": 4.0,
        }
    )


def test_a_leaning_tree_that_hangs_into_the_ground() -> None:
    branch = Stem((5, 5, 0), (5, -1, 0), 0.18, parent=0, offset=5.0)
    trunk = Stem((0, 0, 0), (10, 10, 0), 0.2)
    leaves = [Leaf((4, 1, 0)), Leaf((0, 1, 3)), Leaf((9, 9, 9), is_blossom=True)]
    tree = values(skeleton([[trunk], [branch]], leaves))
    assert tree["lowest"][0] == pytest.approx(-0.1)
    assert tree["clear_stem"][0] == 0.0
    assert tree["lean"][0] == pytest.approx(0.1 * np.hypot(2.0, 1.5))
    assert tree["num_leaves"][0] == 2.0
    assert tree["child_thickness"][0] == pytest.approx(0.9)


def test_children_are_compared_with_their_tapered_parents_by_cross_section() -> None:
    thick = Stem((0, 5, 0), (3, 5, 0), 0.1, parent=0, offset=5.0)
    thin = Stem((0, 7.5, 0), (0.1, 7.5, 0), 0.01, parent=0, offset=7.5)
    tree = values(skeleton([[TRUNK], [thick, thin]], taper=1.0))
    assert tree["child_thickness"][0] == pytest.approx((0.1**2 * 1.0 + 0.01**2 * 0.2) / (0.1**2 + 0.01**2))
    # A cone is 0.174 m thick 1.3 m above the ground.
    assert tree["slenderness"][0] == pytest.approx(10.0 / (2 * 0.2 * 0.87))


def test_a_trunk_that_has_split_counts_with_the_area_of_its_parts() -> None:
    for begin, expected in ((0.1, 10.0 / (0.4 * np.sqrt(2.0))), (0.2, 25.0)):
        clone = Stem((0, 0, 0), (1, 9, 0), 0.2, source=0, begin=begin)
        tree = values(skeleton([[TRUNK, clone]]))
        assert tree["slenderness"][0] == pytest.approx(expected)
        assert tree["straightness"][0] == pytest.approx((1.0 + 9.0 / np.sqrt(82.0)) / 2.0)


@pytest.mark.parametrize("length", [2.0, 8.0])
def test_a_stem_inside_another_clashes_with_its_share(length: float) -> None:
    """A twig of one branch lies inside another branch, but for its joint of twice the radius of its parent."""
    host = Stem((0, 5, 0), (10, 5, 0), 0.1, parent=0, offset=5.0)
    other = Stem((0, 6, 0), (0, 6, 1), 0.1, parent=0, offset=6.0)
    twig = Stem((1, 5.05, 0), (1 + length, 5.05, 0), 0.01, parent=1)
    beside = Stem((1, 5.15, 0), (1 + length, 5.15, 0), 0.01, parent=1)
    total = 10.0 + 10.0 + 1.0 + length
    inside = values(skeleton([[TRUNK], [host, other], [twig]]))["clash"][0]
    assert inside == pytest.approx((length - 0.2) / total, abs=0.006)
    assert values(skeleton([[TRUNK], [host, other], [beside]]))["clash"][0] == 0.0


def test_relatives_do_not_clash() -> None:
    host = Stem((0, 0, 0), (0, 10, 0), 0.5)
    child = Stem((0, 1, 0), (0.1, 9, 0), 0.2, parent=0, offset=1.0)
    clone = Stem((0, 0, 0), (0.1, 10, 0), 0.5, source=0, begin=0.1)
    assert values(skeleton([[host, clone], [child]]))["clash"][0] == 0.0


def test_a_batch_measures_like_its_trees_alone() -> None:
    def tree(number: int, size: float) -> tuple[list[Stem], list[Stem], list[Leaf]]:
        trunk = Stem((0, 0, 0), (0.1, size, 0.2), 0.02 * size, number)
        angles = np.arange(12) * 2.4
        tips = np.stack([np.cos(angles), 1.2 + 0.05 * angles, np.sin(angles)], axis=1) * size / 3
        stems = [
            Stem((0, 0.4 * size, 0), (float(x), float(y), float(z)), 0.011 * size, number, number, 0.4 * size)
            for x, y, z in tips
        ]
        leaves = [Leaf((float(x), float(y), float(z)), tree=number) for x, y, z in tips[: 6 + number]]
        return [trunk], stems, leaves

    parts = [tree(number, 4.0 + 3.3 * number) for number in range(3)]
    trunks = [stem for part in parts for stem in part[0]]
    branches = [stem for part in parts for stem in part[1]]
    batch = measure(skeleton([trunks, branches], [leaf for part in parts for leaf in part[2]]))
    for number, size in enumerate((4.0, 7.3, 10.6)):
        trunks, stems, leaves = tree(0, size)
        leaves = [Leaf(leaf.position) for leaf in parts[number][2]]
        np.testing.assert_array_equal(batch[number], measure(skeleton([trunks, stems], leaves))[0])


def test_a_tree_without_branches_in_a_batch_has_no_crown() -> None:
    bare = Stem((0, 0, 0), (0, 6, 0), 0.1, tree=1)
    branch = Stem((0, 5, 0), (2, 5, 0), 0.05, parent=0, offset=5.0)
    trees = values(skeleton([[TRUNK, bare], [branch]], [Leaf((2, 5, 0))]))
    assert trees["clear_stem"].tolist() == [5.0, 6.0]
    assert trees["twig_diameter"] == pytest.approx([0.1, 0.2])
    assert trees["crown_width"][1] == 0.0
