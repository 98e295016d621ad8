"""Which models a round shows, and where."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grammarlab.pages.record.model_grids import PAIRS, GridLayout, ModelGrid, check_shown
from grammarlab.pages.scoring.knowledge import ModelPool
from grammarlab.pages.scoring.next_models import WAYS, NextModels, extended, laid_out, liked_models, mixed

POOL = ModelPool(5, 200)
RANDOM = np.random.default_rng(1)
FOUR = GridLayout(2, 2, 2)


def record_of(scored: Any = (), shown: Any = ()) -> Any:
    return SimpleNamespace(labelled_models=set(scored), shown_models=dict.fromkeys(shown))


def predicted_of(models: Any, scores: Any) -> np.ndarray:
    mean = np.zeros(len(POOL.names) + 3)  # and scored models outside the pool, at the end
    mean[models] = scores
    mean[-3:] = 100.0
    return mean


def test_models_that_may_be_liked_are_predicted_to_be_and_the_best_comes_first():
    good = RANDOM.permutation(len(POOL.names))[:40]
    predicted = predicted_of(good, RANDOM.uniform(30, 90, 40))
    scored = [POOL.names[index] for index in good[:15]]
    liked = liked_models(POOL, record_of(scored), predicted, 16, 3)
    scores = [predicted[POOL.index[name]] for name in liked]
    assert len(liked) == len(set(liked)) == 16
    assert min(scores) > 20.0
    assert scores == sorted(scores, reverse=True)
    assert not set(liked) & set(scored)
    assert liked == liked_models(POOL, record_of(scored), predicted, 16, 3)


def test_models_that_were_not_shown_come_before_others():
    good = np.arange(20)
    shown = [POOL.names[index] for index in range(10)]
    liked = liked_models(POOL, record_of(shown=shown), predicted_of(good, 80.0), 12, 3)
    assert len(set(liked) & set(shown)) == 2


@pytest.mark.parametrize("everywhere", [0.0, 0.5, 70.0])
def test_nothing_may_be_liked_while_all_predictions_are_alike(everywhere):
    assert liked_models(POOL, record_of(), np.full(len(POOL.names), everywhere), 16, 3) == []


def test_few_liked_models_do_not_get_company_that_is_not_liked():
    liked = liked_models(POOL, record_of(), predicted_of([3, 90], [50.0, 60.0]), 16, 3)
    assert liked == [POOL.names[90], POOL.names[3]]


def test_each_grid_has_what_its_title_says():
    chosen = [f"q{number}" for number in range(8)] + ["b"]
    first, second = mixed(["a", "b"], NextModels(chosen), FOUR)
    assert (first.title, first.models) == ("may be liked, the best first", ("a", "b"))
    assert (second.title, second.models) == ("tell the most", ("q0", "q2", "q4", "q6"))
    (only,) = mixed(["a", "b", "c"], NextModels(chosen), GridLayout(1, 2, 2))
    assert only.title == "may be liked, the best first, then those that tell the most"
    assert only.models == ("a", "b", "q0", "q4")
    assert [len(grid.models) for grid in mixed(["a"], NextModels(["a", "q0"]), FOUR)] == [1, 1]


def test_further_models_follow_those_that_are_shown_and_none_is_shown_twice():
    shown = [ModelGrid("to score", ("a", "b")), ModelGrid("", ("c",))]
    first = extended(shown, [ModelGrid("may be liked, the best first", ("d", "b")), ModelGrid("tell the most", ("e",))])
    assert [grid.models for grid in first] == [("a", "b", "d"), ("c", "e")]
    titles = ["to score, then may be liked, the best first", "more, then tell the most"]
    assert [grid.title for grid in first] == titles
    # The same kinds once more, and only one grid of them.
    second = extended(first, [ModelGrid("may be liked, the best first", ("f",))])
    assert [(grid.title, grid.models) for grid in second] == [
        (titles[0], ("a", "b", "d", "f")),
        (titles[1], ("c", "e")),
    ]


def test_titles_of_whatever_kinds_follow_each_other_are_whole():
    one = GridLayout(1, 1, 3)
    kinds = [mixed("a", NextModels("b", samples), one) for samples in ("", "c")]
    titles = [grid.title for (grid,) in (*kinds, *(laid_out(way, "a", one) for way in WAYS if way != PAIRS))]
    for first in titles:
        for last in titles:
            (grid,) = extended([ModelGrid(first, ("a",))], [ModelGrid(last, ("b",))])
            check_shown({"way": "default", "grids": [{"title": grid.title, "models": []}]})
            assert grid.title.startswith(first.split(", then ")[0])
            assert grid.title.endswith(last)


def test_samples_take_the_places_that_are_left_and_are_not_said_to_tell_the_most():
    two = ["may be liked, the best first", "to score"]
    first, second = mixed(["a", "b"], NextModels("c", "bde"), FOUR)
    assert ([first.title, second.title], second.models) == (two, ("c", "d", "e"))
    (only,) = mixed(["a"], NextModels((), "bcd"), GridLayout(1, 2, 2))
    assert only.title == "may be liked, the best first, then others to score"
