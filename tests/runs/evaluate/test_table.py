"""The tables about densities and grammars: measured once, beside what the paper reports."""

from dataclasses import replace

import pytest

from grammarlab.errors import UsageError
from grammarlab.evaluation.scenario import PaperFigures
from grammarlab.runs.evaluate import paper_table, persons
from grammarlab.runs.evaluate.paper_table import density_rows, density_tables
from grammarlab.runs.evaluate.persons import Person, person_rows, person_table
from grammarlab.runs.evaluate.request import EvaluationRequest
from grammarlab.runs.evaluate.run import evaluate_run
from grammarlab.runs.sample.sources import load_source
from tests.cases import takes_turns
from tests.runs.learn.test_scenario import RULES, SCENARIO


@pytest.fixture
def scenario(tmp_path, monkeypatch):
    monkeypatch.setattr(paper_table, "NUM_SAMPLES", 400)
    (tmp_path / "house.cga").write_text(RULES)
    path = tmp_path / "old.toml"
    text = SCENARIO.replace('grammar = "house.cga"', f'grammar = "{tmp_path / "house.cga"}"')
    path.write_text(text.replace("2000", "400"))
    return path


def test_every_method_has_a_row_beside_the_paper(scenario, tmp_path):
    rows = density_rows([scenario], tmp_path / "out")
    assert [row.method for row in rows] == ["parameters", "structure", "tied", "examples", "compile"]
    by_method = {row.method: row for row in rows}
    assert by_method["compile"].js < 1e-12
    assert by_method["tied"].js < 0.02
    assert by_method["examples"].js < 0.02
    assert by_method["parameters"].js > 0.1
    found = replace(load_source(scenario).scenario, paper=PaperFigures(0.4, 0.3, 0.2))
    text = density_tables(rows, [found])
    lines = [line for line in text.splitlines() if line.startswith("| old |")]
    assert len(lines) == 3
    assert "(0.400) | " in lines[0]
    assert "(0.300) | " in lines[0]
    assert "(0.200) | " in lines[0]
    assert lines[0].endswith("| 0 |")


def test_rows_are_measured_once(scenario, tmp_path, monkeypatch):
    rows = density_rows([scenario], tmp_path / "out")
    monkeypatch.setattr(paper_table, "learned_of", None)
    assert density_rows([scenario], tmp_path / "out") == rows


@takes_turns
def test_persons_make_grammars_that_come_near(scenario, tmp_path):
    people = [Person(scenario, seed, 32, tmp_path / "cache") for seed in range(2)]
    rows = person_rows(people, tmp_path / "out")
    assert [row.seed for row in rows] == [0, 1]
    assert all(row.js < 0.05 for row in rows)
    assert person_rows(people, tmp_path / "out") == rows
    text = person_table(rows, [load_source(scenario).scenario])
    assert "| old | exact | 32 | " in text
    assert text.rstrip().endswith("| 2/2 |")


@takes_turns
def test_the_page_has_both_tables(scenario, tmp_path, monkeypatch):
    request = EvaluationRequest.of(
        (scenario,), methods="default", seeds=1, max_labels=16, density=True, grammar_labels="16,other=99"
    )
    assert request.grammar_labels_of("old") == 16
    assert request.grammar_labels_of("other") == 99
    result = evaluate_run(request, tmp_path / "out")
    assert len(result.densities) == 5
    assert len(result.grammars) == 1
    text = result.page.read_text(encoding="utf-8")
    assert "## From a preference to a density (Table 4.3)" in text
    assert "## From scores to a grammar" in text
    assert persons.STORE in {file.name for file in (tmp_path / "out").iterdir()}


@pytest.mark.parametrize("text", ["many", "F1=", "0", "F1=-3", "F1=9999999"])
def test_wrong_numbers_of_labels_are_told(scenario, text):
    with pytest.raises(UsageError, match="numbers of labels"):
        EvaluationRequest.of((scenario,), grammar_labels=text)
