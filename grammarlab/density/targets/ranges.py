"""Drawn numbers cut into ranges: an approximation of a preference that changes with every value.

A grammar can choose a range and draw uniformly inside it. So the nearest preference that it can express is, in each box
of ranges, the mean of the target preference. Choices that are read by the number of their branch are cut in the same
way, since too many combinations of numbers need too many rules.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from math import prod

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.density.exact.attributes import drawn_range
from grammarlab.density.exact.compile import Preference
from grammarlab.density.exact.readings import Read
from grammarlab.errors import InexactError
from grammarlab.features.patterns.pattern import Draw, Threshold
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax.syntax_tree import Stochastic, alternatives

_NUM_POINTS = 128
"""Number of points in each box for the mean of a preference."""
_MAX_BOXES = 40_000
"""Largest number of combinations of ranges."""


def range_ends(grammar: Grammar, name: str) -> tuple[float, ...]:
    """Ends of the ranges of ``rand(a, b)`` of an attribute, ascending; none for other attributes."""
    attribute = grammar.attributes.get(name)
    leaves = [] if attribute is None else [drawn_range(leaf) for leaf in alternatives(attribute.value)]
    ends = {end for leaf in leaves if leaf is not None for end in leaf}
    return tuple(sorted(ends)) if None not in leaves else ()


def even_cuts(grammar: Grammar, name: str, number: int, more: Sequence[Threshold] = ()) -> list[Threshold]:
    """Bounds that cut an attribute into at least a number of ranges, such that no range contains the end of a draw.

    Args:
        grammar: the grammar.
        name: an attribute with `range_ends`.
        number: at least 1.
        more: further bounds.
    """
    ends = range_ends(grammar, name)
    inner = {
        *ends[1:-1],
        *(threshold.bound for threshold in more),
        *np.linspace(ends[0], ends[-1], number + 1)[1:-1].tolist(),
    }
    return [Threshold(name, cut) for cut in sorted(inner) if ends[0] < cut < ends[-1]]


def with_ranges(
    grammar: Grammar, reads: Sequence[Read], preference: Preference, number: int
) -> tuple[tuple[Read, ...], Preference]:
    """Readings of ranges instead of numbers, and the mean of a preference in these ranges.

    Args:
        grammar: the grammar.
        reads: what the preference reads.
        preference: from their values to a score.
        number: number of ranges of each attribute that is read by its value.

    Returns:
        The given readings and preference if no attribute is read by its value.

    Raises:
        InexactError: If there are too many boxes.
    """
    names = tuple(sorted({name for read in reads for name in _by_value(grammar, read)}))
    if not names:
        return tuple(reads), preference
    bounds = [read for read in reads if isinstance(read, Threshold)]
    choices = {Draw(name) for name in names if _num_branches(grammar, name)}
    new_reads = [read for read in reads if read in choices or not _by_value(grammar, read)]
    axes: list[_AttributeRanges] = []
    for name in names:
        size = _num_branches(grammar, name)
        if size:
            axes.append(
                _AttributeRanges(
                    np.unique(np.linspace(0, size, number + 1).round()), [new_reads.index(Draw(name))], True
                )
            )
            continue
        cuts = even_cuts(grammar, name, number, [threshold for threshold in bounds if threshold.site == name])
        new_reads += [threshold for threshold in cuts if threshold not in new_reads]
        first, *_, last = range_ends(grammar, name)
        edges = np.array([first, *(threshold.bound for threshold in cuts), last])
        axes.append(_AttributeRanges(edges, [new_reads.index(threshold) for threshold in cuts], False))
    if prod(len(axis.edges) - 1 for axis in axes) > _MAX_BOXES:
        raise InexactError(f"{len(names)} drawn numbers have too many combinations of {number} ranges")
    return tuple(new_reads), _Means(tuple(reads), tuple(new_reads), preference, names, tuple(axes))


def _by_value(grammar: Grammar, read: Read) -> tuple[str, ...]:
    """The attributes that are read by their value."""
    if isinstance(read, Draw) and read.branch is None:
        return (read.site,) if range_ends(grammar, read.site) or _num_branches(grammar, read.site) else ()
    return ()


def _num_branches(grammar: Grammar, name: str) -> int:
    """Number of branches of the choice that is drawn for an attribute; 0 if it is not a choice."""
    attribute = grammar.attributes.get(name)
    if attribute is None or range_ends(grammar, name) or not isinstance(attribute.value, Stochastic):
        return 0
    return len(attribute.value.branches)


@dataclass(frozen=True, slots=True)
class _AttributeRanges:
    """The ranges of one attribute."""

    edges: Floats
    """[ranges + 1] ends of the ranges, ascending."""
    columns: list[int]
    """Indices of its bounds, or of the number of its branch, among the readings."""
    is_choice: bool

    def range_of(self, values: Floats) -> NDArray[np.int64]:
        """[n] the range that models lie in."""
        if self.is_choice:
            return np.searchsorted(self.edges, values[:, self.columns[0]], side="right") - 1
        return (len(self.edges) - 2 - values[:, self.columns].sum(axis=1)).astype(np.int64)

    def drawn(self, ranges: NDArray[np.int64], share: float) -> Floats:
        """[n] the value at a share, 0 to 1, of the way through each range."""
        values = self.edges[ranges] + share * np.diff(self.edges)[ranges]
        return np.floor(values) if self.is_choice else values


@dataclass(frozen=True, slots=True)
class _Means:
    """The mean of a preference over the boxes that models lie in."""

    reads: tuple[Read, ...]
    """What the preference reads."""
    new_reads: tuple[Read, ...]
    """The new readings."""
    preference: Preference
    names: tuple[str, ...]
    """The attributes that were cut."""
    axes: tuple[_AttributeRanges, ...]

    def __call__(self, values: Floats) -> Floats:
        ranges = np.stack([axis.range_of(values) for axis in self.axes], axis=1)
        columns = list(chain.from_iterable(axis.columns for axis in self.axes))
        others = np.delete(values, columns, axis=1)
        _, first, box = np.unique(
            np.concatenate([ranges, others], axis=1), axis=0, return_index=True, return_inverse=True
        )
        return self._of_boxes(values[first], ranges[first])[box.reshape(-1)]

    def _of_boxes(self, values: Floats, ranges: NDArray[np.int64]) -> Floats:
        # Imported here, since it takes as long as half of JAX and few preferences are about drawn numbers.
        from scipy.stats import qmc  # noqa: PLC0415

        # Half a step from the lower ends, so that points are evenly distributed.
        points = qmc.Sobol(len(self.axes), scramble=False).random(_NUM_POINTS) + 0.5 / _NUM_POINTS
        total = np.zeros(len(values))
        for point in points:
            shares = zip(self.names, self.axes, ranges.T, point, strict=True)
            drawn = {name: axis.drawn(column, share) for name, axis, column, share in shares}
            total += self.preference(np.stack([self._value(read, values, drawn) for read in self.reads], axis=1))
        return total / len(points)

    def _value(self, read: Read, values: Floats, drawn: dict[str, Floats]) -> Floats:
        if isinstance(read, Draw) and read.branch is None and read.site in drawn:
            return drawn[read.site]
        return values[:, self.new_reads.index(read)]
