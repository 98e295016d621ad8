import pytest

from grammarlab.errors import UsageError
from grammarlab.evaluation.methods import METHODS
from grammarlab.evaluation.scenario import load
from grammarlab.runs.evaluate.figures import load_figures
from grammarlab.runs.evaluate.request import FIGURES, scenarios_folder

GOOD = """
[[figures]]
name = "one"
title = "First"
scenario = "F1"
max_labels = 64
curves = [{ label = "a", method = "paper", batch = 8, options = { noise = 1 } }, { label = "b", scenario = "B1" }]
"""


@pytest.fixture
def folder(tmp_path):
    """Writes a file of experiments and gives its folder."""

    def write(text):
        (tmp_path / "figures").mkdir(exist_ok=True)
        (tmp_path / "figures" / "mine.toml").write_text(text)
        return tmp_path / "figures"

    return write


def test_a_curve_begins_from_a_named_method_and_changes_parts_of_it(folder, tmp_path):
    (figure,) = load_figures(folder(GOOD))
    first, second = figure.curves
    assert (figure.name, figure.max_labels) == ("one", 64)
    assert (first.method.name, first.method.fit, first.method.query) == ("a", "paper", METHODS["paper"].query)
    assert (first.method.batch, first.method.options) == (8, (("noise", 1),))
    assert first.scenario == tmp_path / "F1.toml"
    assert second.scenario == tmp_path / "B1.toml"
    assert second.method.as_json() == METHODS["default"].as_json()


def test_every_shipped_experiment_names_scenarios_that_exist():
    figures = load_figures(scenarios_folder() / FIGURES)
    expected = {"4.7a", "4.7b", "4.7c", "4.7d", "4.8a", "4.8b", "4.9a", "4.9b"}
    expected |= {"4.11a", "4.11b", "4.11c", "4.11d", "4.14", "4.16a", "4.16b", "4.17"}
    assert {figure.name for figure in figures} == expected
    for path in {curve.scenario for figure in figures for curve in figure.curves}:
        load(path)


def test_figures_are_chosen_by_name():
    folder = scenarios_folder() / FIGURES
    assert [figure.name for figure in load_figures(folder, "4.17, 4.7a")] == ["4.17", "4.7a"]
    with pytest.raises(UsageError, match=r"unknown figure '4\.7'\. Expected one of all, 4\.7a"):
        load_figures(folder, "4.7")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('name = "one"', "", "name is missing"),
        ('name = "one"', 'name = "../one"', "expected a name of letters"),
        ('name = "one"', "name = 1", "name has the wrong type"),
        ("max_labels = 64", "max_labels = true", "max_labels has the wrong type"),
        ("max_labels = 64", "max_labels = 0", "expected max_labels from 1 to"),
        ("batch = 8", "batch = 0", "batch is a number from 1"),
        ("batch = 8", "path_length = 9", "path_length is a number from 0 to 4"),
        ("batch = 8", 'query = "none"', "unknown query 'none'"),
        ("batch = 8", "bach = 8", "unknown key 'bach'"),
        ("noise = 1", 'noise = "much"', "expected a number for option noise"),
        ("noise = 1", "loudness = 1", "no option"),
        ('method = "paper"', 'method = "mine"', "unknown method 'mine'"),
        ('label = "b"', 'label = "a"', "a unique label"),
        ('scenario = "F1"', "", "expected a scenario"),
        ("[[figures]]", "[[figure]]", r"expected only tables \[\[figures\]\]"),
        ("[[figures]]", "figures = 1\n[x]", r"expected only tables \[\[figures\]\]"),
        ("[[figures]]", "[[figures", "this is not TOML"),
    ],
)
def test_a_mistake_in_a_file_of_experiments_is_named(folder, old, new, message):
    assert old in GOOD
    with pytest.raises(UsageError, match=message) as raised:
        load_figures(folder(GOOD.replace(old, new, 1)))
    assert "mine.toml" in str(raised.value)


def test_a_folder_without_experiments_says_so(tmp_path):
    with pytest.raises(UsageError, match="no experiments"):
        load_figures(tmp_path)
