"""Divergence of two files of one kind, with the choices and numbers that differ most."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module

from grammarlab.errors import UsageError
from grammarlab.runs.sample.domains import DEFAULT, SPECIES
from grammarlab.runs.sample.shipped import RuleSource, find_rules

COMPARISONS = {
    DEFAULT: "grammarlab.runs.sample.grammar_comparison:compare_grammars",
    SPECIES: "grammarlab.runs.sample.species_comparison:compare_species",
}
"""Module and name of the function that compares two files of each suffix, imported when needed."""
NUM_MODELS = 2_500
"""Number of models of each file."""
MAX_DIFFERENCES = 12
"""Largest number of reported differences of each kind."""
MIN_DIVERGENCE = 0.003
"""Divergences of two samples of one density reach this by chance."""
NUM_BINS = 20
"""Number of bins of the histograms of draws."""


@dataclass(frozen=True, slots=True)
class Difference:
    """A symbol with different frequencies in two grammars."""

    symbol: str
    first: float
    """Share of the models of the first grammar with it."""
    second: float
    js: float
    """Divergence in nats of the counts of the symbol."""


@dataclass(frozen=True, slots=True)
class BranchShare:
    """A branch of a choice, with its frequencies."""

    makes: str
    """Successors of the branch and, if these do not distinguish it from other branches, its line."""
    first: float
    """Share of the rewritings of the symbol in the models of the first grammar."""
    second: float


@dataclass(frozen=True, slots=True)
class ChoiceDifference:
    """A choice with different frequencies in two grammars."""

    symbol: str
    line: int
    """Line of its rule in the common grammar, from 1."""
    js: float
    """Divergence in nats of the shares of its branches."""
    branches: tuple[BranchShare, ...]


@dataclass(frozen=True, slots=True)
class NumberDifference:
    """An attribute with different distributions of draws."""

    attribute: str
    first: float
    """Mean of the draws in the models of the first grammar."""
    second: float
    js: float
    """Divergence in nats of their histograms."""


@dataclass(frozen=True)
class Comparison:
    """Result of a comparison of two grammars, or of two species."""

    sources: tuple[RuleSource, RuleSource]
    origin: str
    """The grammar whose trees both make; empty if unknown, and for species."""
    js: float | None
    """Divergence in nats of the two densities over these trees; None if it is unknown."""
    at_least: float
    """Lower bound of it from the most informative symbol."""
    choices: tuple[ChoiceDifference, ...]
    """The choices that differ most, in the common grammar; none without one."""
    numbers: tuple[NumberDifference, ...]
    differences: tuple[Difference, ...]
    """The symbols that differ most, largest divergence first."""
    only_first: tuple[str, ...]
    """Symbols that the second grammar does not have."""
    only_second: tuple[str, ...]
    are_strangers: bool = False
    """Whether no symbol of one is made by the other, so that there is nothing to compare."""


def compare_files(first: str, second: str, *, num_models: int = NUM_MODELS, seed: int = 0) -> Comparison:
    """Compare two grammars, or two species, on samples of both.

    Args:
        first: a file or the name of a shipped example.
        second: a file or the name of a shipped example.
        num_models: number of models of each, at least 1.
        seed: seed of the models.

    Raises:
        UsageError: If a file does not exist, or they are of different kinds.
        GrammarlabError: If one of them cannot be sampled.
    """
    if num_models < 1:
        raise UsageError(f"expected at least one model of each, found {num_models}")
    sources = find_rules(first), find_rules(second)
    suffix = sources[0].suffix
    if suffix != sources[1].suffix:
        raise UsageError(
            f"{sources[0].file} and {sources[1].file} are of different kinds: expected two grammars or two species."
        )
    if suffix not in COMPARISONS:
        raise UsageError(f"{sources[0].file}: files of this kind cannot be compared.")
    module, name = COMPARISONS[suffix].split(":")
    return getattr(import_module(module), name)(sources, num_models, seed)
