import jax
import numpy as np
import pytest

from grammarlab.baselines import gaussian_process
from grammarlab.errors import UsageError
from grammarlab.preference.observations import observe
from grammarlab.preference.processes.grouped import fit
from grammarlab.preference.processes.grouped_search import (
    AMPLITUDE,
    EPSILON,
    NOISE,
    Kernel,
    problem_of,
    scales_of,
    search,
    starting_kernels,
)
from tests.cases import takes_turns
from tests.preference.processes.test_evidence import dense_covariance, dense_loss

GROUPS = np.repeat(np.arange(6), 3)


def styled_rows(num_rows, seed=0):
    """Six choices of three alternatives as counts; scores depend on choices 0 and 1 only."""
    choices = np.random.default_rng(seed).integers(0, 3, (num_rows, 6))
    rows = np.concatenate([np.eye(3)[column] for column in choices.T], axis=1)
    same = choices[:, 0] == choices[:, 1]
    return rows, np.where(same, np.where(choices[:, 0] == 0, 80.0, 30.0), 0.0)


def energy(rows, scores, kernel, highest):
    """E one label at a time, in units of the highest score."""
    weights = kernel.weights[GROUPS]
    value = dense_loss(rows / scales_of(rows), scores / highest, kernel.amplitude, weights, kernel.noise)
    for value_of, (median, deviation) in ((kernel.amplitude, AMPLITUDE), (kernel.noise, NOISE)):
        value += 0.5 * (np.log(value_of / median) / deviation) ** 2
    epsilon = EPSILON / 6.0  # of six groups
    return value + np.log1p((1.0 + kernel.amplitude) * kernel.weights / epsilon).sum()


def searched(rows, scores, start=0):
    problem = problem_of(observe(rows, scores), GROUPS, scales_of(rows), scores.max())
    with jax.enable_x64(True):
        return problem, search(problem, starting_kernels(problem, 0, 2, np.zeros(problem.num_groups))[start])


@pytest.mark.parametrize("num_rows", [12, 40, 90])
def test_the_energy_is_that_of_a_dense_computation(num_rows):
    rows, scores = styled_rows(num_rows)
    _, kernel = searched(rows, scores)
    assert kernel.energy == pytest.approx(energy(rows, scores, kernel, scores.max()), rel=1e-6)


@takes_turns
def test_errors_are_not_explained_by_many_small_effects():
    randomness = np.random.default_rng(5)
    rows = randomness.integers(0, 2, (64, 140)).astype(float)
    meant = 40.0 * rows[:, 0] + 30.0 * rows[:, 1]
    kernel = fit(rows, np.clip(meant + 20.0 * randomness.normal(size=64), 0.0, 100.0)).explanations[0].kernel
    assert np.count_nonzero(kernel.weights) < 20
    assert 10.0 < 100.0 * np.sqrt(kernel.noise) < 30.0


def test_no_nearby_kernel_explains_the_scores_better():
    rows, scores = styled_rows(60)
    _, kernel = searched(rows, scores)
    for direction in np.random.default_rng(1).normal(0.0, 0.1, (30, 8)):
        moved = Kernel(
            kernel.weights * np.exp(direction[2:]),
            kernel.amplitude * np.exp(direction[0]),
            float(np.clip(kernel.noise * np.exp(direction[1]), 1e-6, 5e-3)),
        )
        assert energy(rows, scores, moved, scores.max()) > kernel.energy - 1e-3


def test_groups_that_matter_get_a_weight_and_the_others_none():
    rows, scores = styled_rows(60)
    _, kernel = searched(rows, scores)
    assert kernel.weights[:2].min() > 0.1
    assert kernel.weights[2:].max() < 0.01


def test_a_group_that_a_start_leaves_out_stays_out():
    rows, scores = styled_rows(30)
    problem = problem_of(observe(rows, scores), GROUPS, scales_of(rows), scores.max())
    start = Kernel(np.array([0.05, 0.0, 0.05, 0.0, 0.05, 0.0]), *(median for median, _ in (AMPLITUDE, NOISE)))
    with jax.enable_x64(True):
        assert not search(problem, start).weights[[1, 3, 5]].any()


@takes_turns
def test_tied_weights_learn_from_fewer_labels_than_one_a_column():
    new, truth = styled_rows(400, seed=5)

    def mistakes(found):
        return np.abs(found.predict(new).mean - truth).mean()

    gains = []
    for seed in range(4):
        rows, scores = styled_rows(30, seed=10 + seed)
        gains.append(mistakes(gaussian_process.fit(rows, scores)) - mistakes(fit(rows, scores, groups=GROUPS)))
    assert np.mean(gains) > 0.0


def test_thirty_labels_settle_two_choices_among_six():
    rows, scores = styled_rows(40, seed=3)
    new, truth = styled_rows(300, seed=4)
    assert np.abs(fit(rows, scores, groups=GROUPS).predict(new).mean - truth).mean() < 2.0


def test_predictions_are_those_of_a_mixture_of_textbook_processes():
    rows, scores = styled_rows(14, seed=2)
    new, _ = styled_rows(20, seed=8)
    found = fit(rows, scores, groups=GROUPS)
    means, variances, shares = [], [], []
    counting = [explanation for explanation in found.explanations if explanation.share > 1e-3]
    for explanation in counting:
        theta = explanation.posterior.hyperparameters
        C = dense_covariance(rows, rows, theta.amplitude, theta.weights) + theta.noise * np.eye(len(rows))
        k = dense_covariance(new, rows, theta.amplitude, theta.weights)
        means.append(k @ np.linalg.solve(C, scores))
        variances.append(theta.amplitude + theta.noise - np.einsum("mn,nm->m", k, np.linalg.solve(C, k.T)))
        shares.append(explanation.share / sum(other.share for other in counting))
    mean = np.array(shares) @ np.array(means)
    second = np.array(shares) @ (np.array(variances) + np.array(means) ** 2)
    prediction = found.predict(new)
    np.testing.assert_allclose(prediction.mean, mean, atol=1e-6)
    np.testing.assert_allclose(prediction.std**2, second - mean**2, atol=1e-4)
    assert sum(shares) == pytest.approx(1.0)


def test_shares_follow_the_evidence():
    rows, scores = styled_rows(12, seed=1)
    found = fit(rows, scores, groups=GROUPS).explanations
    ratios = [explanation.share / found[0].share for explanation in found]
    expected = [np.exp(found[0].kernel.energy - explanation.kernel.energy) for explanation in found]
    np.testing.assert_allclose(ratios, expected, rtol=1e-9)
    assert ratios == sorted(ratios, reverse=True)


def test_choices_that_always_came_together_leave_a_model_uncertain_that_has_one_of_them():
    together = np.repeat(np.random.default_rng(0).integers(0, 2, (12, 1)), 2, axis=1).astype(float)
    found = fit(together, 100.0 * together[:, 0])
    known, apart = found.predict([[0.0, 0.0], [1.0, 1.0]]), found.predict([[1.0, 0.0], [0.0, 1.0]])
    assert apart.std.min() > 3.0 * known.std.max()


def test_units_of_columns_and_scores_do_not_matter():
    rows, scores = styled_rows(30)
    scales = np.random.default_rng(0).uniform(0.01, 100.0, rows.shape[1])
    new, _ = styled_rows(50, seed=1)
    plain = fit(rows, scores, groups=GROUPS).predict(new)
    scaled = fit(rows * scales + 3.0, 0.5 * scores, groups=GROUPS).predict(new * scales + 3.0)
    np.testing.assert_allclose(2.0 * scaled.mean, plain.mean, atol=0.1)
    np.testing.assert_allclose(2.0 * scaled.std, plain.std, atol=0.1)


def test_an_alternative_never_seen_is_unlike_all_others_where_the_choice_matters():
    rows, scores = styled_rows(60)
    seen = rows[:, 2] == 0
    found = fit(rows[seen], scores[seen], groups=GROUPS)
    new = rows[~seen]
    assert found.predict(new).std.min() > 2.0 * found.predict(rows[seen]).std.max()


def test_a_warm_start_never_explains_worse():
    rows, scores = styled_rows(48)
    before = fit(rows[:32], scores[:32], groups=GROUPS)
    cold = fit(rows, scores, groups=GROUPS, seed=1)
    warm = fit(rows, scores, groups=GROUPS, seed=1, warm=before)
    assert warm.explanations[0].kernel.energy <= cold.explanations[0].kernel.energy + 1e-9


def test_a_warm_start_from_other_columns_is_refused():
    rows, scores = styled_rows(10)
    for other in (fit(rows[:, :3], scores, groups=GROUPS[:3]), fit(rows, scores)):
        with pytest.raises(UsageError, match="on the same 18 columns and groups"):
            fit(rows, scores, groups=GROUPS, warm=other)


@takes_turns
def test_noisy_scores_are_smoothed():
    rows, scores = styled_rows(150)
    noisy = np.clip(scores + np.random.default_rng(0).normal(0.0, 8.0, 150), 0.0, 100.0)
    found = fit(rows, noisy, groups=GROUPS)
    assert np.abs(found.predict(rows).mean - scores).mean() < 0.7 * np.abs(noisy - scores).mean()


def test_explain_names_the_choices():
    rows, scores = styled_rows(80)
    found = fit(rows, scores, groups=GROUPS).explain(["wall", "roof", "door", "window", "floor", "lamp"])
    assert {entry.name for entry in found[:2]} == {"wall", "roof"}
    assert {entry.level for entry in found[2:]} == {"none"}
