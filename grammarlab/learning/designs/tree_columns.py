"""Parameters and measures of trees as columns of tables."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from grammarlab.arrays import Floats, Ints
from grammarlab.features.columns.feature_table import FeatureTable
from grammarlab.features.patterns.pattern import Draw
from grammarlab.randomness import Keys
from grammarlab.trees.measures import MEASURES
from grammarlab.trees.parameters import COLUMN, COLUMNS, IS_LOG, NUM_LEVELS, PARAMETERS, SPREAD
from grammarlab.trees.species import Species
from grammarlab.trees.tree_values import parameters

_MEASURE_SHARE = 0.75
"""Prior probability that a condition of a person is about a measure and not about a parameter."""
_UNITS = {"deg": "°"}
"""Units whose text differs from their name."""


@dataclass(frozen=True, eq=False)
class TreeBatch:
    """Trees of a species."""

    rows: Floats
    """[n, P] parameters (`grammarlab.trees.parameters.COLUMNS`)."""
    keys: Keys
    """[n] keys below which stems and leaves are drawn."""
    measures: Floats
    """[n, M] measures (`grammarlab.trees.measures.MEASURES`)."""

    def __len__(self) -> int:
        return len(self.rows)

    def take(self, indices: Ints) -> TreeBatch:
        """Some of the trees."""
        return TreeBatch(self.rows[indices], self.keys[indices], self.measures[indices])

    def columns(self) -> dict[str, Floats]:
        """All columns [n] by name: parameters, then measures."""
        return parameters(self.rows) | dict(zip(MEASURES, self.measures.T, strict=True))


def columns_of(designs: Sequence[TreeBatch], names: Sequence[str]) -> dict[str, Floats]:
    """Columns [n] of batches, one below the other."""
    batches = [batch.columns() for batch in designs]
    return {name: np.concatenate([np.zeros(0), *(columns[name] for columns in batches)]) for name in names}


@dataclass(frozen=True)
class TreeColumns:
    """Columns that distinguish trees; those of sizes and counts are logarithms."""

    names: tuple[str, ...]
    """[F] names of parameters and measures."""
    least: Floats
    """[F] smallest value whose logarithm is taken; NaN for columns that are no logarithms."""
    scales: Floats
    """[F] range of the values of each column."""

    @classmethod
    def of(cls, names: Sequence[str], designs: Sequence[TreeBatch]) -> TreeColumns:
        """The columns of some names that differ between designs."""
        columns = columns_of(designs, names)
        varying = tuple(name for name in names if len(columns[name]) and np.ptp(columns[name]) > 0.0)
        least = np.array([_least(columns[name]) if is_size(name) else np.nan for name in varying])
        plain = cls(varying, least, np.ones(len(varying)))
        return cls(varying, least, np.ptp(plain.table(designs), axis=0)) if varying else plain

    def apply(self, designs: Sequence[TreeBatch], /) -> FeatureTable:
        return FeatureTable(
            counts=sparse.csr_array(self.table(designs)),
            features=tuple(map(Draw, self.names)),
            names=tuple(map(words_of_name, self.names)),
            groups=np.arange(len(self.names)),
            group_names=tuple(map(words_of_name, self.names)),
            scales=self.scales,
            logarithmic=~np.isnan(self.least),
            priors=self.priors,
        )

    @property
    def priors(self) -> Floats:
        """[F] how likely each column is to matter: a person sees measures, and parameters only by their effects."""
        is_measure = np.array([name in MEASURES for name in self.names], dtype=bool)
        shares = np.where(is_measure, _MEASURE_SHARE, 1.0 - _MEASURE_SHARE)
        numbers = np.where(is_measure, is_measure.sum(), (~is_measure).sum())
        return shares * len(self.names) / numbers

    def table(self, designs: Sequence[TreeBatch]) -> Floats:
        """[n, F] values, not scaled."""
        columns = columns_of(designs, self.names)
        num = sum(map(len, designs))
        values = np.column_stack([np.zeros((num, 0)), *(columns[name] for name in self.names)])
        logarithmic = ~np.isnan(self.least)
        values[:, logarithmic] = np.log(np.maximum(values[:, logarithmic], self.least[logarithmic]))
        return values


def _least(values: Floats) -> float:
    """Half of the smallest positive value: 0 has no logarithm."""
    return float(values[values > 0.0].min()) / 2.0


def is_size(name: str) -> bool:
    """Whether a column is on a logarithmic scale: a size or a count."""
    return bool(IS_LOG[COLUMN[name]]) if name in COLUMN else MEASURES[name].log


def unit_of(name: str) -> str:
    """Unit of a parameter or measure for words, such as m or °."""
    unit = PARAMETERS[name.removesuffix(SPREAD)].unit if name in COLUMN else MEASURES[name].unit
    return _UNITS.get(unit, unit)


def words_of_name(name: str) -> str:
    """A parameter or measure in words.

    >>> words_of_name("down_angle_1_v"), words_of_name("crown_width")
    ('spread of down angle 1', 'crown width')
    """
    if name in COLUMN and name.endswith(SPREAD):
        return f"spread of {words_of_name(name.removesuffix(SPREAD))}"
    return name.replace("_", " ")


def relevant_names(species: Species) -> tuple[str, ...]:
    """Parameters that differ between trees of a species and that some tree has, then all measures."""
    low = np.min([kind.low for kind in species.kinds], axis=0)
    high = np.max([kind.high for kind in species.kinds], axis=0)
    unused = set(_unused(low, high))
    varying = low < high
    return (*(name for name in COLUMNS if varying[COLUMN[name]] and name.removesuffix(SPREAD) not in unused), *MEASURES)


def _unused(low: Floats, high: Floats) -> Iterator[str]:
    """Parameters without effect, by the ranges [P] of all columns."""

    def is_zero(name: str) -> bool:
        return low[COLUMN[name]] == high[COLUMN[name]] == 0.0

    num_levels = int(high[COLUMN["levels"]])
    for level in range(num_levels, NUM_LEVELS):
        yield from (name for name in PARAMETERS if name.endswith(f"_{level}"))
    for level in range(num_levels):
        if is_zero(f"seg_splits_{level}") and (level > 0 or is_zero("base_splits")):
            yield f"split_angle_{level}"
    if num_levels < 3:
        yield "attraction_up"
    has_envelope = low[COLUMN["shape"]] <= 8.0 <= high[COLUMN["shape"]]
    for switch, names in _SWITCHES:
        if is_zero(switch) and not (switch == "prune_ratio" and has_envelope):
            yield from names


_LEAVES = ("leaf_shape", "leaf_scale", "leaf_scale_x", "leaf_bend", "leaf_stem_len", "leaf_quality")
_BLOSSOMS = ("blossom_shape", "blossom_scale")
_SWITCHES = (
    ("lobes", ("lobe_depth",)),
    ("lobe_depth", ("lobes",)),
    ("wind_speed", ("wind_direction",)),
    ("prune_ratio", ("prune_width", "prune_width_peak", "prune_power_low", "prune_power_high")),
    ("leaves", (*_LEAVES, "blossom_rate", *_BLOSSOMS)),
    ("blossom_rate", _BLOSSOMS),
)
"""Parameters that have no effect where another one is 0."""
