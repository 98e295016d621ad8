"""docs/evaluation/file.md: what it shows runs, and it names all that there is."""

import doctest
import re
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from grammarlab.evaluation import scenario
from grammarlab.features.expression import MAX_CHARACTERS, MAX_FEATURES, Expression
from grammarlab.features.patterns.operations import FUNCTIONS
from grammarlab.features.patterns.pattern_text import parse as parse_pattern
from grammarlab.runs.sample.domains import opened
from grammarlab.runs.sample.shipped import find_rules
from grammarlab.trees.measures import MEASURES

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "evaluation" / "file.md").read_text()


def rows(heading: str) -> list[list[str]]:
    """The cells of the table below a heading."""
    section = PAGE.split(f"## {heading}\n", 1)[1].split("\n## ", 1)[0]
    lines = [line for line in section.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


def test_the_python_examples_give_what_the_page_says(monkeypatch):
    monkeypatch.chdir(ROOT)
    result = doctest.testfile(str(ROOT / "docs" / "evaluation" / "file.md"), module_relative=False)
    assert result.attempted > 10
    assert result.failed == 0


@pytest.mark.parametrize("text", re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL), ids=lambda text: text[:12])
def test_the_scenarios_of_the_page_fit_their_grammars(text):
    found = scenario.parse(text, ROOT / "scenarios" / "page.toml")
    rules = find_rules(found.grammar)
    space = opened(rules.suffix, rules.text(), rules.name, rules.assets)
    found.check(space)
    score = found.score
    reached = np.unique(score.evaluate(space.values(list(space.sample(False, 400, 1)), score.features)))
    assert len(reached) > 2


@pytest.mark.parametrize("cells", rows("Patterns"), ids=lambda cells: cells[0])
def test_the_patterns_of_the_page_are_patterns(cells):
    text = cells[0].strip("`")
    assert str(parse_pattern(text)) == text


def test_the_expressions_of_the_page_are_expressions():
    definitions = {name: Expression.parse("1") for name in ("valid", "a", "b", "c", "x", "when")}
    shown = [text for cells in rows("Expressions") for text in re.findall(r"`([^`]+)`", cells[0])]
    words = [text for text in shown if re.search(r"\w{2}|\$|\{", text) and text not in {"and", "or", "not"}]
    assert len(words) >= 12
    for text in words:
        Expression.parse(text, definitions)
    assert {text.split("(")[0] for text in words} >= FUNCTIONS.keys()


def test_the_page_names_every_key_family_and_bound():
    keys = " ".join(cells[0] for cells in rows("All keys"))
    for key in scenario._KEYS:
        assert key in keys
    values = " ".join(" ".join(cells) for cells in rows("All keys"))
    for kind in (scenario.FeatureOptions, scenario.PaperFigures, scenario.ScenarioGoal):
        for part in fields(kind):
            assert f"`{part.name}`" in values
    for family in scenario.FAMILIES:
        assert f"`{family}`" in values
    assert f"{MAX_CHARACTERS:,}" in PAGE.replace("\n", " ")
    assert f"{MAX_FEATURES} different" in PAGE


def test_the_page_lists_the_measures_of_trees():
    section = PAGE.split("\n## Trees\n")[1].split("\n## ")[0]
    rows = [f"| `${measure.name}` | {measure.unit} | {measure.why} |" for measure in MEASURES.values()]
    assert [line for line in section.splitlines() if line.startswith("| `$")] == rows
