"""The default method from points to kinds, compared with k-means and the truth."""

from dataclasses import replace

import numpy as np
import pytest

from grammarlab.matching.coupled import couple
from grammarlab.matching.elements import Elements
from grammarlab.matching.library import templates_by_name
from grammarlab.matching.match import Match, groups
from grammarlab.matching.plain import compare, match_alone
from grammarlab.matching.scenes import SceneOptions, rectangles, scene_of_sizes
from tests.cases import some, takes_turns

FIGURE = np.array([[1.0, 1.5], [1.0, 1.9], [1.3, 1.9], [1.3, 1.5]])
TEMPLATES = templates_by_name("rectangle,diamond")
"""Of as many wires and parameters each, so that one sampler is compiled for both."""


def figure(noise: float) -> Elements:
    """The eight rectangles of Figure 5.2; noise is uniform, as a fraction of the distance between points."""
    points = 1500
    kind = np.repeat(np.arange(4), 2)
    made = scene_of_sizes(FIGURE, kind, SceneOptions(noise=0.0, occluded=0.0, points=points), 0)
    spacing = np.repeat(2.0 * FIGURE[kind].sum(axis=1) / points, made.counts)[:, None]
    away = np.random.default_rng(1).uniform(-noise, noise, size=made.points.shape)
    return replace(made, points=made.points + spacing * away)


def mislabelled(match: Match) -> int:
    assert match.elements.truth is not None
    return compare(match, match.elements.truth)["mislabelled"]


@takes_turns
@pytest.mark.parametrize("noise", some([0.0, 4.0]))
def test_rectangles_of_figure_5_2_share_what_they_share_with_noise_of_four_spacings(noise):
    found = couple(figure(noise), TEMPLATES, 0)
    assert mislabelled(found) == 0
    assert len(found.values) == 4
    made = np.array(found.parameters)
    truth = FIGURE[np.repeat(np.arange(4), 2)]
    for axis in (0, 1):
        same = made[:, None, axis] == made[None, :, axis]
        assert np.array_equal(same, truth[:, None, axis] == truth[None, :, axis])
    assert np.abs(made - truth).max() < 0.006


@takes_turns
def test_heights_five_centimetres_apart_are_two_kinds_that_share_their_width():
    sizes = np.array([[0.95, 1.54], [0.95, 1.49]])
    options = SceneOptions(noise=0.01, occluded=0.0)
    found = couple(scene_of_sizes(sizes, np.array([0, 0, 0, 0, 0, 1, 1, 1]), options, 4), TEMPLATES, 0)
    assert mislabelled(found) == 0
    assert [each["shared_parameters"] for each in groups(found)] == [["width"], ["width"]]


@takes_turns
def test_kinds_found_together_agree_more_with_the_truth_than_those_of_k_means():
    scene = rectangles(SceneOptions(), 1)
    assert scene.truth is not None
    together, alone = (
        compare(each, scene.truth) for each in (couple(scene, TEMPLATES, 0), match_alone(scene, TEMPLATES, 5))
    )
    assert together["adjusted_mutual_information"] > alone["adjusted_mutual_information"] + 0.1
    assert together["sure_and_right"] >= 0.9 * together["sure"] > 0
