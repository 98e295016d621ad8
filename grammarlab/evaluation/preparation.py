"""From a scenario and its grammar to the material of the protocol.

The labelled set is derived at the scenario's seed. The pool is derived at seeds that follow from it
(`grammarlab.learning.designs.pool`), so the two have no model in common. Each simulated person has models of their own
(`Source.for_person`), so that nothing is fitted to one pool.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grammarlab.about import __version__
from grammarlab.derivation.forest import Forest
from grammarlab.errors import UsageError
from grammarlab.evaluation.material import Material
from grammarlab.evaluation.scenario import Scenario
from grammarlab.features.counting.counts import count
from grammarlab.language.grammar import Grammar
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.learning.designs.pool import Pool
from grammarlab.learning.round import Study
from grammarlab.learning.settings import Settings
from grammarlab.randomness import derived_seed

Floats = NDArray[np.float64]

_PERSONS = 4
"""Place below the seed of a scenario that persons have their models from."""


@dataclass(frozen=True, slots=True)
class Source:
    """A scenario with what it takes to derive its models."""

    scenario: Scenario
    grammar: Grammar
    assets: Path
    """The folder that asset names in the rules are relative to."""

    @property
    def space(self) -> GrammarSpace:
        """The models of the grammar."""
        return GrammarSpace(self.grammar, self.assets)

    @property
    def pool(self) -> Pool:
        """The models that there are to ask about."""
        return Pool(self.scenario.seed, self.scenario.num_models)

    @property
    def labelled_address(self) -> Address:
        """Of the first model of the labelled set; the others follow under the same seed."""
        return Address(self.scenario.draws == "flattened", self.scenario.seed, 0)

    def for_person(self, seed: int) -> Source:
        """The scenario with a pool and a labelled set that follow from its seed and a person's, 0 <= seed < 2**64."""
        own = derived_seed(self.scenario.seed, _PERSONS, seed)
        return replace(self, scenario=replace(self.scenario, seed=own))

    @property
    def key(self) -> str:
        """SHA-256 of everything that decides the models, their scores and what is offered to learn from."""
        scenario = self.scenario
        preference = [(factor.name, factor.score) for factor in scenario.factors]
        models = (self.grammar.hash, scenario.num_models, scenario.seed, scenario.draws)
        values = (__version__, models, scenario.base, preference, scenario.features)
        return hashlib.sha256(repr(values).encode()).hexdigest()


def prepare(source: Source, settings: Settings) -> Material:
    """The material of a scenario.

    Args:
        source: the scenario and its grammar.
        settings: how to learn.

    Raises:
        UsageError: the preference does not fit the grammar, or no model of the labelled set is liked.
        DerivationError: a rule cannot be carried out.
    """
    scenario, space = source.scenario, source.space
    program = space.program
    scenario.check(program.symbols, program.rule_names, program.sites)
    labelled = labelled_set(source, space)

    def meant(addresses: Sequence[Address]) -> Floats:
        different = {address: place for place, address in enumerate(dict.fromkeys(addresses))}
        scores = true_scores(scenario, space.make(tuple(different)))
        return scores[[different[address] for address in addresses]]

    log_weights = np.concatenate([_log_weight(scenario, space, forest) for forest in labelled])
    material = Material(
        tuple(factor.name for factor in scenario.factors),
        np.concatenate([true_scores(scenario, forest) for forest in labelled]),
        np.exp(log_weights - log_weights.max()),
        Study(space, source.pool, settings, labelled),
        lambda addresses, _before: meant(addresses),
        meant,
    )
    if not (material.weights * material.target).any():
        raise UsageError(
            f"scenario {scenario.name}: none of its {scenario.num_models:,} labelled models has a score above 0, so "
            'there is no density to learn. Raise num_models, or set draws = "flattened".'
        )
    return material


def labelled_set(source: Source, space: GrammarSpace) -> tuple[Forest, ...]:
    """The models of the labelled set, without geometry."""
    first = source.labelled_address
    return tuple(space.sample(first.flat, source.scenario.num_models, first.seed))


def true_scores(scenario: Scenario, forest: Forest) -> Floats:
    """[models, K] how much each factor of a scenario likes some models, 0 to 100."""
    return np.column_stack([factor.score.evaluate(count(forest, factor.score.features)) for factor in scenario.factors])


def _log_weight(scenario: Scenario, space: GrammarSpace, forest: Forest) -> Floats:
    """[models] log of the density that the preference multiplies over the density the models are drawn from."""
    if scenario.base == "uniform":
        return -forest.log_probability()
    return space.log_ratio(forest) if scenario.draws == "flattened" else np.zeros(forest.num_models)
