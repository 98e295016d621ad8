"""Walls, units and labels of known buildings."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from grammarlab.errors import FacadeError
from grammarlab.synthesis.analysis.example import OUTSIDE, Example, analyse
from grammarlab.synthesis.mesh.building_files import read_mesh
from tests.synthesis.analyses import analysed_once
from tests.synthesis.houses import RECESS, House, house
from tests.synthesis.rectangles import BOXES, WALL, empty_file, with_sheets


def analysed(known: House, path: Path, digits: int = 9) -> Example:
    return analysed_once(read_mesh(known.write(path / "house.obj", digits)))


def same_classes(found: np.ndarray, truth: np.ndarray) -> bool:
    """Whether two labellings agree up to names: an adjusted Rand index of 1."""
    pairs = set(zip(found.ravel().tolist(), truth.ravel().tolist(), strict=True))
    return len(pairs) == len(np.unique(found)) == len(np.unique(truth))


@pytest.mark.parametrize("seed", range(6))
def test_rows_columns_and_labels_are_those_of_the_house_with_points_off_by_a_centimetre(
    seed: int, tmp_path: Path
) -> None:
    random = np.random.default_rng(seed)
    columns, rows, side = (int(each) for each in random.integers((4, 3, 1), (8, 7, 5)))
    broad = tuple((int(r), int(c)) for r, c in random.integers((1, 0), (rows, columns), (2, 2)))
    known = house(
        columns,
        rows,
        side,
        pitch=random.uniform(2.4, 3.6),
        storey=random.uniform(2.8, 3.6),
        door=int(random.integers(columns)),
        broad=broad,
        noise=0.01 * (seed % 2),
        seed=seed,
    )
    main = analysed(known, tmp_path).main
    assert main.grid.labels.shape == known.labels.shape
    assert same_classes(main.grid.labels, known.labels)
    assert main.grid.names[int(main.grid.labels[known.labels == 1][0])] == "door"
    assert main.columns.pitch == pytest.approx(known.pitch[0], abs=0.01)


@pytest.mark.parametrize(
    "change", ["plain", "flipped", "half flipped", "empty faces", "twice", "two sides", "soup", "far", "z up", "turned"]
)
def test_how_a_file_is_written_does_not_matter(change: str, tmp_path: Path) -> None:
    known = house(5, 4, 2)
    points, triangles = known.points, known.triangles
    turn = np.array([[0.8, 0, 0.6], [0, 1, 0], [-0.6, 0, 0.8]])
    changed = {
        "plain": (points, triangles),
        "flipped": (points, triangles[:, ::-1]),
        "half flipped": (points, np.where(np.arange(len(triangles))[:, None] % 2, triangles, triangles[:, ::-1])),
        "empty faces": (points, np.concatenate([triangles, triangles[:99, [0, 0, 1]], triangles[:99, [0, 1, 1]]])),
        "twice": (np.concatenate([points, points]), np.concatenate([triangles, triangles + len(points)])),
        "two sides": (points, np.concatenate([triangles, triangles[:, ::-1]])),
        "soup": (points[triangles.ravel()], np.arange(triangles.size).reshape(-1, 3)),
        "far": (points + np.array([678_000.0, 5_403_000.0, 370.0]), triangles),
        "z up": (points[:, [0, 2, 1]] * [1.0, -1.0, 1.0], triangles),
        "turned": (points @ turn, triangles),
    }[change]
    example = analysed(House(changed[0], changed[1], known.labels, known.pitch), tmp_path, digits=6)
    assert [each.name for each in example.regions] == ["front", "right", "back", "left"]
    assert (example.main.grid.labels == known.labels).all()
    assert np.diff(example.main.columns.line) == pytest.approx(3.0, abs=1e-3)
    # After the transform, the house is upright and square.
    assert np.ptp(example.surface.points, axis=0) == pytest.approx(np.ptp(points, axis=0), abs=1e-3)
    assert bool(example.notes) == (change == "z up")


def test_windows_without_glass_are_units(tmp_path: Path) -> None:
    known = house(4, 3, 2)
    corners = known.points[known.triangles]
    span = np.ptp(corners, axis=1)
    middle = corners.mean(axis=1)
    far = known.points.max(axis=0)
    glass = np.zeros(len(corners), dtype=bool)
    for axis in (0, 2):
        behind = np.minimum(np.abs(middle[:, axis] - RECESS), np.abs(middle[:, axis] - far[axis] + RECESS)) < 1e-6
        glass |= (span[:, axis] < 1e-6) & behind
    example = analysed(House(known.points, known.triangles[~glass], known.labels, known.pitch), tmp_path)
    assert same_classes(example.main.grid.labels, known.labels)
    assert len(example.regions) == 4


def test_a_box_without_anything_on_it_is_refused_in_words(tmp_path: Path) -> None:
    import trimesh

    box = trimesh.creation.box((9.0, 7.0, 8.0))
    path = tmp_path / "box.ply"
    box.export(path)
    with pytest.raises(FacadeError, match="No wall of this building"):
        analyse(read_mesh(path))


@pytest.mark.parametrize("rows", [2, 3])
def test_units_of_upper_storeys_are_those_of_upper_storeys(rows: int, tmp_path: Path) -> None:
    """All windows of the house are equal: which one represents them follows from the ground below alone."""
    region = analysed(house(4, rows, 2, door=1), tmp_path).main
    window = region.grid.label("window")
    below, above = (OUTSIDE, window, window, window), (window, OUTSIDE, window, window)
    between, alone = (window, window, window, window), (OUTSIDE, OUTSIDE, window, window)
    assert [region.source(window, around)[0] for around in (below, between, above, alone)] == [0, 1, rows - 1, 0]


def test_a_door_is_a_unit_of_a_house_of_one_storey(tmp_path: Path) -> None:
    """It takes more than 0.6 of the height of the wall, as pilasters do."""
    known = house(4, 1, 2, door=1)
    low = known.points[:, 1] > 3.0
    points = np.where(low[:, None] & [False, True, False], known.points - [0.0, 1.3, 0.0], known.points)
    region = analysed(replace(known, points=points), tmp_path).main
    assert [region.grid.names[label] for label in region.grid.labels[0]] == ["window", "door", "window", "window"]


@pytest.mark.parametrize("axes", [[0, 1, 2], [0, 2, 1]])
def test_a_free_standing_wall_with_boxes_on_it_has_units_whatever_is_up(axes: list[int], tmp_path: Path) -> None:
    parts = np.array([WALL, *BOXES])[:, :, axes].tolist()
    example = analyse(read_mesh(with_sheets(empty_file(tmp_path / "wall.obj"), *parts)))
    assert example.main.grid.labels.shape == (2, 4)
    assert not any("sheet" in note for note in example.notes)
