import pytest

from grammarlab.errors import UsageError
from grammarlab.runs.evaluate.request import MIN_LABELS, EvaluationRequest, shipped_scenarios

B3, F1, L4 = (shipped_scenarios()[name] for name in ("B3", "F1", "L4"))


def test_each_scenario_can_be_measured_up_to_its_own_target():
    request = EvaluationRequest.of((B3, F1, L4), methods="default", max_labels=0)
    assert request.labels_of(B3) == MIN_LABELS
    assert request.labels_of(F1) == 170
    assert request.labels_of(L4) == 768


def test_a_number_of_labels_holds_for_every_scenario():
    request = EvaluationRequest.of((B3, F1), methods="default", max_labels=64)
    assert {request.labels_of(path) for path in request.scenarios} == {64}


@pytest.mark.parametrize("wrong", [{"seeds": 0}, {"max_labels": -1}])
def test_numbers_out_of_range_are_named(wrong):
    (name,) = wrong
    with pytest.raises(UsageError, match=f"{name}: expected a number"):
        EvaluationRequest.of((B3,), **wrong)
