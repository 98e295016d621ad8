"""Attributes and reports as columns."""

from collections.abc import Callable
from statistics import fmean

import numpy as np
import pytest

import grammarlab as gl
from grammarlab.derivation.model_values import Statistic
from grammarlab.derivation.selection import join_forests, select_models
from grammarlab.runs.sample.grammar_models import summarize_reports

GRAMMAR = gl.Grammar.parse("""
attr height = rand(3, 9)
attr storeys = floor(height / 3)
attr unread = storeys * 2
attr broken = broken + 1
attr list = [1, 2]
attr style = 50% : "old" else : "new"
attr flat = height < 5
const side = 4
Lot --> split(x) { 10 : Part(2) | 10 : Part(3) }
Part(n) --> 70% : report("area", n * height) report("style", style) report("flat", flat) Wall else : NIL
""")
FOREST = gl.derive(GRAMMAR, 40, seed=3)


def test_attributes_are_what_the_rules_computed():
    height = gl.attribute(FOREST, "height")
    np.testing.assert_array_equal(height, gl.count(FOREST, ["$height"])[:, 0])
    np.testing.assert_array_equal(gl.attribute(FOREST, "storeys"), height // 3)
    np.testing.assert_array_equal(gl.attribute(FOREST, "unread"), height // 3 * 2)
    np.testing.assert_array_equal(gl.attribute(FOREST, "flat"), height < 5)
    np.testing.assert_array_equal(gl.attribute(FOREST, "side"), np.full(40, 4.0))
    style = np.array(["old", "new"])[gl.count(FOREST, ["$style"])[:, 0].astype(int)]
    np.testing.assert_array_equal(gl.attribute(FOREST, "style"), style)


def test_attributes_given_from_outside_are_those_of_the_models():
    lots = gl.Lots.concatenate([gl.Lots.of(2, seed=3, attributes={"height": 20.0}), gl.Lots.of(2, seed=3)])
    forest = gl.derive(GRAMMAR, lots)
    expected = [20.0, 20.0, *gl.attribute(FOREST, "height")[:2]]
    np.testing.assert_array_equal(gl.attribute(forest, "height"), expected)


def test_attributes_do_not_depend_on_the_batch():
    parts = [gl.derive(GRAMMAR, 20, seed=3, first_model=first) for first in (0, 20)]
    chosen = np.array([2, 5, 31])
    for name in FOREST.attributes:
        whole = gl.attribute(FOREST, name)
        np.testing.assert_array_equal(gl.attribute(join_forests(parts), name), whole)
        np.testing.assert_array_equal(gl.attribute(select_models(FOREST, chosen), name), whole[chosen])


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("hieght", "the models have no attribute 'hieght'; did you mean 'height'?"),
        ("q", r"no attribute 'q'; expected one of height, storeys, .*side"),
        ("broken", "no attribute 'broken'"),
        ("list", "no attribute 'list'"),
    ],
)
def test_an_unknown_attribute_is_named_with_the_nearest(name, message):
    with pytest.raises(gl.GrammarlabError, match=message):
        gl.attribute(FOREST, name)


def test_statistics_of_reports_are_those_of_plain_python():
    values: list[list[float]] = [[] for _ in range(40)]
    reports = FOREST.reports
    for node, key, value in zip(reports.node, reports.key, reports.value, strict=True):
        if reports.keys[key] == "area":
            values[FOREST.nodes.model[node]].append(float(value))
    assert {len(each) for each in values} == {0, 1, 2}
    plain: dict[Statistic, Callable[[list[float]], float]] = {
        "sum": sum,
        "count": len,
        "min": min,
        "max": max,
        "mean": fmean,
    }
    for statistic, function in plain.items():
        of_none = 0.0 if statistic in ("sum", "count") else np.nan
        expected = [function(each) if each else of_none for each in values]
        np.testing.assert_allclose(gl.report(FOREST, "area", statistic), expected, rtol=1e-15)
    assert np.isnan(gl.report(FOREST, "style", "max")).all()
    assert set(gl.report(FOREST, "flat", "max")[gl.report(FOREST, "flat", "count") > 0]) == {0.0, 1.0}


def test_a_key_with_numbers_and_texts_keeps_the_numbers():
    forest = gl.derive(gl.Grammar.parse('Lot --> report("k", 10) report("k", "word") report("k", 4) A'), 2, seed=0)
    expected: dict[Statistic, float] = {"sum": 14.0, "count": 3.0, "mean": 7.0, "min": 4.0, "max": 10.0}
    for statistic, value in expected.items():
        assert gl.report(forest, "k", statistic).tolist() == [value, value]
    assert summarize_reports(forest) == [{"k": expected}] * 2


@pytest.mark.parametrize(
    ("key", "statistic", "message"),
    [
        ("aera", "sum", "no model reports 'aera'; did you mean 'area'?"),
        ("area", "median", "statistic: expected one of sum, mean, min, max, count, found 'median'"),
    ],
)
def test_an_unknown_report_or_statistic_is_named(key, statistic, message):
    with pytest.raises(gl.GrammarlabError, match=message):
        gl.report(FOREST, key, statistic)


def test_models_without_attributes_or_reports_say_so():
    plain = gl.derive(gl.Grammar.parse("Lot --> NIL"), 2, seed=1)
    with pytest.raises(gl.GrammarlabError, match="the models have no attributes"):
        gl.attribute(plain, "height")
    with pytest.raises(gl.GrammarlabError, match="no model reports anything"):
        gl.report(plain, "area")


def test_what_is_evaluated_for_the_columns_leaves_no_traces():
    grammar = gl.Grammar.parse('attr unread = print("seen")  Lot --> NIL')
    assert gl.derive(grammar, 1, seed=1).prints == ()
