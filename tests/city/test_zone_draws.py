"""Zones are drawn with their probabilities, parcel by parcel, in patches, and move little when the probabilities do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid
from scipy.spatial import KDTree
from scipy.special import expit
from scipy.stats import chisquare, kstest

from grammarlab.city import zone_draws
from grammarlab.city.elliptical_slice import MAX_TRIES, drawn_values
from grammarlab.city.zone_density import ZoneDensity, matern, places_km
from grammarlab.city.zone_draws import drawn_density, drawn_zones, zone_noise
from grammarlab.city.zone_learning import learned_zones
from tests.cases import some
from tests.city.test_zone_density import FIELDS, ZONES, density
from tests.city.towns import ZONES as TOWN_ZONES
from tests.city.towns import counts, divergence, patches, sampled, town


def test_zones_are_drawn_with_their_probabilities():
    model = density()
    chances = model.probabilities(FIELDS)
    rows = np.arange(0, len(FIELDS), 400)
    counts = np.zeros((len(rows), 3))
    for seed in range(600):
        counts[np.arange(len(rows)), drawn_zones(model, FIELDS.take(rows), seed)] += 1
    assert chisquare(counts.ravel(), 600 * chances[rows].ravel(), ddof=len(rows) - 1).pvalue > 1e-3


def test_a_parcel_keeps_its_zone_alone_in_another_order_and_without_others():
    model = density(scale=1.5)
    zones = drawn_zones(model, FIELDS, 5)
    order = np.random.default_rng(1).permutation(len(FIELDS))[:1000]
    np.testing.assert_array_equal(drawn_zones(model, FIELDS.take(order), 5), zones[order])
    assert drawn_zones(model, FIELDS.take(np.array([77])), 5)[0] == zones[77]


def test_the_order_of_zones_changes_no_parcel():
    model, order = density(scale=1.5), np.array([2, 0, 1])
    other = replace(
        model,
        zones=tuple(np.array(ZONES)[order]),
        intercept=model.intercept[order],
        slope=model.slope[:, order],
        weights=model.weights[:, order],
        counts=model.counts[:, order],
        offsets=model.offsets[:, order],
    )
    np.testing.assert_array_equal(order[drawn_zones(other, FIELDS, 3)], drawn_zones(model, FIELDS, 3))


def test_a_small_change_of_probabilities_moves_few_parcels():
    """The coupling law: at most 2 t / (1 + t) of parcels change, t being their total variation distance."""
    model = density()
    other = replace(model, intercept=model.intercept + np.array([0.1, 0.0, -0.05]))
    distance = 0.5 * np.abs(model.probabilities(FIELDS) - other.probabilities(FIELDS)).sum(axis=1)
    bound = (2 * distance / (1 + distance)).mean()
    moved = np.mean(
        [(drawn_zones(model, FIELDS, seed) != drawn_zones(other, FIELDS, seed)).mean() for seed in range(20)]
    )
    assert distance.mean() / 2 < moved <= bound * 1.05
    raised = replace(model, intercept=model.intercept + np.array([0.3, 0.0, 0.0]))
    old, new = drawn_zones(model, FIELDS, 1), drawn_zones(raised, FIELDS, 1)
    assert (new[old != new] == 0).all()  # parcels move to the zone that has become more probable, and nowhere else


def test_noise_has_the_distribution_of_gumbel():
    noise = zone_noise(FIELDS.id, ZONES, 2)
    assert abs(noise.mean() - np.euler_gamma) < 0.05
    assert abs(noise.std() - np.pi / np.sqrt(6)) < 0.05
    assert abs(np.corrcoef(noise.T) - np.eye(3)).max() < 0.05


def one_place(answers: tuple[float, float]) -> ZoneDensity:
    """Two zones, and answers about one place, where the first zone is less likely a priori."""
    return replace(
        density(places=1, scale=2.0),
        zones=("a", "b"),
        features=(),
        intercept=np.array([-0.5, 0.5]),
        slope=np.zeros((0, 2)),
        weights=np.zeros((1, 2)),
        counts=np.array([answers]),
        offsets=np.array([[-0.5, 0.5]]),
    )


@pytest.mark.parametrize("answers", some([(0.0, 0.0), (3.0, 0.0), (2.0, 1.0)]))
def test_draws_at_a_place_have_the_posterior_distribution(
    answers: tuple[float, float], monkeypatch: pytest.MonkeyPatch
):
    """By quadrature: the difference of two draws of N(0, 2²) has the variance 8, and the likelihood is binomial."""
    monkeypatch.setattr(zone_draws, "_STEPS", 60)  # one place needs few
    model = one_place(answers)
    here = replace(FIELDS.take(np.array([0])), east_north=model.places * 1000.0)
    odds = np.concatenate([drawn_density(model, seed).log_odds(here) for seed in range(150)])
    grid = np.linspace(-15, 15, 4001)
    chance = expit(grid)
    weight = np.exp(-((grid + 1.0) ** 2) / 16.0) * chance ** answers[0] * (1.0 - chance) ** answers[1]
    cumulative = cumulative_trapezoid(weight, grid, initial=0.0)
    assert kstest(odds[:, 0] - odds[:, 1], lambda x: np.interp(x, grid, cumulative / cumulative[-1])).pvalue > 1e-3


def test_elliptical_slices_keep_a_gaussian_posterior():
    """Of two values with covariances, one of which is observed: mean and covariance are those of regression."""
    rng = np.random.default_rng(0)
    root = np.linalg.cholesky(np.array([[2.0, 1.2], [1.2, 1.5]]))
    steps = [(root @ rng.normal(size=2), rng.uniform(size=2 + MAX_TRIES)) for _ in range(40_000)]
    values, chain = np.zeros(2), []
    for step in steps:
        values = drawn_values(values, [step], lambda g: -((g[0] - 1.0) ** 2))
        chain.append(values)
    gain = np.array([2.0, 1.2]) / 2.5  # noise of variance 1/2
    np.testing.assert_allclose(np.mean(chain, axis=0), gain, atol=0.06)
    expected = root @ root.T - np.outer(gain, [2.0, 1.2])
    np.testing.assert_allclose(np.cov(np.transpose(chain)), expected, atol=0.08)


def test_without_answers_draws_have_the_covariance_of_the_kernel(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(zone_draws, "_STEPS", 60)
    model = replace(density(places=4, scale=1.5), counts=np.zeros((4, 3)), weights=np.zeros((4, 3)))
    few = FIELDS.take(np.array([0, 40, 800, 2500]))
    g = np.stack([drawn_density(model, seed).log_odds(few) - model.log_odds(few) for seed in range(120)])
    u = places_km(few, model.frame)
    covariance = np.einsum("smk,snk->mn", g, g) / (3 * len(g))
    np.testing.assert_allclose(covariance, 1.5**2 * matern(u, u, model.length), atol=0.5)
    assert (
        abs(np.einsum("sn,sn->", g[:, :, 0], g[:, :, 1]) / g[:, :, 0].size) < 0.35
    )  # zones do not depend on each other


def test_zones_of_draws_form_patches_where_little_is_known():
    fields = town(1200)
    asked = fields.take(sampled(1200, 32, 0))
    truth = patches(fields)
    model = learned_zones(asked, counts(patches(asked), 0), TOWN_ZONES, "0" * 64).density
    assert model.scale > 0.0
    _, near = KDTree(fields.east_north).query(fields.east_north, k=7)
    mixed = np.zeros(2)
    chances = np.zeros_like(truth)
    for seed in range(8):
        noise = zone_noise(fields.id, TOWN_ZONES, seed)
        drawn = drawn_density(model, seed).log_odds(fields)
        for column, odds in enumerate((model.log_odds(fields), drawn)):
            zones = (odds + noise).argmax(axis=1)
            mixed[column] += (zones[np.asarray(near)[:, 1:]] != zones[:, None]).mean() / 8
        chance = np.exp(drawn - drawn.max(axis=1, keepdims=True))
        chances += chance / chance.sum(axis=1, keepdims=True) / 8
    assert mixed[1] < 0.95 * mixed[0]
    assert divergence(chances, truth) < 1.2 * divergence(model.probabilities(fields), truth)


def test_another_origin_moves_no_patch():
    model = replace(density(scale=1.5), places=np.round(density().places, 6))
    moved = replace(
        model,
        frame=replace(model.frame, origin=(model.frame.origin[0] + 1000.0, model.frame.origin[1] - 2000.0)),
        places=model.places - np.array([1.0, -2.0]),
    )
    zones = drawn_zones(model, FIELDS, 7)
    assert (drawn_zones(moved, FIELDS, 7) == zones).mean() > 0.999
    assert (drawn_zones(model, FIELDS, 8) != zones).mean() > 0.2
