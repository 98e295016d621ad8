"""Samples before and after learning."""

from pathlib import Path

import numpy as np
import pytest

from grammarlab.evaluation.methods import METHODS
from grammarlab.evaluation.preparation import labelled_set
from grammarlab.features.patterns.counts import count
from grammarlab.runs.evaluate import samples
from grammarlab.runs.evaluate.curve_tasks import CurveTask, make_curve
from grammarlab.runs.evaluate.samples import NUM_MODELS, STORE, choose, draw_models
from grammarlab.runs.sample.sources import load_source
from grammarlab.runs.work.executor_choice import executor_of
from tests.cases import takes_turns

SCENARIO = """
name = "boxes"
title = "Red boxes"
grammar = "boxes.cga"
num_models = 60
[[preference]]
score = 80
when = "{Red}"
"""
RULES = "Lot --> 40% : extrude(2) Red else : extrude(3) Blue\nRed --> color(1, 0, 0) B.\nBlue --> color(0, 0, 1) B."


@pytest.fixture
def tasks(tmp_path: Path) -> list[CurveTask]:
    (tmp_path / "boxes.cga").write_text(RULES)
    (tmp_path / "boxes.toml").write_text(SCENARIO)
    path = tmp_path / "boxes.toml"
    return [CurveTask(path, load_source(path).key, METHODS["kde"], seed, 32, tmp_path / "cache") for seed in (0, 1)]


def test_samples_have_their_true_scores_and_the_divergences_of_the_curve(tasks, tmp_path):
    source = load_source(tasks[0].scenario)
    score = source.scenario.score
    for task, found in zip(tasks, draw_models(tasks, tmp_path), strict=True):
        labelled = labelled_set(source.for_person(task.seed))
        truth = np.concatenate([score.evaluate(count(forest, score.features)) for forest in labelled])
        record = make_curve(task)
        assert found.labels == record.curve.points[-1].labels
        assert (found.before.js, found.after.js) == (record.js_original, record.curve.points[-1].js)
        for sample in (found.before, found.after):
            assert len(sample.models) == NUM_MODELS
            assert sample.scores == pytest.approx(truth[list(sample.models)])
        assert np.mean(found.after.scores) > np.mean(found.before.scores)


@takes_turns
def test_samples_are_the_same_for_any_number_of_processes_and_when_read_back(tasks, tmp_path, monkeypatch):
    one, two = (draw_models(tasks, tmp_path / str(jobs), executor=executor_of(jobs)) for jobs in (1, 2))
    assert one == two
    kept = [{file.name: file.read_bytes() for file in (tmp_path / jobs / STORE).iterdir()} for jobs in "12"]
    assert kept[0] == kept[1]
    monkeypatch.setattr(samples, "run_protocol", None)
    assert draw_models(tasks, tmp_path / "1") == one
    with pytest.raises(TypeError):
        draw_models(tasks, tmp_path / "1", fresh=True)


def test_a_small_sample_is_the_beginning_of_a_large_one():
    weights = np.arange(50.0)
    assert choose(weights, 100, 7)[:16] == choose(weights, 16, 7)
    assert choose(weights, 100, 7) != choose(weights, 100, 8)


def test_models_are_drawn_as_often_as_their_weights_say():
    weights = np.array([0.0, 1.0, 3.0])
    counts = np.bincount(choose(weights, 40_000, 1), minlength=3)
    assert counts[0] == 0
    assert counts[2] / counts[1] == pytest.approx(3, rel=0.05)
