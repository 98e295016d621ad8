"""Pictures of cities: they show the city, not the height of its ground."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from grammarlab.runs.city.picture import StreetView, draw_city
from tests.runs.city.hills import write_hill_plan


def street_at(height: float, folder: Path) -> np.ndarray:
    """Picture of a street of the small city on level ground."""
    plan = write_hill_plan(folder, lambda east, _north: 0.0 * east + height)
    draw_city(plan, folder / "street.png", view=StreetView(44.0, 70.0, 20.0), size=(96, 64))
    return np.asarray(Image.open(folder / "street.png")).astype(int)


def test_a_street_looks_the_same_at_every_height(tmp_path: Path):
    low, high = street_at(0.0, tmp_path / "low"), street_at(64.0, tmp_path / "high")
    assert len(np.unique(low.reshape(-1, 3), axis=0)) > 10
    assert np.percentile(np.abs(high - low), 99) <= 2
