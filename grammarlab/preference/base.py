"""What every way of learning a preference has in common: rows of numbers and scores go in, a function comes out."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from grammarlab.errors import UsageError

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

Rows = ArrayLike | sparse.sparray | sparse.spmatrix
"""What describes models: [n, F], one row a model, dense or sparse."""

MAX_SCORE = 100.0
"""Scores run from 0, not wanted, to this."""


@dataclass(frozen=True, slots=True)
class Prediction:
    """What a preference expects of models."""

    mean: Floats
    """[m] expected score, on the scale of the labels (0-100). It may leave that range a little."""
    std: Floats
    """[m] standard deviation of the score, >= 0, on the same scale."""


Level = Literal["strong", "medium", "weak", "none"]


@dataclass(frozen=True, slots=True)
class Relevance:
    """How much a preference looks at one group of columns."""

    name: str
    """The group, as the caller names it: ``roof of the top block``."""
    share: float
    """How unlike two models become by differing in this group alone, 0 <= share <= 1; see
    `grammarlab.preference.explain`."""
    level: Level
    """The share in a word."""

    def __str__(self) -> str:
        return f"{self.name}: {self.level}"


class AbstractPreference(ABC):
    """A learned preference function."""

    num_columns: int
    """F: how many columns the rows have."""

    @abstractmethod
    def predict(self, rows: Rows) -> Prediction:
        """The expected scores of models, and how sure they are.

        Args:
            rows: [m, F] the columns that the preference was fitted on.

        Raises:
            UsageError: when the rows have another number of columns or hold a value that is not finite.
        """

    @abstractmethod
    def explain(self, group_names: Sequence[str]) -> list[Relevance]:
        """What the preference looks at: one entry a group, most relevant first.

        Args:
            group_names: a name for each group number that `fit` was given; without groups every column is its own.

        Raises:
            UsageError: when there are fewer names than groups.
        """

    def column_weights(self) -> Floats | None:
        """[F] >= 0, how much each column matters to how alike two models are; None where there is no such measure."""
        return None


def dense_rows(rows: Rows, what: str = "rows") -> Floats:
    """Rows as a dense [n, F] table of finite float64 numbers.

    Raises:
        UsageError: when they are no such table; the message names the first bad row and column.
    """
    values: Any = rows
    if isinstance(rows, sparse.sparray | sparse.spmatrix):
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
        UsageError: when they are no such table.
    """
    table = dense_rows(rows)
    if table.shape[1] != num_columns:
        raise UsageError(
            f"rows: this preference was fitted on {num_columns} columns, found {table.shape[1]}. "
            "Apply the vocabulary that made the labelled rows."
        )
    return table
