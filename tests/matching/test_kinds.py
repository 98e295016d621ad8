"""Kinds by description length, with and without rows."""

import numpy as np
import pytest

from grammarlab.matching.evidence_maps import Maps, maps_of
from grammarlab.matching.shared_kinds import VALUE_COST, find_kinds, mixture_gain
from grammarlab.matching.strength import find_kinds_with, with_bias

SIZES = np.array([[1.0, 1.5], [1.0, 1.9], [1.3, 1.9], [1.3, 1.5]])
NONE = np.full(8, -1)


def _maps(kind: np.ndarray, sigma: float = 0.01, at_least: np.ndarray | None = None) -> Maps:
    """Evidence that is normal around the size of each kind; wide if only a lower bound of the width is known."""
    widths, heights = np.linspace(0.8, 1.6, 81), np.linspace(1.3, 2.1, 81)
    across = -0.5 * ((widths[None] - SIZES[kind, :1]) / sigma) ** 2
    if at_least is not None:
        across[at_least] = np.where(widths > 0.9, 0.0, -50.0)
    up = -0.5 * ((heights[None] - SIZES[kind, 1:]) / sigma) ** 2
    evidence = np.exp(across[:, :, None] + up[:, None, :])
    evidence = evidence / evidence.mean(axis=(1, 2), keepdims=True) * 0.9999 + 1e-4
    return Maps(widths, heights, evidence)


def test_eight_rectangles_of_figure_5_2_share_exactly_what_they_share():
    kind = np.array([0, 0, 1, 1, 2, 2, 3, 3])
    maps = _maps(kind)
    found = find_kinds(maps)
    label = found.posterior.argmax(axis=1)
    assert all((label == label[each]).tolist() == (kind == kind[each]).tolist() for each in range(8))
    sizes = np.stack([maps.widths[found.kinds.width], maps.heights[found.kinds.height]], axis=1)[label]
    assert sizes == pytest.approx(SIZES[kind], abs=0.0051)
    # c: equal to the last bit for a shared width or height, and different elsewhere.
    for axis in (0, 1):
        same = sizes[:, None, axis] == sizes[None, :, axis]
        assert (same == (SIZES[kind][:, None, axis] == SIZES[kind][None, :, axis])).all()


def test_no_evidence_makes_no_kinds():
    flat = Maps(np.linspace(1, 2, 11), np.linspace(1, 2, 11), np.ones((5, 11, 11)))
    found = find_kinds(flat)
    assert found.length <= -5 * np.log(0.02) + 1e-9
    assert found.posterior.sum(axis=1) == pytest.approx(np.ones(5))


def test_a_half_hidden_window_is_of_the_kind_of_its_row():
    kind = np.repeat([0, 3, 2, 1], 6)
    row = np.repeat(np.arange(4), 6)
    hidden = np.array([2, 8, 15, 21])
    found, _ = find_kinds_with(_maps(kind, at_least=hidden), row, np.full(24, -1))
    label = found.posterior.argmax(axis=1)
    assert label[hidden].tolist() == label[hidden - 1].tolist()
    plain = find_kinds(_maps(kind, at_least=hidden))
    assert found.posterior[hidden, label[hidden]].min() > plain.posterior[hidden, label[hidden]].max()


def test_maps_are_densities_over_their_mean():
    random = np.random.default_rng(0)
    drawn = np.array([1.2, 1.7]) + 0.02 * random.normal(size=(3, 4000, 2))
    maps = maps_of(drawn, np.full(3, 0.01), np.array([0.8, 1.3]), np.array([1.6, 2.1]))
    assert maps.evidence.mean(axis=(1, 2)) == pytest.approx(np.ones(3), rel=1e-6)
    best = [np.unravel_index(each.argmax(), each.shape) for each in maps.evidence]
    assert [maps.widths[each[0]] for each in best] == pytest.approx([1.2] * 3, abs=0.02)


def test_a_further_kind_gains_the_logarithms_of_all_elements():
    evidence = np.random.default_rng(0).uniform(1e-4, 4e4, (70, 3, 4))
    fit = np.random.default_rng(1).uniform(0.0, 4e4, 70)
    mixture = 0.98 * (0.85 * fit[:, None, None] + 0.15 * evidence) + 0.02
    assert mixture_gain(evidence, fit, 0.15) == pytest.approx(np.log(mixture).sum(axis=0), rel=1e-12)


@pytest.mark.parametrize("seed", range(2))
def test_a_bias_of_each_element_makes_no_kinds_and_hides_none(seed: int):
    bias = np.random.default_rng(seed).normal(0.0, 0.01, (52, 2))
    widths, heights = np.linspace(0.8, 1.2, 41), np.linspace(1.3, 1.7, 41)
    for sizes, num in ((np.array([[0.95, 1.5]]), 1), (np.array([[0.95, 1.45], [0.95, 1.55]]), 2)):
        size = sizes[np.arange(52) % num] + bias
        across = np.exp(-0.5 * ((widths - size[:, :1]) / 0.004) ** 2)
        up = np.exp(-0.5 * ((heights - size[:, 1:]) / 0.004) ** 2)
        evidence = across[:, :, None] * up[:, None]
        raw = Maps(widths, heights, evidence / evidence.mean(axis=(1, 2), keepdims=True) * 0.9999 + 1e-4)
        assert len(find_kinds(raw).kinds) > num  # the density of points says nothing of a bias
        solution, _ = find_kinds_with(with_bias(raw, lambda maps: maps), np.full(52, -1), np.full(52, -1))
        label = solution.posterior.argmax(axis=1)
        assert len(solution.kinds) == num
        assert all(len(set(label[each::num].tolist())) == 1 for each in range(num))


@pytest.mark.parametrize(("step", "bias"), [(0.01, 0.03), (0.02, 0.04), (0.03, 0.04)])
def test_a_bias_of_several_centimetres_is_noticed_though_a_smaller_one_does_not_pay(step: float, bias: float):
    axis = np.arange(0.8, 2.0, step)
    sizes = np.array([[1.0, 1.5], [1.3, 1.75]])[np.arange(24) % 2]
    drawn = sizes + bias * np.random.default_rng(1).normal(size=(24, 2))
    sides = np.exp(-0.5 * ((axis - drawn[:, :, None]) / max(0.01, 0.7 * step)) ** 2)
    evidence = sides[:, 0, :, None] * sides[:, 1, None]
    raw = Maps(axis, axis, evidence / evidence.mean(axis=(1, 2), keepdims=True) * 0.9999 + 1e-4)
    cost = VALUE_COST * np.log(24)
    lengths = [find_kinds(raw).length] + [find_kinds(raw.blurred(each)).length + cost for each in (0.02, 0.04)]
    solution = find_kinds(chosen := with_bias(raw, lambda maps: maps))
    assert solution.length + (0.0 if chosen is raw else cost) <= min(lengths) + 2.0
    label = solution.posterior.argmax(axis=1)
    assert len(solution.kinds) == 2
    # An element that deviates by three biases may be unknown.
    assert all(np.unique(label[each::2], return_counts=True)[1].max() >= 11 for each in range(2))


def test_exact_evidence_has_no_bias():
    maps = _maps(np.array([0, 0, 1, 1, 2, 2, 3, 3]))
    assert with_bias(maps, lambda maps: maps) is maps
