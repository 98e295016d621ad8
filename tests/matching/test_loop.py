"""The loop of the paper, from points to kinds."""

import numpy as np

from grammarlab.matching.library import templates_by_name
from grammarlab.matching.paper_loop import match_as_paper
from grammarlab.matching.plain import compare
from grammarlab.matching.scenes import SceneOptions, scene_of_sizes
from tests.cases import takes_turns


@takes_turns
def test_plain_windows_are_not_windows_with_bars_and_replicas_are_found():
    sizes = np.array([[1.0, 1.5], [1.0, 1.9], [1.3, 1.9], [1.3, 1.5]])
    scene = scene_of_sizes(sizes, np.repeat(np.arange(4), 2), SceneOptions(noise=0.005, occluded=0.0), 0)
    found = match_as_paper(scene, templates_by_name("rectangle,cross_window"))
    assert [template.name for template in found.templates] == ["rectangle"]
    assert scene.truth is not None
    assert compare(found, scene.truth)["mislabelled"] == 0
