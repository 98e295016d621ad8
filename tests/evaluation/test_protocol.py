from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.distance import jensenshannon

from grammarlab.errors import UsageError
from grammarlab.evaluation import protocol
from grammarlab.evaluation.respondents import CHANGE, EXACT, RESPONDENTS
from grammarlab.learning import interview as rounds_of
from grammarlab.learning.interview import interview
from grammarlab.learning.round import init
from grammarlab.preference.liked import MIN_SCORED
from tests.cases import some, takes_turns
from tests.evaluation.doubles import LABELLED, POOL, world
from tests.learning.bits import score_of

BATCH = 16
QUICK = {"fit": "kde", "query": "density", "warm": True}
"""A quick learner, for what does not depend on the learner."""


@takes_turns
def test_a_learner_that_has_seen_every_kind_of_model_is_exact():
    material = world()
    _, curve = protocol.run(material, POOL // 3, seed=1, max_labels=POOL)
    assert curve.points[-1].js == pytest.approx(0, abs=1e-4)
    assert curve.points[-1].correlation == pytest.approx(1, abs=1e-3)
    assert material.js_original > 0.05


def test_equal_seeds_give_equal_curves_and_other_seeds_others():
    curves = [protocol.run(world(), BATCH, seed, 32)[1] for seed in (5, 5, 6)]
    assert curves[0] == curves[1] != curves[2]


@takes_turns
def test_what_other_persons_said_before_does_not_matter():
    shared = world()
    protocol.run(shared, BATCH, 5, BATCH)
    assert protocol.run(shared, BATCH, 6, 32)[1] == protocol.run(world(), BATCH, 6, 32)[1]


def test_a_curve_for_fewer_labels_is_the_beginning_of_a_longer_one():
    long = protocol.run(world(2, **QUICK), BATCH, 3, 48)[1]
    assert protocol.run(world(2, **QUICK), BATCH, 3, 32)[1] == long.until(32)


def test_the_last_round_is_cut_to_the_labels_that_are_left():
    _, curve = protocol.run(world(**QUICK), BATCH, 0, 40)
    assert [point.labels for point in curve.points] == [16, 32, 40]


def test_a_run_ends_when_every_model_of_the_pool_has_a_score_for_every_factor():
    material = world(2, **QUICK)
    state, curve = protocol.run(material, 64, 0, 10_000)
    assert curve.points[-1].labels == 2 * POOL
    assert all(sorted(answers.designs) == list(material.study.pool) for answers in state.answers.values())


def test_rounds_take_the_factors_in_turn_and_the_product_is_learned():
    material = world(2, **QUICK)
    state = init(material.study)
    states = interview(material.study, material.factors, material.person, budget=64, batch=16, seed=7)
    for rounds, state in enumerate(states):
        asked = [len(state.answers[name].designs) for name in material.factors[: rounds + 1]]
        assert asked == [16 * (rounds // 2 + 1), 16 * ((rounds + 1) // 2)][: len(asked)]
    product = np.ones(LABELLED)
    for number, name in enumerate(material.factors):
        answers = state.answers[name]
        true = score_of(material.study.space.make(answers.designs))[:, number]
        assert np.array_equal(answers.scores, true)
        mean = state.preferences[name].predict(material.study.table(state).others).mean
        product *= np.clip(mean, 0, 100) / 100
    assert np.allclose(protocol.learned(material, state), product)


def test_the_divergence_is_that_of_the_normalized_weights_and_before_learning_that_of_the_grammar():
    weights = np.random.default_rng(3).uniform(0.1, 2, LABELLED)
    material = world(2, weights=weights, **QUICK)
    target = weights * material.scores.prod(axis=1)
    assert material.js_original == pytest.approx(jensenshannon(target, weights) ** 2)
    state, curve = protocol.run(material, BATCH, 0, 32)
    current = weights * protocol.learned(material, state)
    assert curve.points[-1].js == pytest.approx(jensenshannon(target, current) ** 2)
    assert curve.points[-1].correlation == pytest.approx(np.corrcoef(target, current)[0, 1])
    assert protocol.learned(material, init(material.study)).tolist() == [1.0] * LABELLED


def test_a_person_may_score_the_product_of_all_factors():
    material = world(2)
    whole = material.as_one_factor()
    assert whole.factors == ("factor 0 x factor 1",)
    assert np.allclose(whole.target, material.target)
    state, _ = protocol.run(whole, BATCH, 0, 32)
    (answers,) = state.answers.values()
    assert np.allclose(answers.scores, score_of(material.study.space.make(answers.designs)).prod(axis=1) / 100)


@takes_turns
def test_a_wider_pool_is_offered_once_liked_models_are_rare():
    def rarely(rows):
        return np.column_stack([100.0 * (rows.sum(axis=1) == 0), np.ones(len(rows))])

    for widens in (False, True):
        material = world(score=rarely, widens=widens, path_length=1)
        state, curve = protocol.run(material, BATCH, 0, MIN_SCORED + BATCH)
        asked = next(iter(state.answers.values()))
        assert state.wide == (widens and curve.points[MIN_SCORED // BATCH - 1].liked < MIN_SCORED / 16)
        assert len(asked.designs) == MIN_SCORED + BATCH


def answers_of(state):
    (answers,) = state.answers.values()
    return answers


def test_an_exact_person_changes_nothing():
    state, curve = protocol.run(world(**QUICK), BATCH, 5, 32)
    exact, same = protocol.run(world(**QUICK).answered_by(EXACT, 5), BATCH, 5, 32)
    assert same == curve
    assert answers_of(exact).scores.tolist() == answers_of(state).scores.tolist()


def test_a_person_with_noise_gives_the_same_scores_again_and_is_measured_against_the_truth():
    noisy = world(**QUICK).answered_by(RESPONDENTS["sd10"], 5)
    assert np.array_equal(noisy.scores, world().scores)
    state, curve = protocol.run(noisy, BATCH, 5, 32)
    again, same = protocol.run(world(**QUICK).answered_by(RESPONDENTS["sd10"], 5), BATCH, 5, 32)
    assert same == curve
    answers = answers_of(state)
    assert answers_of(again).scores.tolist() == answers.scores.tolist()
    # By hand: models are shown in the order of their addresses, and the n-th of all has the n-th noise.
    for start in range(0, 32, BATCH):
        part = sorted(zip(answers.designs[start : start + BATCH], answers.scores[start : start + BATCH], strict=True))
        true = score_of(noisy.study.space.make([design for design, _ in part]))[:, :1]
        expected = RESPONDENTS["sd10"].answers(true, 5, start)[:, 0]
        assert [score for _, score in part] == expected.tolist()
        assert (expected != true[:, 0]).any()


def test_each_answer_has_noise_of_its_own_when_the_same_model_is_asked_about_again(monkeypatch):
    material = world().answered_by(RESPONDENTS["sd10"], 5)
    liked = next(one for one in material.study.pool if 20 < world().true_scores([one])[0, 0] < 80)
    monkeypatch.setattr(rounds_of, "ask", lambda *_arguments, **_options: (liked,) * 8)
    state, _ = protocol.run(material, 8, 5, 24)
    answers = answers_of(state)
    assert answers.designs == (liked,) * 24
    true = world().true_scores([liked] * 24)
    assert len(set(answers.scores.tolist())) == 24
    assert answers.scores.tolist() == RESPONDENTS["sd10"].answers(true, 5, 0)[:, 0].tolist()


def test_what_stars_mean_is_what_there_is_to_learn():
    def graded(rows):
        return np.column_stack([100.0 * rows.mean(axis=1), np.full(len(rows), 60.0)])

    stars = RESPONDENTS["stars"]
    material = world(2, score=graded)
    answered = material.answered_by(stars, 1)
    assert np.array_equal(answered.scores, stars.truth(material.scores))
    assert np.array_equal(answered.target, stars.truth(material.scores).prod(axis=1) / 1e4)
    assert answered.js_original != material.js_original
    product = material.as_one_factor()
    assert np.array_equal(product.answered_by(stars, 1).scores, stars.truth(product.scores))


def test_a_preference_that_stars_cannot_express_is_refused():
    with pytest.raises(UsageError, match="person stars: none of the 300 labelled models has a score above 0"):
        world(score=lambda rows: 12.0 * score_of(rows) / 100.0).answered_by(RESPONDENTS["stars"], 1)


@takes_turns
def test_nothing_but_scores_reaches_the_learner():
    material = world()
    state, curve = protocol.run(material, BATCH, 5, 48)

    def liar(addresses, numbers):
        return np.where(numbers[:, None] < 16, 1.0, -1.0) * (material.person(addresses, numbers) - 50.0) + 50.0

    other = replace(material, scores=100.0 - material.scores)
    same, measured = protocol.run(other, BATCH, 5, 48)
    assert answers_of(same).designs == answers_of(state).designs
    assert [point.js for point in measured.points] != [point.js for point in curve.points]
    lied_to, _ = protocol.run(replace(other, person=liar), BATCH, 5, 48)
    # What is asked in a round follows from the scores of the rounds before.
    assert answers_of(lied_to).designs[:32] == answers_of(state).designs[:32]
    assert answers_of(lied_to).designs[32:] != answers_of(state).designs[32:]


@takes_turns
def test_models_count_as_liked_whatever_a_person_who_errs_says():
    for respondent in (RESPONDENTS["sd20"], RESPONDENTS["blunders10"]):
        material = world(**QUICK).answered_by(respondent, 3)
        state, curve = protocol.run(material, BATCH, 1, 3 * BATCH)
        asked = answers_of(state)
        truth = score_of(material.study.space.make(asked.designs))[:, 0]
        assert curve.points[-1].liked == (truth > 0.0).sum()
        assert (truth > 0.0).sum() != (asked.scores > 0.0).sum()


@pytest.mark.parametrize(("name", "target"), some([("changing", [0.0, 1.0]), ("two", [0.5, 0.5])]))
def test_a_person_of_two_tastes_gives_one_score_and_is_measured_against_what_counts(name, target):
    material = world(2, **QUICK)
    person = material.answered_by(RESPONDENTS[name], 5)
    assert person.factors == (name,)
    assert np.array_equal(person.scores[:, 0], material.scores @ target)
    state, _ = protocol.run(person, BATCH, 5, 80)
    (answers,) = state.answers.values()
    true = material.true_scores(answers.designs)
    of_last = np.arange(80) % 2 == 1 if name == "two" else np.arange(80) >= CHANGE
    assert answers.scores.tolist() == np.where(of_last, true[:, 1], true[:, 0]).tolist()


def test_a_person_of_two_tastes_needs_a_scenario_of_two():
    with pytest.raises(UsageError, match="person two has two tastes, and the scenario has one factor"):
        world().answered_by(RESPONDENTS["two"], 5)
