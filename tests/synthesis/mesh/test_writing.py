"""Written surfaces are read back as they were."""

from pathlib import Path

import numpy as np
import pytest

from grammarlab.synthesis.mesh.building_files import read_mesh, write_glb
from tests.synthesis.houses import house


def test_a_surface_in_colors_is_read_back_with_them(tmp_path: Path) -> None:
    first = read_mesh(house(columns=2, rows=2, side=1, door=None).write(tmp_path / "house.obj"))
    surface = first.surface.part(np.arange(len(first.surface)) >= 0)
    surface.material[::3] = 1
    colors = ((1.0, 0.5020, 0.0, 1.0), (0.2, 0.4, 0.6, 0.4))
    again = read_mesh(write_glb(surface, colors, tmp_path / "again.glb"))
    assert again.colors == pytest.approx(np.array(colors))
    assert again.num_read == len(again.surface) == len(surface)

    def by_place(corners: np.ndarray, material: np.ndarray) -> list[tuple[float, ...]]:
        ends = np.sort(np.round(corners, 3) + 0.0, axis=1).reshape(-1, 9)
        return sorted((number, *row) for number, row in zip(material.tolist(), ends.tolist(), strict=True))

    found = by_place(again.surface.corners() + again.origin, again.surface.material)
    assert found == by_place(surface.corners(), surface.material)
