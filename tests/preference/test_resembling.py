"""Models like the few liked ones: when they are asked about, and which."""

import numpy as np

from grammarlab.preference import blended
from grammarlab.preference.liked import FEW_LIKED, most_similar, most_unexplained, surely_liked
from tests.preference.rows import bits


def judged(num_liked, num_random=0, seed=0):
    """Rows of 40 disliked designs, some liked ones with four bits of ten, and some disliked ones with random scores."""
    rows = bits(4000, 10, seed)
    liked = rows[:, :4].sum(axis=1) == 4.0
    asked = np.concatenate([np.flatnonzero(~liked)[: 40 + num_random], np.flatnonzero(liked)[:num_liked]])
    scores = np.where(liked[asked], 90.0, 0.0)
    scores[40 : 40 + num_random] = 75.0
    return rows, asked, scores


def test_liked_models_are_sure_but_for_a_first_one_that_may_be_a_blunder():
    found = []
    for num_liked in (0, 1, FEW_LIKED - 1, FEW_LIKED + 2):
        rows, asked, scores = judged(num_liked)
        sure = surely_liked(blended.fit(rows[asked], scores), rows[asked], scores)
        assert not sure[scores == 0.0].any()
        found.append(np.count_nonzero(sure))
    assert (found[0], found[3]) == (0, FEW_LIKED + 2)
    assert found == sorted(found)


def test_random_scores_are_not_liked_models():
    rows, asked, scores = judged(0, num_random=FEW_LIKED)
    preference = blended.fit(rows[asked], scores)
    assert preference.partition.predict(rows[asked]).mean.max() < 20.0
    assert not surely_liked(preference, rows[asked], scores).any()


def test_models_most_alike_share_what_liked_models_share():
    rows, asked, scores = judged(2)
    allowed = np.ones(len(rows), dtype=bool)
    allowed[asked] = False
    found = most_similar(rows, asked, scores, 12, allowed, np.random.default_rng(0))
    assert len(np.unique(found)) == 12
    assert allowed[found].all()
    distance = np.abs(rows[found][:, None] - rows[asked[scores > 0.0]]).sum(axis=2).min(axis=1)
    assert distance.max() <= 1.0


def test_no_more_models_than_there_are():
    rows, asked, scores = judged(1)
    allowed = np.zeros(len(rows), dtype=bool)
    allowed[[7, 9]] = True
    assert sorted(most_similar(rows, asked, scores, 8, allowed, np.random.default_rng(0)).tolist()) == [7, 9]


def errs(num_rare):
    """Rows of 90 designs scored with noise: a tenth is liked, and some of a rare kind are worth half as much."""
    rows = bits(4000, 12, 0)
    liked, rare = (rows[:, :3].sum(axis=1) == total for total in (3.0, 0.0))
    rare &= rows[:, 3:6].sum(axis=1) == 0.0
    known = [np.flatnonzero(~liked & ~rare)[:78], np.flatnonzero(liked)[:12], np.flatnonzero(rare)[:num_rare]]
    asked = np.concatenate(known)
    value = np.select([liked, rare], [80.0, 40.0], 0.0)
    scores = np.clip(value[asked] + np.random.default_rng(1).normal(0.0, 10.0, len(asked)), 0.0, 100.0)
    allowed = np.ones(len(rows), dtype=bool)
    allowed[asked] = False
    return rows, asked, scores, allowed, rare


def test_a_rare_liked_kind_that_cells_take_for_errors_is_asked_about_again():
    rows, asked, scores, allowed, rare = errs(num_rare=1)
    preference = blended.fit(rows[asked], scores)
    assert preference.partition.predict(rows[asked[-1:]]).mean < 20.0
    found = most_unexplained(preference, rows, asked, scores, 8, allowed, np.random.default_rng(0))
    assert allowed[found].all()
    assert len(np.unique(found)) == 8
    assert rare[found].mean() > 10.0 * rare.mean()


def test_scores_that_cells_explain_lead_to_no_questions():
    rows, asked, scores, allowed, _ = errs(num_rare=0)
    exact = np.where(scores > 50.0, 80.0, 0.0)
    preference = blended.fit(rows[asked], exact)
    assert not len(most_unexplained(preference, rows, asked, exact, 8, allowed, np.random.default_rng(0)))
