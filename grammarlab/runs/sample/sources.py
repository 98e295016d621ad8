"""Rule files by path or by name, and scenario files with their design spaces."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, overload

from grammarlab.errors import UsageError
from grammarlab.language.grammar import Grammar
from grammarlab.language.presets import NO_CHOICES, RuleChoices
from grammarlab.runs.sample.checks import grammar_to_run
from grammarlab.runs.sample.domains import SPECIES, opened
from grammarlab.runs.sample.shipped import find_rules

if TYPE_CHECKING:
    from grammarlab.evaluation.preparation import Source
    from grammarlab.trees.species import Species

ShippedGrammar: TypeAlias = Literal[
    "airplane", "building", "furniture", "limits", "limits_discrete", "limits_rare", "quarter", "skyscraper", "toy"
]
"""Names of the shipped grammars, for type checkers."""
ShippedSpecies: TypeAlias = Literal[
    "any", "apple", "birch", "oak", "palm", "poplar", "shrub", "spruce", "weeping_willow"
]
"""Names of the shipped species, for type checkers."""


@overload
def load(grammar: ShippedGrammar, choices: RuleChoices = ...) -> Grammar: ...
@overload
def load(grammar: ShippedSpecies) -> Species: ...
@overload
def load(grammar: str | os.PathLike[str], choices: RuleChoices = ...) -> Any: ...
def load(grammar: str | os.PathLike[str], choices: RuleChoices = NO_CHOICES) -> Grammar | Species:
    """Read a rule file or a species of trees without errors.

    Its meshes and images are found as by the command line: in ``assets`` beside the file, otherwise beside it.

    Args:
        grammar: a path, or the name of a shipped grammar or species.
        choices: style, start rule, values of attributes and library for a rule file.

    Returns:
        A `Grammar` for rule files, a `Species` for files that end in .toml, and for those of Arbaro (.xml).

    Raises:
        UsageError: If there is no such file, example, start rule or attribute; it names the nearest. If a value has
            another type than its attribute.
        LanguageError: If the file has errors; it lists all of them.

    >>> import grammarlab as gl
    >>> gl.load("toy").start_rules[0].name
    'Start'
    >>> gl.load("toy", gl.RuleChoices(start_rule="MASS")).start_rules[0].name
    'MASS'
    >>> gl.load("oak").name
    'oak'
    """
    source = find_rules(os.fspath(grammar), choices=choices)
    if source.suffix == SPECIES:
        # Grammars do without trees.
        from grammarlab.runs.sample.species_models import species_to_run  # noqa: PLC0415

        return replace(species_to_run(source.text(), source.file), assets=source.assets)
    return replace(grammar_to_run(source.text(), source.file), assets=source.assets)


def load_source(scenario: Path) -> Source:
    """A scenario file with its design space.

    Raises:
        GrammarlabError: If the files cannot be used.
    """
    # Models are made without the libraries of learning, which take seconds to import.
    from grammarlab.evaluation.preparation import Source  # noqa: PLC0415
    from grammarlab.evaluation.scenario import load as load_scenario  # noqa: PLC0415

    loaded = load_scenario(scenario)
    rules = find_rules(loaded.grammar, choices=loaded.choices)
    try:
        text = rules.text()
    except UsageError as error:  # about a start rule or an attribute
        raise UsageError(f"{scenario}: {error}") from error
    return Source(loaded, opened(rules.suffix, text, rules.name, rules.assets))
