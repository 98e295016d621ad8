"""Buildings along an arc."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from grammarlab.synthesis.analysis.example import analyse
from grammarlab.synthesis.mesh.bending import Bend, bend_of
from grammarlab.synthesis.mesh.building_files import ExampleMesh, read_mesh
from tests.synthesis.analysis.test_example import same_classes
from tests.synthesis.houses import House, house

KNOWN = house(12, 3, 2, broad=((1, 2), (1, 9)))


def read(known: House, path: Path) -> ExampleMesh:
    return read_mesh(known.write(path / "house.obj"))


@pytest.mark.parametrize(("middle", "center"), [(0.0, (0.0, 0.0)), (2.5, (30.0, -12.0)), (-3.1, (5.0, 5.0))])
def test_what_is_bent_is_found_laid_out_straight_and_bent_again(
    middle: float, center: tuple[float, float], tmp_path: Path
) -> None:
    straight = KNOWN.points - [np.ptp(KNOWN.points[:, 0]) / 2.0, 0.0, KNOWN.points[:, 2].max()]
    bend = Bend(np.array(center), 30.0, middle)
    points = bend.bent(straight)
    assert bend.straight(points) == pytest.approx(straight, abs=1e-9)
    mesh = read(House(points, KNOWN.triangles, KNOWN.labels, KNOWN.pitch), tmp_path)
    example = analyse(mesh, "y")
    assert example.bend is not None
    assert example.bend.center + mesh.origin[[0, 2]] == pytest.approx(center, abs=0.2)
    front = max(example.regions, key=lambda each: len(each.grid.names))
    assert same_classes(front.grid.labels, KNOWN.labels)
    assert front.grid.names[int(front.grid.labels[0, 3])] == "door"
    # Bent back, it has its original coordinates.
    assert example.bent(example.surface.points) == pytest.approx(mesh.surface.points, abs=1e-6)


def test_a_long_street_never_meets_itself() -> None:
    bend = Bend(np.zeros(2), 10.0, 0.0)
    points = np.stack([np.linspace(-100.0, 100.0, 50), np.zeros(50), np.zeros(50)], axis=1)
    bent = bend.bent(points)
    angles = np.unwrap(np.arctan2(bent[:, 0], bent[:, 2]))
    assert np.ptp(angles) == pytest.approx(2.0 * np.pi - np.radians(30.0))
    # Distances along the arc are preserved.
    assert np.diff(angles) * np.hypot(bent[0, 0], bent[0, 2]) == pytest.approx(np.diff(points[:, 0]))


@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_straight_walls_are_no_arc(noise: float, tmp_path: Path) -> None:
    mesh = read(house(6, 4, 3, noise=noise, seed=2), tmp_path)
    assert bend_of(mesh.surface) is None
    turn = np.array([[0.8, 0, 0.6], [0, 1, 0], [-0.6, 0, 0.8]])
    assert bend_of(replace(mesh.surface, points=mesh.surface.points @ turn)) is None
