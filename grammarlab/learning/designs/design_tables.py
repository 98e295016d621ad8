"""Designs as rows of numbers: the only place where rows are made."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Generic

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import ROUNDING, Flags, Floats, Ints
from grammarlab.features.columns.column_names import FeatureNames
from grammarlab.features.columns.feature_table import FeatureTable
from grammarlab.features.columns.formula_names import formula_words, unit_of
from grammarlab.features.patterns.node_labels import NodeLabels
from grammarlab.features.patterns.pattern import Feature, Formula
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.design_space import AbstractDesignSpace, DesignColumns, Designs
from grammarlab.learning.designs.pool import PoolDesigns
from grammarlab.learning.settings import FeatureOptions


@dataclass(frozen=True, slots=True)
class Columns:
    """Definition of the columns of a table, in addition to the pool."""

    path_length: int
    """Number of edges of the longest paths."""
    extra: tuple[Feature, ...] = ()
    """Features composed of others; each has its own column and group."""
    prices: tuple[float, ...] = ()
    """Description length of each of them, in nats."""
    elsewhere: tuple[Address, ...] = ()
    """Scored designs outside the pool, ascending; columns must distinguish them as well."""


@dataclass(frozen=True)
class DesignTable:
    """Features of m designs of a pool, then of e designs from elsewhere; and of n others."""

    columns: Columns
    rows: Floats
    """[m + e, F] values divided by their scales."""
    others: Floats
    """[n, F] scaled values of designs outside the questions."""
    features: tuple[Feature, ...]
    """[F] the features of the columns."""
    names: tuple[str, ...]
    """[F] readable names, all different."""
    groups: Ints
    """[F] index into `group_names`: alternatives of one choice share a group."""
    group_names: tuple[str, ...]
    scales: Floats
    """[F] scale of each column, > 0."""
    logarithmic: Flags | None = None
    """[F] whether values are logarithms of the features; None if none is."""
    priors: Floats | None = None
    """[F] how likely columns are to matter to a person, relative to each other; None if all are equally likely."""
    units: tuple[str, ...] = ()
    """[F] units of the features, empty for none; () if none has one."""
    labels: NodeLabels | None = None
    """Labels of the nodes of the designs; None if they have no nodes."""

    @cached_property
    def words(self) -> FeatureNames:
        """Words for features, columns or not."""
        return FeatureNames(dict(zip(self.features, self.names, strict=True)), self.labels)

    def values(self, num: int) -> Floats:
        """[num, F] values of the features of the first designs, in their units."""
        values = self.rows[:num] * self.scales
        if self.logarithmic is not None:
            values[:, self.logarithmic] = np.exp(values[:, self.logarithmic])
        return values

    @cached_property
    def continuous(self) -> NDArray[np.bool_]:
        """[F] whether columns are continuous instead of counts."""
        values = self.rows * self.scales
        return np.any(np.abs(values - np.round(values)) > ROUNDING * np.maximum(np.abs(values), 1.0), axis=0)


class DesignTables(Generic[Designs]):
    """Tables of a pool, with a cache."""

    def __init__(
        self,
        space: AbstractDesignSpace[Designs],
        pool_designs: PoolDesigns[Designs],
        features: FeatureOptions,
        others: tuple[Designs, ...] = (),
    ) -> None:
        """Tables of features.

        Args:
            space: the design space.
            pool_designs: the designs of the pool.
            features: the features.
            others: further designs with rows in tables; they do not affect the columns.
        """
        self.space, self.pool_designs, self._features, self._others = space, pool_designs, features, others
        self.table = lru_cache(maxsize=2)(self._table)
        """Table of `Columns`."""
        self._base = lru_cache(maxsize=4)(self._count)
        self._composed = lru_cache(maxsize=64)(self._measure)
        self._elsewhere = lru_cache(maxsize=4)(lambda addresses: (space.make(addresses),) if addresses else ())

    @cached_property
    def addresses(self) -> tuple[Address, ...]:
        """[m] addresses of the designs of the pool, in the order of the rows of a table."""
        return tuple(self.pool_designs.pool)

    @cached_property
    def index(self) -> dict[Address, int]:
        """Addresses of the designs of the pool, with their indices."""
        return {address: row for row, address in enumerate(self.addresses)}

    def designs(self, rows: Ints, elsewhere: tuple[Address, ...]) -> tuple[Designs, ...]:
        """The designs of rows of a table.

        Args:
            rows: [k] ascending; those beyond the pool are of ``elsewhere``.
            elsewhere: `Columns.elsewhere` of the table.
        """
        num_pool = len(self.pool_designs.pool)
        inside = self.pool_designs.select(self.space, rows[rows < num_pool])
        outside = rows[rows >= num_pool] - num_pool
        outside_designs = self._elsewhere(elsewhere) if len(outside) else ()
        return (*inside, *(self.space.take(designs, outside) for designs in outside_designs))

    def rows_of(self, columns: Columns, addresses: tuple[Address, ...]) -> Floats:
        """[k, F] rows of designs by ascending address, in the columns of a table."""
        vocabulary, _, _ = self._base(columns.path_length, columns.elsewhere)
        designs = self._elsewhere(addresses)
        return self._extended(vocabulary.apply(designs).rows(), designs, columns.extra)

    def _table(self, columns: Columns) -> DesignTable:
        _, base, others = self._base(columns.path_length, columns.elsewhere)
        pool = [self._composed(feature)[0] for feature in columns.extra]
        elsewhere = self._elsewhere(columns.elsewhere)
        rows = base.rows()
        if columns.extra:
            composed = np.concatenate([np.column_stack(pool), self._scaled(elsewhere, columns.extra)])
            rows = np.column_stack([rows, composed])
        first, names = len(base.group_names), _names(columns.extra, base)
        return DesignTable(
            columns=columns,
            rows=rows,
            others=self._extended(others, self._others, columns.extra),
            features=(*base.features, *columns.extra),
            names=(*base.names, *names),
            groups=np.append(base.groups, np.arange(first, first + len(names))),
            group_names=(*base.group_names, *names),
            scales=np.append(base.scales, [self._composed(feature)[1] for feature in columns.extra]),
            logarithmic=None if base.logarithmic is None else np.append(base.logarithmic, np.zeros(len(names), bool)),
            priors=_priors(base, columns.prices),
            units=tuple(unit_of(feature, self.space.unit_of) for feature in (*base.features, *columns.extra)),
            labels=base.labels,
        )

    def _count(
        self, path_length: int, elsewhere: tuple[Address, ...]
    ) -> tuple[DesignColumns[Designs], FeatureTable, Floats]:
        """The columns of the vocabulary: of the pool and elsewhere, and the rows of the others."""
        designs = (*self.pool_designs.batches, *self._elsewhere(elsewhere))
        vocabulary, table = self.space.tabulated(designs, replace(self._features, path_length=path_length))
        return vocabulary, table, vocabulary.apply(self._others).rows()

    def _measure(self, feature: Feature) -> tuple[Floats, float]:
        """[m] scaled values of a feature composed of others, and the scale: its standard deviation, at least 1."""
        values = self.space.values(self.pool_designs.batches, (feature,))[:, 0]
        scale = max(1.0, float(values.std()))
        return values / scale, scale

    def _extended(self, rows: Floats, designs: Sequence[Designs], extra: tuple[Feature, ...]) -> Floats:
        """Rows with the columns of features composed of others."""
        return np.column_stack([rows, self._scaled(designs, extra)]) if extra else rows

    def _scaled(self, designs: Sequence[Designs], extra: tuple[Feature, ...]) -> Floats:
        """[n, X] values of features composed of others, divided by their scales."""
        return self.space.values(designs, extra) / [self._composed(feature)[1] for feature in extra]


def _priors(base: FeatureTable, prices: tuple[float, ...]) -> Floats | None:
    """[F] how likely columns are to matter: composed ones by their description, relative to a group of the others."""
    if not prices:
        return base.priors
    known = np.ones(len(base.features)) if base.priors is None else base.priors
    return np.append(known, np.minimum(len(base.group_names) * np.exp(-np.array(prices)), 1.0))


def _names(features: Sequence[Feature], base: FeatureTable) -> tuple[str, ...]:
    """Readable names of features composed of others, numbered if another column has the same name."""
    names = FeatureNames(dict(zip(base.features, base.names, strict=True)), base.labels)
    texts = [formula_words(feature, names) if isinstance(feature, Formula) else names[feature] for feature in features]
    occurrences = Counter(base.names)
    numbered: list[str] = []
    for text in texts:
        occurrences[text] += 1
        numbered.append(f"{text} ({occurrences[text]})" if occurrences[text] > 1 else text)
    return tuple(numbered)
