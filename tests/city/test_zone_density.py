"""Densities are their formula, wherever the origin of the metres is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from grammarlab.city.fields import parcel_fields
from grammarlab.city.zone_density import Feature, ZoneDensity, matern
from grammarlab.errors import UsageError
from grammarlab.geometry.footprints.frame import Frame
from tests.city.quarters import quarter

FIELDS = parcel_fields(quarter(4000))
ZONES = ("tower", "row", "park")


def density(seed: int = 0, places: int = 20, scale: float = 0.0) -> ZoneDensity:
    """A density; with the scale 0, its draws have no patches."""
    rng = np.random.default_rng(seed)
    return ZoneDensity(
        zones=ZONES,
        frame=FIELDS.frame,
        features=(Feature("area", "m²", 6.2, 0.5, is_log=True), Feature("aspect", "", 1.8, 0.6)),
        intercept=rng.normal(size=3),
        slope=rng.normal(size=(2, 3)),
        places=rng.uniform(0, 2, (places, 2)),
        weights=rng.normal(size=(places, 3)),
        length=0.5,
        scale=scale,
        counts=rng.integers(0, 2, (places, 3)).astype(np.float64),
        offsets=rng.normal(size=(places, 3)),
        answers="0" * 64,
    )


def test_probabilities_are_the_formula():
    model = density()
    row = 17
    x = [(np.log(1 + FIELDS.values[row, 0]) - 6.2) / 0.5, (FIELDS.values[row, 1] - 1.8) / 0.6]
    r = np.sqrt(3) * np.hypot(*(model.places - FIELDS.east_north[row] / 1000).T) / 0.5
    odds = np.exp(model.intercept + x @ model.slope + ((1 + r) * np.exp(-r)) @ model.weights)
    np.testing.assert_allclose(model.probabilities(FIELDS)[row], odds / odds.sum(), rtol=1e-12)


def test_the_kernel_is_positive_definite_with_a_unit_diagonal():
    points = np.random.default_rng(0).uniform(0, 1, (30, 2))
    kernel = matern(points, points, 0.4)
    np.testing.assert_allclose(np.diag(kernel), 1.0)
    assert np.linalg.eigvalsh(kernel)[0] > 0


def test_the_frame_of_the_parcels_may_have_another_origin():
    model = density()
    moved = replace(FIELDS, frame=Frame(FIELDS.frame.crs, (440000.0, 5400000.0)))
    moved = replace(moved, east_north=FIELDS.east_north + np.array([8000.0, 12000.0]))
    np.testing.assert_allclose(model.probabilities(moved), model.probabilities(FIELDS), atol=1e-9)


def test_other_coordinates_and_missing_fields_are_refused():
    with pytest.raises(UsageError, match="learned in EPSG:32631, and the parcels are in EPSG:32632"):
        density().log_odds(replace(FIELDS, frame=Frame("EPSG:32632", (0.0, 0.0))))
    with pytest.raises(UsageError, match="unknown field 'frontage'; expected one of area, aspect"):
        replace(density(), features=(Feature("frontage", "m", 1.0, 1.0),) * 2).log_odds(FIELDS)
