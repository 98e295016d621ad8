"""Scans with few points: windows that are equal are one kind, and deviations include the spacing of the points."""

import numpy as np
import pytest
import trimesh

from grammarlab.matching.coupled import couple
from grammarlab.matching.elements import Elements
from grammarlab.matching.library import templates_by_name
from grammarlab.matching.scans.scan_files import load_elements
from tests.cases import some, takes_turns

SIZE, DEPTH = np.array([1.2, 1.5]), 0.15
CORNERS = np.stack(np.meshgrid(0.9 + 3.0 * np.arange(4), 0.75 + 3.0 * np.arange(3)), axis=2).reshape(-1, 2)
TEMPLATES = templates_by_name("rectangle,trapezium")


def scanned(folder, spacing: float, noise: float, seed: int) -> Elements:
    """The elements of a wall with twelve equal windows, their panes and their jambs, evenly sampled."""
    random = np.random.default_rng(seed)
    sheets = [sheet(random, spacing, (0, 0, 0), (12, 0, 0), (0, 9, 0))]
    inside = (((sheets[0][:, None, :2] > CORNERS) & (sheets[0][:, None, :2] < CORNERS + SIZE)).all(axis=2)).any(axis=1)
    sheets[0][inside, 2] = -DEPTH
    across, up = np.array([SIZE[0], 0, 0]), np.array([0, SIZE[1], 0])
    for corner in np.column_stack([CORNERS, np.zeros(len(CORNERS))]):
        for start, along in ((corner, up), (corner + across, up), (corner, across), (corner + up, across)):
            sheets.append(sheet(random, spacing, start, along, (0, 0, -DEPTH)))
    points = np.vstack(sheets)
    points += random.normal(0, noise, points.shape)
    trimesh.PointCloud(points * [1, 1, -1] @ np.eye(3)[[0, 2, 1]]).export(folder / "wall.ply")
    return load_elements(folder / "wall.ply")


def sheet(random, spacing, start, along, across):
    """[P, 3] points on a parallelogram."""
    count = random.poisson(np.linalg.norm(along) * np.linalg.norm(across) / spacing**2)
    parts = random.uniform(size=(2, count, 1))
    return start + parts[0] * np.asarray(along) + parts[1] * np.asarray(across)


@pytest.mark.parametrize(("spacing", "noise"), some([(0.06, 0.008), (0.09, 0.004)]))
@takes_turns
def test_equal_windows_of_a_coarse_scan_are_one_kind_and_its_deviations_include_the_spacing(tmp_path, spacing, noise):
    elements = scanned(tmp_path, spacing, noise, 1)
    assert elements.spacing == pytest.approx(spacing, rel=0.2)
    assert "cm apart" in elements.notes[-1]
    found = couple(elements, TEMPLATES, 0)
    assert len(found.values) == 1
    assert found.kind.tolist() == [0] * len(CORNERS)
    assert (np.abs(found.values[0] - SIZE) < 3.0 * found.spread[0]).all()
    assert (found.spread[0] < 0.5 * spacing).all()


def test_a_dense_scan_has_no_note_about_its_points(tmp_path):
    elements = scanned(tmp_path, 0.018, 0.002, 1)
    assert elements.notes == (
        "12 boxes were found on the facade",
        "z is taken as the up axis; give `up=` if another one is",
    )
