"""Strings as integers: a column of texts is a column of ids into one table."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

StringIds = NDArray[np.int32]


class StringTable:
    """The different strings of one derivation."""

    def __init__(self) -> None:
        self._ids: dict[str, int] = {}
        self._texts: list[str] = []

    def __len__(self) -> int:
        return len(self._texts)

    def __getitem__(self, index: int) -> str:
        return self._texts[index]

    def id(self, text: str) -> int:
        """The id of a string, new or known."""
        index = self._ids.get(text)
        if index is None:
            index = self._ids[text] = len(self._texts)
            self._texts.append(text)
        return index

    def ids(self, texts: Iterable[str]) -> StringIds:
        """The ids of several strings."""
        return np.array([self.id(text) for text in texts], dtype=np.int32)

    def map(self, column: StringIds, function: Callable[[str], str]) -> StringIds:
        """A column with a function applied to each different string once."""
        unique, inverse = np.unique(column, return_inverse=True)
        return self.ids(function(self._texts[i]) for i in unique)[inverse]

    def numbers(self, column: StringIds, function: Callable[[str], float]) -> NDArray[np.float64]:
        """A number column from a function applied to each different string once."""
        unique, inverse = np.unique(column, return_inverse=True)
        return np.array([function(self._texts[i]) for i in unique], dtype=np.float64)[inverse]
