"""How a length is divided: worked examples, and laws over random sizes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from grammarlab.derivation.operations.split import along_shapes, numbers_along
from grammarlab.derivation.split_sizes import SplitRepeat, SplitSize, divide


def about(value: float) -> SplitSize:
    return SplitSize(value, floating=True)


def extents(length: float, *elements: SplitSize | SplitRepeat) -> list[list[float]]:
    return [np.round(piece.extent, 6).tolist() for piece in divide(np.array([length]), elements)]


EXAMPLES = [
    ("fixed sizes around a floating one", 10.0, [SplitSize(3.3), about(3), SplitSize(5)], [[3.3], [1.7], [5.0]]),
    ("floating sizes share in proportion", 10.0, [about(0.5), about(0.1), about(0.2)], [[6.25], [1.25], [2.5]]),
    ("what does not fill leaves a gap", 10.0, [SplitSize(5.0), SplitSize(1.0), SplitSize(2.0)], [[5.0], [1.0], [2.0]]),
    ("what is too much is cut", 10.0, [SplitSize(5.0), SplitSize(6.0), SplitSize(3.0)], [[5.0], [5.0], []]),
    (
        "sizes of nothing are skipped",
        5.0,
        [SplitSize(1.5), SplitSize(-2.0), SplitSize(1.5), SplitSize(0.0), SplitSize(4.0)],
        [[1.5], [], [1.5], [], [2.0]],
    ),
    (
        "floating sizes get nothing when there is no room",
        4.0,
        [SplitSize(3.0), about(1), SplitSize(2.0)],
        [[3.0], [], [1.0]],
    ),
    (
        "a fixed pattern repeats and its last part is cut",
        10.0,
        [SplitRepeat((SplitSize(2.0), SplitSize(1.0)))],
        [[2, 2, 2, 1], [1, 1, 1]],
    ),
    ("a floating pattern is stretched", 12.2, [SplitRepeat((about(3),))], [[3.05] * 4]),
    ("never less than one", 0.5, [SplitRepeat((about(3),))], [[0.5]]),
    (
        "beside fixed sizes",
        10.0,
        [SplitSize(1.0), SplitRepeat((about(1), SplitSize(0.2), about(1))), SplitSize(1.0)],
        [[1], [0.9] * 4, [0.2] * 4, [0.9] * 4, [1]],
    ),
    (
        "fixed and floating in one pattern",
        10.0,
        [SplitRepeat((SplitSize(1.0), about(2.7))), SplitSize(1.0)],
        [[1] * 3, [2] * 3, [1]],
    ),
    (
        "two groups share the count",
        17.35,
        [SplitRepeat((about(3.55),)), SplitRepeat((about(3.55),))],
        [[3.47] * 3, [3.47] * 2],
    ),
]


@pytest.mark.parametrize(("length", "elements", "expected"), [e[1:] for e in EXAMPLES], ids=[e[0] for e in EXAMPLES])
def test_worked_examples(length, elements, expected):
    assert extents(length, *elements) == [[pytest.approx(value) for value in row] for row in expected]


@pytest.mark.parametrize(("length", "count"), [(40.0, 13), (12.2, 4)])
def test_the_repeat_count_brings_the_stretch_nearest_to_one(length, count):
    assert len(extents(length, SplitRepeat((about(3.0),)))[0]) == count


@pytest.mark.parametrize("tile", [2.5, 3.55, 4.5])
@pytest.mark.parametrize(
    ("step", "counts"), [(1, [1, 0]), (5, [1, 0]), (8, [1, 1]), (14, [2, 1]), (18, [2, 2]), (23, [3, 2])]
)
def test_the_first_of_two_groups_gets_the_extra_part_as_in_the_other_runtime(tile, step, counts):
    room = 0.21 * step * tile + 0.03
    group = SplitRepeat((about(tile),))
    elements = [SplitSize(1.0), SplitSize(tile), group, SplitSize(tile), group, SplitSize(tile), SplitSize(1.0)]
    pieces = divide(np.array([3.0 * tile + 2.0 + room]), elements)
    assert [len(pieces[i].extent) for i in (2, 4)] == counts


# Lengths of the room for two groups, in parts, at which another CGA runtime repeats more often or, at the first, less.
@pytest.mark.parametrize("tile", [2.5, 3.55])
@pytest.mark.parametrize(
    ("threshold", "below", "above"),
    [
        (0.1667, 2, 1),
        (1.2777, 1, 2),
        (2.4571, 2, 3),
        (3.3470, 3, 4),
        (4.5079, 4, 5),
        (5.3767, 5, 6),
        (6.5275, 6, 7),
        (7.3905, 7, 8),
        (8.5378, 8, 9),
    ],
)
def test_two_groups_repeat_as_often_as_in_the_other_runtime(tile, threshold, below, above):
    group = SplitRepeat((about(tile),))
    elements = [SplitSize(1.0), SplitSize(tile), group, SplitSize(tile), group, SplitSize(tile), SplitSize(1.0)]
    rooms = np.array([threshold - 2e-4, threshold + 2e-4]) * tile
    pieces = divide(3.0 * tile + 2.0 + rooms, elements)
    counts = np.bincount(pieces[2].row, minlength=2) + np.bincount(pieces[4].row, minlength=2)
    assert counts.tolist() == [below, above]


def test_a_floating_rest_changes_the_count():
    tiles, joints, rest = extents(2.15, SplitRepeat((about(0.7167), SplitSize(0.25))), about(0.7167))
    assert (len(tiles), len(joints), len(rest)) == (2, 2, 1)


sizes = st.builds(SplitSize, st.floats(0.05, 5.0), st.booleans())
patterns = st.lists(
    st.one_of(sizes, st.builds(lambda s: SplitRepeat(tuple(s)), st.lists(sizes, min_size=1, max_size=3))),
    min_size=1,
    max_size=5,
)


@given(st.lists(st.floats(0.2, 60.0), min_size=1, max_size=4), patterns)
def test_pieces_are_ordered_along_their_lengths(lengths, elements):
    pieces = divide(np.array(lengths), elements)
    row = np.concatenate([piece.row for piece in pieces])
    start = np.concatenate([piece.start for piece in pieces])
    order = np.lexsort((start, row))
    assert np.array_equal(along_shapes(pieces, row), order)
    number = np.concatenate(numbers_along(pieces, len(lengths)))
    assert number[order].tolist() == [index for count in np.bincount(row).tolist() for index in range(count)]


@given(st.lists(st.floats(0.2, 60.0), min_size=1, max_size=4), patterns)
def test_pieces_lie_within_their_length_without_overlap(lengths, elements):
    length = np.array(lengths)
    counts: list[int] = []
    pieces = divide(length, elements, counts.append)
    assert sum(len(piece.row) for piece in pieces) <= counts[0]
    for row, whole in enumerate(lengths):
        spans = sorted((s, e) for p in pieces for r, s, e in zip(p.row, p.start, p.extent, strict=True) if r == row)
        ends = [start + extent for start, extent in spans]
        assert all(extent > 0.0 for _, extent in spans)
        assert all(np.isclose(a, b[0], atol=1e-6) for a, b in zip(ends, spans[1:], strict=False))
        assert not ends or ends[-1] <= whole * (1 + 1e-12)


@given(st.floats(0.2, 60.0), patterns)
def test_floating_sizes_fill_the_length(length, elements):
    outside = [e for e in elements if isinstance(e, SplitSize)]
    assume(any(size.floating for size in outside))
    assume(sum(size.value for size in outside if not size.floating) < 0.9 * length)
    assert sum(piece.extent.sum() for piece in divide(np.array([length]), elements)) == pytest.approx(length)


@given(st.lists(st.floats(0.2, 60.0), min_size=2, max_size=5), patterns)
def test_every_length_is_divided_as_if_alone(lengths, elements):
    together = divide(np.array(lengths), elements)
    for row, length in enumerate(lengths):
        alone = divide(np.array([length]), elements)
        for a, b in zip(alone, together, strict=True):
            assert np.array_equal(a.start, b.start[b.row == row])
            assert np.array_equal(a.extent, b.extent[b.row == row])
