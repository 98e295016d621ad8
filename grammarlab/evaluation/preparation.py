"""Material of an evaluation, from a scenario: labelled models, and a simulated person who scores others.

The labelled set is derived at the scenario's seed. The pool is derived at seeds that follow from it
(`grammarlab.learning.designs.pool`), so the two have no model in common. Each simulated person has its own models
(`Source.for_person`), so that methods are not fitted to one pool.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from grammarlab.about import __version__
from grammarlab.arrays import Floats, Ints
from grammarlab.errors import UsageError
from grammarlab.evaluation.respondents import Respondent
from grammarlab.evaluation.scenario import Scenario
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.design_space import AbstractDesignSpace
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.learning.designs.pool import Pool
from grammarlab.learning.interview import Person
from grammarlab.learning.round import Report, Study, silent
from grammarlab.learning.settings import Settings
from grammarlab.learning.targets.divergence import agreement
from grammarlab.randomness import derived_seed

_PERSONS = 4
"""Lane below the seed of a scenario for the models of persons."""


@dataclass(frozen=True, slots=True)
class Material:
    """n labelled models with the true scores of K factors, and a person with those of all others."""

    factors: tuple[str, ...]
    """Names of the K factors, K >= 1; the preference is their product."""
    scores: Floats
    """[n, K] true scores of the labelled set, 0 to 100."""
    weights: Floats
    """[n] > 0, importance weight of each labelled model (`agreement`)."""
    study: Study[Any]
    """The pool, with tables whose `Table.others` are the labelled set."""
    person: Person
    """True scores of any models."""
    true_scores: Callable[[Sequence[Address]], Floats]
    """True scores [k, K] of models by ascending address, 0 to 100."""

    def as_one_factor(self) -> Material:
        """The same models for a person who scores the product of all factors."""
        if len(self.factors) == 1:
            return self
        return replace(
            self,
            factors=(" x ".join(self.factors),),
            scores=_product(self.scores),
            person=lambda addresses, numbers: _product(self.person(addresses, numbers)),
            true_scores=lambda addresses: _product(self.true_scores(addresses)),
        )

    def answered_by(self, respondent: Respondent, seed: int) -> Material:
        """The same models for a respondent; its exact scores are the target.

        Args:
            respondent: the respondent.
            seed: seed of the person, 0 <= seed < 2**64.

        Raises:
            UsageError: If no model of the labelled set is liked on the person's scale, or the person has two tastes and
                the scenario one.
        """
        if not respondent.has_one_voice and len(self.factors) == 1:
            raise UsageError(
                f"person {respondent.name} has two tastes, and the scenario has one factor: take one with several "
                "factors, of which the first and the last one are the tastes, such as F3xF4."
            )

        def answers(addresses: Sequence[Address], numbers: Ints) -> Floats:
            meant = respondent.spoken(self.person(addresses, numbers), numbers)
            return respondent.answers(meant, seed, int(numbers.min()) if len(numbers) else 0)

        answered = replace(
            self,
            factors=self.factors if respondent.has_one_voice else (respondent.name,),
            scores=respondent.truth(respondent.taste(self.scores)),
            person=answers,
            true_scores=lambda addresses: respondent.truth(respondent.taste(self.true_scores(addresses))),
        )
        if not (answered.weights * answered.target).any():
            raise UsageError(
                f"person {respondent.name}: none of the {len(self.scores):,} labelled models has a score above 0 on "
                f"the scale of this person, so there is no density to learn. Raise num_models, or give higher scores."
            )
        return answered

    @property
    def target(self) -> Floats:
        """[n] true preference: the product of the factors' scores, each as a share of 100."""
        return np.prod(self.scores / 100.0, axis=1)

    @property
    def js_original(self) -> float:
        """Divergence in nats of the original grammar."""
        return agreement(self.target, np.ones(len(self.weights)), self.weights).js


@dataclass(frozen=True, slots=True)
class Source:
    """A scenario with its design space."""

    scenario: Scenario
    space: AbstractDesignSpace[Any]
    """The designs, such as the models of a grammar."""

    @property
    def grammar_space(self) -> GrammarSpace:
        """The models of the grammar.

        Raises:
            UsageError: If the scenario is about designs of another kind.
        """
        if not isinstance(self.space, GrammarSpace):
            raise UsageError(
                f"scenario {self.scenario.name} is about {self.scenario.grammar}, whose designs have no grammar. "
                "Label some of them and learn from the labels."
            )
        return self.space

    @property
    def pool(self) -> Pool:
        """The pool of models to ask about."""
        return Pool(self.scenario.seed, self.scenario.num_models)

    @property
    def labelled_address(self) -> Address:
        """Address of the first model of the labelled set; the others follow under the same seed."""
        return Address(self.scenario.draws == "flattened", self.scenario.seed, 0)

    def for_person(self, seed: int) -> Source:
        """The scenario with a pool and a labelled set that follow from its seed and a person's, 0 <= seed < 2**64."""
        person_seed = derived_seed(self.scenario.seed, _PERSONS, seed)
        return replace(self, scenario=replace(self.scenario, seed=person_seed))

    @property
    def key(self) -> str:
        """SHA-256 of all inputs of the models, their scores and the features for learning."""
        scenario = self.scenario
        preference = [(factor.name, factor.score) for factor in scenario.factors]
        models = (self.space.hashes[0], scenario.num_models, scenario.seed, scenario.draws)
        values = (__version__, models, scenario.base, preference, scenario.features)
        return hashlib.sha256(repr(values).encode()).hexdigest()


def prepare(source: Source, settings: Settings, report: Report = silent) -> Material:
    """The material of a scenario.

    Args:
        source: the scenario and its design space.
        settings: settings of learning.
        report: called with the number of labelled models that are made.

    Raises:
        UsageError: If the preference does not fit the space, or no model of the labelled set is liked.
        DerivationError: If a rule cannot be applied.
    """
    scenario, space = source.scenario, source.space
    scenario.check(space)
    labelled, scores, log_weights = list[Any](), list[Floats](), list[Floats]()
    for designs in _labelled(source):
        labelled.append(designs)
        scores.append(true_scores(source, designs))
        log_weights.append(_log_weight(source, designs))
        report(f"labelled models of {scenario.name}", sum(map(len, scores)), scenario.num_models)

    def truth(addresses: Sequence[Address]) -> Floats:
        different = {address: index for index, address in enumerate(dict.fromkeys(addresses))}
        of_different = true_scores(source, space.make(tuple(different)))
        return of_different[[different[address] for address in addresses]]

    log_weight = np.concatenate(log_weights)
    material = Material(
        tuple(factor.name for factor in scenario.factors),
        np.concatenate(scores),
        np.exp(log_weight - log_weight.max()),
        Study(space, source.pool, settings, tuple(labelled)),
        lambda addresses, _numbers: truth(addresses),
        truth,
    )
    if not (material.weights * material.target).any():
        raise UsageError(
            f"scenario {scenario.name}: none of its {scenario.num_models:,} labelled models has a score above 0, so "
            'there is no density to learn. Raise num_models, or set draws = "flattened".'
        )
    return material


def true_scores(source: Source, designs: Any) -> Floats:
    """[n, K] scores of a batch of designs by each factor of a scenario, 0 to 100."""
    scores = (factor.score for factor in source.scenario.factors)
    return np.column_stack([score.evaluate(source.space.values([designs], score.features)) for score in scores])


def labelled_set(source: Source) -> tuple[Any, ...]:
    """The designs of the labelled set in batches, without geometry."""
    return tuple(_labelled(source))


def _labelled(source: Source) -> Iterator[Any]:
    first = source.labelled_address
    return source.space.sample(first.flat, source.scenario.num_models, first.seed)


def _product(scores: Floats) -> Floats:
    """[n, 1] the scores of the product of K factors [n, K], 0 to 100."""
    return 100.0 * np.prod(scores / 100.0, axis=1, keepdims=True)


def _log_weight(source: Source, designs: Any) -> Floats:
    """[n] log of the base density divided by the density from which the designs are drawn."""
    if source.scenario.base == "uniform":
        return -source.space.log_density(designs)
    log_ratio = source.space.log_ratio(designs)
    return log_ratio if source.scenario.draws == "flattened" else np.zeros_like(log_ratio)
