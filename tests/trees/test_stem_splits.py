"""Error diffusion over the segments of a level."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.trees.growth import grow
from tests.trees.rows import row, tree_keys


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
