"""The page of the parameters of trees: every parameter has its section and its picture, and changes the tree."""

import re
from pathlib import Path

import numpy as np
import pytest

from docs.gen.tree_parameters import FOLDER, STRIPS, models, paper_name, picture
from grammarlab.trees.parameters import COLUMN, DEFAULTS, HIGH, IS_INTEGER, LOW, PARAMETERS

PAGE = (Path(__file__).parents[2] / "docs" / "trees" / "parameters.md").read_text(encoding="utf-8")
MAX_BYTES = 2_500_000


def test_every_parameter_has_a_section_with_a_picture_that_is_there():
    sections = dict(re.findall(r"^### `(\w+)`\n(.*?)(?=^##|\Z)", PAGE, re.MULTILINE | re.DOTALL))
    assert list(sections) == list(PARAMETERS)
    for name, text in sections.items():
        assert f"images/trees/{name}.jpg)" in text
        assert f"*{paper_name(name)}*" in text
        assert PARAMETERS[name].why[1:] in text
    shown = re.findall(r"images/trees/(\w+)\.jpg", PAGE)
    assert sorted(shown) == sorted(path.stem for path in FOLDER.glob("*.jpg")) == sorted(STRIPS)
    assert sum(path.stat().st_size for path in FOLDER.glob("*.jpg")) < MAX_BYTES


def test_strips_have_possible_values():
    for column, strip in STRIPS.items():
        rows = strip.rows(column)
        assert np.all((rows >= LOW) & (rows <= HIGH)), column
        assert np.all(rows[:, IS_INTEGER] == np.rint(rows[:, IS_INTEGER])), column
        assert len(np.unique(strip.values)) == len(strip.values) >= 3
        assert set(strip.tree) <= set(COLUMN)
        assert len(DEFAULTS) == rows.shape[1]


@pytest.mark.parametrize("column", STRIPS)
def test_a_parameter_changes_the_tree(column):
    corners = [model.vertices[model.triangles].reshape(-1, 3) for model in models(column)]
    for number, one in enumerate(corners):
        for other in corners[:number]:
            same = one.shape == other.shape and np.allclose(one, other, atol=1e-3)
            assert not same, f"{column}: two values give one tree"


def test_a_strip_shows_its_trees_side_by_side():
    strip = picture("taper_0")
    assert strip.width > 1.5 * strip.height
    assert len(strip.getcolors(1 << 20) or ()) > 100


@pytest.mark.parametrize(
    ("column", "name"),
    [("curve_1_v", "1CurveV"), ("base_size", "BaseSize"), ("scale_0", "0Scale"), ("base_splits", "0BaseSplits")],
)
def test_names_of_the_paper(column, name):
    assert paper_name(column) == name
