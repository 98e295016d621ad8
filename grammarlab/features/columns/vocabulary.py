"""Vocabulary: the columns of tables, found on some models and then used for any others.

>>> from grammarlab.derivation import derive
>>> from grammarlab.language.grammar import Grammar
>>> grammar = Grammar.parse('''
... attr height = rand(3, 9)
... Lot --> extrude(height) split(y) { ~1 : Block | ~1 : Block }
... Block --> 50% : Box else : i("builtin:cylinder") Round
... ''')
>>> table = extract([derive(grammar, 100, seed=1)])
>>> for name, feature in zip(table.names, table.features): print(name, "|", feature)
Block → Box | Block:0
Lot › Block 1 → Box | Lot:* > Block@0:0
Lot › Block 2 → Box | Lot:* > Block@1:0
height | height
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from grammarlab.arrays import Floats, Ints, offsets_from_counts
from grammarlab.derivation.forest import Forest
from grammarlab.errors import UsageError, check_type
from grammarlab.features.columns.column_keys import Meaning
from grammarlab.features.columns.column_names import ColumnNames
from grammarlab.features.columns.feature_table import FeatureTable, distinguishable, size_of
from grammarlab.features.columns.paths import (
    Tally,
    columns_of,
    count_adjacent_pairs,
    count_branches,
    count_far_pairs,
    count_paths,
    count_sequences,
    count_symbols,
    measure_draws,
)
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.node_labels import Key, KeyIndex, NodeLabels
from grammarlab.features.patterns.pattern import Draw, Feature, Pattern, Present
from grammarlab.features.patterns.tree_index import Trees

MAX_LENGTH = 20
"""Largest allowed length of paths."""

_KINDS = ("extra", "choice", "alternative", "rule", "symbol", "edge", "branch", "far", "next", "draw")
"""Order of kinds of columns; of equivalent columns the first is kept. Rules chosen at random, and symbols that are
alternatives of a choice, represent everything that follows from them, and share the group of their alternatives."""


@dataclass(frozen=True, slots=True)
class Options:
    """Features of a table."""

    length: int = 2
    """Largest length of paths, 1 to `MAX_LENGTH`; k in the paper."""
    symbols: bool = True
    """Whether to count symbols."""
    draws: bool = True
    """Whether to use draws: the mean of the draws of each name, and counts of the branches of a choice."""
    far_pairs: bool = False
    """Whether to count edges with choices far below them."""
    adjacent_pairs: bool = False
    """Whether to count choices of adjacent siblings."""
    repeats: Literal["present", "count"] = "present"
    """Values of patterns that geometry repeats, such as windows: presence or counts."""
    extra: tuple[Feature, ...] = ()
    """Additional features; one column each, unless constant."""

    def __post_init__(self) -> None:
        if not 1 <= self.length <= MAX_LENGTH:
            raise UsageError(f"expected paths of length 1 to {MAX_LENGTH}, found {self.length}")


@dataclass(frozen=True)
class Vocabulary:
    """The columns of tables."""

    options: Options
    labels: NodeLabels
    index: KeyIndex
    """All columns that were found."""
    columns: Ints
    """[F] the kept columns."""
    present: NDArray[np.bool_]
    """[F] whether a column has only the values 0 and 1 for presence."""
    features: tuple[Feature, ...]
    names: tuple[str, ...]
    groups: Ints
    group_names: tuple[str, ...]
    scales: Floats
    """[F]; this and the previous fields are those of `FeatureTable`."""

    @classmethod
    def find(cls, forests: Forest | Sequence[Forest], options: Options | None = None) -> Vocabulary:
        """Columns that distinguish models.

        Constant columns and equivalent columns are left out; rules are preferred to edges, short paths to long ones.
        Models should be many, and include rare ones.

        Args:
            forests: models of one grammar, or of grammars with the same symbols.
            options: the features.

        Raises:
            UsageError: If the columns of a forest are not trees.
        """
        return cls.find_with_table(forests, options)[0]

    @classmethod
    def find_with_table(
        cls, forests: Forest | Sequence[Forest], options: Options | None = None
    ) -> tuple[Vocabulary, FeatureTable]:
        """`find`, and the table that `apply` would make of the same models, which are counted once.

        Raises:
            UsageError: If the columns of a forest are not trees.
        """
        vocabulary, values = _find(_listed(forests), options or Options())
        return vocabulary, vocabulary._table(values)

    def apply(self, forests: Forest | Sequence[Forest]) -> FeatureTable:
        """Table of any models. Features outside the vocabulary are not counted.

        Raises:
            UsageError: If the columns of a forest are not trees.
        """
        tallies = [_collect(forest, self.labels, self.options, self.index, grow=False) for forest in _listed(forests)]
        tables = [_widened(part.counts, len(self.index))[:, self.columns] for part in tallies]
        for counts in tables:
            _flatten(counts, self.present)
        return self._table(_stacked(tables, len(self.columns)))

    def _table(self, values: sparse.csr_array) -> FeatureTable:
        return FeatureTable(
            counts=values,
            features=self.features,
            names=self.names,
            groups=self.groups,
            group_names=self.group_names,
            scales=self.scales,
            labels=self.labels,
        )


def extract(forests: Forest | Sequence[Forest], options: Options | None = None) -> FeatureTable:
    """Table of models, with the columns that distinguish them: `Vocabulary.find`, then its `apply`.

    >>> import grammarlab as gl
    >>> forest = gl.derive(gl.Grammar.parse("Lot --> 50% : A else : B"), 8, seed=1)
    >>> gl.extract([forest]).rows().shape
    (8, 1)
    """
    return Vocabulary.find_with_table(forests, options)[1]


def _listed(forests: Forest | Sequence[Forest]) -> tuple[Forest, ...]:
    if isinstance(forests, Forest):
        return (forests,)
    check_type("forests", forests, Iterable, "[gl.derive(grammar, 100, seed=1)]")
    listed = tuple(forests)
    for number, forest in enumerate(listed):
        check_type(f"forests[{number}]", forest, Forest, "gl.derive(grammar, 100, seed=1)")
    return listed


def _find(forests: tuple[Forest, ...], options: Options) -> tuple[Vocabulary, sparse.csr_array]:
    """A vocabulary, and the values [models, F] that it was found on."""
    labels, index = NodeLabels.of(forests), KeyIndex()
    tallies = [_collect(forest, labels, options, index, grow=True) for forest in forests]
    present = _any([part.repeated for part in tallies], len(index)) & (options.repeats == "present")
    meaning = Meaning(labels, index.keys, options.extra)
    tables = [_widened(part.counts, len(index)) for part in tallies]
    for counts in tables:
        _flatten(counts, present)
    order = sorted(range(len(index)), key=lambda column: (bool(present[column]), *_rank(index.keys[column], meaning)))
    columns = distinguishable(tables, np.array(order, dtype=np.int64))
    values = _stacked([counts[:, columns] for counts in tables], len(columns))
    keys = [index.keys[column] for column in columns]
    features = tuple(_wrapped(meaning.feature(key), bool(present[c])) for key, c in zip(keys, columns, strict=True))
    names = ColumnNames(labels, meaning)
    groups = [meaning.group(key) for key in keys]
    numbers = {group: number for number, group in enumerate(dict.fromkeys(groups))}
    vocabulary = Vocabulary(
        options=options,
        labels=labels,
        index=index,
        columns=columns,
        present=present[columns],
        features=features,
        names=_unique([names.column(key, feature) for key, feature in zip(keys, features, strict=True)], features),
        groups=np.array([numbers[group] for group in groups], dtype=np.int64),
        group_names=tuple(names.group(group) for group in numbers),
        scales=_scales(values, [key[0] == "draw" for key in keys]),
    )
    return vocabulary, values


def _rank(key: Key, meaning: Meaning) -> tuple:
    """Sort key of a column, independent of the order in which columns were found."""
    sort_key = meaning.sort_key(key)
    kind = "choice" if meaning.is_choice(key) else "alternative" if meaning.is_alternative(key) else key[0]
    return _KINDS.index(kind), len(sort_key), sort_key


def _wrapped(feature: Feature, present: bool) -> Feature:
    return Present(feature) if present and isinstance(feature, Pattern | Draw) else feature


def _unique(names: Sequence[str], features: Sequence[Feature]) -> tuple[str, ...]:
    """Names; the feature is added to names that are not unique."""
    occurrences = Counter(names)
    return tuple(f"{n} [{f}]" if occurrences[n] > 1 else n for n, f in zip(names, features, strict=True))


def _scales(values: sparse.csr_array, drawn: Sequence[bool]) -> Floats:
    """[F] the range of the draws, or the standard deviation of a count if it is more than 1."""
    num_models, width = size_of(values)
    scales = np.ones(width)
    columns = values.tocsc()
    for column, is_drawn in enumerate(drawn):
        data = columns.data[columns.indptr[column] : columns.indptr[column + 1]]
        if is_drawn:
            scales[column] = np.ptp(data) or 1.0
        else:
            mean = data.sum() / num_models
            scales[column] = max(1.0, np.sqrt(max(0.0, (data**2).sum() / num_models - mean**2)))
    return scales


def _flatten(counts: sparse.csr_array, present: NDArray[np.bool_]) -> None:
    """Give columns of presence 0 and 1, in place: new memory takes more time than anything else here."""
    counts.data[present[counts.indices] & (counts.data > 0.0)] = 1.0


def _collect(forest: Forest, labels: NodeLabels, options: Options, index: KeyIndex, grow: bool) -> Tally:
    """All columns for the models of one forest."""
    trees = Trees(forest)
    sequences = count_sequences(trees, labels, options.length, index, grow)
    tallies = [count_paths(sequences, len(index))]
    if options.symbols:
        tallies.append(count_symbols(sequences, labels, index, grow))
    if options.far_pairs:
        tallies.append(count_far_pairs(trees, labels, index, grow))
    if options.adjacent_pairs:
        tallies.append(count_adjacent_pairs(trees, labels, index, grow))
    if options.draws:
        tallies += [count_branches(trees, index, grow), measure_draws(trees, index, grow)]
    columns = index.columns((("extra", number) for number in range(len(options.extra))), grow)
    tallies.append(columns_of(count(trees, options.extra), columns, len(index)))
    counts = _merged([part.counts for part in tallies], len(index))
    return Tally(counts, _any([part.repeated for part in tallies], len(index)))


def _merged(parts: Sequence[sparse.csr_array], width: int) -> sparse.csr_array:
    """The sum of tables of the same models that have no column in common."""
    ends = np.cumsum([np.diff(part.indptr) for part in parts], axis=0)
    offsets = offsets_from_counts(ends[-1])
    data, columns = np.empty(offsets[-1]), np.empty(offsets[-1], np.int32)
    for part, end in zip(parts, ends, strict=True):
        lengths = np.diff(part.indptr)
        rows = np.repeat(offsets[:-1] + end - lengths - part.indptr[:-1], lengths) + np.arange(len(part.data))
        data[rows], columns[rows] = part.data, part.indices
    return sparse.csr_array((data, columns, offsets), shape=(len(offsets) - 1, width))


def _stacked(tables: Sequence[sparse.csr_array], width: int) -> sparse.csr_array:
    """The rows of several tables of ``width`` columns, one below the other."""
    empty = sparse.csr_array((0, width), dtype=np.float64)
    return sparse.csr_array(sparse.vstack([empty, *tables], format="csr"))


def _widened(counts: sparse.csr_array, width: int) -> sparse.csr_array:
    return sparse.csr_array((counts.data, counts.indices, counts.indptr), shape=(size_of(counts)[0], width))


def _any(flags: Sequence[NDArray[np.bool_]], width: int) -> NDArray[np.bool_]:
    """[width] whether any of several arrays of flags, of different lengths, is true."""
    result = np.zeros(width, dtype=bool)
    for part in flags:
        result[: len(part)] |= part
    return result
