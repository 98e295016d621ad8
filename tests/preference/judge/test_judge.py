"""The judge: composed columns are accepted where scores need them, and only there."""

from math import comb

import numpy as np
import pytest

from grammarlab.preference.judge.judge import judged
from grammarlab.preference.judge.votes import votes
from grammarlab.preference.judge.weighted_sums import Measures
from tests.cases import some, takes_turns

KNOWN, FLAGS, COMPOSED = 36, 20, 100
NO_MEASURES = Measures(np.zeros((96, 0)), np.zeros(0))


def columns(num, seed):
    """Known columns, half of them flags, and composed ones."""
    randomness = np.random.default_rng(seed)
    known = np.column_stack([randomness.integers(0, 2, (num, FLAGS)), randomness.random((num, KNOWN - FLAGS))])
    composed = randomness.random((num, COMPOSED))
    composed[:, ::2] = composed[:, ::2] > 0.5
    return known.astype(float), composed


def verdict_of(known, composed, scores):
    return judged(
        known,
        composed,
        np.full(COMPOSED, np.log(2.0 * COMPOSED)),
        known[:, : min(FLAGS, known.shape[1])],
        Measures(known, np.full(known.shape[1], np.log(2.0 * max(known.shape[1], 1)))),
        scores,
    )


def noisy(values, noise, seed):
    randomness = np.random.default_rng(seed + 1000)
    return np.clip(values + randomness.normal(0.0, noise, len(values)), 0.0, 100.0).round()


TASTES = {
    "a composed flag": (lambda known, composed: 90.0 * composed[:, 10], {10}),
    "a band of a composed size": (lambda known, composed: 90.0 * (np.abs(composed[:, 11] - 0.5) < 0.2), {11}),
    "a graded composed size": (lambda known, composed: 100.0 * np.exp(-12.0 * (composed[:, 11] - 0.5) ** 2), {11}),
    "a composed flag under a known one": (lambda known, composed: 90.0 * known[:, 0] * composed[:, 10], {10}),
    "a known flag": (lambda known, composed: 90.0 * known[:, 3], set()),
    "points for known flags": (lambda known, composed: known[:, :3] @ [15.0, 30.0, 55.0], set()),
}


@pytest.mark.parametrize("noise", [0.0, 10.0])
@pytest.mark.parametrize("taste", some(list(TASTES)))
def test_what_scores_need_is_accepted(taste, noise):
    value, needed = TASTES[taste]
    known, composed = columns(96, seed=5)
    verdict = verdict_of(known, composed, noisy(value(known, composed), noise, seed=5))
    assert set(verdict.accepted) == needed
    assert not verdict.votes
    assert (verdict.total > verdict.known) == bool(needed)


@takes_turns
def test_flags_are_joined_where_scores_need_it():
    known, composed = columns(96, seed=6)
    either = verdict_of(known, composed, noisy(90.0 * (known[:, 4] != known[:, 9]), 10.0, seed=6))
    assert [(set(vote.flags), vote.odd) for vote in either.votes] == [({4, 9}, True)]
    three = verdict_of(known, composed, noisy(90.0 * (known[:, 10:15].sum(axis=1) >= 3), 10.0, seed=6))
    assert [(set(vote.flags), vote.odd) for vote in three.votes] == [({10, 11, 12, 13, 14}, False)]
    assert not either.accepted
    assert not three.accepted


def test_an_odd_number_of_flags_is_seen():
    known, composed = columns(96, seed=12)
    odd = verdict_of(known[:, :16], composed, noisy(90.0 * (known[:, [1, 3, 8, 9, 12]].sum(axis=1) % 2), 10.0, seed=12))
    assert [(set(vote.flags), vote.odd) for vote in odd.votes] == [({1, 3, 8, 9, 12}, True)]


def test_scores_without_a_pattern_need_nothing():
    """At most 5 % of files: the prices are the logs of probabilities."""
    accepting = 0
    for seed in some(range(24)):
        known, composed = columns((24, 48, 96)[seed % 3], seed)
        randomness = np.random.default_rng(seed)
        scores = randomness.permutation(noisy(90.0 * (composed[:, 11] > 0.6), (0.0, 15.0)[seed % 2], seed))
        verdict = verdict_of(known, composed, scores)
        accepting += bool(verdict.accepted or verdict.votes or verdict.sums)
    assert accepting <= 1


@pytest.mark.parametrize("num", [16, 24, 32])
def test_few_noisy_scores_of_two_values_need_no_vote_of_many_flags(num):
    """A vote that divides them by chance also says that there are two values, which is no pattern."""
    for seed in some(range(10)):
        flags = np.random.default_rng(seed).integers(0, 2, (num, 300)).astype(float)
        scores = noisy(np.repeat([100.0, 5.0], [2 * num // 5, num - 2 * num // 5]), 8.0, seed)
        verdict = judged(flags, flags[:, :0], np.zeros(0), flags, Measures(flags[:, :0], np.zeros(0)), scores)
        assert not verdict.votes


def test_equal_scores_need_nothing():
    known, composed = columns(30, seed=7)
    for score in (0.0, 50.0):
        verdict = verdict_of(known, composed, np.full(30, score))
        assert not verdict.accepted
        assert not verdict.votes
        assert not verdict.sums


@pytest.mark.parametrize("num", [1, 2])
def test_few_scores_need_nothing(num):
    known, composed = columns(num, seed=8)
    assert not verdict_of(known, composed, np.linspace(0.0, 90.0, num)).accepted


def test_a_column_costs_its_price():
    known, composed = columns(96, seed=9)
    scores = 90.0 * composed[:, 10]
    cheap, dear = (
        judged(known, composed, np.full(COMPOSED, price), known[:, :0], NO_MEASURES, scores) for price in (5.0, 8.0)
    )
    assert cheap.total - dear.total == pytest.approx(3.0)
    assert judged(known, composed, np.full(COMPOSED, 1e3), known[:, :0], NO_MEASURES, scores).accepted == ()


def test_dear_columns_that_explain_everything_do_not_hide_two_cheap_ones():
    randomness = np.random.default_rng(3)
    cheap = randomness.integers(0, 5, (256, 2)).astype(float)
    liked = (cheap == 4.0).all(axis=1)
    # Flags that are right but for one design, each for another.
    dear = np.repeat(liked[:, None], 40, axis=1).astype(float)
    dear[np.flatnonzero(~liked)[:40], np.arange(40)] = 1.0
    composed, prices = np.column_stack([dear, cheap]), np.append(np.full(40, 20.0), np.full(2, 6.0))
    none = np.zeros((256, 0))
    verdict = judged(randomness.random((256, 4)), composed, prices, none, Measures(none, np.zeros(0)), 100.0 * liked)
    assert verdict.accepted == (40, 41)


def test_the_order_of_labels_does_not_matter():
    known, composed = columns(64, seed=10)
    scores = noisy(90.0 * composed[:, 10], 10.0, seed=10)
    order = np.random.default_rng(0).permutation(64)
    first, second = verdict_of(known, composed, scores), verdict_of(known[order], composed[order], scores[order])
    assert first.accepted == second.accepted
    assert first.total == pytest.approx(second.total)


def test_votes_count_flags_at_the_price_of_their_choice():
    known, _ = columns(96, seed=11)
    flags = known[:, :12]
    held = np.asarray(flags[:, 0] + flags[:, 1] + (1.0 - flags[:, 2]), dtype=np.float64)
    found = votes(flags, 80.0 * (held >= 2.0).astype(np.float64))
    wanted = [vote for vote in found if set(vote.flags) == {0, 1, 2} and not vote.odd]
    numbers = [vote.values(flags) for vote in wanted]
    # The opposite flags count as well: the column is the number, or three less the number.
    assert any((number == held).all() or (number == 3.0 - held).all() for number in numbers)
    assert wanted[0].price == pytest.approx(np.log(3 * 4 * comb(12, 3) * 2**3))
    assert votes(flags, np.full(96, 3.0, dtype=np.float64)) == []
    assert votes(flags[:, :1], 80.0 * flags[:, 0]) == []
