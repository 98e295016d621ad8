"""Scores become zones in proportion to the prior and to the predicted scores."""

from __future__ import annotations

import numpy as np

from grammarlab.city.zone_learning import learned_zones
from grammarlab.city.zone_scores import ScoredZones, counts_of_scores
from tests.cases import takes_turns
from tests.city.towns import ZONES, divergence, sampled, three_rings, town

TOWN = town(1000)
ROWS = sampled(len(TOWN), 40, 0)
FIELDS = TOWN.take(ROWS)
PARCEL, ZONE = np.repeat(np.arange(40), 3), np.tile(np.arange(3), 40)


@takes_turns
def test_scores_in_proportion_to_the_truth_teach_the_truth():
    score = np.clip(100 * three_rings(FIELDS)[PARCEL, ZONE] + np.random.default_rng(0).normal(0, 4, 120), 0, 100)
    scored = ScoredZones(FIELDS, PARCEL, ZONE, score)
    counts = counts_of_scores(scored, np.ones(3))
    density = learned_zones(FIELDS, counts, ZONES, "0" * 64).density
    assert divergence(density.probabilities(TOWN), three_rings(TOWN)) < 0.02
    order = np.random.default_rng(1).permutation(120)
    shuffled = ScoredZones(FIELDS, PARCEL[order], ZONE[order], score[order])
    np.testing.assert_array_equal(counts_of_scores(shuffled, np.ones(3)), counts)


def test_equal_scores_leave_the_prior():
    scored = ScoredZones(FIELDS, PARCEL, ZONE, np.full(120, 50.0))
    counts = counts_of_scores(scored, np.array([2.0, 1.0, 1.0]))
    shares = counts / counts.sum(axis=1, keepdims=True)
    np.testing.assert_allclose(shares, np.tile([0.5, 0.25, 0.25], (40, 1)), atol=0.02)
