"""Summaries of reports against sums made one by one."""

import math

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.language.grammar import Grammar
from grammarlab.runs.sample.grammar_models import summarize_reports

RULES = """
attr n = rint(rand(2, 6))
Lot --> extrude(3 * n) split(y) { ~3 : Floor(split.index) }*
Floor(i) --> report("height." + (i % 2), scope.sy) report("one", true) B
B --> 50% : report("half", scope.sx) A else : A
"""


def test_each_model_has_the_sums_of_its_own_reports():
    forest = derive(Grammar.parse(RULES), 20, seed=3)
    found = summarize_reports(forest)
    values = [{} for _ in range(20)]
    for node, key, value in zip(forest.reports.node, forest.reports.key, forest.reports.value, strict=True):
        values[forest.nodes.model[node]].setdefault(forest.reports.keys[key], []).append(value)
    assert [sorted(summary) for summary in found] == [sorted(model) for model in values]
    for summary, model in zip(found, values, strict=True):
        for key, numbers in model.items():
            assert summary[key]["count"] == len(numbers)
            assert summary[key]["sum"] == pytest.approx(math.fsum(numbers))
            assert summary[key]["mean"] == pytest.approx(np.mean(numbers))
            assert (summary[key]["min"], summary[key]["max"]) == (min(numbers), max(numbers))


def test_texts_and_infinite_numbers_are_counted_only():
    forest = derive(Grammar.parse('Lot --> report("a", "b") report("c", 1 / 0) report("d", 2)'), 1, seed=0)
    nothing = {"count": 1, "sum": None, "mean": None, "min": None, "max": None}
    assert summarize_reports(forest)[0] == {
        "a": nothing,
        "c": nothing,
        "d": {"count": 1, "sum": 2.0, "mean": 2.0, "min": 2.0, "max": 2.0},
    }


def test_models_without_reports_have_empty_summaries():
    assert summarize_reports(derive(Grammar.parse("Lot --> A"), 3, seed=0)) == [{}, {}, {}]
