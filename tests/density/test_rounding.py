"""Round percentages."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.density.rounding import EXACT, rounded, rounded_parts

SHARES = st.lists(st.floats(1e-6, 1.0), min_size=2, max_size=12)


@given(SHARES, st.sampled_from([0.05, 0.01, 1e-3, 1e-4]))
def test_they_sum_to_one_stay_above_0_and_move_little(weights, step):
    own = np.array(weights) / np.sum(weights)
    found = np.array(rounded(own.tolist(), step))
    assert abs(found.sum() - 1.0) < 1e-9
    assert (found > 0.0).all()
    others = np.delete(np.arange(len(own)), own.argmax())
    assert (np.abs(found - own)[others] <= step / 2 + 1e-12).all()


@given(SHARES)
def test_no_step_changes_nothing(weights):
    assert rounded(weights, EXACT) == weights


def test_ranges_that_are_one_get_one_round_percentage():
    original = np.array([0.25, 0.25, 0.5])
    wanted = original * [0.613, 0.613, 1.387]
    found = rounded_parts(wanted, original, ["a", "a", "a"], 0.01)
    np.testing.assert_allclose(found, [0.155, 0.155, 0.69])
    none = rounded_parts(np.array([0.0, 0.333, 0.667]), original, ["a", "a", "b"], 0.01)
    np.testing.assert_allclose(none, [0.0, 0.33, 0.67])
