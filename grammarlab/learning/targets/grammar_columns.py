"""Columns that trees may test on models of a grammar: those of a table, and random attributes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import ROUNDING, Floats, Ints
from grammarlab.density.exact.compile import Exactness
from grammarlab.density.targets.ranges import range_ends
from grammarlab.derivation.forest import Forest
from grammarlab.features.patterns.conditions import at_least
from grammarlab.features.patterns.pattern import Draw, Feature, Threshold
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.learning.round import State, Study
from grammarlab.learning.targets.simplification import Predicted
from grammarlab.preference.base import NEGLIGIBLE_SHARE
from grammarlab.preference.simplified import SimplifiedPreference


@dataclass(frozen=True)
class GrammarColumns:
    """Columns of the models of a pool."""

    rows: Floats
    """[m, F] values of the pool, in the units of the features."""
    features: tuple[Feature, ...]
    """[F] the features of the columns."""
    names: tuple[str, ...]
    """[F] names of the features in words."""
    shares: Floats
    """[F] relevance of each feature to the preference; for attributes outside the table the largest share."""
    exact: NDArray[np.bool_]
    """[F] whether exact grammars can express the feature."""

    @classmethod
    def of(
        cls, space: GrammarSpace, study: Study[Forest], state: State, predicted: Predicted, exactness: Exactness
    ) -> GrammarColumns:
        """Columns of a state's table, without constant ones, and of random attributes.

        Args:
            space: space of the study.
            study: the pool and its tables.
            state: the state.
            predicted: predictions of the pool.
            exactness: features that exact grammars can express.
        """
        table, batches = study.table(state), study.tables(state.wide).pool_designs.batches
        pool = table.rows[: sum(forest.num_models for forest in batches)] * table.scales
        draws = tuple(Draw(name) for name in space.grammar.attributes if range_ends(space.grammar, name))
        values = space.values(batches, draws)
        new = [number for number, draw in enumerate(draws) if draw not in table.features]
        features = (*table.features, *(draws[number] for number in new))
        highest = predicted.shares.max(initial=0.0)
        return cls(
            np.concatenate([_with_integers(pool), values[:, new]], axis=1),
            features,
            (*table.names, *(str(draws[number]) for number in new)),
            np.append(predicted.shares, np.full(len(features) - len(table.features), highest)),
            np.array([not exactness.reason_against(_bound_feature(feature)) for feature in features], dtype=bool),
        )

    @property
    def order(self) -> Ints:
        """Columns: exactly expressible ones first, then by share, patterns of few symbols first."""
        length = np.array([len(str(feature)) for feature in self.features], dtype=np.int64)
        return np.lexsort((length, -self.shares, ~self.exact)).astype(np.int64)

    @property
    def relevant(self) -> Ints:
        """The columns of `order` that matter to the preference; others may only stand for them on a pool."""
        order, least = self.order, NEGLIGIBLE_SHARE * float(self.shares.max(initial=0.0))
        return order[(self.shares[order] > 0.0) & (self.shares[order] >= least)]

    def text(self, preference: SimplifiedPreference) -> str:
        """A function of the columns as an expression over the features."""
        return preference.text(lambda column, bound: at_least(self.features[column], bound))


def _bound_feature(feature: Feature) -> Feature:
    """Feature for a bound; a bound on an attribute cuts it into ranges."""
    return Threshold(feature.site, 0.0) if isinstance(feature, Draw) and feature.branch is None else feature


def _with_integers(values: Floats) -> Floats:
    """Values with counts restored to integers after division and multiplication by a scale."""
    rounded = np.rint(values)
    return np.where(np.abs(values - rounded) <= ROUNDING * np.maximum(1.0, np.abs(rounded)), rounded, values)
