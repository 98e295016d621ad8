import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse

from grammarlab.errors import UsageError
from grammarlab.preference.observations import checked_groups, observe, thinned


@given(st.lists(st.tuples(st.integers(0, 2), st.integers(0, 2), st.integers(0, 100)), min_size=1, max_size=30))
def test_counts_means_and_spread_are_those_of_the_labels(labels):
    table = np.array(labels, dtype=float)
    rows, scores = table[:, :2], table[:, 2]
    seen = observe(rows, scores)
    first_seen = list(dict.fromkeys(map(tuple, rows)))
    assert list(map(tuple, seen.rows)) == first_seen
    spread = 0.0
    for row, mean, count in zip(first_seen, seen.means, seen.counts, strict=True):
        own = scores[np.all(rows == row, axis=1)]
        assert count == len(own)
        assert mean == pytest.approx(own.mean())
        spread += np.sum((own - own.mean()) ** 2)
    assert seen.spread == pytest.approx(spread)


def test_sparse_rows_are_the_same_as_dense_ones():
    rows = np.array([[0.0, 2.0], [1.0, 0.0], [0.0, 2.0]])
    np.testing.assert_array_equal(observe(sparse.csr_array(rows), [1, 2, 3]).rows, observe(rows, [1, 2, 3]).rows)


@pytest.mark.parametrize(
    ("rows", "scores", "message"),
    [
        ([[1.0]], [float("nan")], "found nan at index 0"),
        ([[1.0], [2.0]], [5.0, 101.0], "found 101 at index 1"),
        ([[1.0]], [-1.0], "found -1 at index 0"),
        ([[1.0]], [1.0, 2.0], "2 scores for 1 rows"),
        ([[1.0]], [[1.0]], "found 2 axes"),
        ([[1.0]], ["good"], "numbers from 0 to 100"),
        (np.zeros((0, 3)), [], "at least one label"),
        ([[1.0, 2.0], [3.0, float("inf")]], [1.0, 2.0], "found inf in row 1, column 1"),
        ([1.0, 2.0], [1.0, 2.0], "found 1 axes"),
        ([["a"]], [1.0], "table of numbers"),
    ],
)
def test_bad_labels_are_named(rows, scores, message):
    with pytest.raises(UsageError, match=message):
        observe(rows, scores)


@pytest.mark.parametrize("groups", [[0, 1], [0.5, 1.0, 2.0], [0, -1, 2]])
def test_groups_must_be_one_number_a_column(groups):
    with pytest.raises(UsageError, match="one integer >= 0"):
        checked_groups(groups, 3)


def test_thinning_keeps_the_distribution_of_scores_and_depends_on_the_seed_alone():
    rng = np.random.default_rng(0)
    rows = rng.normal(size=(3000, 2))
    seen = observe(rows, rng.choice([0.0, 20.0, 70.0], 3000, p=[0.8, 0.15, 0.05]))
    part = thinned(seen, 300, seed=4)
    for score in (0.0, 20.0, 70.0):
        assert np.mean(part.means == score) == pytest.approx(np.mean(seen.means == score), abs=0.01)
    np.testing.assert_array_equal(part.rows, thinned(seen, 300, seed=4).rows)
    assert not np.array_equal(part.rows, thinned(seen, 300, seed=5).rows)
    assert thinned(seen, 3000, seed=4) is seen
