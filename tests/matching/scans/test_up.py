"""The up axis and the unit of scans: windows stand, whichever axis is up and whatever the coordinates count."""

import laspy
import numpy as np
import pytest
import trimesh

from grammarlab.errors import FacadeError, UsageError
from grammarlab.matching.scans.scan_files import load_elements
from tests.cases import some

COUNT = 14_000
UP = {"y": [0, 1, 2], "z": [2, 0, 1]}
"""Columns of points (along, up, out of the wall) of a file with this axis up, and a wall that is not mirrored."""


def scan(*, ground=0, side=False):
    """[P, 3] along, up and out of a wall of two rows and three columns of windows, 15 cm deep, 1 x 1.5 m."""
    random = np.random.default_rng(4)
    points = np.column_stack([random.uniform(0, [9, 7], (COUNT, 2)), np.zeros(COUNT)])
    for left in (1, 4, 7):
        for bottom in (1, 4):
            inside = ((points[:, :2] > [left, bottom]) & (points[:, :2] < [left + 1, bottom + 1.5])).all(axis=1)
            points[inside, 2] = -0.15
    parts = [points, np.column_stack([random.uniform(-1, 10, ground), np.zeros(ground), random.uniform(0, 5, ground)])]
    if side:  # a wall without windows around the corner
        parts.append(np.column_stack([np.zeros(COUNT), *random.uniform([[0], [-8]], [[7], [0]], (2, COUNT))]))
    points = np.vstack(parts)
    return points + random.normal(0, 0.003, points.shape)


def rows_and_columns(elements):
    size = elements.high - elements.low
    assert (size[:, 1] > size[:, 0]).all()
    return len(elements), int(elements.row.max()) + 1, int(elements.column.max()) + 1


def written(tmp_path, points, columns, scale=1.0):
    trimesh.PointCloud(points[:, columns] * scale).export(tmp_path / "scan.ply")
    return tmp_path / "scan.ply"


@pytest.mark.parametrize("options", some([{}, {"ground": COUNT}, {"side": True}]), ids=str)
@pytest.mark.parametrize("up", ["y", "z"])
def test_windows_of_a_scan_stand_whichever_axis_is_up(tmp_path, up, options):
    elements = load_elements(written(tmp_path, scan(**options), UP[up]))
    assert rows_and_columns(elements) == (6, 2, 3)
    assert f"{up} is taken as the up axis; give `up=` if another one is" in elements.notes


@pytest.mark.parametrize(("columns", "up"), [([2, 1, 0], "y"), ([2, 0, 1], "z")])
def test_the_ground_shows_what_is_up_of_a_wall_that_is_upright_for_both_axes(tmp_path, columns, up):
    elements = load_elements(written(tmp_path, scan(ground=COUNT), columns))
    assert rows_and_columns(elements) == (6, 2, 3)
    assert f"{up} is taken as the up axis; give `up=` if another one is" in elements.notes


def test_a_given_axis_is_not_doubted(tmp_path):
    path = written(tmp_path, scan(), [2, 1, 0])
    assert rows_and_columns(load_elements(path, up="y")) == (6, 2, 3)
    lying = load_elements(path, up="z")
    assert ((lying.high - lying.low)[:, 0] > (lying.high - lying.low)[:, 1]).all()
    assert not any("`up=`" in note for note in lying.notes)
    with pytest.raises(FacadeError, match=r"No vertical plane .* give `up=`|No element"):
        load_elements(written(tmp_path, scan(), UP["y"]), up="z")


def test_a_las_file_may_have_y_up_although_the_format_says_z(tmp_path):
    cloud = laspy.LasData(laspy.LasHeader(point_format=3, version="1.2"))
    cloud.header.scales = np.full(3, 0.001)
    cloud.x, cloud.y, cloud.z = scan().T
    cloud.write(str(tmp_path / "scan.las"))
    elements = load_elements(tmp_path / "scan.las")
    assert rows_and_columns(elements) == (6, 2, 3)
    assert "y is taken as the up axis; give `up=` if another one is" in elements.notes


@pytest.mark.parametrize(("unit", "metres"), [("mm", 0.001), ("ft", 0.3048)])
def test_a_scan_in_other_units_gives_the_same_metres(tmp_path, unit, metres):
    expected = load_elements(written(tmp_path, scan(), UP["z"]), up="z")
    found = load_elements(written(tmp_path, scan(), UP["z"], 1 / metres), unit=unit, up="z")
    np.testing.assert_allclose(np.sort(found.low, axis=0), np.sort(expected.low, axis=0), atol=0.01)
    np.testing.assert_allclose(np.sort(found.high, axis=0), np.sort(expected.high, axis=0), atol=0.01)


def test_a_mesh_in_other_units_gives_the_same_metres(tmp_path):
    parts = []
    frame = [(0, 9, 0, 1), (0, 9, 5.5, 7), (0, 9, 2.5, 4)] + [
        (left, right, bottom, bottom + 1.5) for bottom in (1, 4) for left, right in ((0, 1), (2, 4), (5, 7), (8, 9))
    ]
    for (left, right, bottom, top), thick in [(each, 0.4) for each in frame] + [((0, 9, 0, 7), 0.1)]:
        part = trimesh.creation.box((right - left, top - bottom, thick))
        part.apply_translation(((left + right) / 2, (bottom + top) / 2, thick / 2))
        parts.append(part)
    mesh = trimesh.util.concatenate(parts)
    mesh.export(tmp_path / "wall.stl")
    expected = load_elements(tmp_path / "wall.stl", up="y")
    assert rows_and_columns(expected) == (6, 2, 3)
    mesh.apply_scale(100.0)
    mesh.export(tmp_path / "wall.stl")
    found = load_elements(tmp_path / "wall.stl", unit="cm", up="y")
    np.testing.assert_allclose(np.sort(found.low, axis=0), np.sort(expected.low, axis=0), atol=0.02)


def test_elements_have_a_unit_and_an_axis_of_their_own(tmp_path):
    (tmp_path / "a.json").write_text('{"format": "grammarlab elements", "version": 1, "elements": []}')
    for unit, up in (("mm", ""), ("m", "z")):
        with pytest.raises(UsageError, match="a file of elements is in metres, with y up"):
            load_elements(tmp_path / "a.json", unit=unit, up=up)
