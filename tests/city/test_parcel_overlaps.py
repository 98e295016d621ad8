"""Overlaps: what two outlines share belongs to the first, as by comparing all pairs."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.city import parcel_overlaps
from grammarlab.city.packed_outlines import Outlines, PackedOutlines
from grammarlab.city.parcel_overlaps import MIN_OVERLAP, Disjoint, disjoint
from grammarlab.errors import AssetError

boxes = st.tuples(*[st.integers(0, 12)] * 2, *[st.integers(2, 8)] * 2).map(
    lambda box: shapely.box(box[0], box[1], box[0] + box[2], box[1] + box[3])
)


def separated(outlines: Outlines) -> Disjoint:
    """All outlines without what they share with earlier ones."""
    return disjoint(PackedOutlines.of(outlines), np.arange(len(outlines)))


@settings(max_examples=80)
@given(st.lists(boxes, max_size=12), st.sampled_from([1, 3, 64]))
def test_each_place_belongs_to_the_first_outline_that_has_it(outlines, rows):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(parcel_overlaps, "_ROWS", rows)
        result = separated(np.array(outlines, dtype=object))
    for row, outline in enumerate(outlines):
        earlier = [one for one in outlines[:row] if one.intersection(outline).area > MIN_OVERLAP]
        rest = outline.difference(shapely.union_all(earlier))
        largest = max((piece.area for piece in shapely.get_parts(rest)), default=0.0)
        assert result.is_covered[row] == (largest < MIN_OVERLAP)
        expected = outline.area if result.is_covered[row] else largest
        assert result.outlines.area[row] == pytest.approx(expected)
        assert result.is_cut[row] == (bool(earlier) and not result.is_covered[row])


def test_neighbours_stay_as_they_are():
    """To the last bit, also with corners on the edges of others."""
    outlines = np.array([shapely.box(0.1, 0, 7.3, 5), shapely.box(7.3, 1.7, 9, 4), shapely.box(0.1, 5, 9, 6)])
    assert (separated(outlines).outlines[:] == outlines).all()
    assert len(separated(np.empty(0, dtype=object)).outlines) == 0


def test_stacks_of_outlines_are_refused(monkeypatch):
    monkeypatch.setattr(parcel_overlaps, "_MOST_PAIRS", 100)
    monkeypatch.setattr(parcel_overlaps, "_MOST_PAIRS_EACH", 2)
    stack = np.array([shapely.box(0, 0, 10 + size, 10) for size in range(40)])
    with pytest.raises(AssetError, match="beside each other"):
        separated(stack)
