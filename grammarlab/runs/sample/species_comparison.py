"""Divergence of two species from the densities of their trees, and the parameters that differ most."""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Flags, Floats
from grammarlab.learning.targets.divergence import jensen_shannon
from grammarlab.randomness import root_keys
from grammarlab.runs.sample.comparison import MAX_DIFFERENCES, MIN_DIVERGENCE, NUM_BINS, Comparison, NumberDifference
from grammarlab.runs.sample.domains import opened_models
from grammarlab.runs.sample.shipped import RuleSource
from grammarlab.trees.accepted_trees import accepted_rows, log_density, rule_of
from grammarlab.trees.parameters import COLUMNS, IS_INTEGER
from grammarlab.trees.species import Species


def compare_species(sources: tuple[RuleSource, RuleSource], num_models: int, seed: int) -> Comparison:
    """Compare two species on trees of both.

    Args:
        sources: the species.
        num_models: number of trees of each, at least 1.
        seed: seed of the trees.

    Raises:
        LanguageError: If a file has errors.
        GrammarlabError: If an acceptance rule keeps none of many candidates.
    """
    first, second = (opened_models(s.suffix, s.text(), s.name, s.assets).species for s in sources)
    keys = root_keys(seed, np.arange(num_models))
    trees = [accepted_rows(species, keys) for species in (first, second)]
    numbers = _numbers(*(part.rows for part in trees))
    rows, keys = (np.concatenate([getattr(part, name) for part in trees]) for name in ("rows", "keys"))
    densities = [
        _log_density(species, rows, keys) - np.log(part.is_accepted.sum() / part.tries.sum())
        for species, part in zip((first, second), trees, strict=True)
    ]
    share = np.exp(densities[0] - np.logaddexp(*densities))
    js = float(np.log(2.0)) if _are_disjoint(first, second) else jensen_shannon(share, 1.0 - share)
    return Comparison(
        sources=sources,
        origin="",
        js=js,
        at_least=max((number.js for number in numbers), default=0.0),
        choices=(),
        numbers=numbers[:MAX_DIFFERENCES],
        differences=(),
        only_first=(),
        only_second=(),
    )


def _log_density(species: Species, rows: Floats, keys: np.ndarray) -> Floats:
    """[n] log of the density of candidates that are kept; -inf where it is 0."""
    rule = rule_of(species.acceptance)
    densities = log_density(species, rows)
    if rule is None:
        return densities
    with np.errstate(divide="ignore"):
        return densities + np.log(rule.probabilities(rows, keys))


def _are_disjoint(first: Species, second: Species) -> bool:
    """Whether a continuous parameter is constant in one species and has a range in the other."""
    constant = [_is_constant(species) for species in (first, second)]
    return bool(((constant[0] != constant[1]) & ~IS_INTEGER).any())


def _is_constant(species: Species) -> Flags:
    """[P] whether a column is constant in every kind."""
    return np.all([kind.low == kind.high for kind in species.kinds], axis=0)


def _numbers(first: Floats, second: Floats) -> tuple[NumberDifference, ...]:
    """Columns with different distributions, largest divergence first."""
    numbers: list[NumberDifference] = []
    for name, one, other in zip(COLUMNS, first.T, second.T, strict=True):
        edges = np.histogram_bin_edges(np.concatenate([one, other]), NUM_BINS)
        js = jensen_shannon(*(np.histogram(values, edges)[0] for values in (one, other)))
        if js > MIN_DIVERGENCE + NUM_BINS / (4.0 * min(len(one), len(other))):
            numbers.append(NumberDifference(name, float(one.mean()), float(other.mean()), js))
    return tuple(sorted(numbers, key=lambda number: -number.js))
