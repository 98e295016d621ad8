"""Rule files by path or by name, and scenario files with their design spaces."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from grammarlab.evaluation.preparation import Source
from grammarlab.evaluation.scenario import load as load_scenario
from grammarlab.language.grammar import Grammar
from grammarlab.runs.sample.checks import grammar_to_run
from grammarlab.runs.sample.domains import opened
from grammarlab.runs.sample.shipped import find_rules


def load(grammar: str | os.PathLike[str]) -> Grammar:
    """Read a rule file without errors.

    Its meshes and images are found as by the command line: in ``assets`` beside the file, otherwise beside it.

    Args:
        grammar: a path, or the name of a shipped grammar.

    Raises:
        UsageError: If there is no such file or grammar; it names the nearest.
        LanguageError: If the file has errors; it lists all of them.

    >>> import grammarlab as gl
    >>> gl.load("toy").start_rules[0].name
    'Start'
    """
    source = find_rules(os.fspath(grammar))
    return replace(grammar_to_run(source.text(), source.file), assets=source.assets)


def load_source(scenario: Path) -> Source:
    """A scenario file with its design space.

    Raises:
        GrammarlabError: If the files cannot be used.
    """
    loaded = load_scenario(scenario)
    rules = find_rules(loaded.grammar)
    return Source(loaded, opened(rules.suffix, rules.text(), rules.name, rules.assets))
