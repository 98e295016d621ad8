"""Windows in the plane of their wall, as in city models: holes of one polygon, filled with rectangles."""

from pathlib import Path

import mapbox_earcut
import numpy as np
import pytest
import trimesh

from grammarlab.errors import FacadeError
from grammarlab.synthesis.analysis.example import Example, analyse
from grammarlab.synthesis.mesh.building_files import read_mesh

WIDTH, HEIGHT, DEPTH = 21.0, 12.4, 9.0
COLUMNS, ROWS = (2.0, 4.2, 6.9, 9.1, 15.2, 17.4), (1.4, 4.4, 7.4)
SMALL, LARGE = (0.7, 1.4), (1.2, 1.8)


def flat_house(path: Path, *, back: float, noise: float, askew: float = 0.0) -> Path:
    """A box whose front has windows in two sizes, each at a depth behind the wall, without reveals."""
    outer = np.array([[0.0, 0.0], [WIDTH, 0.0], [WIDTH, HEIGHT], [0.0, HEIGHT]])
    rings, panes = [outer], []
    for row, bottom in enumerate(ROWS):
        for left in COLUMNS:
            size = np.array(LARGE if row == 0 else SMALL)
            low = np.array([left, bottom])
            panes.append(low + size * np.array([[0, 0], [1, 0], [1, 1], [0, 1]]))
            rings.append(panes[-1][::-1])
    flat = np.concatenate(rings)
    wall = mapbox_earcut.triangulate_float64(flat, np.cumsum([len(ring) for ring in rings]).astype(np.uint32))
    box = trimesh.creation.box(bounds=[[0.0, 0.0, -DEPTH], [WIDTH, HEIGHT, 0.0]])
    inner = box.faces[box.face_normals[:, 2] < 0.5]
    points = [np.column_stack([flat, np.zeros(len(flat))]), np.asarray(box.vertices)]
    faces = [wall.reshape(-1, 3).astype(np.int64), inner + len(flat)]
    first = len(flat) + len(box.vertices)
    for pane in panes:
        points.append(np.column_stack([pane, np.full(4, -back)]))
        faces.append(np.array([[0, 1, 2], [0, 2, 3]]) + first)
        first += 4
    corners = np.concatenate(points)
    # The back is skewed: the house is not quite rectangular.
    corners[:, 2] += np.where(corners[:, 2] < -DEPTH / 2.0, askew * corners[:, 0], 0.0)
    corners, place = np.unique(np.round(corners, 9), axis=0, return_inverse=True)
    corners = corners + np.random.default_rng(4).uniform(-noise, noise, corners.shape)
    trimesh.Trimesh(corners, place.ravel()[np.concatenate(faces)], process=False).export(path)
    return path


@pytest.mark.parametrize(
    ("back", "noise", "askew"), [(0.0, 0.0, 0.0), (0.0, 0.01, 0.02), (0.03, 0.0, 0.0), (0.03, 0.01, 0.0)]
)
def test_windows_that_lie_in_the_wall_are_units(tmp_path: Path, back: float, noise: float, askew: float) -> None:
    example: Example = analyse(read_mesh(flat_house(tmp_path / "flat.ply", back=back, noise=noise, askew=askew)), "y")
    main = example.main
    # The wide gap after the fourth column becomes a column, so that the cells beside it have the size of others.
    labels = main.grid.labels
    assert labels.shape == (3, 7)
    assert len({*labels[0, [0, 1, 2, 3, 5, 6]].tolist()}) == 1
    assert len({*labels[1:, [0, 1, 2, 3, 5, 6]].ravel().tolist()}) == 1
    assert len({labels[0, 0], labels[1, 0], labels[1, 4]}) == 3
    sizes = main.elements[:, 2:] - main.elements[:, :2]
    assert np.abs(np.sort(sizes[:, 0]) - np.sort([SMALL[0]] * 12 + [LARGE[0]] * 6)).max() <= 2.0 * noise + 1e-6
    assert main.rows.pitch == pytest.approx(2.9, abs=0.01)


def test_a_wall_that_is_divided_evenly_has_no_panes(tmp_path: Path) -> None:
    box = trimesh.creation.box((12.0, 9.0, 6.0)).subdivide().subdivide().subdivide()
    box.export(tmp_path / "box.ply")
    with pytest.raises(FacadeError, match="No wall"):
        analyse(read_mesh(tmp_path / "box.ply"))
    # Lines from end to end, at windows of other walls, are not windows either.
    lines = [np.array([0.0, 1.0, 2.2, 4.0, 5.2, 7.0, 8.2, 10.0]), np.array([0.0, 1.0, 2.5, 4.0, 5.5, 7.0])]
    x, y = np.meshgrid(*lines)
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    faces = np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)
    trimesh.Trimesh(np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3), faces, process=False).export(tmp_path / "l.ply")
    with pytest.raises(FacadeError, match="No wall"):
        analyse(read_mesh(tmp_path / "l.ply"), "y")
