"""Elements of one label as few products: columns by rows, where each cell has an element or is hidden.

Elements of a facade on common lines, in front of its wall.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from grammarlab.facade.editing.grids import BACKGROUND
from grammarlab.facade.tree import Facade, Floats, Ints, X, Y

Interval = tuple[int, int]
"""Indices of the first and last line along an axis."""


@dataclass(frozen=True, eq=False)
class LabelledRectangles:
    """E labelled rectangles between lines."""

    lines: tuple[Floats, Floats]
    """Coordinates along x and y, metres, ascending, from 0 to the end of the facade."""
    boxes: Ints
    """[E, 4] line indices of left, bottom, right, top."""
    labels: tuple[str, ...]
    """[E] labels."""
    backdrop: str | None
    """Label of the wall behind them; None if there is none."""

    def interval(self, element: int, axis: int) -> Interval:
        """Interval of an element along an axis."""
        return int(self.boxes[element, axis]), int(self.boxes[element, axis + 2])


def backdrop_of(facade: Facade) -> str | None:
    """The background label that covers the most area of a facade; None if no leaf is background."""
    area: dict[str, float] = {}
    for leaf in facade.leaves.tolist():
        name = facade.name_of(leaf)
        if name.lower() in BACKGROUND:
            area[name] = area.get(name, 0.0) + float(facade.size[leaf].prod())
    return max(area, key=lambda name: (area[name], name)) if area else None


def elements_of(facade: Facade, tolerance: float) -> LabelledRectangles:
    """All leaves of a facade that are not its backdrop.

    Args:
        facade: the facade.
        tolerance: largest distance of sides on one line, metres; thinner leaves are left out.
    """
    backdrop = backdrop_of(facade)
    leaves = np.array([leaf for leaf in facade.leaves.tolist() if facade.name_of(leaf) != backdrop], dtype=np.int64)
    low = facade.position[leaves]
    sides = np.concatenate([low, low + facade.size[leaves]], axis=1).reshape(-1, 4)
    lines, boxes = [], np.zeros(sides.shape, dtype=np.int64)
    for axis in (X, Y):
        found, place = _lines(sides[:, axis::2].ravel(), float(facade.size[0, axis]), tolerance)
        lines.append(found)
        boxes[:, axis::2] = place.reshape(-1, 2)
    kept = (boxes[:, :2] < boxes[:, 2:]).all(axis=1)
    labels = tuple(facade.name_of(leaf) for leaf in leaves[kept].tolist())
    return LabelledRectangles((lines[X], lines[Y]), boxes[kept], labels, backdrop)


def grouped(values: Floats, tolerance: float) -> Ints:
    """[N] a group number for each value, in ascending order; values of one group differ by at most the tolerance."""
    order = np.argsort(values, kind="stable")
    number, first, found = -1, -np.inf, np.zeros(len(values), dtype=np.int64)
    for place in order.tolist():
        if values[place] - first > tolerance:
            number, first = number + 1, values[place]
        found[place] = number
    return found


def _lines(values: Floats, end: float, tolerance: float) -> tuple[Floats, Ints]:
    """Means of groups of values, and the line of each value; 0 and the end are lines."""
    inside = np.where(values <= tolerance, 0.0, np.where(values >= end - tolerance, end, values))
    inside = np.concatenate([[0.0, end], inside])
    number = grouped(inside, tolerance)
    lines = np.bincount(number, inside) / np.bincount(number)
    lines[0], lines[-1] = 0.0, end
    return lines, number[2:]


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
