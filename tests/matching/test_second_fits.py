"""Fits of elements that are unlike their row start from the parameters of the others."""

import jax.numpy as jnp
import numpy as np
import pytest

from grammarlab.matching.coupled import unlike_row
from grammarlab.matching.fit import first_guess

REACH = np.array([[0.0, 0.0], [1.4, 1.0]])
"""Visible part of an element, 1.4 m wide and 1 m high."""
USUAL, LOW, HIGH = (np.array(values) for values in ([1.0, 1.6, 1.1], [0.5, 0.5, 0.3], [2.0, 3.0, 2.5]))
"""Width, height and transom, metres."""


def test_elements_are_compared_with_the_most_frequent_template_of_their_row() -> None:
    row = np.array([0, 0, 0, 1, 1, 1, -1, -1, -1])
    template = np.array([2, 2, 1, 1, 1, 1, 0, 3, 3])
    assert unlike_row(row, template).tolist() == [2, 6]
    assert unlike_row(row, np.zeros(9, dtype=np.int64)).tolist() == []


@pytest.mark.parametrize(
    ("guess", "expected"),
    [
        (1.0, [0.0, 0.0, 1.4, 1.0, 1.1]),  # as large as what is visible
        (0.0, [0.0, 0.0, 1.0, 1.6, 1.1]),  # hidden above
        (-1.0, [0.4, -0.6, 1.0, 1.6, 1.1]),  # hidden below
    ],
)
def test_first_guesses_have_usual_proportions_or_usual_values_from_a_corner(
    guess: float, expected: list[float]
) -> None:
    arguments = (jnp.asarray(each) for each in (REACH, USUAL, LOW, HIGH, guess))
    assert np.asarray(first_guess(*arguments)) == pytest.approx(expected, abs=1e-6)
