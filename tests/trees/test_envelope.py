"""Outlines of crowns and the envelope."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.trees.envelope import crown_ratio, envelope_ratio
from tests.trees.rows import row


@pytest.mark.parametrize(
    ("shape", "values"),
    [
        (0, [0.2, 0.6, 1.0]),
        (1, [0.2, 1.0, 0.2]),
        (2, [0.2, 0.2 + 0.8 * np.sqrt(0.5), 1.0]),
        (3, [1.0, 1.0, 1.0]),
        (4, [0.5, 0.75, 1.0]),
        (5, [0.0, 0.5 / 0.7, 0.0]),
        (6, [1.0, 0.6, 0.2]),
        (7, [0.5, 0.5 + 0.25 / 0.7, 0.5]),
        (8, [0.0, 1.0, 0.0]),
    ],
)
def test_outlines_at_the_top_in_the_middle_and_at_the_lowest_branch(shape: int, values: list[float]):
    rows, tree = row(shape=shape)[None], np.zeros(3, int)
    np.testing.assert_allclose(crown_ratio(rows, tree, np.array([0.0, 0.5, 1.0])), values, atol=1e-12)


def test_flames_are_widest_at_seven_tenths():
    tree = np.zeros(1, int)
    for shape in (5, 7):
        np.testing.assert_allclose(crown_ratio(row(shape=shape)[None], tree, np.array([0.7])), [1.0])


@pytest.mark.parametrize("peak", [0.0, 0.3, 0.5, 1.0])
@pytest.mark.parametrize("power", [0.3, 1.0, 4.0])
def test_the_envelope_is_1_at_its_peak_falls_to_both_sides_and_is_continuous(peak: float, power: float):
    rows = row(prune_width_peak=peak, prune_power_low=power, prune_power_high=power)[None]
    share = np.linspace(0.0, 1.0, 100_001)
    ratio = envelope_ratio(rows, np.zeros(len(share), int), share)
    assert ratio.max() == pytest.approx(1.0, abs=1e-9)
    assert share[np.argmax(ratio)] == pytest.approx(1.0 - peak, abs=1e-4)
    rise, fall = np.diff(ratio[share <= 1.0 - peak + 1e-9]), np.diff(ratio[share >= 1.0 - peak - 1e-9])
    assert (rise >= 0).all()
    assert (fall <= 0).all()
    inner = (share[1:] > 0.01) & (share[1:] < 0.99)
    assert np.abs(np.diff(ratio))[inner].max() < 0.01


def test_nothing_is_above_or_below_the_envelope():
    ratio = envelope_ratio(row()[None], np.zeros(2, int), np.array([-0.01, 1.01]))
    np.testing.assert_array_equal(ratio, [0.0, 0.0])
