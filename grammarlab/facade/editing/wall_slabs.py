"""Slabs: columns of the whole facade, from its lowest to its highest part, that are repeated in all storeys at once.

Cuts between slabs lie where few openings are, summed over the storeys; a storey with another rhythm bends around its
openings (`composition.py`). Everything in a slab travels together: a window with its sill, shutters and balcony. What
is outside of the first and the last slab is a border, and occurs once; so does a slab with a door, or with a sign if
others can be repeated. Signs are not cut either, but they make no columns.

Rows are slabs along y; here they are called columns as well.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.facade.editing.grids import is_background, single_shops, topmost
from grammarlab.facade.looks import covers_opening, is_door, is_opening, is_sign
from grammarlab.facade.tree import TOLERANCE, Facade, X, Y

_WHOLE_SHARE = 0.9
"""Least share of the facade's length that makes an element a band: it has no place in a column."""
_GAP_COVERAGE = 1.0 / 3.0
"""Largest share of the openings of the fullest column that a cut may cross, by their size across the axis."""
_LEAST_GAP_SHARE = 0.35
"""Least width of a gap between columns, as a share of the median: narrower ones are inside of a column."""


@dataclass(frozen=True, slots=True)
class Slab:
    """A column of the whole facade."""

    begin: float
    """Start along the axis, metres from the start of the facade."""
    end: float
    """End along the axis."""
    is_fixed: bool
    """Whether it occurs exactly once, as a column with a door does, and the first and the last of several."""
    is_required: bool
    """Whether one copy has to stay, since it has a locked part."""
    contents: tuple[tuple[int, int], ...]
    """Labels of its elements, ascending, with the number of each."""

    @property
    def length(self) -> float:
        """Length along the axis, metres."""
        return self.end - self.begin


@dataclass(frozen=True, eq=False)
class Elements:
    """E elements of a facade along one axis."""

    node: Ints
    """[E] nodes, ascending."""
    low: Floats
    """[E] start, metres from the start of the facade."""
    high: Floats
    """[E] end."""
    thickness: Floats
    """[E] size across the axis, metres."""
    is_solid: Flags
    """[E] whether it is never cut: openings, or all elements if there are no openings."""
    is_whole: Flags
    """[E] whether it is about as long as the facade, and belongs to no column."""
    is_sign: Flags
    """[E] whether it bears letters."""
    is_alone: Flags
    """[E] whether it is neither an opening nor a sign, and none of its label is beside it; of none along Y."""

    @property
    def uncut(self) -> Ints:
        """Nodes that are never cut, ascending: solid ones and signs."""
        return self.node[self.is_solid | (self.is_sign & ~self.is_whole)]


def find_slabs(facade: Facade, along: int, elements: Elements, locked: Collection[int] = ()) -> tuple[Slab, ...]:
    """The columns of a facade, or its rows along Y from the bottom, side by side; empty if nothing can be repeated.

    Args:
        facade: the facade.
        along: X for columns, Y for rows.
        elements: its elements along this axis.
        locked: nodes with locks.
    """
    runs = _runs(elements, TOLERANCE * float(facade.size[0, along]))
    if not runs:
        return ()
    cuts = _cuts(runs, elements, float(facade.size[0, along]))
    slabs = _slabs(facade, elements, cuts, locked)
    without_signs = _with_borders(slabs, elements, along)
    chosen = _with_borders(_with_signs(slabs, elements), elements, along)
    # Slivers repeated often are stranger than signs: one usual column has to be left.
    chosen = chosen if _is_enough(chosen, without_signs, elements) else without_signs
    return _with_singles(chosen, elements)


def find_elements(facade: Facade, along: int, *, shops: bool = False, singles: bool = True) -> Elements:
    """The topmost nodes with a label; if none is an opening, also elements of grids shorter than half the facade.

    Blinds and shutters belong to openings: of a window behind a closed blind, only slivers are left.

    Args:
        facade: the facade.
        along: X for columns, Y for rows.
        shops: whether shop windows count as openings; else they may be cut, as bands are.
        singles: whether elements that are alone in their storey are told from others.
    """
    whole = float(facade.size[0, along])
    opens = np.array([*(is_opening(name) for name in facade.labels), False])
    chosen = ~is_background(facade)
    for grid in facade.grids if not opens[facade.label].any() else ():
        chosen[grid.node[facade.size[grid.node, along] < 0.5 * whole]] = True
    chosen[0] = False
    node = topmost(facade, chosen)
    low = facade.position[node, along] - facade.position[0, along]
    length, thickness = facade.size[node, along], facade.size[node, 1 - along]
    solid = opens[facade.label[node]]
    if solid.any():
        covers = np.array([*(covers_opening(name) for name in facade.labels), False])
        solid |= covers[facade.label[node]]
        if shops:
            solid |= single_shops(facade)[node]
    solid = solid if solid.any() else thickness < _WHOLE_SHARE * facade.size[0, 1 - along]
    is_whole = length >= _WHOLE_SHARE * whole
    signs = np.array([*(is_sign(name) for name in facade.labels), False])[facade.label[node]]
    candidates = ~(solid | is_whole | signs) if singles and along == X else np.zeros(len(node), dtype=bool)
    return Elements(
        node=node,
        low=low,
        high=low + length,
        thickness=thickness,
        is_solid=solid & ~is_whole,
        is_whole=is_whole,
        is_sign=signs,
        is_alone=candidates & _is_alone(facade, node) if candidates.any() else candidates,
    )


def _is_alone(facade: Facade, node: Ints) -> Flags:
    """[E] whether no other one of some nodes has the same label and overlaps with its storey."""
    label, bottom = facade.label[node], facade.position[node, Y]
    top, slack = bottom + facade.size[node, Y], TOLERANCE * facade.size[0, Y]
    is_alone = np.zeros(len(node), dtype=bool)
    rows = np.lexsort((bottom, label))
    rows = rows[top[rows] - bottom[rows] > slack]
    for same in np.split(rows, np.flatnonzero(np.diff(label[rows])) + 1):
        # From the bottom up, the next one begins first of all above, and one below may reach over those between.
        next_bottom = np.append(bottom[same[1:]], np.inf)
        reached = np.append(-np.inf, np.maximum.accumulate(top[same])[:-1])
        is_alone[same] = (top[same] - next_bottom <= slack) & (reached - bottom[same] <= slack)
    return is_alone


def _runs(elements: Elements, tolerance: float) -> list[tuple[float, float]]:
    """Intervals of columns: where more than a few openings are. Those with a narrow gap between them are one."""
    low, high, thickness = (values[elements.is_solid] for values in (elements.low, elements.high, elements.thickness))
    if not len(low):
        return []
    edges = np.sort(np.concatenate([low, high]))
    edges = edges[np.append(True, np.diff(edges) > tolerance)]
    middle = 0.5 * (edges[1:] + edges[:-1])
    coverage = ((low[:, None] < middle) & (middle < high[:, None])).astype(np.float64).T @ thickness
    is_full = np.concatenate([[False], coverage > _GAP_COVERAGE * coverage.max(), [False]])
    turns = np.flatnonzero(is_full[1:] != is_full[:-1])
    runs = list(zip(edges[turns[::2]].tolist(), edges[turns[1::2]].tolist(), strict=True))
    gaps = [after[0] - before[1] for before, after in pairwise(runs)]
    narrow = _LEAST_GAP_SHARE * float(np.median(gaps)) if gaps else 0.0
    merged = runs[:1]
    for begin, end in runs[1:]:
        if begin - merged[-1][1] < narrow:
            merged[-1] = merged[-1][0], end
        else:
            merged.append((begin, end))
    return merged


def _cuts(runs: Sequence[tuple[float, float]], elements: Elements, whole: float) -> list[float]:
    """Ascending cuts: about in the middle of each gap, and half a gap before the first and after the last column."""
    first, last = runs[0][0], runs[-1][1]
    before = first - _end_of_border(elements.low, elements.high, first)
    after = whole - _end_of_border(whole - elements.high, whole - elements.low, whole - last) - last
    gaps = [high[0] - low[1] for low, high in pairwise(runs)] or [2.0 * min(before, after)]
    middles = [_cut_between(low[1], high[0], elements, TOLERANCE * whole) for low, high in pairwise(runs)]
    start, stop = first - min(before, 0.5 * gaps[0]), last + min(after, 0.5 * gaps[-1])
    return [start, *middles, stop]


def _cut_between(low: float, high: float, elements: Elements, tolerance: float) -> float:
    """The position in a gap where a cut crosses the least of openings, then of elements, then nearest to the middle."""
    is_inside = ~elements.is_whole & (elements.low < high - tolerance) & (elements.high > low + tolerance)
    begin, end, thickness = (values[is_inside] for values in (elements.low, elements.high, elements.thickness))
    edges = np.unique(np.clip(np.concatenate([begin, end, [low, high]]), low, high))
    edges = edges[np.append(True, np.diff(edges) > tolerance)]
    between = 0.5 * (edges[1:] + edges[:-1])
    # A sign or a balcony may be cut, as bands are; half a window beside it would be worse however small it is.
    sizes = np.stack([thickness, thickness * elements.is_solid[is_inside]], axis=1)
    coverage = ((begin[:, None] < between) & (between < end[:, None])).astype(np.float64).T @ sizes
    middle = 0.5 * (low + high)
    # A cut directly beside an element would leave no gap in the copy.
    margin = np.minimum(0.25 * np.diff(edges), 0.1 * (high - low))
    position = np.clip(middle, edges[:-1] + margin, edges[1:] - margin)
    return float(position[np.lexsort((np.abs(position - middle), *np.round(coverage / tolerance).T))[0]])


def _end_of_border(low: Floats, high: Floats, first: float) -> float:
    """End of the elements before the first column that do not belong to it, as a pillar at the corner does not.

    Args:
        low: [E] starts of elements, metres.
        high: [E] their ends.
        first: start of the first column.
    """
    slack = TOLERANCE * float(high.max())
    for index in np.argsort(-high, kind="stable").tolist():
        if high[index] > first + slack:
            continue
        # What touches the column belongs to it, as shutters do, unless it is at the edge of the facade.
        if high[index] < first - slack or low[index] <= slack:
            return float(high[index])
        first = float(low[index])
    return 0.0


def _slabs(facade: Facade, elements: Elements, cuts: Sequence[float], locked: Collection[int]) -> list[Slab]:
    """The columns between these cuts."""
    label = facade.label[elements.node]
    doors = np.array([*(is_door(name) for name in facade.labels), False])[label]
    has_lock = np.array(
        [any(node <= lock < facade.end[node] for lock in locked) for node in elements.node.tolist()], dtype=bool
    )
    middle = 0.5 * (elements.low + elements.high)
    slabs = []
    for begin, end in pairwise(cuts):
        inside = (middle >= begin) & (middle < end) & ~elements.is_whole
        slabs.append(
            Slab(
                begin=begin,
                end=end,
                is_fixed=bool(doors[inside].any()),
                is_required=bool(has_lock[inside].any()),
                contents=tuple(sorted(Counter(label[inside].tolist()).items())),
            )
        )
    return slabs


def _free_openings(slabs: Sequence[Slab], elements: Elements) -> int:
    """Number of openings in columns that can be repeated."""
    middle = 0.5 * (elements.low + elements.high)[elements.is_solid]
    return sum(int(((middle >= slab.begin) & (middle < slab.end)).sum()) for slab in slabs if not slab.is_fixed)


def _is_enough(chosen: Sequence[Slab], usual: Sequence[Slab], elements: Elements) -> bool:
    """Whether at least one usual column can be repeated."""
    num_free = sum(not slab.is_fixed for slab in usual)
    return num_free * _free_openings(chosen, elements) >= max(_free_openings(usual, elements), 1)


def _with_singles(slabs: tuple[Slab, ...], elements: Elements) -> tuple[Slab, ...]:
    """The columns, fixed where an element that is alone begins or ends: a balcony may go on through a column.

    The shorter an element, the stranger are copies of it: short ones are first, as long as enough columns remain.
    """
    slack = TOLERANCE * float(elements.high.max())
    low, high = elements.low[elements.is_alone], elements.high[elements.is_alone]
    chosen = slabs
    for index in np.argsort(high - low, kind="stable").tolist():
        ends = low[index], high[index]
        fixed = tuple(
            replace(slab, is_fixed=slab.is_fixed or any(slab.begin + slack < end < slab.end - slack for end in ends))
            for slab in chosen
        )
        if not _is_enough(fixed, slabs, elements):
            continue
        # A house keeps both corners or neither.
        if fixed[0].is_fixed == fixed[-1].is_fixed or slabs[0].is_fixed != slabs[-1].is_fixed:
            chosen = fixed
    return chosen


def _with_signs(slabs: Sequence[Slab], elements: Elements) -> list[Slab]:
    """The columns, fixed where most of a sign is, or where they are inside of a long one."""
    signs = elements.is_sign & ~elements.is_whole
    low, high = elements.low[signs], elements.high[signs]
    chosen = []
    for slab in slabs:
        overlap = np.minimum(high, slab.end) - np.maximum(low, slab.begin)
        has_sign = bool((overlap > 0.5 * np.minimum(high - low, slab.length)).any())
        chosen.append(replace(slab, is_fixed=slab.is_fixed or has_sign))
    return chosen


def _with_borders(slabs: Sequence[Slab], elements: Elements, along: int) -> tuple[Slab, ...]:
    """The columns with the first and the last one fixed, if others remain; empty if all are fixed.

    A border with openings, such as a ground floor, is first or last itself.
    """
    low, high = elements.low[elements.is_solid], elements.high[elements.is_solid]
    has_inner = bool((high <= slabs[0].begin).any()), bool((low >= slabs[-1].end).any())
    ends = [index for index, inner in zip((0, len(slabs) - 1), has_inner, strict=True) if not inner]
    # A house keeps both corners or neither, but its ground floor whenever there is another one.
    for fixed in [ends, ends[:1], []] if along == Y else [ends, []]:
        chosen = tuple(replace(slab, is_fixed=slab.is_fixed or index in fixed) for index, slab in enumerate(slabs))
        if not all(slab.is_fixed for slab in chosen):
            return chosen
    return ()
