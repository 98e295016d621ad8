"""Scenario files with their grammars."""

from __future__ import annotations

from pathlib import Path

from grammarlab.evaluation.preparation import Source
from grammarlab.evaluation.scenario import load
from grammarlab.runs.requests.examples import find_rules
from grammarlab.runs.sampling.derive_batch import compiled


def load_source(scenario: Path) -> Source:
    """A scenario file with its grammar.

    Raises:
        GrammarlabError: If the files cannot be used.
    """
    found = load(scenario)
    rules = find_rules(found.grammar)
    grammar, _ = compiled(rules.text(), rules.name)
    return Source(found, grammar, rules.assets)
