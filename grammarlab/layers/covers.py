"""Elements of a facade on common lines, and those of one label as few products of columns and rows.

In each cell of a product there is an element, or the cell is hidden.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.facade.editing.grids import BACKGROUND
from grammarlab.facade.tree import Facade, X, Y

Interval = tuple[int, int]
"""Indices of the first and last line along an axis."""
GridCell = tuple[Interval, Interval]
"""Intervals along x and y of an element."""
_MOST_PAIRS = 40
"""Largest number of different rows of which all pairs are tried."""
_MAX_CANDIDATES = 200
"""Largest number of sets of columns to try, the largest first."""


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


@dataclass(frozen=True, slots=True)
class Product:
    """Elements of one label at all crossings of some columns and rows."""

    label: str
    across: frozenset[Interval]
    """Intervals along x."""
    up: frozenset[Interval]
    """Intervals along y."""


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
        axis_lines, side_lines = _lines(sides[:, axis::2].ravel(), float(facade.size[0, axis]), tolerance)
        lines.append(axis_lines)
        boxes[:, axis::2] = side_lines.reshape(-1, 2)
    has_extent = (boxes[:, :2] < boxes[:, 2:]).all(axis=1)
    labels = tuple(facade.name_of(leaf) for leaf in leaves[has_extent].tolist())
    return LabelledRectangles((lines[X], lines[Y]), boxes[has_extent], labels, backdrop)


def backdrop_of(facade: Facade) -> str | None:
    """The background label that covers the most area of a facade; None if no leaf is background."""
    area: dict[str, float] = {}
    for leaf in facade.leaves.tolist():
        name = facade.name_of(leaf)
        if name.lower() in BACKGROUND:
            area[name] = area.get(name, 0.0) + float(facade.size[leaf].prod())
    return max(area, key=lambda name: (area[name], name)) if area else None


def grouped(values: Floats, tolerance: float) -> Ints:
    """[N] a group number for each value, in ascending order; values of one group differ by at most the tolerance."""
    order = np.argsort(values, kind="stable")
    number, first, group = -1, -np.inf, np.zeros(len(values), dtype=np.int64)
    for index in order.tolist():
        if values[index] - first > tolerance:
            number, first = number + 1, values[index]
        group[index] = number
    return group


def products(
    label: str, cells: Collection[GridCell], hidden: Callable[[Interval, Interval], bool], most: int
) -> list[Product]:
    """Products that cover the given cells, and others only where they are hidden; large ones first.

    Each product is the largest one spanned by the possible columns of one row, or of two.

    Args:
        label: label of the elements.
        cells: cells of the elements, which do not overlap.
        hidden: whether a cell is fully hidden.
        most: largest number of products; some cells may remain uncovered.
    """
    uncovered = set(cells)
    rows: dict[Interval, set[Interval]] = {}
    for across, up in cells:
        rows.setdefault(up, set()).add(across)
    columns = sorted({across for across, _ in cells})
    possible = {
        up: frozenset(column for column in columns if column in row_columns or hidden(column, up))
        for up, row_columns in rows.items()
    }
    spanned = _spanned(rows, possible)
    result: list[Product] = []
    while uncovered and len(result) < most:
        candidates = (_product(label, across, rows, possible, uncovered) for across in spanned)
        best = max(candidates, key=lambda candidate: _gain(candidate, uncovered), default=None)
        if best is None or not _gain(best, uncovered)[0]:
            break
        result.append(best)
        uncovered -= {(across, up) for across in best.across for up in best.up}
    return result


def _lines(values: Floats, end: float, tolerance: float) -> tuple[Floats, Ints]:
    """Means of groups of values, and the line of each value; 0 and the end are lines."""
    inside = np.where(values <= tolerance, 0.0, np.where(values >= end - tolerance, end, values))
    inside = np.concatenate([[0.0, end], inside])
    number = grouped(inside, tolerance)
    lines = np.bincount(number, inside) / np.bincount(number)
    lines[0], lines[-1] = 0.0, end
    return lines, number[2:]


def _spanned(
    rows: dict[Interval, set[Interval]], possible: dict[Interval, frozenset[Interval]]
) -> list[frozenset[Interval]]:
    """Sets of columns that are possible in one row or in two, without overlapping columns."""
    different = list(dict.fromkeys((frozenset(rows[up]), possible[up]) for up in sorted(rows)))
    sets = [_apart(visible, wider) for visible, wider in different] + [visible for visible, _ in different]
    if len(different) <= _MOST_PAIRS:
        for (one, wider), (other, widest) in combinations(different, 2):
            sets += [_apart((one | other) & wider & widest, wider & widest), one & other]
    return sorted((candidate for candidate in dict.fromkeys(sets) if candidate), key=len, reverse=True)[
        :_MAX_CANDIDATES
    ]


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
    possible: dict[Interval, frozenset[Interval]],
    uncovered: set[GridCell],
) -> Product:
    """All rows that can have these columns; columns and rows without elements of their own are left out."""
    possible_rows = [up for up in sorted(rows) if across <= possible[up]]
    useful = [up for up in possible_rows if any((column, up) in uncovered for column in across)]
    up = _apart(useful, ())
    visible = frozenset(column for column in across if any(column in rows[row] for row in up))
    return Product(label, visible, up)


def _gain(product: Product, uncovered: set[GridCell]) -> tuple[int, int, int]:
    new = sum((across, up) in uncovered for across in product.across for up in product.up)
    return new, -len(product.across) - len(product.up), len(product.across)
