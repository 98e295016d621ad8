from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from grammarlab.baselines import gaussian_process
from grammarlab.errors import UsageError
from grammarlab.preference import blended, queries
from grammarlab.preference.base import LIKED_SHARE
from grammarlab.preference.liked import FEW_LIKED, MIN_SCORED, RARE_SHARE, liked_are_rare
from grammarlab.preference.processes.posterior import squared_distances
from grammarlab.preference.queries import WAYS, Situation, propose
from tests.cases import some, takes_turns
from tests.preference.processes.test_grouped import GROUPS, styled_rows

NEW_WAYS = [way for way in WAYS if way != "already ranked"]


def by_process(rows, scores, groups=None):
    """What the default learns where a process explains it best."""
    return replace(blended.fit(rows, scores, groups=groups), share=1.0)


@cache
def situation(num_pool=80, num_asked=20, method="blended", scores=None):
    """A pool whose last fifth comes from a flattened grammar, and some of the rest scored."""
    rows, truth = styled_rows(num_pool, seed=1)
    asked = np.random.default_rng(0).choice(int(0.8 * num_pool), num_asked, replace=False)
    known = truth[asked] if scores is None else np.full(num_asked, scores)
    fit = {"blended": by_process, "paper": gaussian_process.fit}.get(method)
    preference = fit(rows[asked], known, groups=GROUPS) if fit and num_asked else None
    return Situation(rows, np.arange(num_pool) < 0.8 * num_pool, asked, known, preference)


@pytest.fixture(scope="module", params=["none", "paper", "blended"])
def known(request):
    return situation(method=request.param)


@pytest.mark.parametrize("way", NEW_WAYS)
def test_every_way_gives_different_models_without_a_score(way, known):
    chosen = propose(way, known, 16, seed=0)
    assert chosen.shape == (16,)
    assert len(np.unique(chosen)) == 16
    assert not np.isin(chosen, known.scored).any()


@pytest.mark.parametrize("way", WAYS)
def test_the_same_seed_gives_the_same_models_and_changes_nothing(way, known):
    before = known.pool.copy(), known.scored.copy()
    np.testing.assert_array_equal(propose(way, known, 6, seed=5), propose(way, known, 6, seed=5))
    np.testing.assert_array_equal(known.pool, before[0])
    np.testing.assert_array_equal(known.scored, before[1])


@pytest.mark.parametrize("way", WAYS)
def test_a_pool_that_ends_gives_all_it_has(way, known):
    left = np.setdiff1d(np.arange(80), known.scored) if way != "already ranked" else np.sort(known.scored)
    np.testing.assert_array_equal(np.sort(propose(way, known, 1000, seed=1)), left)
    assert not len(propose(way, known, 0, seed=1))


@pytest.mark.parametrize("way", ["grammar", "density", "uncertainty"])
def test_samples_of_the_grammar_come_before_those_of_a_flattened_one(way, known):
    num = int(known.from_grammar.sum()) - len(known.scored)
    assert known.from_grammar[propose(way, known, num, seed=2)].all()


def test_grammar_draws_alike_from_all_samples():
    known = replace(situation(num_asked=0, method="none"), preference=None)
    times = np.bincount(np.concatenate([propose("grammar", known, 8, seed) for seed in range(400)]), minlength=80)
    assert not times[64:].any()
    np.testing.assert_allclose(times[:64], 50.0, atol=5.0 * np.sqrt(50.0))


def test_uniform_takes_the_farthest_model_each_time():
    known = situation()
    assert isinstance(known.preference, blended.BlendedPreference)
    weights = known.preference.column_weights()
    near = list(known.scored)
    for index in propose("uniform", known, 8, seed=0):
        squared = ((known.pool[:, None] - known.pool[near]) ** 2 @ weights).min(axis=1)
        assert squared[index] == pytest.approx(squared.max())
        near.append(index)


def test_uniform_compares_a_block_of_models_with_all_scored_ones_at_once(monkeypatch):
    known, sizes = situation(), []

    def noted(rows, others):
        sizes.append((len(rows), len(others)))
        return squared_distances(rows, others)

    monkeypatch.setattr(queries, "squared_distances", noted)
    whole = propose("uniform", known, 8, seed=0)
    assert sizes == [(80, 20), *[(80, 1)] * 8]
    sizes.clear()
    monkeypatch.setattr(queries, "BATCH", 32)
    np.testing.assert_array_equal(propose("uniform", known, 8, seed=0), whole)
    assert sizes[:3] == [(32, 20), (32, 20), (16, 20)]


def test_density_shows_one_half_liked_and_one_half_disliked():
    known = situation(num_pool=400, num_asked=60)
    assert known.preference is not None
    mean = known.preference.predict(known.pool).mean
    chosen = propose("density", known, 40, seed=0)
    assert mean[chosen[:20]].min() > 10.0
    assert mean[chosen[20:]].mean() < 20.0


def test_uncertainty_prefers_models_that_are_hard_to_predict():
    known = situation(num_pool=400, num_asked=12)
    assert known.preference is not None
    std = known.preference.predict(known.pool).std
    chosen = np.concatenate([propose("uncertainty", known, 16, seed) for seed in range(20)])
    assert std[chosen].mean() > std[known.from_grammar].mean()


def test_already_ranked_begins_with_the_score_that_looks_like_a_mistake():
    known = situation(num_asked=60)
    scores = known.scores.copy()
    wrong = int(np.flatnonzero(scores == 80.0)[0])
    scores[wrong] = 0.0
    preference = by_process(known.pool[known.scored], scores, groups=GROUPS)
    # Rows repeat in this pool, so that the others of this kind speak against it.
    found = propose("already ranked", replace(known, scores=scores, preference=preference), 3, seed=0)
    kind = known.pool[:, :6]
    assert (kind[found[0]] == kind[known.scored[wrong]]).all()


def test_the_default_looks_elsewhere_for_rare_models_while_nothing_is_liked():
    known = situation(scores=0.0)
    chosen = propose("default", known, 16, seed=0)
    assert (~known.from_grammar[chosen]).sum() >= round(queries._LIKING_SHARE * 16) // 2
    assert known.from_grammar[chosen].any()


def test_the_default_goes_on_with_rare_models_where_they_hold_all_that_is_liked():
    rows = np.array([[i >> k & 1 for k in range(5)] for i in range(32)], dtype=float)
    pool = np.concatenate([rows[[0] * 40], rows])
    scores = 100.0 * (pool.sum(axis=1) == 5)
    rare = np.arange(len(pool)) >= 40
    asked = np.array([0, 1, 2, 3, len(pool) - 1, len(pool) - 2])
    preference = by_process(pool[asked], scores[asked], groups=np.arange(5))
    weights = 0.9 ** (5 - pool.sum(axis=1)) * 0.1 ** pool.sum(axis=1)
    known = Situation(pool, ~rare, asked, scores[asked], preference, weights)
    chosen = propose("default", known, 8, seed=0)
    assert rare[chosen].sum() >= round(queries._LIKING_SHARE * 8)
    assert not rare[propose("default", replace(known, weights=None), 8, seed=0)].all()


@takes_turns
def test_the_default_asks_about_what_lowers_the_error_more_than_chance():
    def error(way, seed):
        rows, truth = styled_rows(300, seed=20 + seed)
        asked = np.arange(12)
        for number in range(2):
            preference = by_process(rows[asked], truth[asked], groups=GROUPS)
            known = Situation(rows, np.ones(300, dtype=bool), asked, truth[asked], preference)
            asked = np.concatenate((asked, propose(way, known, 6, seed=number)))
        found = by_process(rows[asked], truth[asked], groups=GROUPS)
        return np.abs(found.predict(rows).mean - truth).mean()

    chance, chosen = (np.mean([error(way, seed) for seed in some(range(3))]) for way in ("grammar", "default"))
    assert chosen < chance / 2.0


def test_an_unknown_way_is_answered_with_the_known_ones():
    with pytest.raises(UsageError, match=r"'magic'; expected one of default, uniform"):
        propose("magic", situation(num_asked=4), 1, seed=0)  # ty: ignore[invalid-argument-type]  # pyright: ignore[reportArgumentType]


def test_models_that_once_were_rare_stay_rare():
    randomness = np.random.default_rng(0)
    for share in (0.0, 0.03, 0.06, 0.09, 0.5):
        scores = np.where(randomness.random(300) < share, 70.0, 0.0)
        answers = [liked_are_rare(scores[:n]) for n in range(301)]
        expected = [any((scores[:k] > 0).mean() < RARE_SHARE for k in range(MIN_SCORED, n + 1)) for n in range(301)]
        assert answers == expected == sorted(answers)


@cache
def rare_situation(num_liked, num_asked=MIN_SCORED):
    """A pool in which models with three bits of twelve are liked, and some scored ones, the liked ones last."""
    rows = np.random.default_rng(3).integers(0, 2, (1600, 12)).astype(float)
    truth = 100.0 * (rows[:, :3].sum(axis=1) == 3) * (rows[:, 3:6].sum(axis=1) == 0)
    asked = np.concatenate([np.flatnonzero(truth == 0)[: num_asked - num_liked], np.flatnonzero(truth)[:num_liked]])
    preference = by_process(rows[asked], truth[asked])
    return Situation(rows, np.arange(1600) < 1200, asked, truth[asked], preference), truth


def test_where_liked_models_are_rare_others_like_the_few_known_ones_are_asked_about():
    known, truth = rare_situation(num_liked=1)
    assert (truth > 0).mean() < 0.03
    assert (truth[propose("default", known, 16, seed=0)] > 0).sum() >= 2


def test_while_all_high_scores_may_be_random_one_half_of_the_questions_looks_for_what_is_liked():
    known, _ = rare_situation(num_liked=0)
    scores = known.scores.copy()
    scores[::16] = (70.0, 20.0, 45.0, 30.0)
    known = replace(known, scores=scores, preference=by_process(known.pool[known.scored], scores))
    chosen = propose("default", known, 16, seed=0)
    assert np.count_nonzero(~known.from_grammar[chosen[8:]]) >= 4
    distance = np.abs(known.pool[chosen][:, None] - known.pool[known.scored[::16]]).sum(axis=2).min(axis=1)
    assert distance[:8].mean() < distance[8:].mean() - 1.0


def test_where_nothing_is_liked_for_long_only_models_from_elsewhere_are_asked_about():
    known, _ = rare_situation(num_liked=0)
    assert not known.from_grammar[propose("default", known, 16, seed=0)].any()
    before, _ = rare_situation(num_liked=0, num_asked=MIN_SCORED - 1)
    assert known.from_grammar[propose("default", before, 16, seed=0)].any()


def test_where_liked_models_are_rare_the_likeliest_ones_from_elsewhere_are_candidates():
    known, _ = rare_situation(num_liked=FEW_LIKED, num_asked=80)
    assert known.preference is not None
    assert liked_are_rare(known.scores)
    mean = known.preference.predict(known.pool).mean
    chosen = propose("default", known, 16, seed=0)
    # The first ones are about models with scores above what is expected, whatever is predicted for them.
    first, others = np.split(chosen, [queries._one_in(queries._QUESTIONS_PER_RANDOM, 16)])
    left = np.setdiff1d(np.flatnonzero(~known.from_grammar), np.append(known.scored, first))
    worst = np.sort(mean[left])[-200]
    assert (mean[others[~known.from_grammar[others]]] >= worst - 1e-9).all()


def test_one_of_eight_questions_is_about_a_model_at_random():
    rows = np.random.default_rng(7).integers(0, 2, (300, 8)).astype(float)
    rows[100:, :] = 0.0  # the scores known of such models leave nothing to learn from another one
    truth = 100.0 * rows[:, 0] * rows[:, 1]
    asked = np.concatenate([np.arange(40), np.arange(100, 110)])
    preference = replace(blended.fit(rows[asked], truth[asked]), share=0.0)
    known = Situation(rows, np.ones(300, dtype=bool), asked, truth[asked], preference)
    chosen = np.array([propose("default", known, 8, seed) for seed in range(16)])
    of_known_kind = (chosen >= 100).sum(axis=1)
    assert of_known_kind.max() == 1
    # 190 of the 250 models without a score are of this kind.
    assert of_known_kind.mean() > 0.5
    many = [(propose("default", known, 24, seed) >= 100).sum() for seed in range(4)]
    assert max(many) == 2  # the process chooses some of the 24


def test_where_the_grammar_makes_hardly_any_liked_model_half_of_the_questions_are_about_models_that_seem_liked():
    randomness = np.random.default_rng(5)
    own = (randomness.random((1600, 10)) < 0.1).astype(float)
    own[:, :4] *= own[:, [0]] == 0.0  # the grammar makes none of the liked models
    elsewhere = randomness.integers(0, 2, (400, 10)).astype(float)
    pool, from_grammar = np.concatenate([own, elsewhere]), np.arange(2000) < 1600
    truth = 90.0 * (pool[:, :4].sum(axis=1) == 4.0)
    liked, others = np.flatnonzero(truth), np.flatnonzero(truth == 0.0)
    asked = np.concatenate([randomness.permutation(others)[:50], liked[:6]])
    scores = np.clip(truth[asked] + 10.0 * randomness.normal(size=56), 0.0, 100.0)
    preference = blended.fit(pool[asked], scores)
    known = Situation(pool, from_grammar, asked, scores, preference, np.where(from_grammar, 1.0, 1e-3))
    meant = preference.predict(pool).mean
    chosen = propose("default", known, 16, seed=0)
    assert (meant[chosen] > LIKED_SHARE * meant.max()).sum() >= 6
