"""Page about the rule of scenario T1: how many trees with random parameters each of its clauses removes."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from grammarlab.evaluation.preparation import Source
from grammarlab.evaluation.scenario_values import TomlFile, read
from grammarlab.features.expression import Expression
from grammarlab.runs.evaluate.request import scenarios_folder
from grammarlab.runs.sample.sources import load_source
from grammarlab.tables import markdown_table

SCENARIO = "T1"
NUM_TREES = 10_000
SEED = 1
"""Another one than that of the scenario, so that its clauses were not adjusted to these trees."""
HEAD = f"""\
# Plausible trees

Written by `python -m docs.gen.tree_clauses FILE`. Run it again instead of editing this page.

Scenario `{SCENARIO}` likes plausible trees among those with random parameters (`grammars/species/any.toml`). Its rule
is a list of clauses, each with its number and its reason in `scenarios/{SCENARIO}.toml`. The measures are defined in
`grammarlab/trees/measures.py`.

"""


def page() -> str:
    """The page."""
    path = scenarios_folder() / f"{SCENARIO}.toml"
    source = load_source(path)
    clauses = clauses_of(path)
    holds = shares(source, clauses)
    lines, rest = [], np.ones(NUM_TREES, dtype=bool)
    for name, expression in clauses.items():
        others = np.all([held for other, held in holds.items() if other != name], axis=0)
        rest &= holds[name]
        percent = (100.0 * np.mean(part) for part in (~holds[name], rest, others & ~holds[name]))
        lines.append((name, f"`{expression.text}`", *(f"{value:.2f}" for value in percent)))
    head = ("clause", "condition", "removes alone", "left after it and those above", "removed by it alone")
    total = (
        f"\nOf {NUM_TREES:,} trees of seed {SEED}, {rest.sum()} are plausible: {100.0 * rest.mean():.2f} %. All "
        "numbers are per cent of all trees. *removed by it alone*: trees that keep all other clauses.\n"
    )
    return HEAD + markdown_table(head, lines) + total


def clauses_of(path: Path) -> dict[str, Expression]:
    """The definitions of a scenario by name, in their order."""
    definitions: dict[str, Expression] = {}
    for name, text in TomlFile(read(path, "scenario"), path).table()["definitions"].items():
        definitions[name] = Expression.parse(text, definitions)
    return definitions


def shares(source: Source, clauses: dict[str, Expression]) -> dict[str, np.ndarray]:
    """[NUM_TREES] whether each clause holds, by name."""
    batches = list(source.space.sample(False, NUM_TREES, SEED))
    return {
        name: expression.evaluate(source.space.values(batches, expression.features)) != 0.0
        for name, expression in clauses.items()
    }


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(page())
