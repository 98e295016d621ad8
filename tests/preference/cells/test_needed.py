"""Columns of further kinds: needed where they explain scores that others do not, and only there."""

import numpy as np
import pytest

from grammarlab.preference.cells.further_columns import MAX_ROWS, MIN_LABELS, required_columns, selected

KNOWN, WIDTH = 8, 40


def asked(scores_of, num=60, noise=0.0, seed=0, price=0.0):
    """Indices of needed columns for scores that are a function of coins, with normal noise."""
    randomness = np.random.default_rng(seed)
    rows = randomness.integers(0, 2, (num, WIDTH)).astype(float)
    scores = np.clip(scores_of(rows) + randomness.normal(0.0, noise, num), 0.0, 100.0)
    plain, prices = np.zeros(WIDTH, dtype=bool), np.full(WIDTH - KNOWN, price)
    return required_columns(
        rows, scores, groups=np.arange(WIDTH), continuous=plain, num_known=KNOWN, prices=prices
    ).columns.tolist()


@pytest.mark.parametrize("noise", [0.0, 10.0])
def test_a_column_that_alone_explains_scores_is_needed(noise):
    assert asked(lambda rows: 80.0 * rows[:, 20], noise=noise) == [20]
    assert asked(lambda rows: 80.0 * rows[:, 1] * rows[:, 20], noise=noise) == [20]


def test_a_column_must_gain_its_price():
    assert asked(lambda rows: 80.0 * rows[:, 20], price=20.0) == [20]
    assert asked(lambda rows: 80.0 * rows[:, 20], price=1e4) == []


def test_a_column_that_is_too_expensive_hides_no_other():
    rows = np.random.default_rng(0).integers(0, 2, (60, WIDTH)).astype(float)
    rows[:, 30] = rows[:, 1] * rows[:, 20]
    prices = np.where(np.arange(KNOWN, WIDTH) == 30, 1e4, 0.0)
    options = {"groups": np.arange(WIDTH), "continuous": np.zeros(WIDTH, dtype=bool), "num_known": KNOWN}
    assert required_columns(rows, 80.0 * rows[:, 30], **options, prices=prices).columns.tolist() == [20]
    assert required_columns(rows, 80.0 * rows[:, 30], **options, prices=0.0 * prices).columns.tolist() == [30]


def test_a_column_that_is_too_expensive_leaves_cheaper_ones():
    # Of three columns that say nearly the same, the first two cost too much.
    rows = np.random.default_rng(0).integers(0, 2, (60, WIDTH)).astype(float)
    rows[:, 30] = rows[:, 31] = rows[:, 32]
    rows[0, 31], rows[:2, 32] = 1.0 - rows[0, 31], 1.0 - rows[:2, 32]
    prices = 9.0 * (np.arange(KNOWN, WIDTH) == 32)
    prices[30 - KNOWN], prices[31 - KNOWN] = 1e5, 1e4
    options = {"groups": np.arange(WIDTH), "continuous": np.zeros(WIDTH, dtype=bool), "num_known": KNOWN}
    assert required_columns(rows, 80.0 * rows[:, 30], **options, prices=prices).columns.tolist() == [32]


@pytest.mark.parametrize("noise", [0.0, 10.0])
@pytest.mark.parametrize("seed", range(3))
def test_nothing_is_needed_where_known_columns_explain_scores(noise, seed):
    assert asked(lambda rows: 80.0 * rows[:, 0] * rows[:, 1], noise=noise, seed=seed) == []


@pytest.mark.parametrize("seed", range(3))
def test_nothing_is_needed_for_scores_without_a_reason(seed):
    assert asked(lambda rows: np.random.default_rng(seed + 9).uniform(0.0, 100.0, len(rows)), seed=seed) == []


def test_few_labels_need_nothing():
    assert asked(lambda rows: 80.0 * rows[:, 20], num=MIN_LABELS - 1) == []


@pytest.mark.parametrize("num", [0, 1, MAX_ROWS, MAX_ROWS + 1, 5000])
def test_of_many_labels_an_even_selection_by_score_is_used(num):
    scores = np.random.default_rng(num).uniform(0.0, 100.0, num)
    some = selected(scores)
    assert len(some) == min(num, MAX_ROWS)
    assert (np.diff(some) > 0).all()
    if num > MAX_ROWS:
        assert np.abs(np.sort(scores[some]) - np.quantile(scores, np.linspace(0.0, 1.0, MAX_ROWS))).max() < 3.0


def test_the_posterior_is_higher_where_cells_explain_more():
    rows = np.random.default_rng(0).integers(0, 2, (60, WIDTH)).astype(float)
    options = {"groups": np.arange(WIDTH), "continuous": np.zeros(WIDTH, dtype=bool), "num_known": KNOWN}
    prices = np.zeros(WIDTH - KNOWN)

    def posterior(scores, price=0.0):
        return required_columns(rows, scores, **options, prices=prices + price).log_posterior

    clear, unclear = 80.0 * rows[:, 1], np.random.default_rng(1).permutation(80.0 * rows[:, 1])
    assert posterior(clear) > posterior(unclear)
    assert posterior(80.0 * rows[:, 20], 9.0) == pytest.approx(posterior(80.0 * rows[:, 20]) - 9.0)
    assert required_columns(rows[:9], clear[:9], **options, prices=prices).log_posterior == -np.inf
