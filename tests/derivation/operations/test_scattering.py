"""``scatter``: where points lie, how they stand, and that they depend on nothing but their place."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import kstest, truncnorm

from grammarlab.derivation import Budget, derive
from grammarlab.errors import BudgetError, DerivationError
from grammarlab.language.checking.check import check_text
from grammarlab.language.grammar import Grammar
from grammarlab.runs.sample.checks import SUPPORTED

L_SHAPE = np.array([[0.0, 0, 0], [0, 0, 12], [8, 0, 12], [8, 0, 22], [26, 0, 22], [26, 0, 0]])
MARK = "primitiveCube() s(1, 1, 1) Mark"


def marks(rules: str, num_models: int = 1, **options):
    """The forest, and the points [K, 3] at which its marks stand."""
    forest = derive(Grammar.parse(rules), num_models, seed=5, **options)
    wanted = forest.nodes.symbol[forest.leaves.node] == forest.symbols.index("Mark")
    return forest, forest.leaves.position[wanted], forest.leaves.frame[wanted]


def test_uniform_points_fill_a_rectangle_evenly():
    _, points, _ = marks(f"Lot --> scatter(surface, 4000, uniform) {{ {MARK} }}", footprint=(10.0, 4.0))
    assert points.shape == (4000, 3)
    assert np.abs(points[:, 1]).max() == 0.0
    for axis, length in ((0, 10.0), (2, 4.0)):
        assert kstest(points[:, axis] / length, "uniform").pvalue > 0.001


def test_uniform_points_lie_on_the_faces_of_a_box_in_proportion_to_their_areas():
    rules = f"Lot --> extrude(2) scatter(surface, 6000, uniform) {{ {MARK} }}"
    forest, points, frame = marks(rules, footprint=(10.0, 4.0))
    sides = {(0, 0.0): 8, (0, 10.0): 8, (1, 0.0): 40, (1, 2.0): 40, (2, 0.0): 20, (2, 4.0): 20}
    up = forest.frames[frame][:, :, 1]
    for (axis, place), area in sides.items():
        there = np.abs(points[:, axis] - place) < 1e-9
        assert there.sum() / 6000 == pytest.approx(area / 136, abs=0.03)
        outwards = np.eye(3)[axis] * (1.0 if place else -1.0)
        assert np.allclose(up[there], outwards)
    assert np.allclose(np.linalg.det(forest.frames), 1.0)


@pytest.mark.parametrize("distribution", ["uniform", "gaussian", "gaussian, left, '0.3", "gaussian, center, 4"])
def test_points_lie_on_the_polygon(distribution):
    _, points, _ = marks(f"Lot --> scatter(surface, 2000, {distribution}) {{ {MARK} }}", footprint=L_SHAPE)
    x, y, z = points.T
    assert np.abs(y).max() < 1e-9
    assert ((x >= -1e-9) & (x <= 26 + 1e-9) & (z >= -1e-9) & (z <= 22 + 1e-9)).all()
    assert not ((x < 8 - 1e-6) & (z > 12 + 1e-6)).any()


def test_normally_distributed_points_are_those_of_a_truncated_normal_distribution():
    rules = f"Lot --> scatter(surface, 3000, gaussian, left, '0.1) {{ {MARK} }}"
    _, points, _ = marks(rules, footprint=(10.0, 4.0))
    assert kstest(points[:, 0], truncnorm(0, 10, 0, 1.0).cdf).pvalue > 0.001
    assert kstest(points[:, 2], truncnorm(-5, 5, 2, 0.4).cdf).pvalue > 0.001
    _, plain, _ = marks(f"Lot --> scatter(surface, 3000, gaussian) {{ {MARK} }}", footprint=(10.0, 4.0))
    assert plain[:, 0].std() == pytest.approx(1.6, abs=0.1)


def test_without_deviation_all_points_are_at_the_mean():
    rules = f"Lot --> extrude(6) scatter(scope, 5, gaussian, front, 0) {{ {MARK} }}"
    _, points, _ = marks(rules, footprint=(10.0, 4.0))
    assert np.allclose(points, [5.0, 3.0, 4.0])


def test_points_in_a_scope_fill_it_and_keep_its_axes():
    rules = f"Lot --> extrude(6) rotateScope(0, 90, 0) scatter(scope, 3000, uniform) {{ {MARK} }}"
    forest, points, frame = marks(rules, footprint=(10.0, 4.0))
    for axis, length in enumerate((10.0, 6.0, 4.0)):
        assert kstest(points[:, axis] / length, "uniform").pvalue > 0.001
    assert len(np.unique(frame)) == 1
    assert np.allclose(forest.frames[frame[0]][:, 0], [0, 0, -1])


def test_points_are_the_same_in_any_batch():
    rules = f"""Lot --> extrude(rand(2, 9)) roofHip(30) scatter(surface, 3 + rand(5), uniform) {{ {MARK} }}
        comp(f) {{ top : scatter(surface, 9, gaussian) {{ 30% : {MARK} else : NIL }} }}"""
    whole, points, _ = marks(rules, 30, footprint=L_SHAPE)
    model = whole.nodes.model[whole.leaves.node]
    for index in (0, 7, 29):
        _, alone, _ = marks(rules, 1, first_model=index, footprint=L_SHAPE)
        assert np.array_equal(alone, points[model == index])


def test_points_draw_for_themselves_and_do_not_change_other_draws():
    plain = derive(Grammar.parse("Lot --> extrude(rand(2, 9)) A"), 5, seed=5)
    rules = f"Lot --> extrude(rand(2, 9)) scatter(surface, 20, uniform) {{ [ s(rand(1, 2), 1, 1) A ] {MARK} }} A"
    forest = derive(Grammar.parse(rules), 5, seed=5)
    heights = forest.draws.value[forest.draws.site == 0]
    assert np.array_equal(heights, plain.draws.value)
    inner = forest.draws.value[forest.draws.site == 1]
    assert len(np.unique(inner)) == 100
    assert len(forest.draws.node) == 105


@pytest.mark.parametrize("count", ["0", "-3", "0.4"])
def test_less_than_one_point_is_none(count):
    forest = derive(Grammar.parse(f"Lot --> scatter(surface, {count}, uniform) {{ A }}"), 2, seed=1)
    assert len(forest.nodes) == len(forest.leaves) == 2, "a lot without points is a leaf itself"


def test_a_shape_without_a_surface_gets_no_points_on_it():
    rules = "Lot --> scatter(scope, 1, uniform) { scatter(surface, 5, uniform) { A } scatter(scope, 2, uniform) { B } }"
    forest = derive(Grammar.parse(rules), 1, seed=1)
    assert [forest.symbols[symbol] for symbol in forest.nodes.symbol] == ["Lot", "B", "B"]


def test_too_many_points_and_a_negative_deviation_are_refused():
    with pytest.raises(BudgetError, match="1:9"):
        derive(Grammar.parse("Lot --> scatter(surface, 1000000000, uniform) { A }"), 1, 1, budget=Budget(shapes=1000))
    with pytest.raises(DerivationError, match="deviation of at least 0"):
        derive(Grammar.parse("Lot --> scatter(surface, 3, gaussian, center, -1) { A }"), 1, 1)


def test_points_in_a_volume_are_not_carried_out_and_reported():
    text = "Lot --> extrude(3) scatter(volume, 3, uniform) { A }"
    assert [f.severity for f in check_text(text, "lot.cga", SUPPORTED) if f.code == "unsupported"] == ["unsupported"]
    with pytest.raises(DerivationError, match="volume is not supported"):
        derive(Grammar.parse(text), 1, 1)
