"""What has been learned so far, as plain arrays: enough to show, sort and compare without learning again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import UsageError
from grammarlab.evaluation.pool import pool_seeds, pool_sizes
from grammarlab.runs.scoring.addresses import Address
from grammarlab.runs.scoring.tasks import Features, Learned, Predicted

MOST_NAMES = 50
"""Features that one search gives at most."""


class ModelPool:
    """The models that a session chooses from: names and numbers."""

    def __init__(self, seed: int, size: int) -> None:
        """Names all models.

        Args:
            seed: of the session.
            size: how many models, samples of the grammar first.
        """
        self.sizes = pool_sizes(size)
        parts = enumerate(zip(self.sizes, pool_seeds(seed), strict=True))
        self.names = tuple(
            str(Address(bool(part), of_part, model)) for part, (num, of_part) in parts for model in range(num)
        )
        self.index = {name: index for index, name in enumerate(self.names)}

    @property
    def samples(self) -> tuple[str, ...]:
        """Those that are samples of the grammar itself."""
        return self.names[: self.sizes[0]]

    def indices(self, names: Sequence[str]) -> NDArray[np.int64]:
        """[n] numbers of models, -1 for those that are not of the pool."""
        return np.array([self.index.get(name, -1) for name in names], dtype=np.int64)


@dataclass
class Knowledge:
    """The latest features and predictions."""

    features: Features | None = None
    learned: Learned | None = None
    judgements: int = -1
    """`Record.judgements` when it was learned."""

    def take(self, learned: Learned, judgements: int) -> None:
        """What an update found, and `Record.judgements` when it began."""
        self.learned, self.judgements = learned, judgements
        if learned.features is not None:
            self.features = learned.features

    def of(self, factor: str) -> Predicted | None:
        """What is expected of a factor; of the product for the empty name."""
        if self.learned is None:
            return None
        return self.learned.factors.get(factor) if factor else self.learned.product

    def names_like(self, query: str) -> list[str]:
        """Names of features that hold all words of a query.

        Raises:
            UsageError: when features are not known yet.
        """
        words = query.casefold().split()
        names = self._known_features().names
        return [name for name in names if all(word in name.casefold() for word in words)][:MOST_NAMES]

    def column(self, name: str) -> NDArray[np.float32]:
        """[m] a feature of all models of the pool.

        Raises:
            UsageError: when there is none of that name.
        """
        features = self._known_features()
        if name not in features.names:
            raise UsageError(f"no feature is called {name[:80]!r}; search for one by a word of its name.")
        return features.rows[:, features.names.index(name)]

    def scaled_rows(self, factor: str) -> NDArray[np.float32]:
        """[m, F] rows whose distances are those of the learned kernel; of all features alike where there is none.

        Raises:
            UsageError: when features are not known yet.
        """
        rows, predicted = self._known_features().rows, self.of(factor)
        weights = None if predicted is None else predicted.weights
        if weights is None or len(weights) != rows.shape[1] or not weights.any():
            spread = np.ptp(rows, axis=0)
            weights = np.divide(1.0, spread**2, out=np.zeros_like(spread), where=spread > 0.0)
        return rows[:, weights > 0.0] * np.sqrt(weights[weights > 0.0])

    def _known_features(self) -> Features:
        if self.features is None:
            raise UsageError("the features of the models are still being counted; try again in a few seconds.")
        return self.features
