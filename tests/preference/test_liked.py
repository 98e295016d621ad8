"""What is liked, whoever says so."""

import numpy as np
import pytest

from grammarlab.preference.liked import MIN_SCORED, liked, liked_are_rare


def said(values, noise, seed):
    errors = noise * np.random.default_rng(seed).normal(size=len(values))
    return np.clip(values + errors, 0.0, 100.0)


@pytest.mark.parametrize("noise", [0.0, 10.0, 20.0])
def test_models_that_a_person_likes_rarely_are_rare_whatever_the_noise(noise):
    for seed in range(20):
        values = np.where(np.arange(200) % 50 == 49, 90.0, 0.0)
        scores = said(values, noise, seed)
        assert liked_are_rare(scores, noise)
        assert liked(scores, noise)[values > 0.0].mean() > 0.7
        often = np.where(np.arange(200) % 4 == 3, 90.0, 0.0)
        assert not liked_are_rare(said(often, noise, seed), noise)


def test_without_noise_whatever_is_above_nothing_is_liked():
    scores = np.array([0.0, 0.5, 40.0, 100.0])
    assert liked(scores, 0.0).tolist() == [False, True, True, True]


def test_noise_alone_is_liked_no_oftener_than_rare_models():
    scores = said(np.zeros(20_000), 15.0, 0)
    assert liked(scores, 15.0).mean() < 1 / 100
    assert liked(scores, 0.0).mean() > 0.45
    assert not liked_are_rare(scores[: MIN_SCORED - 1], 15.0)
