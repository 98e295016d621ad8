"""Types of columns, ragged lists as values plus offsets, and basic operations on columns.

A ragged list of N rows is ``values`` of length ``offsets[N]`` and ``offsets`` of length N + 1: row i is
``values[offsets[i]:offsets[i + 1]]``.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]
AnyFloats = NDArray[np.floating]
"""Numbers of single or double precision, as pictures are made of."""
_Integer = TypeVar("_Integer", bound=np.integer)

ROUNDING = 1e-9
"""Largest relative error of sums and products of many numbers: what differs less is equal."""

MAX_STEPS = 200
"""Largest number of steps of an iteration that ends by itself. More are only slower."""
BATCH = 1_000
"""Number of rows of a table that are made at once, or of labels of several kinds that are weighed together: more need
more memory, fewer more calls."""
FEW = 3
"""Number of folds, sweeps, starts, gates, steps without a gain, or kept results, where one may do. More are only
slower."""
SEVERAL = 8
"""Number of alternatives that a search begins or continues with, those that a screening ranks first. More are only
slower."""
MANY = 24
"""Number of alternatives of one thing that are compared exactly, those that a screening ranks or a text declares
first. More are only slower."""
MANY_COLUMNS = 120
"""Number of columns that a search compares exactly or begins with, those that are likely to explain most or cheapest.
More are only slower."""
MOST_COLUMNS = 1_000
"""Largest number of columns of one recipe, of pairs of choices, and of symbols, lines or flags that are compared."""
NUM_LEVELS = 12
"""Number of levels or bins of a quantity, or of alternatives of a choice, where a search needs no more. More are only
slower."""
_HASH_FACTORS = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
"""Factors of the finaliser of SplitMix64."""
_WORD = 8
"""Bytes of a word that is hashed."""
_HASH_SHIFTS = np.uint64(30), np.uint64(27)
_HALF_WORD = np.uint64(32)
_LARGEST_CODE = 1 << 62
"""Largest code of a pair of integers, so that differences of two codes are within 64 bits."""
_FEW_ROWS = 40
"""Number of rows up to which a dictionary of their bytes is faster than columns of hashes."""
_FEW_HASHES = 1000
"""Number of hashes up to which sorting them is as fast as writing them to the places of a table; of 4,000, it takes
four times as long."""
_FEW_PLACES = 4000
"""Number of possible values up to which marking flags is faster than sorting any number of values."""
_MOST_DIGITS = 1 << 16
"""Number of different short integers."""
_MOST_PLACES = 8
"""Largest ratio of possible to given values for which marking flags is faster than sorting."""


def offsets_from_counts(counts: NDArray[np.integer]) -> Ints:
    """Offsets [N + 1] of a ragged list from the length of each row [N].

    >>> offsets_from_counts(np.array([2, 0, 3])).tolist()
    [0, 2, 2, 5]
    """
    offsets = np.zeros(len(counts) + 1, dtype=np.int64)
    counts.cumsum(out=offsets[1:])
    return offsets


def row_lengths(offsets: Ints) -> Ints:
    """Length of each row [N] of a ragged list from its offsets [N + 1].

    >>> row_lengths(np.array([0, 2, 2, 5])).tolist()
    [2, 0, 3]
    """
    return offsets[1:] - offsets[:-1]


def row_of_value(counts: NDArray[np.integer]) -> Ints:
    """Row of each value of a ragged list.

    >>> row_of_value(np.array([2, 0, 3])).tolist()
    [0, 0, 2, 2, 2]
    """
    return np.arange(len(counts), dtype=np.int64).repeat(counts)


def rows_of_groups(group: NDArray[np.integer], num: int) -> list[Ints]:
    """Rows [K] of each of ``num`` groups, ascending, from the group of each row.

    >>> [rows.tolist() for rows in rows_of_groups(np.array([2, 0, 2]), 3)]
    [[1], [], [0, 2]]
    """
    ends = np.cumsum(np.bincount(group, minlength=num))
    return np.split(np.argsort(narrow(group), kind="stable"), ends[:-1]) if num else []


def narrow(values: NDArray[np.integer]) -> NDArray[np.integer]:
    """The same integers of at least 0, in 16 bits if they fit: NumPy sorts these by radix sort, ten times as fast."""
    return values.astype(np.uint16) if values.max(initial=0) < _MOST_DIGITS else values


def index_in_row(counts: NDArray[np.integer]) -> Ints:
    """Index of each value of a ragged list within its row.

    >>> index_in_row(np.array([2, 0, 3])).tolist()
    [0, 1, 0, 1, 2]
    """
    index = (counts - counts.cumsum()).repeat(counts).astype(np.int64, copy=False)
    index += np.arange(len(index))
    return index


def take_rows(offsets: NDArray[np.integer], rows: NDArray[np.integer]) -> tuple[Ints, Ints]:
    """Indices of the values of chosen rows, and the offsets of the list of these rows.

    Args:
        offsets: [N + 1] offsets of a ragged list.
        rows: [K] rows to take, in any order, repeats allowed.

    Returns:
        Indices into the values, and the new offsets [K + 1].

    >>> where, offsets = take_rows(np.array([0, 2, 2, 5]), np.array([2, 0]))
    >>> where.tolist(), offsets.tolist()
    ([2, 3, 4, 0, 1], [0, 3, 5])
    """
    starts = offsets.take(rows)
    counts = offsets[1:].take(rows) - starts
    ends = offsets_from_counts(counts)
    where = (starts - ends[:-1]).repeat(counts)
    where += np.arange(len(where))
    return where, ends


def runs(*columns: NDArray) -> tuple[Ints, Ints]:
    """Runs [R] of rows in which no column [N] changes: the first row of each, and their lengths.

    >>> [column.tolist() for column in runs(np.array([4, 4, 4, 7]), np.array([0, 1, 1, 1]))]
    [[0, 1, 3], [1, 2, 1]]
    """
    num = len(columns[0])
    begins = np.zeros(num, dtype=bool)
    begins[:1] = True
    for column in columns:
        begins[1:] |= column[1:] != column[:-1]
    starts = np.flatnonzero(begins)
    return starts, np.diff(starts, append=num)


def distinct(values: NDArray[np.integer], limit: int) -> Ints:
    """The different values, ascending, of a column of integers in 0 <= value < limit.

    >>> distinct(np.array([4, 1, 4]), 6).tolist()
    [1, 4]
    """
    if limit > _MOST_PLACES * len(values):
        ordered = np.sort(values).astype(np.int64)  # `numpy.unique` takes several times as long: it hashes the values
        return ordered[runs(ordered)[0]]
    present = np.zeros(limit, dtype=bool)
    present[values] = True
    return np.flatnonzero(present)


def ranked(values: NDArray[np.integer], limit: int) -> tuple[Ints, Ints]:
    """The different values, ascending, of a column of integers in 0 <= value < limit, and the rank of each value.

    >>> different, rank = ranked(np.array([4, 1, 4]), 6)
    >>> different.tolist(), rank.tolist()
    ([1, 4], [1, 0, 1])
    """
    if limit > max(_FEW_PLACES, _MOST_PLACES * len(values)):
        different, rank = np.unique(values, return_inverse=True)
        return different.astype(np.int64), rank
    present = np.zeros(limit, dtype=bool)
    present[values] = True
    return np.flatnonzero(present), (present.cumsum() - 1).take(values)


def distinct_counts(
    values: NDArray[np.integer], limit: int, weights: NDArray[np.integer] | None = None
) -> tuple[Ints, Ints]:
    """The different values, ascending, of a column of integers in 0 <= value < limit, and how often each occurs.

    Args:
        values: [N] the integers.
        limit: their bound.
        weights: [N] how often each is counted, at least 1, with a sum below 2^53; None for once.

    >>> different, counts = distinct_counts(np.array([4, 1, 4]), 6)
    >>> different.tolist(), counts.tolist()
    ([1, 4], [1, 2])
    """
    if limit > _MOST_PLACES * len(values):
        if weights is None:
            different, counts = np.unique(values, return_counts=True)
            return different.astype(np.int64), counts
        different, rank = np.unique(values, return_inverse=True)
        return different.astype(np.int64), np.bincount(rank, weights).astype(np.int64)
    counts = np.bincount(values, weights, minlength=limit)
    different = np.flatnonzero(counts > 0)  # nonzero of flags is twice as fast as of integers
    return different, counts[different].astype(np.int64, copy=False)


def hashed(values: NDArray) -> NDArray[np.uint64]:
    """Hashes of the bits of 64-bit floats or integers, of the same shape; 0.0 and -0.0 differ, and that of 0 is 0."""
    bits = values.view(np.uint64) if values.dtype.itemsize == _WORD else values.astype(np.uint64)
    mixed = bits ^ (bits >> _HASH_SHIFTS[0])
    mixed *= _HASH_FACTORS[0]
    mixed ^= mixed >> _HASH_SHIFTS[1]
    mixed *= _HASH_FACTORS[1]
    return mixed


def same_bits(one: NDArray, other: NDArray) -> bool:
    """Whether two columns of one type are equal to the last bit; every NaN equals every other."""
    if one.shape != other.shape or one.dtype.kind != "f":
        return bool(np.array_equal(one, other))
    is_same = one.view(np.uint64) == other.view(np.uint64)
    return bool(is_same.all() or (is_same | (np.isnan(one) & np.isnan(other))).all())


def distinct_rows(*columns: NDArray) -> tuple[Ints, Ints]:
    """Different rows of columns, compared to the last bit: index [K] of the first of each, ascending, and number [N].

    Args:
        columns: [N] or [N, ...] contiguous columns of 64-bit floats or integers of any width, at least one.

    >>> first, number = distinct_rows(np.array([3, 3, 1, 3]), np.array([0.5, 2.0, 0.5, 0.5]))
    >>> first.tolist(), number.tolist()
    ([0, 1, 2], [0, 1, 2, 0])
    """
    num = len(columns[0])
    every = np.arange(num)
    if num <= 1:
        return every, every
    if num <= _FEW_ROWS:
        return _distinct_keys([tuple(row) for row in zip(*map(_row_bytes, columns), strict=True)])
    tables = [np.ascontiguousarray(column).reshape(num, -1) for column in columns]
    first, number = distinct_hashes(_row_hashes(tables))
    if len(first) == num:
        return first, number
    leader = first.take(number)
    # Two rows with one hash are possible in principle: then all rows count as different.
    return (first, number) if all(same_bits(table, table.take(leader, axis=0)) for table in tables) else (every, every)


def distinct_hashes(keys: NDArray[np.uint64]) -> tuple[Ints, Ints]:
    """Different values of a column of hashes: index [K] of the first of each, ascending, and number [N] of each.

    >>> first, number = distinct_hashes(hashed(np.array([7, 5, 7])))
    >>> first.tolist(), number.tolist()
    ([0, 1], [0, 1, 0])
    """
    leader = _first_of_equal(keys)
    is_first = leader == np.arange(len(keys))
    return np.flatnonzero(is_first), (np.cumsum(is_first) - 1).take(leader)


def distinct_pairs(one: NDArray[_Integer], other: Ints, limit: int) -> tuple[NDArray[_Integer], Ints, Ints]:
    """Different pairs of integers, ascending: both columns [K], and the number [N] of each.

    Args:
        one: [N] the first integers.
        other: [N] the second integers, 0 <= value < limit.
        limit: bound of the second integers; times any first integer, it is less than 2^62 in size.

    Raises:
        OverflowError: If it is not.

    >>> [column.tolist() for column in distinct_pairs(np.array([3, 2, 3]), np.array([1, 0, 1]), 2)]
    [[2, 3], [0, 1], [1, 0, 1]]
    """
    largest = max(-int(one.min(initial=0)), int(one.max(initial=0))) + 1
    if largest * limit > _LARGEST_CODE:
        raise OverflowError(f"pairs of integers below {largest:,} and {limit:,}: expected a product of at most 2^62")
    codes = one.astype(np.int64) * limit + other
    different, number = _distinct_codes(codes)
    first, second = np.divmod(different, limit)
    return first.astype(one.dtype), second, number


def _distinct_codes(codes: Ints) -> tuple[Ints, Ints]:
    """Different integers [K], ascending, and the number [N] of each."""
    if len(codes) <= _FEW_HASHES:
        order, begins = _sorted_runs(codes)
        number = np.empty(len(codes), dtype=np.int64)
        number[order] = begins.cumsum() - 1
        return codes.take(order[begins]), number
    low = int(codes.min())
    span = int(codes.max()) - low + 1
    if span <= _MOST_PLACES * len(codes):
        different, number = ranked(codes - low, span)
        return different + low, number
    first, number = distinct_hashes(hashed(codes))
    different, order = np.unique(codes.take(first), return_inverse=True)
    return different, order.take(number)


def _sorted_runs(values: NDArray) -> tuple[Ints, Flags]:
    """Order [N] of values, equal ones ascending by index, and whether each begins a run of equal ones [N].

    For few values this takes a third of the time of `numpy.unique`.
    """
    order = values.argsort(kind="stable")
    ordered = values.take(order)
    begins = np.ones(len(values), dtype=bool)
    np.not_equal(ordered[1:], ordered[:-1], out=begins[1:])
    return order, begins


def _first_of_equal(keys: NDArray[np.uint64]) -> Ints:
    """[N] index of the first of the hashes that equal each."""
    num = len(keys)
    if num <= _FEW_HASHES:
        order, begins = _sorted_runs(keys)
        leader = np.empty(num, dtype=np.int64)
        leader[order] = order[begins].take(begins.cumsum() - 1)
        return leader
    bits = num.bit_length() + 1
    place = (keys >> np.uint64(64 - bits)).astype(np.int64)
    first = np.full(1 << bits, num)
    np.minimum.at(first, place, np.arange(num))
    leader = first.take(place)
    other = np.flatnonzero(keys.take(leader) != keys)
    if len(other):
        leader[other] = other.take(_first_of_equal(hashed(keys.take(other))))
    return leader


def _row_hashes(tables: Sequence[NDArray]) -> NDArray[np.uint64]:
    """[N] hash of the bits of the rows of tables [N, K]."""
    key = np.zeros(len(tables[0]), dtype=np.uint64)
    for table in tables:
        bits = table.view(np.uint64) if table.dtype.itemsize == _WORD else table.astype(np.uint64)
        for values in bits.T:
            # One multiplication a column mixes less than `hashed` does, in a third of the passes; rows are compared.
            key ^= values
            key *= _HASH_FACTORS[1]
            key ^= key >> _HALF_WORD
    return key


def _row_bytes(column: NDArray) -> list[bytes]:
    """[N] the bytes of each row of a column."""
    content, num = column.tobytes(), len(column)
    width = len(content) // num
    return [content[start : start + width] for start in range(0, len(content), width)] if width else [b""] * num


def _distinct_keys(keys: Sequence[Hashable]) -> tuple[Ints, Ints]:
    """Index [K] of the first of each different key, ascending, and the number [N] of each key."""
    first: dict[Hashable, int] = {}
    for index, key in enumerate(keys):
        first.setdefault(key, index)
    rank = {index: number for number, index in enumerate(first.values())}
    return np.array(list(rank)), np.array([rank[first[key]] for key in keys])


def distinct_lists(values: NDArray, counts: NDArray[np.integer]) -> tuple[Ints, Ints]:
    """Different rows of a ragged list [V] or [V, ...]: index [K] of the first of each, ascending, and number [N].

    If their lengths are very different, all lists count as different.

    >>> first, number = distinct_lists(np.array([4, 5, 4, 4, 5]), np.array([2, 1, 2]))
    >>> first.tolist(), number.tolist()
    ([0, 1], [0, 1, 0])
    """
    num, longest = len(counts), int(counts.max(initial=0))
    if not lists_are_compared(counts):
        return np.arange(num), np.arange(num)
    table = np.zeros((num, longest, *values.shape[1:]), dtype=values.dtype)
    table[row_of_value(counts), index_in_row(counts)] = values
    return distinct_rows(counts, table)


def lists_are_compared(counts: NDArray[np.integer]) -> bool:
    """Whether `distinct_lists` compares lists of these lengths [N]."""
    return len(counts) * int(counts.max(initial=0)) <= _MOST_PLACES * int(counts.sum())


def connected(num: int, one: Ints, other: Ints) -> Ints:
    """[num] connected component of each node of an undirected graph, numbered in the order of their first nodes.

    Args:
        num: number of nodes.
        one: [E] one end of each edge.
        other: [E] the other end.

    >>> connected(5, np.array([3, 4]), np.array([1, 3])).tolist()
    [0, 1, 2, 1, 1]
    """
    # Imported here, since few models need it and it takes a third of the time to start.
    from scipy.sparse import coo_array  # noqa: PLC0415
    from scipy.sparse.csgraph import connected_components  # noqa: PLC0415

    graph = coo_array((np.ones(len(one), dtype=np.int8), (one, other)), shape=(num, num))
    _, label = connected_components(graph, directed=False)
    _, first, inverse = np.unique(label, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return rank[inverse]
