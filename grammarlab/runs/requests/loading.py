"""Rule files by path or by name, ready to be derived."""

from __future__ import annotations

import os

from grammarlab.language.grammar import Grammar
from grammarlab.runs.requests.checks import grammar_to_run
from grammarlab.runs.requests.examples import find_rules


def load(grammar: str | os.PathLike[str]) -> Grammar:
    """Reads a rule file without errors.

    Args:
        grammar: a path, or the name of a shipped grammar.

    Raises:
        UsageError: when there is no such file or grammar; names the nearest.
        LanguageError: with all errors of the file.

    >>> load("toy").start_rules[0].name
    'Start'
    """
    source = find_rules(os.fspath(grammar))
    return grammar_to_run(source.text(), source.file)
