"""Zones are drawn with their probabilities, parcel by parcel, and move little when the probabilities do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chisquare

from grammarlab.city.fields import parcel_fields
from grammarlab.city.zone_density import Feature, ZoneDensity, matern, zone_noise
from grammarlab.errors import UsageError
from grammarlab.geometry.footprints.frame import Frame
from tests.city.quarters import quarter

FIELDS = parcel_fields(quarter(4000))
ZONES = ("tower", "row", "park")


def density(seed: int = 0, places: int = 20) -> ZoneDensity:
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


def test_zones_are_drawn_with_their_probabilities():
    model = density()
    chances = model.probabilities(FIELDS)
    rows = np.arange(0, len(FIELDS), 400)
    counts = np.zeros((len(rows), 3))
    for seed in range(600):
        counts[np.arange(len(rows)), model.drawn(FIELDS.take(rows), seed)] += 1
    assert chisquare(counts.ravel(), 600 * chances[rows].ravel(), ddof=len(rows) - 1).pvalue > 1e-3


def test_a_parcel_keeps_its_zone_alone_in_another_order_and_without_others():
    model = density()
    zones = model.drawn(FIELDS, 5)
    order = np.random.default_rng(1).permutation(len(FIELDS))[:1000]
    np.testing.assert_array_equal(model.drawn(FIELDS.take(order), 5), zones[order])
    assert model.drawn(FIELDS.take(np.array([77])), 5)[0] == zones[77]


def test_the_order_of_zones_changes_no_parcel():
    model, order = density(), np.array([2, 0, 1])
    other = replace(
        model,
        zones=tuple(np.array(ZONES)[order]),
        intercept=model.intercept[order],
        slope=model.slope[:, order],
        weights=model.weights[:, order],
    )
    np.testing.assert_array_equal(order[other.drawn(FIELDS, 3)], model.drawn(FIELDS, 3))


def test_a_small_change_of_probabilities_moves_few_parcels():
    """The coupling law: at most 2 t / (1 + t) of parcels change, t being their total variation distance."""
    model = density()
    other = replace(model, intercept=model.intercept + np.array([0.1, 0.0, -0.05]))
    distance = 0.5 * np.abs(model.probabilities(FIELDS) - other.probabilities(FIELDS)).sum(axis=1)
    bound = (2 * distance / (1 + distance)).mean()
    moved = np.mean([(model.drawn(FIELDS, seed) != other.drawn(FIELDS, seed)).mean() for seed in range(20)])
    assert distance.mean() / 2 < moved <= bound * 1.05
    raised = replace(model, intercept=model.intercept + np.array([0.3, 0.0, 0.0]))
    old, new = model.drawn(FIELDS, 1), raised.drawn(FIELDS, 1)
    assert (new[old != new] == 0).all()  # parcels move to the zone that has become more probable, and nowhere else


def test_noise_has_the_distribution_of_gumbel():
    noise = zone_noise(FIELDS.id, ZONES, 2)
    assert abs(noise.mean() - np.euler_gamma) < 0.05
    assert abs(noise.std() - np.pi / np.sqrt(6)) < 0.05
    assert abs(np.corrcoef(noise.T) - np.eye(3)).max() < 0.05


def test_the_frame_of_the_parcels_may_have_another_origin():
    model = density()
    moved = replace(FIELDS, frame=Frame(FIELDS.frame.crs, (440000.0, 5400000.0)))
    moved = replace(moved, east_north=FIELDS.east_north + np.array([8000.0, 12000.0]))
    np.testing.assert_allclose(model.probabilities(moved), model.probabilities(FIELDS), atol=1e-9)


def test_other_coordinates_and_missing_fields_are_refused():
    with pytest.raises(UsageError, match="learned in EPSG:32631, and the parcels are in EPSG:32632"):
        density().drawn(replace(FIELDS, frame=Frame("EPSG:32632", (0.0, 0.0))), 1)
    with pytest.raises(UsageError, match="unknown field 'frontage'; expected one of area, aspect"):
        replace(density(), features=(Feature("frontage", "m", 1.0, 1.0),) * 2).drawn(FIELDS, 1)
