"""One round of learning: the state is a function of the scores, whoever gave them, in whatever steps and order."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.learning.answers import Answers, answers_of
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.questions import ask
from grammarlab.learning.round import answered, init, step
from grammarlab.preference.blended import BlendedPreference
from grammarlab.preference.labels import Labels
from grammarlab.preference.liked import MIN_SCORED
from grammarlab.preference.queries import WAYS
from tests.cases import bulk, takes_turns
from tests.learning.bits import BITS, SIZE, BitsSpace, answers_about, score_of, study_of

STUDY = study_of()
POOL = tuple(STUDY.pool)


@cache
def learned(*models):
    """The state after exact scores of the first factor of these designs of the pool; a frozen value."""
    return step(STUDY, init(STUDY), [answers_about(STUDY, [POOL[model] for model in models])])


def predictions(study, state):
    """Of all liked factors together, of every design of the table."""
    assert state.product is not None
    return state.product.predict(study.table(state).rows).mean


@bulk(25)
@given(
    st.lists(st.integers(0, SIZE - 1), min_size=4, max_size=24, unique=True),
    st.lists(st.integers(0, 24), max_size=4),
    st.randoms(),
)
def test_neither_steps_nor_order_of_the_answers_matter(models, cuts, random):
    designs = [POOL[model] for model in models]
    whole = step(STUDY, init(STUDY), [answers_about(STUDY, designs)])
    if not whole.liked:
        return
    random.shuffle(designs)
    state, ends = init(STUDY), sorted({0, *cuts, len(designs)})
    for first, last in pairwise(ends):
        state = step(STUDY, state, [answers_about(STUDY, designs[first:last])])
    assert state.columns == whole.columns
    assert np.array_equal(predictions(STUDY, state), predictions(STUDY, whole))


@takes_turns
def test_a_person_who_has_seen_every_kind_of_design_is_understood():
    state = step(STUDY, init(STUDY), [answers_about(STUDY, POOL, factor) for factor in (0, 1)])
    true = score_of(STUDY.space.make(POOL)).prod(axis=1) / 100.0
    assert predictions(STUDY, state)[:SIZE] == pytest.approx(true, abs=0.5)


def test_a_preference_is_a_density_over_the_pool():
    study = study_of(BitsSpace(share=0.15))
    truth = 90.0 * (study.space.make(POOL)[:, :2].sum(axis=1) == 2.0)
    said = np.clip(truth + 10.0 * np.random.default_rng(0).normal(size=SIZE), 0.0, 100.0)[:40]
    state = step(study, init(study), [Answers("overall", POOL[:40], said)])
    found = state.preferences["overall"]
    assert isinstance(found, BlendedPreference)
    assert 0.0 < found.share < 1.0
    rows = study.table(state).rows
    again = found.for_density(rows, study.tables().pool_designs.weights)
    assert found.density == again.density
    np.testing.assert_array_equal(found.predict(rows).mean, again.predict(rows).mean)


def test_designs_from_elsewhere_are_learned_from_like_those_of_the_pool():
    outside = [POOL[0]._replace(seed=99, model=model) for model in range(40)]
    state = step(STUDY, init(STUDY), [answers_about(STUDY, outside)])
    assert state.columns.elsewhere == tuple(sorted(outside))
    true = score_of(STUDY.space.make(POOL))[:, 0]
    assert predictions(STUDY, state)[:SIZE] == pytest.approx(true, abs=5.0)
    assert len(STUDY.table(state).rows) == SIZE + len(outside)


@takes_turns
def test_factors_without_a_liked_design_are_left_out_of_the_product():
    nothing = Answers("nothing", POOL[:9], np.zeros(9))
    state = step(STUDY, init(STUDY), [nothing])
    assert state.product is None
    both = step(STUDY, state, [answers_about(STUDY, POOL[:20])])
    alone = learned(*range(20))
    assert both.liked == ("factor 0",)
    assert set(both.preferences) == {"nothing", "factor 0"}
    assert np.array_equal(predictions(STUDY, both), predictions(STUDY, alone))


@pytest.mark.parametrize(("grows", "length", "columns"), [(True, 2, BITS), (False, 1, BITS - 1)])
def test_equal_designs_with_different_scores_make_paths_longer(grows, length, columns):
    study = study_of(path_length=1, grows=grows)
    state = step(study, init(study), [answers_about(study, POOL[:64])])
    assert state.columns.path_length == length
    assert study.table(state).rows.shape[1] == columns


def test_paths_that_never_tell_designs_apart_stay_as_short_as_possible():
    study = study_of(BitsSpace(blind=True), path_length=1)
    assert step(study, init(study), [answers_about(study, POOL[:64])]).columns.path_length == 1


def test_contradictions_are_no_reason_for_longer_paths():
    study = study_of(path_length=1)
    twice = Answers("factor 0", POOL[:8] * 2, np.append(np.zeros(8), np.full(8, 90.0)))
    state = step(study, init(study), [twice])
    assert state.columns.path_length == 1
    assert predictions(study, state)[:8] == pytest.approx(np.full(8, 45.0), abs=1.0)


@takes_turns
@pytest.mark.parametrize("widens", [True, False])
def test_the_pool_is_widened_once_liked_designs_are_rare(widens):
    study = study_of(widens=widens)
    few = step(study, init(study), [Answers("factor 0", POOL[: MIN_SCORED - 1], np.zeros(MIN_SCORED - 1))])
    assert not few.wide
    state = step(study, few, [Answers("factor 0", POOL[MIN_SCORED - 1 : MIN_SCORED], np.zeros(1))])
    assert state.wide == widens
    assert len(study.table(state).rows) == (SIZE - SIZE // 5 + 10 * (SIZE // 5) if widens else SIZE)
    chosen = ask(study, state, 16, 0, factor="factor 0")
    assert any(address not in POOL for address in chosen) == widens
    assert step(study, few, [Answers("factor 0", POOL[-2:], np.zeros(2))], widens=False).wide is False


@takes_turns
def test_noise_does_not_hide_that_liked_designs_are_rare():
    study, num = study_of(), MIN_SCORED + 16
    scores = np.clip(10.0 * np.random.default_rng(0).normal(size=num), 0.0, 100.0)
    assert (scores > 0.0).mean() > 0.4
    assert step(study, init(study), [Answers("factor 0", POOL[:num], scores)]).wide
    liked = np.clip(scores + 80.0 * (np.arange(num) % 3 == 0), 0.0, 100.0)
    assert not step(study, init(study), [Answers("factor 0", POOL[:num], liked)]).wide


def test_a_wider_pool_begins_with_the_pool():
    narrow, wide = STUDY.tables(), STUDY.tables(wide=True)
    common = [place for place, address in enumerate(wide.addresses) if address in narrow.index]
    assert tuple(wide.addresses[place] for place in common) == narrow.addresses
    assert common == list(range(SIZE))
    assert all(
        np.array_equal(a, b) for a, b in zip(narrow.pool_designs.batches, wide.pool_designs.batches, strict=False)
    )


def test_a_preference_is_fitted_again_only_where_its_answers_or_columns_changed():
    first = step(STUDY, init(STUDY), [answers_about(STUDY, POOL[:20], factor) for factor in (0, 1)])
    again = step(STUDY, first, [answers_about(STUDY, POOL[20:24], 1)])
    assert again.preferences["factor 0"] is first.preferences["factor 0"]
    assert again.preferences["factor 1"] is not first.preferences["factor 1"]


@pytest.mark.parametrize("way", [way for way in WAYS if way != "already ranked"])
@pytest.mark.parametrize("factor", ["factor 0", ""])
def test_questions_are_different_designs_of_the_pool_that_have_no_answer(way, factor):
    asked = answers_about(STUDY, POOL[10:30])
    for state in (answered(init(STUDY), [asked]), learned(*range(10, 30))):
        chosen = ask(STUDY, state, 24, 3, factor=factor, way=way)
        assert len(set(chosen)) == 24
        assert set(chosen) <= set(POOL)
        if factor or state.product is not None:
            assert not set(chosen) & set(asked.designs)
        assert chosen == ask(STUDY, state, 24, 3, factor=factor, way=way)


def test_there_are_no_more_questions_than_designs():
    state = answered(init(STUDY), [answers_about(STUDY, POOL[:-3])])
    assert sorted(ask(STUDY, state, 16, 0, factor="factor 0")) == sorted(POOL[-3:])


def test_answers_that_surprise_most_are_asked_again_first_also_those_from_elsewhere():
    outside = POOL[0]._replace(seed=7)
    given = answers_about(STUDY, [*POOL[:60], outside])
    state = step(STUDY, init(STUDY), [given])
    given.scores[-1] = 100.0 - given.scores[-1]
    wrong = answered(init(STUDY), [given])
    state = replace(state, answers=wrong.answers)
    assert ask(STUDY, state, 3, 0, factor="factor 0", way="already ranked")[0] == outside


def comparisons_of(designs, others):
    """Labels of somebody who compares pairs of designs exactly."""
    own, other = (score_of(STUDY.space.make(some))[:, 0] for some in (designs, others))
    labels = []
    for one, two, gain in zip(designs, others, (own - other).tolist(), strict=True):
        better, worse = (one, two) if gain >= 0.0 else (two, one)
        place = f'{{"seed":{worse.seed},"model":{worse.model},"grammar":"{STUDY.space.hashes[worse.flat]}"}}'
        label = better.label("overall", 100.0 if gain else 50.0, STUDY.space.hashes)
        labels.append(replace(label, kind="rather" if gain else "tie", other=place))
    return Labels(tuple(labels))


@takes_turns
def test_comparisons_in_a_label_table_are_learned_from_beside_scores():
    scored = Labels(
        tuple(
            address.label("overall", score, STUDY.space.hashes)
            for address, score in zip(POOL[:6], score_of(STUDY.space.make(POOL[:6]))[:, 0].tolist(), strict=True)
        )
    )
    elsewhere = POOL[0]._replace(seed=99)
    labels = scored + comparisons_of(POOL[20:80], (*POOL[100:159], elsewhere))
    told = answers_of(labels, STUDY.space.hashes)
    state = step(STUDY, init(STUDY), told)
    assert state.num_answers == len(labels)
    assert state.columns.elsewhere == (elsewhere,)
    true = score_of(STUDY.space.make(POOL))[:, 0]
    found = predictions(STUDY, state)[:SIZE]
    assert np.corrcoef(found, true)[0, 1] > 0.95
    assert len(ask(STUDY, state, 8, 0)) == 8


def test_comparisons_alone_are_enough_to_go_on():
    (told,) = answers_of(comparisons_of(POOL[20:40], POOL[100:120]), STUDY.space.hashes)
    state = step(STUDY, init(STUDY), [told])
    assert state.liked == ("overall",)
    assert told.scored.designs == ()
    assert len(told.mentioned) == 40
    assert len(set(ask(STUDY, state, 8, 0))) == 8


def test_answers_of_several_kinds_are_joined_in_order():
    (told,) = answers_of(comparisons_of(POOL[:3], POOL[3:6]), STUDY.space.hashes)
    plain = Answers("overall", POOL[:2], np.array([3.0, 4.0]))
    both = plain + told
    assert both.kinds == ("score", "score", *told.kinds)
    assert both.others == (None, None, *told.others)
    assert both.scored.designs == POOL[:2]
    assert not Answers("overall", POOL[:1], np.array([50.0]), ("tie",), (POOL[1],)).is_liked
    assert isinstance(told.others[0], Address)
