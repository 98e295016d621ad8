from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.distance import jensenshannon

from grammarlab.evaluation import protocol
from grammarlab.evaluation.material import Columns, Table
from grammarlab.evaluation.scenario import MAX_PATH_LENGTH
from grammarlab.preference.queries import FEWEST
from tests.evaluation.doubles import BITS, LABELLED, LEARNER, POOL, Remembers, world


def test_a_learner_that_has_seen_every_kind_of_model_is_exact():
    material = world()
    _, curve = protocol.run(material, LEARNER, seed=1, max_labels=POOL)
    assert curve.points[-1].js == pytest.approx(0, abs=1e-12)
    assert curve.points[-1].correlation == pytest.approx(1)
    assert curve.points[0].js > 0.005


def test_equal_seeds_give_equal_curves_and_other_seeds_others():
    curves = [protocol.run(world(), LEARNER, seed, 48)[1] for seed in (5, 5, 6)]
    assert curves[0] == curves[1] != curves[2]


def test_a_curve_for_fewer_labels_is_the_beginning_of_a_longer_one():
    long = protocol.run(world(2), LEARNER, 3, 96)[1]
    assert protocol.run(world(2), LEARNER, 3, 48)[1] == long.until(48)


def test_the_last_round_is_cut_to_the_labels_that_are_left():
    _, curve = protocol.run(world(), LEARNER, 0, 40)
    assert [point.labels for point in curve.points] == [16, 32, 40]


def test_a_run_ends_when_every_model_of_the_pool_has_a_score_for_every_factor():
    state, curve = protocol.run(world(2), LEARNER, 0, 10_000)
    assert curve.points[-1].labels == 2 * POOL
    assert all(sorted(factor.asked) == list(range(POOL)) for factor in state.factors)


def test_rounds_take_the_factors_in_turn_and_the_product_is_learned():
    material = world(2)
    state = protocol.init(material, LEARNER)
    for count in range(1, 5):
        state, point = protocol.step(material, LEARNER, 7, 16, state)
        asked = [len(factor.asked) for factor in state.factors]
        assert asked == [16 * (count - count // 2), 16 * (count // 2)]
        assert point.labels == sum(asked)
    for index, factor in enumerate(state.factors):
        assert np.array_equal(factor.scores, material.pool_scores[factor.asked, index])
    product = np.ones(LABELLED)
    for factor in state.factors:
        assert factor.preference is not None
        product *= factor.preference.predict(material.table(state.columns).labelled).mean / 100
    assert np.allclose(protocol.learned(material, state), product)


def test_the_divergence_is_that_of_the_normalized_weights_and_before_learning_that_of_the_grammar():
    weights = np.random.default_rng(3).uniform(0.1, 2, LABELLED)
    material = world(2, weights=weights)
    target = weights * material.scores.prod(axis=1)
    assert material.js_original == pytest.approx(jensenshannon(target, weights) ** 2)
    state, point = protocol.step(material, LEARNER, 0, 16, protocol.init(material, LEARNER))
    current = weights * protocol.learned(material, state)
    assert point.js == pytest.approx(jensenshannon(target, current) ** 2)
    assert point.correlation == pytest.approx(np.corrcoef(target, current)[0, 1])


def test_equal_models_with_different_scores_make_paths_longer():
    material, short = world(), replace(LEARNER, path_length=1)
    state, _ = protocol.run(material, short, 0, 64)
    assert state.columns.path_length == 2
    preference = state.factors[0].preference
    assert isinstance(preference, Remembers)
    assert preference.rows.shape == (64, BITS)
    state, _ = protocol.run(material, replace(short, grows=False), 0, 64)
    assert state.columns.path_length == 1


def test_paths_that_never_tell_models_apart_do_not_grow_for_ever():
    material = world()
    blind = replace(material, table=lambda _columns: material.table(Columns(1)))
    state, _ = protocol.run(blind, LEARNER, 0, 64)
    assert state.columns.path_length == MAX_PATH_LENGTH


def test_longer_paths_begin_all_factors_anew():
    material, short = world(2), replace(LEARNER, path_length=1)
    state, _ = protocol.run(material, short, 0, 96)
    rows = [factor.preference.rows for factor in state.factors if isinstance(factor.preference, Remembers)]
    assert [len(r) for r in rows] == [48, 48]
    assert all(r.shape[1] == BITS for r in rows)


def test_a_wider_pool_is_offered_once_liked_models_are_rare():
    material = world(2)
    rows, rare = material.table(Columns(2)), replace(material, pool_scores=np.zeros_like(material.pool_scores))
    twice = Table(rows.labelled, np.concatenate([rows.pool, rows.pool]), rows.groups, rows.group_names)
    wider = replace(
        rare,
        pool_scores=np.concatenate([rare.pool_scores, material.pool_scores]),
        pool_weights=np.ones(2 * POOL),
        pool_from_grammar=np.arange(2 * POOL) < POOL,
        table=lambda _columns: twice,
    )
    rare = replace(rare, wider=lambda: wider)
    for offered, learner in ((rare, LEARNER), (material, replace(LEARNER, widens=True))):
        assert not protocol.run(offered, learner, 0, 2 * POOL)[0].wide
    learner, state = replace(LEARNER, widens=True), protocol.init(rare, LEARNER)
    for labels in range(16, 320, 16):
        state, _ = protocol.step(rare, learner, 0, 16, state)
        assert state.wide == (labels >= 2 * FEWEST - 16)
    assert any((factor.scores > 0).any() for factor in state.factors)
    assert any((factor.asked >= POOL).any() for factor in state.factors)
    assert len(protocol.learned(rare, state)) == LABELLED
    whole = rare.as_one_factor().wider
    assert whole is not None
    assert whole().pool_scores.shape == (2 * POOL, 1)


def test_a_query_rule_that_repeats_itself_is_a_mistake_that_shows():
    stubborn = replace(LEARNER, propose=lambda _round, num_models, _seed: np.arange(num_models))
    with pytest.raises(ValueError, match="16 new models"):
        protocol.run(world(), stubborn, 0, 32)
