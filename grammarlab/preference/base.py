"""Interface of all preferences: functions learned from rows of numbers and scores."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike

from grammarlab.arrays import Floats
from grammarlab.errors import UsageError


class SparseRows(Protocol):
    """A sparse table, such as those of SciPy, which this module does without: it takes long to load."""

    def toarray(self) -> Any:
        """Dense table [n, F]."""
        ...


Rows = ArrayLike | SparseRows
"""Features of models: [n, F], one row per model, dense or sparse."""

MAX_SCORE = 100.0
"""Highest score; the lowest is 0 for disliked models."""
MIN_SHARE = 1e-3
"""Smallest share of one of several explanations in predictions; those below it are left out."""
LIKED_SHARE = 0.25
"""Share of the highest score from which a design or a kind of designs is liked."""
NEGLIGIBLE_SHARE = 0.01
"""Share of the relevance of a part, of the range of a quantity, or of a variance, that does not count."""
MANY_LABELS = 160
"""Number of labels from which on a part of the searches, or of the labels, is enough. More are only slower."""
ODDS_OF_SIMPLER = 20.0
"""Prior odds of the simpler explanation, where another one has more parts: one person, or cells alone."""
MIN_PART = 8
"""Smallest number of labels, or of designs of a pool, that may have an explanation of their own: those of a leaf, or of
a voice."""
HOPELESS = 12.0
"""Loss in nats that a search does not expect to make up for."""
SCORE_STEP = 1.0
"""Smallest difference of scores in points that a person can mean: a score means half of it on both sides, and designs
of a smaller value are not liked."""


@dataclass(frozen=True, slots=True)
class Prediction:
    """Predicted scores of models."""

    mean: Floats
    """[m] expected score, on the scale of the labels (0-100). It may leave that range a little."""
    std: Floats
    """[m] standard deviation of the score, >= 0, on the same scale."""


Level = Literal["strong", "medium", "weak", "none"]


@dataclass(frozen=True, slots=True)
class Relevance:
    """Relevance of one group of columns to a preference."""

    name: str
    """Name of the group, from the caller: ``roof of the top block``."""
    share: float
    """Loss of correlation of two models that differ in this group only, 0 <= share <= 1; see
    `grammarlab.preference.factors`."""
    level: Level
    """The share as a word."""

    def __str__(self) -> str:
        return f"{self.name}: {self.level}"


class AbstractPreference(ABC):
    """A learned preference function."""

    num_columns: int
    """F: number of columns of the rows."""

    @abstractmethod
    def predict(self, rows: Rows) -> Prediction:
        """Expected scores of models, with their uncertainty.

        Args:
            rows: [m, F] the columns that the preference was fitted on.

        Raises:
            UsageError: If the rows have another number of columns or a value that is not finite.
        """

    @abstractmethod
    def explain(self, group_names: Sequence[str]) -> list[Relevance]:
        """Relevance of the groups: one entry per group, most relevant first.

        Args:
            group_names: a name for each group number of `fit`; without groups every column is its own group.

        Raises:
            UsageError: If there are fewer names than groups.
        """

    @property
    def explaining(self) -> AbstractPreference:
        """What it explains, without a share that it leaves to the designs as they are: the preference to ask with."""
        return self

    def column_weights(self) -> Floats | None:
        """[F] >= 0, weight of each column in the distance of two models; None without such a measure."""
        return None


def dense_rows(rows: Rows, what: str = "rows") -> Floats:
    """Rows as a dense [n, F] table of finite float64 numbers.

    Raises:
        UsageError: If they are not such a table; the message names the first bad row and column.
    """
    values: Any = rows
    if hasattr(values, "toarray"):
        values = values.toarray()
    try:
        table = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise UsageError(f"{what}: expected a table of numbers [models, columns] ({error}).") from error
    if table.ndim != 2:
        raise UsageError(
            f"{what}: expected a table [models, columns], found {table.ndim} axes of sizes {list(table.shape)}."
        )
    if not np.isfinite(table).all():
        row, column = np.argwhere(~np.isfinite(table))[0]
        raise UsageError(f"{what}: expected finite numbers, found {table[row, column]} in row {row}, column {column}.")
    return table


def rows_to_predict(rows: Rows, num_columns: int) -> Floats:
    """Rows as a dense table with as many columns as a preference was fitted on.

    Raises:
        UsageError: If they are not such a table.
    """
    table = dense_rows(rows)
    if table.shape[1] != num_columns:
        raise UsageError(
            f"rows: this preference was fitted on {num_columns} columns, found {table.shape[1]}. "
            "Apply the vocabulary that made the labelled rows."
        )
    return table
