"""What is learned from the scores of a session, whatever they are."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from grammarlab.errors import UsageError
from grammarlab.learning.answers import answers_of
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.pool import Pool
from grammarlab.learning.round import Study, init, step
from grammarlab.pages.record.judgements import Judgement, compared
from grammarlab.pages.record.label_exchange import labels_of
from grammarlab.pages.record.model_grids import PAIRS
from grammarlab.pages.scoring.knowledge import ModelPool
from grammarlab.pages.scoring.next_models import LISTS, WAYS
from grammarlab.pages.workers.artist import artist
from grammarlab.pages.workers.learner import learner
from grammarlab.pages.workers.tasks import (
    NUM_FITS,
    Choose,
    DrawContrast,
    Factors,
    Features,
    LearnedUpdate,
    ModelChoice,
    Prepare,
    Update,
)
from grammarlab.pages.workers.worker_pool import Handler
from grammarlab.preference.label_files import read_labels, save_labels
from grammarlab.preference.labels import Kind, Labels
from grammarlab.runs.sample.domains import opened
from tests.cases import some
from tests.pages.scoring.tower import TOWER, kind_of

SEED, SIZE = 3, 150
NUMBERS = {name: number for number, name in enumerate(("overall", "a", "b", "c"), 1)}
"""Of factors."""
ASKED = [way for way in WAYS if way not in LISTS]
"""Strategies that ask the learner for models."""


def report(_stage: str, done: int, total: int) -> None:
    assert 0 <= done <= total


@pytest.fixture(scope="module")
def pool() -> ModelPool:
    return ModelPool(SEED, SIZE)


@pytest.fixture(scope="module")
def handler() -> Handler:
    return learner(".cga", TOWER, "tower", Path(), SEED, SIZE, False)


def update(handler: Handler, factors: dict[str, dict[str, float]], choice: ModelChoice | None = None) -> LearnedUpdate:
    return handler(Update(said(factors), NUMBERS, choice), report)


def said(factors: dict[str, dict[str, float]]) -> Factors:
    """Scores of 0 to 100."""
    return {name: {model: Judgement(score) for model, score in scores.items()} for name, scores in factors.items()}


def test_features_are_sent_once_and_again_when_they_change(pool: ModelPool):
    handler = learner(".cga", TOWER, "tower", Path(), SEED, SIZE, False)
    features: Features = handler(Prepare(), report)
    assert features.rows.shape == (SIZE, len(features.names))
    assert len(set(features.names)) == len(features.names)
    scores = {"overall": dict.fromkeys(pool.names[:3], 50.0)}
    assert handler(Update(said(scores), NUMBERS, None, features.version), report).features is None
    again = handler(Update(said(scores), NUMBERS, None, 0), report).features
    assert again.version == features.version
    assert np.array_equal(again.rows, features.rows)


def test_new_models_after_the_same_scores_need_no_second_fit(pool: ModelPool, monkeypatch: pytest.MonkeyPatch):
    scores = {"overall": {name: 100.0 if kind_of(name) == "Flat" else 0.0 for name in pool.names[:12]}}
    choice = ModelChoice("default", "overall", 8, 5)
    once = update(learner(".cga", TOWER, "tower", Path(), SEED, SIZE, False), scores, choice)
    handler = learner(".cga", TOWER, "tower", Path(), SEED, SIZE, False)
    behind = update(handler, scores)
    assert (behind.chosen, behind.js) == (None, 0.0)
    with monkeypatch.context() as forbidden:
        forbidden.delattr("grammarlab.pages.workers.learner.step")
        then = update(handler, scores, choice)
    assert (then.chosen, then.js, then.words) == (once.chosen, once.js, once.words)
    assert np.array_equal(then.factors["overall"].mean, once.factors["overall"].mean)
    other = scores["overall"] | {pool.names[0]: 50.0}
    assert not np.array_equal(
        update(handler, {"overall": other}, choice).factors["overall"].mean, once.factors["overall"].mean
    )


def test_a_choice_that_was_learned_is_drawn_as_two_models_that_differ_in_it_alone(handler: Handler, pool: ModelPool):
    scores = {"overall": {name: 90.0 if kind_of(name) == "Flat" else 10.0 for name in pool.names[:40]}}
    contrast = update(handler, scores).contrasts[0]
    assert (contrast.having > contrast.without) == ("Flat" in contrast.text)
    assert {model[0] for model in contrast.models} == {"g"}
    drawn = artist(".cga", TOWER, "tower", Path())(DrawContrast(contrast, 48, 1), report).pictures
    assert [picture.shape for picture in drawn] == [(48, 48, 3)] * 2
    assert not np.array_equal(*drawn)
    with pytest.raises(UsageError, match="no seed here gives two models"):
        artist(".cga", TOWER, "tower", Path())(DrawContrast(replace(contrast, models=()), 48, 1), report)


@pytest.mark.parametrize(
    "scores",
    some([[0.0], [0.0] * 8, [100.0] * 8, [0.0, 100.0] * 4, [1e-9, 0.0], [100.0], [12.5] * 8]),
    ids=str,
)
def test_any_scores_can_be_learned_from(handler: Handler, pool: ModelPool, scores: list[float]):
    for way in ASKED:
        found = update(
            handler, {"overall": dict(zip(pool.names, scores, strict=False))}, ModelChoice(way, "overall", 6, 1)
        )
        predicted = found.factors["overall"]
        assert np.isfinite(predicted.mean).all()
        assert (predicted.std >= 0).all()
        assert 0.0 <= found.js <= math.log(2.0)
        assert (found.product is None) == (not any(scores))
        assert found.chosen is not None
        assert len(set(found.chosen)) == len(found.chosen) == (min(6, len(scores)) if way == "already ranked" else 6)
        assert len(predicted.relevance) <= 8


def test_factors_without_a_liked_model_are_left_out_of_the_product_in_words(handler: Handler, pool: ModelPool):
    liked = {model: 50.0 + index for index, model in enumerate(pool.names[:9])}
    factors = {"a": liked, "b": dict.fromkeys(pool.names[:9], 0.0), "c": {}}
    found = update(handler, factors, ModelChoice("default", "", 5, 1))
    assert set(found.factors) == {"a", "b"}
    assert found.product is not None
    assert np.allclose(found.product.mean, np.maximum(found.factors["a"].mean, 0.0))
    assert found.left_out == (
        "Factor b is left out of the product: all its scores are 0.",
        "Factor c is left out of the product: it has no scores yet.",
    )
    assert found.chosen is not None


def test_nothing_liked_is_told(handler: Handler, pool: ModelPool):
    found = update(handler, {"a": dict.fromkeys(pool.names[:5], 0.0)})
    assert found.left_out == ("Nothing is liked yet: score at least one model above 0.",)
    assert np.abs(found.factors["a"].mean).max() < 1.0


def test_models_that_are_not_of_the_pool_are_learned_from(handler: Handler):
    elsewhere = [str(Address(flat, 99, index)) for flat in (False, True) for index in range(20)]
    scores = {model: 100.0 * (kind_of(model) == "Flat") for model in elsewhere}
    found = update(handler, {"overall": scores}, ModelChoice("already ranked", "overall", 50, 1))
    predicted, pool = found.factors["overall"], ModelPool(SEED, SIZE)
    flat = np.array([kind_of(model) == "Flat" for model in (*pool.names, *found.elsewhere)])
    assert set(found.elsewhere) == set(elsewhere)
    assert predicted.mean.shape == predicted.std.shape == (SIZE + 40,)
    assert predicted.mean[flat].min() > 80
    assert predicted.mean[~flat].max() < 20
    assert found.chosen is not None
    assert set(found.chosen) == set(elsewhere)
    assert found.features is not None
    assert len(found.features.rows) == SIZE + 40


def test_a_mistake_among_models_that_are_not_of_the_pool_is_shown_first(handler: Handler, pool: ModelPool):
    elsewhere = [str(Address(False, 99, index)) for index in range(20)]
    scores = {model: 100.0 * (kind_of(model) == "Flat") for model in (*pool.names[:20], *elsewhere)}
    scores[elsewhere[13]] = 100.0 - scores[elsewhere[13]]
    choice = ModelChoice("already ranked", "overall", 40, 1)
    update(handler, {"overall": scores})
    chosen = handler(Choose(said({"overall": scores}), NUMBERS, choice), report)
    assert chosen[0] == elsewhere[13]
    assert set(chosen) == set(scores)
    others = handler(Choose(said({"overall": scores}), NUMBERS, ModelChoice("default", "overall", SIZE, 1)), report)
    assert set(others) == set(pool.names[20:])


def test_what_is_learned_depends_on_the_scores_alone(handler: Handler, pool: ModelPool):
    scores = {"overall": {model: float(index % 3) * 50 for index, model in enumerate(pool.names[:20])}}
    choice = ModelChoice("default", "overall", 8, 7)
    fresh = update(learner(".cga", TOWER, "tower", Path(), SEED, SIZE, False), scores, choice)
    update(handler, {"overall": dict.fromkeys(pool.names[40:60], 80.0)})
    again = update(handler, scores, choice)
    assert np.array_equal(fresh.factors["overall"].mean, again.factors["overall"].mean)
    assert fresh.chosen == again.chosen


def test_the_density_does_not_move_without_new_scores(handler: Handler, pool: ModelPool):
    scores = {"overall": {model: float(index % 2) * 80 for index, model in enumerate(pool.names[:12])}}
    update(handler, scores)
    assert update(handler, scores).js == pytest.approx(0.0, abs=1e-9)


def test_changes_are_measured_from_one_of_the_last_updates_and_older_ones_are_forgotten(pool: ModelPool):
    handler = learner(".cga", TOWER, "tower", Path(), SEED, SIZE, False)
    scores = said({"overall": {name: 100.0 * (kind_of(name) == "Flat") for name in pool.names[:12]}})
    choice = ModelChoice("default", "overall", 2, 5)
    every = [handler(Update(scores, NUMBERS, choice), report) for _ in range(NUM_FITS + 1)]
    assert len({update.js for update in every}) == 1
    assert every[0].js > 0.05
    forgotten = handler(Update(scores, NUMBERS, choice, since=every[0].number), report)
    assert forgotten.js == every[0].js
    assert handler(Update(scores, NUMBERS, choice, since=every[-1].number), report).js == 0.0


def test_models_that_are_on_the_page_are_not_chosen(handler: Handler, pool: ModelPool):
    scores = {"overall": {name: 100.0 * (kind_of(name) == "Flat") for name in pool.names[:20]}}
    update(handler, scores)
    without = pool.names[20:100]
    for way in WAYS:
        if way in (*LISTS, "already ranked", PAIRS):
            continue
        choice = ModelChoice(way, "overall", SIZE, 1, without)
        chosen = handler(Choose(said(scores), NUMBERS, choice), report)
        assert not set(chosen) & {*without, *pool.names[:20]}
        assert set(pool.samples[100:]) <= set(chosen)


def test_models_are_chosen_before_anything_is_learned(pool: ModelPool):
    handler = learner(".cga", TOWER, "tower", Path(), SEED, SIZE, False)
    for way in ASKED:
        chosen = handler(
            Choose(said({"overall": {pool.names[0]: 5.0}}), NUMBERS, ModelChoice(way, "overall", 4, 2)), report
        )
        assert len(chosen) == (1 if way == "already ranked" else 4)
        assert (pool.names[0] in chosen) == (way == "already ranked")


def test_a_renamed_factor_keeps_what_was_learned(handler: Handler, pool: ModelPool):
    scores = {model: 100.0 * (kind_of(model) == "Flat") for model in pool.names[:40]}
    update(handler, {"a": scores, "b": scores})

    def chosen(factors: dict[str, dict[str, float]], numbers: dict[str, int], factor: str) -> list[str]:
        return handler(Choose(said(factors), numbers, ModelChoice("density", factor, 20, 1)), report)

    for factor, renamed in (("a", "roofs"), ("", "")):
        before = chosen({"a": scores, "b": scores}, NUMBERS, factor)
        numbers = {"roofs": NUMBERS["a"], "b": NUMBERS["b"], "a": 9}
        assert chosen({"roofs": scores, "b": scores, "a": {}}, numbers, renamed) == before
    assert chosen({"roofs": scores, "b": scores, "a": {}}, numbers, "a") != before


def test_a_label_file_teaches_what_the_session_learns_to_the_last_bit(
    handler: Handler, pool: ModelPool, tmp_path: Path
):
    """Whatever was said, and in whatever order it stands in the file."""
    elsewhere = [str(Address(flat, 99, 4)) for flat in (False, True)]
    liked = {model: kind_of(model) == "Flat" for model in (*pool.names[:60], *elsewhere)}
    kinds: list[Kind] = ["score", "stars", "thumb"]
    scores = {model: Judgement(100.0 * liked[model], kinds[index % 3]) for index, model in enumerate(pool.names[:30])}
    pairs = [*zip(pool.names[30:44], pool.names[44:58], strict=True), (pool.names[58], elsewhere[0]), tuple(elsewhere)]
    for one, other in pairs:
        kind: Kind = "tie" if liked[one] == liked[other] else "rather"
        scores |= [compared([one, other] if liked[one] else [other, one], kind)]
    factors: Factors = {"overall": scores, "a": {pool.names[0]: Judgement(30.0)}}
    study = Study(opened(".cga", TOWER, "tower", Path()), Pool(SEED, SIZE))
    labels = labels_of(factors, study.space.hashes[0])
    save_labels(Labels(labels.rows[::-1]), tmp_path / "all.csv")
    state = step(study, init(study), answers_of(read_labels(tmp_path / "all.csv"), study.space.hashes))
    found = handler(Update(factors, NUMBERS, ModelChoice("default", "overall", 4, 1)), report)
    assert set(found.elsewhere) == set(elsewhere)
    rows = study.table(state).rows
    for name in factors:
        assert np.array_equal(found.factors[name].mean, state.preferences[name].predict(rows).mean.astype(np.float32))
    flat = np.array([kind_of(model) == "Flat" for model in pool.names])
    mean = found.factors["overall"].mean[:SIZE]
    assert mean[flat].min() > mean[~flat].max()


@pytest.mark.parametrize("kind", some(["rather", "tie"]))
def test_comparisons_alone_can_be_learned_from(handler: Handler, pool: ModelPool, kind: Kind):
    pairs = list(zip(pool.names[:16:2], pool.names[1:16:2], strict=True))
    scores = dict(compared(pair, kind) for pair in pairs)
    for way in ASKED:
        found = handler(Update({"overall": scores}, NUMBERS, ModelChoice(way, "overall", 6, 1)), report)
        assert np.isfinite(found.factors["overall"].mean).all()
        assert (found.product is None) == (kind == "tie")
        assert len(set(found.chosen)) == (0 if way == "already ranked" else 6)
    found = handler(Update({"overall": scores}, NUMBERS, ModelChoice("pairs", "overall", 6, 1)), report)
    asked = {frozenset(found.chosen[place : place + 2]) for place in (0, 2, 4)}
    assert not asked & {frozenset(pair) for pair in pairs}


@pytest.mark.parametrize("num_labels", [8, 40])
def test_scores_are_explained_once_less_than_half_of_the_original_is_kept(
    handler: Handler, pool: ModelPool, num_labels: int
):
    liked = {model: kind_of(model) == "Flat" for model in pool.names}
    scores = {model: 100.0 * liked[model] for model in pool.names[:40]}
    shuffled = dict(zip(scores, np.random.default_rng(num_labels).permutation(list(scores.values())), strict=True))
    pairs = list(zip(pool.names[: 2 * num_labels : 2], pool.names[1 : 2 * num_labels : 2], strict=True))
    compare_alone = handler(
        Update({"overall": dict(compared(pair, "rather") for pair in pairs)}, NUMBERS, None), report
    )
    assert update(handler, {"overall": scores}).is_explained
    for unknown in (update(handler, {"overall": shuffled}), compare_alone):
        assert not unknown.is_explained
        assert unknown.words[0].startswith(("No pattern yet", "Not enough yet"))


def test_the_factor_with_the_fewest_scores_is_next_and_one_alone_has_no_turn(handler: Handler, pool: ModelPool):
    scores = {model: 100.0 * (number % 2) for number, model in enumerate(pool.names[:8])}
    assert update(handler, {"a": scores}).turn == ""
    assert update(handler, {"a": scores, "b": dict(list(scores.items())[:4])}).turn == "b"
    assert update(handler, {"a": dict(list(scores.items())[:4]), "b": scores}).turn == "a"
