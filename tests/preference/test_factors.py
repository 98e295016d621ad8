import numpy as np
import pytest

from grammarlab.errors import UsageError
from grammarlab.learning.fitting import fit
from grammarlab.preference.base import AbstractPreference, Prediction, Relevance, dense_rows
from grammarlab.preference.factors import ProductPreference
from tests.cases import takes_turns
from tests.preference.rows import toy_towers


class Fixed(AbstractPreference):
    """A preference that expects the same of every model."""

    num_columns = 2

    def __init__(self, mean, std=0.0, shares=(0.7, 0.0)):
        self.mean, self.std, self.shares = mean, std, shares

    def predict(self, rows):
        size = len(dense_rows(rows))
        return Prediction(np.full(size, float(self.mean)), np.full(size, float(self.std)))

    def explain(self, group_names):
        return [Relevance(name, share, "none") for name, share in zip(group_names, self.shares, strict=True)]


ROWS = np.zeros((3, 2))


def test_scores_multiply_as_shares_of_100():
    predicted = ProductPreference({"colour": Fixed(50), "shape": Fixed(40), "size": Fixed(100)}).predict(ROWS)
    np.testing.assert_allclose(predicted.mean, 20.0)
    np.testing.assert_allclose(predicted.std, 0.0, atol=1e-6)


def test_mean_and_deviation_are_those_of_independent_draws():
    product = ProductPreference({"colour": Fixed(60, 15), "shape": Fixed(30, 10), "size": Fixed(80, 5)})
    rng = np.random.default_rng(0)
    draws = rng.normal([60, 30, 80], [15, 10, 5], (400_000, 3)).prod(axis=1) / 100.0**2
    predicted = product.predict(ROWS)
    np.testing.assert_allclose(predicted.mean, draws.mean(), rtol=0.01)
    np.testing.assert_allclose(predicted.std, draws.std(), rtol=0.01)


def test_two_factors_below_zero_do_not_make_a_wanted_model():
    assert ProductPreference({"a": Fixed(-20), "b": Fixed(-30)}).predict(ROWS).mean.max() == 0.0


def test_a_single_factor_is_itself():
    predicted = ProductPreference({"a": Fixed(30, 4)}).predict(ROWS)
    np.testing.assert_allclose(predicted.mean, 30.0)
    np.testing.assert_allclose(predicted.std, 4.0)


def test_explanations_say_which_factor_looks():
    product = ProductPreference({"colour": Fixed(1, 0, (0.1, 0.9)), "shape": Fixed(1, 0, (0.6, 0.0))})
    names = [entry.name for entry in product.explain(["roof", "door"])]
    assert names == ["colour: door", "shape: roof", "colour: roof", "shape: door"]


@takes_turns
def test_two_factors_learn_the_toy_grammars_preference_from_few_labels_each():
    """Figure 4.5: colour and geometry, trained apart, combined for towers that nobody has scored."""
    rows, by_color, by_geometry = toy_towers(24, 40)
    colour, shape = fit(rows, by_color, method="paper"), fit(rows[:16], by_geometry[:16], method="paper")
    new, color_of_new, geometry_of_new = toy_towers(60, 140, seed=1)
    truth = color_of_new * geometry_of_new / 100.0
    predicted = ProductPreference({"colour": colour, "geometry": shape}).predict(new).mean
    assert np.corrcoef(predicted, truth)[0, 1] > 0.95


def test_factors_must_exist_and_share_their_columns():
    with pytest.raises(UsageError, match="found none"):
        ProductPreference({})
    wide = Fixed(1)
    wide.num_columns = 3
    with pytest.raises(UsageError, match="a: 2, b: 3"):
        ProductPreference({"a": Fixed(1), "b": wide})
