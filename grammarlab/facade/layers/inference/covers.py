"""Elements of one label as few products: columns by rows, where each cell has an element or is hidden."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass
from itertools import combinations

from grammarlab.facade.layers.inference.elements import Interval

Place = tuple[Interval, Interval]
_MOST_PAIRS = 40
"""Largest number of different rows of which all pairs are tried."""
_MOST_TRIED = 200
"""Number of sets of columns to try, the largest first."""


@dataclass(frozen=True, slots=True)
class Product:
    """Elements of one label at all crossings of some columns and rows."""

    label: str
    across: frozenset[Interval]
    """Intervals along x."""
    up: frozenset[Interval]
    """Intervals along y."""


def products(
    label: str, places: Collection[Place], hidden: Callable[[Interval, Interval], bool], most: int
) -> list[Product]:
    """Products that cover the given places, and others only where they are hidden; large ones first.

    Each product is the largest one spanned by the possible columns of one row, or of two.

    Args:
        label: label of the elements.
        places: places of the elements, which do not overlap.
        hidden: whether a place is fully hidden.
        most: largest number of products; some places may remain uncovered.
    """
    left = set(places)
    rows: dict[Interval, set[Interval]] = {}
    for across, up in places:
        rows.setdefault(up, set()).add(across)
    columns = sorted({across for across, _ in places})
    may = {up: frozenset(each for each in columns if each in own or hidden(each, up)) for up, own in rows.items()}
    spanned = _spanned(rows, may)
    found: list[Product] = []
    while left and len(found) < most:
        tried = (_product(label, across, rows, may, left) for across in spanned)
        best = max(tried, key=lambda each: _gain(each, left), default=None)
        if best is None or not _gain(best, left)[0]:
            break
        found.append(best)
        left -= {(across, up) for across in best.across for up in best.up}
    return found


def _spanned(
    rows: dict[Interval, set[Interval]], may: dict[Interval, frozenset[Interval]]
) -> list[frozenset[Interval]]:
    """Sets of columns that are possible in one row or in two, without overlapping columns."""
    different = list(dict.fromkeys((frozenset(rows[up]), may[up]) for up in sorted(rows)))
    found = [_apart(own, wider) for own, wider in different] + [own for own, _ in different]
    if len(different) <= _MOST_PAIRS:
        for (one, wider), (other, widest) in combinations(different, 2):
            found += [_apart((one | other) & wider & widest, wider & widest), one & other]
    return sorted((each for each in dict.fromkeys(found) if each), key=len, reverse=True)[:_MOST_TRIED]


def _apart(first: Collection[Interval], others: Iterable[Interval]) -> frozenset[Interval]:
    """Intervals that do not overlap; the first ones take precedence."""
    chosen: list[Interval] = []
    for low, high in (*sorted(first), *sorted(set(others) - set(first))):
        if all(high <= begin or end <= low for begin, end in chosen):
            chosen.append((low, high))
    return frozenset(chosen)


def _product(
    label: str,
    across: frozenset[Interval],
    rows: dict[Interval, set[Interval]],
    may: dict[Interval, frozenset[Interval]],
    left: set[Place],
) -> Product:
    """All rows that can have these columns; columns and rows without elements of their own are left out."""
    having = [up for up in sorted(rows) if across <= may[up]]
    wanted = [up for up in having if any((each, up) in left for each in across)]
    up = _apart(wanted, ())
    seen = frozenset(each for each in across if any(each in rows[one] for one in up))
    return Product(label, seen, up)


def _gain(product: Product, left: set[Place]) -> tuple[int, int, int]:
    new = sum((across, up) in left for across in product.across for up in product.up)
    return new, -len(product.across) - len(product.up), len(product.across)
