"""Templates from CGA rules: their outline is that of a derivation, for any values of the attributes."""

import numpy as np
import pytest
import shapely

from grammarlab.derivation import derive
from grammarlab.errors import GrammarlabError
from grammarlab.language.grammar import Grammar
from grammarlab.matching.library import templates_by_name, templates_of_rules
from grammarlab.matching.template import points_along
from grammarlab.scene import realize, triangles

CASEMENT = """
version "2023.0"
@Range(min=0.3, max=0.8) attr pane = 0.4
@Range(min=0.8, max=2.5) attr h = 1.5
@Range(min=0.05, max=0.15) attr frame = 0.08
@Range(min=1, max=3, stepsize=1) attr panes = 2
attr glass = "clear"
@StartRule
Lot --> s(panes * pane + 2 * frame, h, 0.1) primitiveCube() comp(f) { front : Window }
Window --> split(x) { frame : Frame. | ~1 : Middle | frame : Frame. }
Middle --> split(y) { frame : Frame. | ~1 : Panes | frame : Frame. }
Panes --> split(x) { pane : Pane. }*
"""
FRONT = "--> s(w, h, 0.1) primitiveCube() comp(f) { front : Window } "


def drawn(segments):
    return shapely.union_all([shapely.LineString(each) for each in segments if np.ptp(each, axis=0).any()])


@pytest.mark.parametrize("seed", range(3))
def test_a_template_looks_like_the_derivation_for_any_attributes(seed):
    random = np.random.default_rng(seed)
    values = {"pane": random.uniform(0.3, 0.8), "h": random.uniform(0.8, 2.5), "frame": random.uniform(0.05, 0.15)}
    panes = int(random.integers(1, 4))
    template = templates_of_rules(CASEMENT, "casement.cga")[panes - 1]
    assert (template.name, template.parameters) == (f"casement[panes={panes}]", ("width", "height", "frame"))
    batch = triangles(realize(derive(Grammar.parse(CASEMENT), 1, seed=0, attributes={**values, "panes": float(panes)})))
    corners = batch.vertices.astype(np.float64)[:, :2]
    corners = corners - corners.min(axis=0)
    parameters = np.array([*corners.max(axis=0), values["frame"]])
    assert np.abs(parameters[0] - (panes * values["pane"] + 2 * values["frame"])) < 1e-5
    outline = drawn(points_along(template, parameters))
    assert shapely.distance(outline, shapely.points(corners)).max() < 1e-5
    ends = shapely.get_coordinates(outline)
    assert np.abs(ends[:, None] - corners).max(axis=2).min(axis=1).max() < 1e-5
    assert (template.limits[:, 0] + template.limits[:, 1:] @ parameters > -1e-6).all()
    narrow = parameters - [0.9 * parameters[0], 0, 0]
    assert (template.limits[:, 0] + template.limits[:, 1:] @ narrow).min() < 0.0


@pytest.mark.parametrize(
    ("rules", "message"),
    [
        (f"attr w = 1 attr h = 1 Lot {FRONT} Window --> split(x) {{ ~0.3 : A. }}*", "stepsize"),
        (f"attr w = 1 const h = 1 Lot {FRONT} Window --> X.", "change the width only"),
        (f"const w = 1 const h = 1 Lot {FRONT} Window --> X.", "1 to 12 attributes"),
        (f"attr w = 1 attr h = 1 Lot {FRONT} Window --> NIL", "edges"),
        (f"attr w = 1 attr h = 1 Lot {FRONT} Window --> extrude(", "mine.cga:1"),
        (f"@Range(min=2, max=3) attr w = 1 attr h = 1 Lot {FRONT} Window --> X.", "w: expected a @Range"),
        (f"attr w = 1 attr h = 1 Lot {FRONT} Window --> split(x) {{ w * w / 3 : A. | ~1 : B. }}", "deviates"),
    ],
)
def test_rules_that_make_no_template_are_refused_with_the_reason(rules, message):
    with pytest.raises(GrammarlabError, match=message):
        templates_of_rules(rules, "mine.cga")


def test_rules_are_named_like_other_templates(tmp_path):
    path = tmp_path / "casement.cga"
    path.write_text(CASEMENT)
    assert len(templates_by_name(f"rectangle,{path}")) == 4
