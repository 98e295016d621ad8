"""Zones are learned where the answers depend on something, and nowhere else."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from grammarlab.city.softmax_process import evidence_of
from grammarlab.city.zone_density import matern, places_km
from grammarlab.city.zone_design import spread_order, whitened_kernels
from grammarlab.city.zone_file import parse_zones, zones_text
from grammarlab.city.zone_learning import (
    LearnedZones,
    held_out_chances,
    learned_zones,
    shares_of_log_odds,
)
from grammarlab.errors import UsageError
from tests.city.towns import (
    ZONES,
    Truth,
    by_area,
    counts,
    divergence,
    everywhere_alike,
    patches,
    sampled,
    three_rings,
    town,
)

TOWN = town(2000)
HASH = "0" * 64


@cache
def learn(truth: Truth, num: int, seed: int = 0, wrong: float = 0.0) -> LearnedZones:
    fields = TOWN.take(sampled(len(TOWN), num, seed))
    return learned_zones(fields, counts(truth(fields), seed, wrong), ZONES, HASH)


def error(learned: LearnedZones, truth: Truth) -> float:
    return divergence(learned.density.probabilities(TOWN), truth(TOWN))


@pytest.mark.parametrize("truth", [three_rings, by_area])
def test_zones_by_place_or_by_a_field_are_learned(truth: Truth):
    """The target, a mean of .02 at most, is measured over many towns (`benchmarks/bench_zones.py`)."""
    assert np.mean([error(learn(truth, 64, seed), truth) for seed in range(3)]) < 0.03


def test_what_decides_is_named():
    shares = shares_of_log_odds(learn(three_rings, 128))
    assert max(shares, key=lambda name: shares[name]) == "distance to a centre"
    shares = shares_of_log_odds(learn(by_area, 64))
    assert shares["area"] > 0.9
    assert sum(shares.values()) == pytest.approx(1.0)


def test_the_centre_is_found():
    learned = learn(three_rings, 128)
    centre = next(feature.centre for feature in learned.density.features if feature.centre is not None)
    np.testing.assert_allclose(centre, (2.3, -0.7), atol=0.1)


def test_answers_without_a_pattern_give_nearly_constant_probabilities():
    chances = np.stack([learn(everywhere_alike, 64, seed).density.probabilities(TOWN) for seed in range(3)])
    assert chances.std(axis=1).mean() < 0.02
    assert np.abs(chances.mean(axis=(0, 1)) - [0.5, 0.3, 0.2]).max() < 0.1


def test_wrong_answers_are_never_worse_than_no_answers():
    equal = np.full((len(TOWN), 3), 1 / 3)
    for truth in (three_rings, by_area):
        assert error(learn(truth, 64, 1, wrong=0.1), truth) < 0.7 * divergence(equal, truth(TOWN))


def test_few_answers_and_answers_of_one_zone_are_enough_to_learn_something():
    for num in (1, 2, 5):
        learned = learn(three_rings, num)
        chances = learned.density.probabilities(TOWN)
        assert np.isfinite(chances).all()
        assert chances.min() > 0.01
    fields = TOWN.take(np.arange(40))
    chances = learned_zones(fields, np.tile([1.0, 0.0, 0.0], (40, 1)), ZONES, HASH).density.probabilities(TOWN)
    assert chances[:, 0].min() > 0.8


def test_the_order_of_answers_and_other_parcels_change_nothing():
    rows = sampled(len(TOWN), 50, 3)
    fields, answers = TOWN.take(rows), counts(three_rings(TOWN.take(rows)), 3)
    expected = zones_text(learned_zones(fields, answers, ZONES, HASH).density)
    order = np.random.default_rng(0).permutation(50)
    assert zones_text(learned_zones(fields.take(order), answers[order], ZONES, HASH).density) == expected
    more = TOWN.take(np.concatenate([rows, np.setdiff1d(np.arange(200), rows)]))
    unanswered = np.zeros((len(more) - 50, 3))
    assert zones_text(learned_zones(more, np.concatenate([answers, unanswered]), ZONES, HASH).density) == expected


def test_a_file_has_the_learned_density_to_the_last_bit():
    density = learn(three_rings, 64, 1, wrong=0.1).density
    np.testing.assert_array_equal(parse_zones(zones_text(density).encode()).log_odds(TOWN), density.log_odds(TOWN))


def test_the_density_has_the_log_odds_of_the_design():
    learned = learn(three_rings, 64, 1, wrong=0.1)
    odds = learned.design.rows(TOWN) @ learned.mode.weights
    centred = learned.density.log_odds(TOWN)
    centred -= centred.mean(axis=1, keepdims=True)
    np.testing.assert_allclose(np.linalg.norm(centred, axis=1), np.linalg.norm(odds, axis=1), atol=2e-3)


def test_scales_length_and_centre_are_better_than_others_near_them():
    """The evidence is at its optimum: any change of one scale by a fifth makes it smaller, prices included."""
    learned = learn(three_rings, 64)
    best = _price(learned, learned.design.scales)
    for index in range(len(learned.design.scales) - 1):
        for factor in (0.8, 1.25):
            scales = learned.design.scales.copy()
            scales[index] *= factor
            assert _price(learned, scales) > best - 0.05


def _price(learned: LearnedZones, scales: np.ndarray) -> float:
    rows = replace(learned.design, scales=scales).rows(learned.fields)
    return 0.1 * scales[0] + scales[1:].sum() - evidence_of(rows, learned.counts).value


def test_whitened_kernels_have_the_kernel_as_their_products():
    u = places_km(TOWN.take(np.arange(60)), TOWN.frame)
    kernels = whitened_kernels(u, u, 0.4)
    np.testing.assert_allclose(kernels @ kernels.T, matern(u, u, 0.4), atol=2e-4)


def test_places_are_spread():
    points = np.random.default_rng(0).uniform(0, 1, (400, 2))
    order = spread_order(points, 40)
    assert len(set(order.tolist())) == 40
    distance = np.linalg.norm(points[:, None] - points[order], axis=2).min(axis=1)
    assert distance.max() < np.linalg.norm(points[order][:, None] - points[order], axis=2)[np.triu_indices(40, 1)].min()
    np.testing.assert_array_equal(spread_order(np.zeros((3, 2)), 5), [0, 1, 2])


def test_held_out_probabilities_do_not_know_their_answer():
    learned = learn(everywhere_alike, 60)
    folds = np.arange(60) % 5
    before = held_out_chances(learned, folds)
    flipped = replace(learned, counts=np.where(folds[:, None] == 0, learned.counts[:, [1, 2, 0]], learned.counts))
    np.testing.assert_allclose(held_out_chances(flipped, folds)[folds == 0], before[folds == 0], atol=1e-5)


def test_too_few_and_too_many_zones_are_refused():
    fields = TOWN.take(np.arange(3))
    for zones in (("a",), tuple(f"z{number}" for number in range(33))):
        with pytest.raises(UsageError, match="zones: expected 2 to 32"):
            learned_zones(fields, np.ones((3, len(zones))), zones, HASH)
    with pytest.raises(UsageError, match="expected at least one"):
        learned_zones(fields, np.zeros((3, 3)), ZONES, HASH)


def test_a_density_has_its_answers_at_their_nearest_places():
    learned = learn(patches, 64)
    density = learned.density
    assert density.scale > 0.0
    np.testing.assert_array_equal(density.counts.sum(axis=0), learned.counts.sum(axis=0))
    u = places_km(learned.fields, density.frame)
    at_answers = density.log_odds(learned.fields) - matern(u, density.places, density.length) @ density.weights
    order = np.argmin(np.linalg.norm(density.places[:, None] - u, axis=2), axis=1)
    np.testing.assert_allclose(density.offsets, at_answers[order], atol=1e-3)
