"""Questions are those whose answers tell most about the whole map."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import softmax

from grammarlab.city.softmax_process import contrasts, evidence_of, fisher_information
from grammarlab.city.zone_learning import LearnedZones, learned_zones
from grammarlab.city.zone_questions import first_questions, next_questions
from tests.city.towns import ZONES, counts, sampled, three_rings, town

TOWN = town(300)


@pytest.fixture(scope="module")
def learned() -> LearnedZones:
    rows = sampled(len(TOWN), 24, 1)
    return learned_zones(TOWN.take(rows), counts(three_rings(TOWN.take(rows)), 1, wrong=0.2), ZONES, "0" * 64)


def test_the_first_question_leaves_the_smallest_expected_divergence(learned: LearnedZones):
    """By brute force: the covariance of the weights with one more answer, for each parcel."""
    answered = learned.design.rows(learned.fields)
    covariance = evidence_of(answered, learned.counts).covariance
    width = covariance.shape[1]
    precision = np.linalg.inv(covariance.reshape(2 * width, 2 * width))
    unasked = TOWN.take(~np.isin(TOWN.id.astype(str), learned.fields.id.astype(str)))
    rows = learned.design.rows(unasked)
    chance = softmax(rows @ learned.mode.weights @ contrasts(3).T, axis=1)
    information = fisher_information(chance, np.ones(len(rows)))

    def divergence(row: int) -> float:
        more = np.einsum("d,ab,e->adbe", rows[row], information[row], rows[row]).reshape(2 * width, 2 * width)
        after = np.linalg.inv(precision + more).reshape(2, width, 2, width)
        return float(np.einsum("iab,id,bdae,ie->", information, rows, after, rows, optimize=True))

    expected = min(range(len(rows)), key=divergence)
    best = next_questions(learned, TOWN, 1)[0]
    chosen = int(np.flatnonzero(unasked.id == best)[0])
    assert divergence(chosen) == pytest.approx(divergence(expected), rel=1e-6)


def test_questions_are_different_parcels_without_answers_in_any_order_of_rows(learned: LearnedZones):
    asked = next_questions(learned, TOWN, 20)
    assert len(set(asked)) == 20
    assert not set(asked) & set(learned.fields.id)
    order = np.random.default_rng(0).permutation(len(TOWN))
    assert next_questions(learned, TOWN.take(order), 20).tolist() == asked.tolist()
    assert next_questions(learned, TOWN, 5).tolist() == asked[:5].tolist()


def test_there_are_no_more_questions_than_parcels(learned: LearnedZones):
    assert len(next_questions(learned, learned.fields, 5)) == 0
    few = TOWN.take(~np.isin(TOWN.id.astype(str), learned.fields.id.astype(str))).take(np.arange(3))
    assert len(next_questions(learned, few, 10)) == 3
    assert len(first_questions(few, 10)) == 3
    assert len(first_questions(few.take(np.arange(0)), 10)) == 0


def test_first_questions_are_spread_over_the_map():
    asked = np.isin(TOWN.id, first_questions(TOWN, 16))
    nearest = np.hypot(*(TOWN.east_north[:, None] - TOWN.east_north[asked]).transpose(2, 0, 1)).min(axis=1)
    assert nearest.max() < 500.0
