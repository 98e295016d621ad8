"""What a simulated person and a learner look at: models as rows of numbers, with the true scores."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.forest import Forest
from grammarlab.evaluation.agreement import agreement
from grammarlab.features.pattern import Feature, HalfSpace, Threshold

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bound: TypeAlias = Threshold | HalfSpace


@dataclass(frozen=True, slots=True)
class Columns:
    """Which features there are."""

    path_length: int
    """Edges of the longest paths."""
    extra: tuple[Feature, ...] = ()
    """What was searched for because labels asked for it; each a column and a group of its own."""

    @property
    def bounds(self) -> tuple[Bound, ...]:
        """The extra features that are bounds on draws."""
        return tuple(feature for feature in self.extra if isinstance(feature, Threshold | HalfSpace))


@dataclass(frozen=True, slots=True)
class Table:
    """The features of every model."""

    labelled: Floats
    """[n, F] of the labelled set, on which densities are compared."""
    pool: Floats
    """[m, F] of the pool, from which models are shown."""
    groups: NDArray[np.int64]
    """[F] features that are alternatives of one choice share a group."""
    group_names: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Material:
    """n labelled models and m models to ask about, with the true scores of K factors."""

    factors: tuple[str, ...]
    """Names of the K factors, K >= 1; the preference is their product."""
    scores: Floats
    """[n, K] true scores of the labelled set, 0 to 100."""
    weights: Floats
    """[n] > 0, how much each labelled model stands for (`agreement`)."""
    pool_scores: Floats
    """[m, K] what the person answers, 0 to 100."""
    pool_weights: Floats
    """[m] >= 0, how much of the grammar's density each of them stands for: the density by that of the whole pool."""
    pool_from_grammar: NDArray[np.bool_]
    """[m] whether the model is a sample of the grammar itself; the others come from a flattened one."""
    table: Callable[[Columns], Table]
    """The features of all models."""
    examples: Callable[[Ints], tuple[Forest, ...]]
    """Derivations of some models of the pool, by index, in order."""
    margins: Callable[[Bound], Floats]
    """[m] signed distance of each model of the pool to a bound."""
    wider: Callable[[], Material] | None = None
    """The same with many more models of the flattened grammar at the end of the pool, for what is rare; None where
    there are no more."""

    def as_one_factor(self) -> Material:
        """The same models for a person who scores the product of all factors."""
        if len(self.factors) == 1:
            return self
        wider = self.wider
        return replace(
            self,
            factors=(" x ".join(self.factors),),
            scores=_product(self.scores),
            pool_scores=_product(self.pool_scores),
            wider=None if wider is None else lambda: wider().as_one_factor(),
        )

    @property
    def target(self) -> Floats:
        """[n] true preference: the product of the factors' scores, each as a share of 100."""
        return np.prod(self.scores / 100.0, axis=1)

    @property
    def js_original(self) -> float:
        """Divergence in nats of the grammar as it is, nothing learned."""
        return agreement(self.target, np.ones(len(self.weights)), self.weights).js


def _product(scores: Floats) -> Floats:
    """[n, 1] the scores of the product of K factors [n, K], 0 to 100."""
    return 100.0 * np.prod(scores / 100.0, axis=1, keepdims=True)
