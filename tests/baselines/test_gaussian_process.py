import numpy as np
import pytest

from grammarlab.baselines import gaussian_process, kde
from grammarlab.baselines.gaussian_process import PENALTY, fit
from grammarlab.errors import UsageError
from tests.preference.processes.test_evidence import dense_loss
from tests.preference.rows import counted_rows, toy_towers


def energy(rows, scores, found, penalty=PENALTY):
    """Equation 4.8 at what a fit found, one label at a time."""
    theta = found.posterior.hyperparameters
    return dense_loss(rows, scores, theta.amplitude, theta.weights, theta.noise) + penalty * theta.weights.sum()


def test_learned_relevance_makes_predictions_blind_to_heights():
    """Figure 4.6: along h1 and h2 the prediction is flat with relevance detection, and not without it."""
    rows, scores, _ = toy_towers(9, 7)
    found = fit(rows, scores)
    green = np.flatnonzero((rows[:, 1] == 1) & (rows[:, 4] == 1))[0]
    heights = np.linspace(1.0, 5.0, 41)
    theta = found.posterior.hyperparameters
    shared = gaussian_process.common_relevance(gaussian_process.observe(rows, scores), theta.noise, PENALTY)
    isotropic = gaussian_process.condition(
        gaussian_process.Hyperparameters(shared.amplitude, shared.weights, theta.noise),
        gaussian_process.observe(rows, scores),
    )
    for column in (12, 13):
        varied = np.repeat(rows[green : green + 1], len(heights), axis=0)
        varied[:, column] = heights
        with_detection, without = found.predict(varied).mean, isotropic.predict(varied).mean
        np.testing.assert_allclose(with_detection, 50.0, atol=2.5)
        assert np.ptp(without) > 5.0 * np.ptp(with_detection)


def test_irrelevant_columns_get_no_weight_and_relevant_ones_do():
    rows, scores = counted_rows(120, 12)
    found = fit(rows, scores)
    assert (found.search.weights[:2] > 0.01).all()
    assert (found.search.weights[2:] < 0.002).all()
    new, truth = counted_rows(500, 12, seed=9)
    assert np.corrcoef(found.predict(new).mean, truth)[0, 1] > 0.99


def test_the_energy_is_that_of_equation_4_8():
    rows, scores = counted_rows(40, 6)
    found = fit(rows, scores)
    assert energy(rows, scores, found) == pytest.approx(found.search.energy, abs=0.1)


def test_no_single_hyperparameter_can_be_changed_for_a_better_energy():
    rows, scores = counted_rows(40, 6)
    found = fit(rows, scores)
    least = energy(rows, scores, found)
    theta = found.posterior.hyperparameters
    for column in range(6):
        for factor in (0.8, 1.25):
            weights = theta.weights.copy()
            weights[column] = weights[column] * factor or 1e-4 * factor
            moved = dense_loss(rows, scores, theta.amplitude, weights, theta.noise) + PENALTY * weights.sum()
            assert moved > least - 0.05
    for factor in (0.8, 1.25):
        moved = dense_loss(rows, scores, theta.amplitude * factor, theta.weights, theta.noise)
        assert moved + PENALTY * theta.weights.sum() > least - 0.05


def test_a_warm_start_never_ends_higher():
    rows, scores = counted_rows(60, 10)
    before = fit(rows[:40], scores[:40])
    assert fit(rows, scores, warm=before).search.energy <= fit(rows, scores).search.energy


def test_a_warm_start_must_fit():
    rows, scores = counted_rows(10, 4)
    with pytest.raises(UsageError, match="same 4 columns"):
        fit(rows, scores, warm=fit(rows[:, :3], scores))
    with pytest.raises(UsageError, match="KernelDensityPreference"):
        fit(rows, scores, warm=kde.fit(rows, scores))


@pytest.mark.parametrize("options", [{"noise": 0.0}, {"noise": float("nan")}, {"penalty": -1.0}])
def test_noise_and_penalty_must_be_in_range(options):
    with pytest.raises(UsageError, match="noise > 0"):
        fit([[1.0]], [1.0], **options)


def test_zero_mean_far_from_all_labels():
    rows, scores = counted_rows(60, 5)
    far = fit(rows, scores).predict(np.full((1, 5), 500.0))
    assert far.mean[0] == pytest.approx(0.0, abs=1e-9)
    assert far.std[0] > 10.0


def test_labels_beyond_the_bound_still_inform_predictions(monkeypatch):
    monkeypatch.setattr(gaussian_process, "MAX_ROWS_TO_FIT", 30)
    rows, scores = counted_rows(100, 8)
    found = fit(rows, scores, seed=1)
    np.testing.assert_allclose(found.predict(rows).mean, scores, atol=8.0)
    assert len(found.rows) == len(np.unique(rows, axis=0))
