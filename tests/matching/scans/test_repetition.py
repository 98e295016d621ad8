"""Elements that repeat: found where depth alone does not separate them, and where one of them is partly hidden."""

from dataclasses import replace
from itertools import product

import laspy
import numpy as np
import pytest

from grammarlab.matching.scans.repetition import completed, overlapping, repeated
from grammarlab.matching.scans.scan_boxes import FacadePlane, cut_out, find_boxes
from grammarlab.matching.scans.scan_files import load_elements
from grammarlab.matching.scans.wall_cells import cells_of
from tests.cases import takes_turns

WIDTH, HEIGHT = 13.0, 9.1
WINDOWS = np.array([[x, y, x + 1.0, y + 1.5] for y in (1.0, 3.8, 6.6) for x in (1.2, 3.6, 6.0, 8.4, 10.8)])
MARGIN = 0.12


def wall(windows, *, depth=0.0, frame=0.0, kept=1.0, gradient=1.0, noise=0.003, strays=0.0, holes=(), trees=()):
    """[P, 3] along, up and out of a wall.

    Args:
        windows: [N, 4] left, bottom, right, top.
        depth: of the windows behind the wall.
        frame: relief of frames of 8 cm.
        kept: share of the points inside the frames that a scanner sees.
        gradient: ratio of the densities of points at the left and at the right end.
        noise: standard deviation of each coordinate.
        strays: outliers, as a share of all points.
        holes: centres and radii of ellipses without points.
        trees: centres and radii of crowns in front.
    """
    random = np.random.default_rng(0)
    count = int(WIDTH * HEIGHT * 1_600)
    points = np.column_stack([random.uniform(0, [WIDTH, HEIGHT], (count, 2)), np.zeros(count)])
    points = points[random.uniform(size=count) < gradient ** (-points[:, 0] / WIDTH)]
    seen = np.ones(len(points), dtype=bool)
    for left, bottom, right, top in windows:
        inside = ((points[:, :2] > [left, bottom]) & (points[:, :2] < [right, top])).all(axis=1)
        low, high = points[:, :2] > [left + 0.08, bottom + 0.08], points[:, :2] < [right - 0.08, top - 0.08]
        glass = np.all(low & high, axis=1)
        points[inside, 2] = np.where(glass[inside], -depth, frame - depth)
        seen &= ~glass | (random.uniform(size=len(points)) < kept)
    for x, y, across, up in holes:
        seen &= ((points[:, 0] - x) / across) ** 2 + ((points[:, 1] - y) / up) ** 2 > 1.0
    for x, y, across, up in trees:
        behind = ((points[:, 0] - x) / across) ** 2 + ((points[:, 1] - y) / up) ** 2 < 1.0
        points[behind, 2] = random.uniform(1.0, 3.0, behind.sum())
    points = points[seen] + random.normal(0, noise, (seen.sum(), 3))
    stray = random.uniform([0, 0, -1], [WIDTH, HEIGHT, 1], (int(strays * len(points)), 3))
    return np.vstack([points, stray])


def found_in(points):
    found = find_boxes(FacadePlane(points, np.zeros((0, 3))))
    return found.box + MARGIN * np.array([1.0, 1.0, -1.0, -1.0]), found.outline, found.num_repeated


def matched(boxes, windows=WINDOWS):
    """[N] index of the box of each window; -1 for none."""
    near = np.abs(boxes - windows[:, None]).max(axis=2) if len(boxes) else np.full((len(windows), 1), np.inf)
    return np.where(near.min(axis=1) < 0.15, near.argmin(axis=1), -1)


@pytest.mark.parametrize(
    ("scene", "error"),
    [
        ({"frame": 0.02}, 0.02),
        ({"frame": 0.02, "noise": 0.008, "strays": 0.05}, 0.05),
        ({"frame": 0.015, "kept": 0.3}, 0.03),
        ({"depth": 0.015, "noise": 0.01}, 0.04),
        ({"frame": 0.02, "gradient": 4.0, "holes": [(2.9, 3.0, 0.5, 0.3)]}, 0.06),
    ],
)
def test_windows_flush_with_the_wall_are_found_since_they_repeat(scene, error):
    boxes, outlines, num_repeated = found_in(wall(WINDOWS, **scene))
    place = matched(boxes)
    assert (place >= 0).all()
    assert num_repeated == len(WINDOWS)
    elements = cut_out(outlines, boxes + MARGIN * np.array([-1.0, -1.0, 1.0, 1.0]))
    away = []
    for window, element in enumerate(place.tolist()):
        middle, half = (WINDOWS[window, :2] + WINDOWS[window, 2:]) / 2, (WINDOWS[window, 2:] - WINDOWS[window, :2]) / 2
        points = np.abs(elements.points_of(element) - middle)
        for axis in (0, 1):
            away.append(np.median(points[points[:, 1 - axis] < half[1 - axis] / 2, axis]) - half[axis])
    assert np.sqrt(np.mean(np.square(away))) < error


def test_single_flat_parts_and_empty_walls_have_no_elements():
    for windows, scene in (
        (WINDOWS[:0], {"noise": 0.02}),
        (WINDOWS[:0], {"gradient": 6.0, "strays": 0.05}),
        (WINDOWS[:1], {"frame": 0.02}),
        (WINDOWS[[0, 6, 12]], {"depth": 0.02}),
    ):
        assert not len(found_in(wall(windows, **scene))[0])


def test_depth_finds_elements_that_do_not_repeat():
    windows = np.array([[1.0, 1.0, 2.0, 2.5], [3.1, 4.0, 5.6, 5.1], [8.0, 2.0, 8.6, 6.5]])
    for which in (windows[:1], windows):
        boxes, _, num_repeated = found_in(wall(which, depth=0.15))
        assert sorted(matched(boxes, which)) == list(range(len(boxes))) == list(range(len(which)))
        assert not num_repeated


@pytest.mark.parametrize("trees", [[(6.5, 4.0, 0.9, 1.3)], [(5.2, 3.6, 1.6, 1.6), (5.2, 1.0, 0.3, 2.0)]])
def test_elements_behind_a_tree_are_found_by_their_rows_and_columns(trees):
    boxes, _, num_repeated = found_in(wall(WINDOWS, depth=0.15, trees=trees))
    assert sorted(matched(boxes)) == list(range(len(WINDOWS))) == list(range(len(boxes)))
    assert num_repeated
    for axis, count in ((0, 5), (1, 3)):
        assert len(np.unique(boxes[:, [axis, axis + 2]], axis=0)) == count


@takes_turns
def test_neither_doors_nor_bare_wall_are_taken_for_hidden_windows():
    for bare in (None, np.array([6.0, 0.0, 7.0, 2.5])):
        others = np.delete(WINDOWS, 2, axis=0)
        points = wall(others, depth=0.15)
        if bare is not None:
            points[((points[:, :2] > bare[:2]) & (points[:, :2] < bare[2:])).all(axis=1), 2] -= 0.15
        boxes, _, num_repeated = found_in(points)
        assert sorted(matched(boxes, others)) == list(range(len(others))) == list(range(len(boxes)))
        assert not num_repeated


def test_a_turned_scan_far_from_the_origin_shows_the_same_windows(tmp_path):
    points = wall(WINDOWS, frame=0.02, trees=[(6.5, 4.0, 0.4, 0.5)])
    rooms = np.random.default_rng(1).uniform([0, 0, -6], [WIDTH, HEIGHT, -4], (50, 3))
    points = np.vstack([points, rooms])
    along, out = np.array([np.cos(0.6), np.sin(0.6), 0]), np.array([np.sin(0.6), -np.cos(0.6), 0])
    scan = points[:, :1] * along + points[:, 1:2] * [0, 0, 1] + points[:, 2:] * out + [5e5, 5.4e6, 400.0]
    header = laspy.LasHeader(point_format=3, version="1.2")
    header.scales, header.offsets = np.full(3, 0.001), np.array([500_000, 5_400_000, 0])
    written = laspy.LasData(header)
    written.x, written.y, written.z = scan.T
    written.write(str(tmp_path / "wall.las"))
    elements = load_elements(tmp_path / "wall.las")
    boxes = np.hstack([elements.low + MARGIN, elements.high - MARGIN]) - [0, 400, 0, 400]
    assert (matched(boxes) >= 0).all()
    assert "by repetition" in elements.notes[0]
    assert elements.row.max() == 2
    assert elements.column.max() == 4


def test_repeated_boxes_are_joined_by_moves_along_one_axis():
    random = np.random.default_rng(4)
    low = random.integers(0, 6, (40, 2)) * 1.0
    boxes = np.hstack([low, low + random.integers(1, 3, (40, 2))]) + random.uniform(-0.04, 0.04, (40, 4))
    group = list(range(len(boxes)))
    for one, other in product(range(len(boxes)), repeat=2):
        first, second = np.rint(boxes[one]), np.rint(boxes[other])
        move = second - first
        if (move[:2] == move[2:]).all() and (move[:2] == 0).any():
            group = [group[one] if each == group[other] else each for each in group]
    often = np.array([group.count(each) >= 4 for each in group])
    assert 0 < often.sum() < len(boxes)
    assert (repeated(boxes, 0.05) == often).all()


def test_overlaps_count_relative_to_the_smaller_box():
    large, small, corner = np.array([[0, 0, 4, 4.0]]), np.array([[1, 1, 2, 2.0]]), np.array([[3.9, 3.9, 5, 5.0]])
    assert overlapping(large, small).all()
    assert overlapping(small, large).all()
    assert not overlapping(large, corner).any()
    assert not len(overlapping(large[:0], small))
    assert not overlapping(large, small[:0]).any()


def test_columns_without_agreement_and_coarse_points_are_no_reason_for_more_boxes():
    uneven = np.array([[0, 0, 1, 1], [0.5, 3, 2.5, 4], [6, 0, 7, 1], [6.5, 3, 8.5, 4], [9, 0, 10, 1], [12, 0, 13, 1.0]])
    cells = cells_of(np.column_stack([np.mgrid[0:15:0.5, 0:6:0.5].reshape(2, -1).T, np.zeros(360)]))
    aligned, lacking = completed(uneven, uneven[:0], np.zeros(cells.empty.shape, dtype=bool), replace(cells, side=0.01))
    assert np.isfinite(aligned).all()
    assert not len(lacking)
    random = np.random.default_rng(2)
    for count in (50, 200, 800):
        points = random.uniform([0, 0, -0.1], [9, 7, 0.1], (count, 3))
        assert np.isfinite(found_in(points)[0]).all()


def test_ten_thousand_boxes_need_little_memory():
    low = np.stack(np.meshgrid(np.arange(100.0), np.arange(100.0)), axis=-1).reshape(-1, 2)
    boxes = np.hstack([low, low + 0.5])  # ty: ignore[unsupported-operator]
    assert overlapping(boxes, boxes[::50]).sum() == 200
