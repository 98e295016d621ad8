"""What every method promises, whatever it does inside."""

import builtins
import sys
from importlib import import_module

import numpy as np
import pytest
from scipy import sparse

from grammarlab.errors import UsageError
from grammarlab.learning.fitting import fit
from tests.preference.rows import counted_rows

METHODS = ["blended", "grouped", "paper", "kde", "sklearn", "lightgbm"]
LEARN_NOISE = ("blended", "grouped")
"""Methods to which few labels that contradict each other say less than their mean."""


@pytest.fixture(params=METHODS)
def method(request):
    return request.param


def is_sound(prediction, num_rows):
    for part in (prediction.mean, prediction.std):
        assert part.shape == (num_rows,)
        assert part.dtype == np.float64
        assert np.isfinite(part).all()
    assert (prediction.std >= 0.0).all()


def test_the_same_seed_gives_the_same_preference(method):
    rows, scores = counted_rows(30, 6)
    first, second = (fit(rows, scores, method=method, seed=3).predict(rows) for _ in range(2))
    np.testing.assert_array_equal(first.mean, second.mean)
    np.testing.assert_array_equal(first.std, second.std)


def test_labels_are_predicted_and_wanted_rows_rank_above_unwanted_ones(method):
    rows, scores = counted_rows(80, 5)
    predicted = fit(rows, scores, method=method).predict(rows).mean
    assert np.corrcoef(predicted, scores)[0, 1] > 0.7


def test_one_label(method):
    preference = fit([[1.0, 2.0]], [60.0], method=method)
    predicted = preference.predict([[1.0, 2.0], [5.0, 9.0]])
    is_sound(predicted, 2)
    assert predicted.mean[0] == pytest.approx(60.0, abs=0.5)


def test_equal_scores_everywhere(method):
    rows, _ = counted_rows(20, 4)
    predicted = fit(rows, np.full(20, 40.0), method=method).predict(rows)
    is_sound(predicted, 20)
    np.testing.assert_allclose(predicted.mean, 40.0, atol=0.5)


def test_scores_of_zero_only_predict_zero_and_stay_unsure_elsewhere(method):
    rows, _ = counted_rows(20, 4)
    preference = fit(rows, np.zeros(20), method=method)
    near, far = preference.predict(rows), preference.predict(rows + 50.0)
    is_sound(near, 20)
    np.testing.assert_allclose(near.mean, 0.0, atol=1e-9)
    np.testing.assert_allclose(far.mean, 0.0, atol=1e-9)
    assert far.std.min() > 10.0 > 0.9 * near.std.max() or method in ("kde", "lightgbm")


def test_contradicting_scores_meet_in_the_middle(method):
    preference = fit([[0.0], [0.0], [0.0], [4.0]], [30.0, 60.0, 30.0, 0.0], method=method).explaining
    is_sound(preference.predict([[0.0]]), 1)
    assert preference.predict([[0.0]]).mean[0] == pytest.approx(40.0, abs=6.0 if method in LEARN_NOISE else 0.5)


def test_repeating_all_labels_changes_little(method):
    rows, scores = counted_rows(25, 4)
    once = fit(rows, scores, method=method).predict(rows).mean
    twice = fit(np.tile(rows, (2, 1)), np.tile(scores, 2), method=method).predict(rows).mean
    np.testing.assert_allclose(twice, once, atol=2.0)


def test_no_columns(method):
    preference = fit(np.zeros((3, 0)), [10.0, 20.0, 30.0], method=method)
    predicted = preference.predict(np.zeros((2, 0)))
    is_sound(predicted, 2)
    np.testing.assert_allclose(predicted.mean, 20.0, atol=1.0 if method in LEARN_NOISE else 0.5)
    assert preference.explain([]) == []


def test_nothing_to_predict(method):
    preference = fit(*counted_rows(5, 3), method=method)
    is_sound(preference.predict(np.zeros((0, 3))), 0)


def test_huge_and_constant_columns(method):
    rows, scores = counted_rows(20, 4)
    rows[:, 2] = 1e6
    rows[:, 3] *= 1e5
    is_sound(fit(rows, scores, method=method).predict(rows), 20)


def test_thousands_of_labels_stay_bounded(method, monkeypatch):
    for name in ("preference.processes.grouped", "baselines.gaussian_process", "baselines.kde"):
        module = import_module(f"grammarlab.{name}")
        monkeypatch.setattr(module, "MAX_ROWS_TO_FIT" if name.startswith("base") else "MANY_LABELS", 100)
        monkeypatch.setattr(module, "MAX_ROWS_TO_KEEP" if name.startswith("base") else "MAX_ROWS", 400)
    module = import_module("grammarlab.baselines.sklearn_process")
    monkeypatch.setattr(module, "MAX_GRADIENT_NUMBERS", 100**2 * 8)
    rows, scores = counted_rows(2_000, 8)
    preference = fit(rows, scores, method=method)
    assert np.corrcoef(preference.predict(rows).mean, scores)[0, 1] > (0.5 if method == "kde" else 0.9)


def test_sparse_rows_are_the_same_as_dense_ones(method):
    rows, scores = counted_rows(15, 4)
    preference = fit(sparse.csr_array(rows), scores, method=method)
    np.testing.assert_array_equal(preference.predict(sparse.csr_array(rows)).mean, preference.predict(rows).mean)


def test_explanations_name_the_groups_that_matter(method):
    rows, scores = counted_rows(100, 6)
    found = fit(rows, scores, groups=[0, 0, 1, 1, 2, 2], method=method).explain(["roof", "windows", "door"])
    assert {entry.name for entry in found} == {"roof", "windows", "door"}
    assert [entry.share for entry in found] == sorted((entry.share for entry in found), reverse=True)
    assert all(0.0 <= entry.share <= 1.0 for entry in found)
    if method == "paper":  # all columns have the same say in a density, and evidence alone may keep an idle one
        assert str(found[0]) == "roof: strong"
        assert {entry.level for entry in found[1:]} <= {"weak", "none"}


def test_rows_of_other_columns_are_refused(method):
    preference = fit(*counted_rows(5, 3), method=method)
    with pytest.raises(UsageError, match="fitted on 3 columns, found 2"):
        preference.predict(np.zeros((1, 2)))
    with pytest.raises(UsageError, match="found nan in row 0, column 1"):
        preference.predict([[0.0, float("nan"), 0.0]])


def test_an_unknown_method_is_answered_with_the_known_ones():
    with pytest.raises(
        UsageError, match="expected one of blended, partition, grouped, paper, kde, sklearn, lightgbm, found 'magic'"
    ):
        fit([[1.0]], [1.0], method="magic")  # ty: ignore[invalid-argument-type]  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize(
    ("method", "module", "library", "extra"),
    [
        ("sklearn", "sklearn_process", "sklearn", "learn"),
        ("lightgbm", "boosted_trees", "lightgbm", "rivals"),
    ],
)
def test_a_missing_library_is_named_with_how_to_get_it(monkeypatch, method, module, library, extra):
    real = builtins.__import__

    def without_library(name, *arguments, **options):
        if name.split(".")[0] == library:
            raise ModuleNotFoundError(name=library)
        return real(name, *arguments, **options)

    import_module(f"grammarlab.baselines.{module}")
    monkeypatch.delitem(sys.modules, f"grammarlab.baselines.{module}")
    monkeypatch.setattr(builtins, "__import__", without_library)
    with pytest.raises(UsageError, match=rf"the package {library}, .*: pip install 'grammarlab\[{extra}\]'"):
        fit([[1.0]], [1.0], method=method)
