"""Fits of elements that are unlike their row start from the parameters of the others."""

from dataclasses import replace

import numpy as np
import pytest

from grammarlab.arrays import Floats
from grammarlab.matching import coupled
from grammarlab.matching.coupled import unlike_row
from grammarlab.matching.elements import Clouds, clouds_of
from grammarlab.matching.fit import Fits, first_guess
from grammarlab.matching.library import templates_by_name
from grammarlab.matching.scenes import SceneOptions, scene_of_sizes
from grammarlab.matching.template import Stack, stack

REACH = np.array([[0.0, 0.0], [1.4, 1.0]])
"""Visible part of an element, 1.4 m wide and 1 m high."""
USUAL, LOW, HIGH = (np.array(values) for values in ([1.0, 1.6, 1.1], [0.5, 0.5, 0.3], [2.0, 3.0, 2.5]))
"""Width, height and transom, metres."""


def test_elements_are_compared_with_the_most_frequent_template_of_their_row() -> None:
    row = np.array([0, 0, 0, 1, 1, 1, 2, 2, 2, -1, -1, -1])
    template = np.array([2, 2, 1, 1, 1, 1, 0, 3, 3, 0, 3, 3])
    assert unlike_row(row, template).tolist() == [2, 6]
    assert unlike_row(row, np.zeros(12, dtype=np.int64)).tolist() == []


COSTS = {
    1.0: [[1, 9], [1, 9], [1, 9], [9, 5], [9, 5], [9, 1]],
    0.0: [[3, 9], [9, 9]],
    -1.0: [[4, 4], [9, 2]],
}
"""Costs of two templates by first guess: the second one is that of element 5, without a row. Of elements 3 and 4, which
are fitted again, a first fit hid that 3 is as its row, and 4 differs indeed."""


def test_elements_unlike_their_row_get_the_best_of_fits_from_the_parameters_of_the_others(monkeypatch) -> None:
    calls: list[tuple[list[int], Stack]] = []

    def fit(clouds: Clouds, templates: Stack) -> Fits:
        calls.append((clouds.element.tolist(), templates))
        cost = np.array(COSTS[float(templates.guess[0])], dtype=float)
        # Every number of a fit tells its element, its template and the call that made it.
        name = np.array(100 * len(calls) + 10 * clouds.element[:, None] + np.arange(2), dtype=np.float64)

        def filled(*end: int) -> Floats:
            return np.broadcast_to(name.reshape(*name.shape, *(1,) * len(end)), (*name.shape, *end)).copy()

        return Fits(
            corner=filled(2),
            parameters=filled(3),
            covariance=filled(3, 3),
            noise=filled(),
            cost=cost,
            inside=np.ones_like(cost),
            plane=filled(2),
            hidden=np.zeros_like(cost),
            distance=filled(),
        )

    monkeypatch.setattr(coupled, "fit_all", fit)
    made = scene_of_sizes(np.array([[1.0, 1.5]]), np.zeros(6, dtype=np.int64), SceneOptions(points=20), 0)
    elements = replace(made, row=np.array([0, 0, 0, 0, 0, -1]))
    found = coupled._fits(elements, clouds_of(elements, np.arange(6)), templates_by_name("transom_window,t_window"))
    assert [numbers for numbers, _ in calls] == [[0, 1, 2, 3, 4, 5], [3, 4], [3, 4]]
    for (_, templates), corner in zip(calls[1:], (0.0, -1.0), strict=True):
        assert templates.guess.tolist() == [corner, corner]
        assert templates.usual.tolist() == [[110.0] * 3, [151.0] * 3]
    expected = np.array([[100, 101], [110, 111], [120, 121], [230, 331], [140, 341], [150, 151]], dtype=float)
    for name in ("corner", "parameters", "covariance", "noise", "plane", "distance"):
        column = getattr(found, name)
        assert np.array_equal(column, np.broadcast_to(expected.reshape(6, 2, *(1,) * (column.ndim - 2)), column.shape))
    assert found.cost.tolist() == [[1, 9], [1, 9], [1, 9], [3, 4], [9, 2], [9, 1]]


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
    template = templates_by_name("transom_window")
    given = replace(stack(template), usual=USUAL[None], low=LOW[None], high=HIGH[None], guess=np.array([guess]))
    assert first_guess(REACH[None], given)[0, 0] == pytest.approx(expected, abs=1e-12)
