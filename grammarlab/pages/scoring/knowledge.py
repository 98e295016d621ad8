"""Results of learning as plain arrays, for showing, sorting and comparing models."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import UsageError
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.pool import Pool
from grammarlab.pages.workers.tasks import Features, LearnedUpdate, Predictions

MOST_NAMES = 50
"""Largest number of features from one search."""


class ModelPool:
    """The models of the pool: addresses and indices."""

    def __init__(self, seed: int, size: int, wide: bool = False) -> None:
        """Names all models; see `Pool`."""
        self.pool = Pool(seed, size, wide)
        self.names = tuple(map(str, self.pool))
        self.index = {name: index for index, name in enumerate(self.names)}

    @property
    def samples(self) -> tuple[str, ...]:
        """The samples of the grammar itself."""
        return self.names[: self.pool.sizes[0]]

    def label_of(self, model: str) -> str:
        """Name of a model, with the seed and the number that ``grammarlab show`` takes."""
        address = Address.parse(model)
        return f"model {address.model} of seed {address.seed}" + (", drawn evenly" if address.flat else "")


@dataclass
class Knowledge:
    """The latest features and predictions."""

    features: Features | None = None
    learned: LearnedUpdate | None = None
    label_revision: int = -1
    """`Record.label_revision` at the time of learning."""
    names: Mapping[int, str] = field(default_factory=dict)
    """Names of the factors at that time, by number."""

    def take(self, learned: LearnedUpdate, label_revision: int, numbers: Mapping[str, int]) -> None:
        """Result of an update, and `Record.label_revision` and `Record.numbers` at its start."""
        self.learned, self.label_revision = learned, label_revision
        self.names = {number: name for name, number in numbers.items()}
        if learned.features is not None:
            self.features = learned.features

    def indices(self, names: Sequence[str], pool: ModelPool) -> NDArray[np.int64]:
        """[n] indices of models in the arrays, -1 for unknown models."""
        other_models = () if self.learned is None else self.learned.elsewhere
        other_index = {name: len(pool.names) + number for number, name in enumerate(other_models)}
        return np.array([pool.index.get(name, other_index.get(name, -1)) for name in names], dtype=np.int64)

    def predictions_of(self, factor: int) -> Predictions | None:
        """Predictions of the factor of a number, independent of its current name; of the product for 0."""
        if self.learned is None:
            return None
        return self.learned.factors.get(self.names.get(factor, "")) if factor else self.learned.product

    def names_like(self, query: str) -> list[str] | None:
        """Names of features that contain all words of a query; None if features are not known yet."""
        if self.features is None:
            return None
        words = query.casefold().split()
        return [name for name in self.features.names if all(word in name.casefold() for word in words)][:MOST_NAMES]

    def column(self, name: str) -> NDArray[np.float32]:
        """[m + e] a feature of all models.

        Raises:
            UsageError: If there is none of that name.
        """
        features = self._known_features()
        if name not in features.names:
            raise UsageError(f"unknown feature {name[:80]!r}; search for one by a word of its name.")
        return features.rows[:, features.names.index(name)]

    def scaled_rows(self, factor: int) -> NDArray[np.float32]:
        """[m + e, F] rows whose distances are those of the learned kernel; with equal weights without a kernel.

        Raises:
            UsageError: If features are not known yet.
        """
        rows, predicted = self._known_features().rows, self.predictions_of(factor)
        weights = None if predicted is None else predicted.weights
        if weights is None or len(weights) != rows.shape[1] or not weights.any():
            spread = np.ptp(rows, axis=0)
            weights = np.divide(1.0, spread**2, out=np.zeros_like(spread), where=spread > 0.0)
        return rows[:, weights > 0.0] * np.sqrt(weights[weights > 0.0])

    def _known_features(self) -> Features:
        if self.features is None:
            raise UsageError("the features of the models are still being counted; try again in a few seconds.")
        return self.features
