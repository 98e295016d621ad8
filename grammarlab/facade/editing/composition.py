"""A facade put together from intervals of another one, side by side along one axis.

The intervals are cut through all storeys at once, and everything keeps its distance from the start of its interval. So
what stood exactly above each other still does, in every copy. Openings are never cut: where a cut would cross one, the
row of parts around it keeps or drops it whole, and the walls beside it become longer or shorter. The same holds for
other elements, if there are such walls. But where two intervals meet inside of one element that is not an opening, such
as a cornice, it becomes longer; walls that meet are one wall.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from grammarlab.arrays import Ints
from grammarlab.errors import FacadeError
from grammarlab.facade.editing.grids import is_background, single_shops
from grammarlab.facade.editing.pieces import WHOLE, part_of, take
from grammarlab.facade.editing.variations import Variation, check_depth
from grammarlab.facade.grid import Grid
from grammarlab.facade.tree import LEAF, TOLERANCE, Facade, X, check

Interval = tuple[float, float]
"""Start and end, metres from the start of the facade."""


@dataclass(frozen=True, slots=True)
class _Span:
    """A part of an interval inside of a node."""

    low: float
    """Start in the source, metres."""
    high: float
    """End in the source, metres."""
    shift: float
    """Distance from a place in the source to that in the result, metres."""
    interval: int
    """Index of the interval."""
    before: float
    """End of the interval before in the source, metres; infinite if there is none."""
    after: float
    """Start of the interval after in the source, metres; infinite if there is none."""


@dataclass(slots=True)
class _Part:
    """A node of the result."""

    source: int
    spans: tuple[_Span, ...]
    low: float
    """Start in the result, metres."""
    high: float
    """End in the result, metres."""
    parts: list[_Part] | None = None
    """Its parts; None for a leaf."""
    protrudes: bool = False
    """Whether it is whole though a cut crosses it."""


class _Composer:
    """The source facade, with what the composition along one axis needs."""

    def __init__(self, facade: Facade, along: int, solid: Ints) -> None:
        low = facade.position[:, along] - facade.position[0, along]
        high = low + facade.size[:, along]
        self.facade, self.along = facade, along
        self.slack = TOLERANCE * float(facade.size[0, along])
        self.low, self.high = low.tolist(), high.tolist()
        self.axis = facade.axis.tolist()
        self.wall = (is_background(facade) & (facade.axis == LEAF)).tolist()
        self.solid, self.is_solid = solid, frozenset(solid.tolist())
        hard = is_background(facade) & (facade.axis == LEAF)
        hard[solid] = True
        self.is_shop = single_shops(facade).tolist()
        self._hard_before = np.append(0, hard.cumsum()).tolist()
        self._solid_low, self._solid_high = low[solid] + self.slack, high[solid] - self.slack

    def is_protected(self, node: int, span: _Span, cut: float, other: float) -> bool:
        """Whether a cut would cross a part of a row that should not be cut.

        Args:
            node: a part of a row along the axis.
            span: a part of an interval.
            cut: start or end of the span, metres.
            other: where the result goes on there, metres.
        """
        low, high = self.low[node] + self.slack, self.high[node] - self.slack
        if not low < cut < high:
            return False
        if self.is_soft(node):
            # What is longer than the repeated part, as a cornice, goes on behind the cut, unless only its end is there.
            period = abs(other - cut)
            return not low < other < high and (high - low < period or self._is_stub(node, span, period))
        if self.axis[node] == LEAF or node in self.is_solid:
            return self._crosses_opening(node, cut)
        return any(self._is_rigid(child, cut) for child in self.facade.children[node].tolist())

    def _is_stub(self, node: int, span: _Span, period: float) -> bool:
        """Whether a span shows less than half of a node, which takes up less than half of it and of a length, metres.

        A shop window stays cut, which is a fault: a ground floor with whole ones is better than one without them.
        """
        overlap = min(span.high, self.high[node]) - max(span.low, self.low[node])
        whole = min(self.high[node] - self.low[node], span.high - span.low, period)
        return not self.is_shop[node] and 2.0 * overlap < whole

    def _is_rigid(self, node: int, cut: float) -> bool:
        """Whether a cut crosses an opening in a node, and it has no row with walls that can bend around it."""
        if not self._crosses_opening(node, cut):
            return False
        if self.axis[node] == LEAF or node in self.is_solid:
            return True
        return not any(self.wall[child] for child in self.facade.children[node].tolist())

    def _crosses_opening(self, node: int, cut: float) -> bool:
        first, last = np.searchsorted(self.solid, [node, self.facade.end[node]])
        return bool(((self._solid_low[first:last] < cut) & (cut < self._solid_high[first:last])).any())

    def is_soft(self, node: int) -> bool:
        """Whether a node is an element, or several side by side, without walls and openings."""
        return self._hard_before[self.facade.end[node]] == self._hard_before[node]

    def _can_grow(self, node: int, end: int) -> bool:
        """Whether a node can be longer without longer openings.

        Args:
            node: the node.
            end: the end where it grows: 0 for its start, -1 for its end.
        """
        if node in self.is_solid or self.axis[node] == LEAF:
            return node not in self.is_solid
        children = self.facade.children[node].tolist()
        return all(
            self._can_grow(child, end) for child in (children if self.axis[node] != self.along else [children[end]])
        )

    def part(self, node: int, spans: tuple[_Span, ...], low: float, high: float) -> _Part:
        """A node over some spans of it, from a start to an end in the result."""
        if self.axis[node] == LEAF:
            return _Part(node, spans, low, high)
        children = self.facade.children[node].tolist()
        if self.axis[node] != self.along:
            parts = [self.part(child, spans, low, high) for child in children]
        else:
            row = self._fitted(self._row(children, spans) or [self._filler(children, spans[0])], low, high)
            parts = [self.part(one.source, one.spans, one.low, one.high) for one in row]
        parts = [inner for part in parts for inner in self._opened(node, part)]
        return _Part(node, spans, low, high, parts) if len(parts) > 1 else parts[0]

    def _opened(self, node: int, part: _Part) -> list[_Part]:
        """The parts of a part that is divided along the same axis as the node around it; otherwise itself."""
        return part.parts if part.parts is not None and self.axis[part.source] == self.axis[node] else [part]

    def _row(self, children: list[int], spans: tuple[_Span, ...]) -> list[_Part]:
        """The children of a row over some spans, each at the shift of its span, with walls joined."""
        row: list[_Part] = []
        for span in spans:
            for index, piece in enumerate(self._inside(children, span, row[-1].source if row else -1)):
                if row and index == 0 and self._continues(row[-1], piece):
                    row.append(self._joined(row.pop(), piece))
                elif not (row and index == 0 and self._repeats(row[-1], piece)):
                    row.append(piece)
        return row

    def _inside(self, children: list[int], span: _Span, previous: int) -> list[_Part]:
        """The children over one span; elements that an end of it crosses are whole or left out."""
        inside: list[_Part] = []
        for index, child in enumerate(children):
            low, high = max(span.low, self.low[child]), min(span.high, self.high[child])
            if high - low <= self.slack:
                continue
            middle = 0.5 * (self.low[child] + self.high[child])
            cut_low = self.is_protected(child, span, span.low, span.before)
            cut_high = self.is_protected(child, span, span.high, span.after)
            drop_low = cut_low and (middle < span.low or child == previous)
            drop_high = cut_high and middle >= span.high
            if self.is_soft(child):
                # Something that can be longer has to fill its place, and no opening.
                is_stuck = drop_low and not any(self._can_grow(one, 0) for one in children[index + 1 : index + 2])
                drop_low, cut_low = drop_low and not is_stuck, cut_low and not is_stuck
                is_stuck = drop_high and not any(self._can_grow(one.source, -1) for one in inside[-1:])
                drop_high, cut_high = drop_high and not is_stuck, cut_high and not is_stuck
            if cut_low and cut_high:
                drop_low = drop_high = child == previous
            if not (drop_low or drop_high):
                low, high = self.low[child] if cut_low else low, self.high[child] if cut_high else high
                inside.append(replace(self._piece(child, low, high, span), protrudes=cut_low or cut_high))
        return inside

    def _filler(self, children: list[int], span: _Span) -> _Part:
        """What fills a row of which everything was left out: one of its walls, or else what is most in a span."""
        walls = [child for child in children if self.wall[child]]
        if walls:
            return self._piece(walls[0], self.low[walls[0]], self.high[walls[0]], span)
        overlap, child = max((min(span.high, self.high[one]) - max(span.low, self.low[one]), one) for one in children)
        low = max(span.low, self.low[child])
        return self._piece(child, low, low + overlap, span)

    def _piece(self, child: int, low: float, high: float, span: _Span) -> _Part:
        return _Part(child, (replace(span, low=low, high=high),), low + span.shift, high + span.shift)

    def _continues(self, last: _Part, piece: _Part) -> bool:
        """Whether a part at the start of a span is one with the last part of the span before."""
        if last.source != piece.source:
            return self.wall[last.source] and self.wall[piece.source]
        is_cut = (
            last.spans[-1].high < self.high[last.source] - self.slack
            or piece.spans[0].low > self.low[piece.source] + self.slack
        )
        return is_cut or self.wall[last.source] or self.is_soft(last.source)

    def _repeats(self, last: _Part, piece: _Part) -> bool:
        """Whether an element at the start of a span takes the place of one that the span before ends with."""
        return self.is_soft(last.source) and self.is_soft(piece.source) and piece.low < 0.5 * (last.low + last.high)

    def _joined(self, last: _Part, piece: _Part) -> _Part:
        """One part for two that meet; of walls the first."""
        return _Part(last.source, (*last.spans, *piece.spans), last.low, piece.high)

    def look(self, part: _Part, whole: float) -> int:
        """The node that a part shows, in a result of this length.

        A wall at the edge of the facade looks different: a copy inside shows another wall of its row, if there is one.
        """
        if not (self.wall[part.source] and part.low > self.slack and part.high < whole - self.slack):
            return part.source
        if self._is_inside(part.source):
            return part.source
        siblings = self.facade.children[self.facade.parent[part.source]].tolist()
        return next((one for one in siblings if self.wall[one] and self._is_inside(one)), part.source)

    def _is_inside(self, node: int) -> bool:
        """Whether a node is not at the edge of the facade."""
        return self.low[node] > self.slack and self.high[node] < self.high[0] - self.slack

    def _fitted(self, row: list[_Part], low: float, high: float) -> list[_Part]:
        """A row without gaps and overlaps from a start to an end: walls give way, then elements, and openings last."""
        row = [one for one in row if one.high - one.low > self.slack]
        if row:
            row[0].low, row[-1].high = low, high
        for before, after in pairwise(row):
            firmness = self._firmness(before.source) - self._firmness(after.source)
            if not firmness and (before.protrudes or after.protrudes) and self._collide(before, after):
                # Both are at their places elsewhere: one of them is enough here.
                left_out = before if before.protrudes else after
                return self._fitted([one for one in row if one is not left_out], low, high)
            meet = 0.5 * (before.high + after.low) if not firmness else before.high if firmness > 0 else after.low
            before.high = after.low = meet
        remaining = [one for one in row if one.high - one.low > self.slack]
        return self._fitted(remaining, low, high) if len(remaining) < len(row) else row

    def _collide(self, before: _Part, after: _Part) -> bool:
        """Whether two parts overlap, and more than some walls and elements between their openings would give way."""
        overlap = before.high - after.low
        shorter = min(before.high - before.low, after.high - after.low)
        gives_way = self._can_grow(before.source, -1) and self._can_grow(after.source, 0)
        return overlap > self.slack and not (gives_way and 2.0 * overlap < shorter)

    def _firmness(self, node: int) -> int:
        return 0 if self.wall[node] else 1 if self.is_soft(node) else 2


def composed(before: Variation, along: int, intervals: Sequence[Interval], solid: Ints) -> Variation:
    """The facade of some intervals of a variation, side by side.

    Its sizes are a layout in which nothing is deformed. The targets of parts that became longer are their new lengths.

    Args:
        before: a variation whose facade is laid out with its targets.
        along: X for intervals from the left to the right, Y for those from the bottom to the top.
        intervals: intervals of the facade, in the order of the result.
        solid: nodes that are not cut, ascending.

    Raises:
        FacadeError: If nothing remains, or the tree is too deep.
    """
    check_depth(before.facade)
    joined = _joined(intervals, TOLERANCE * float(before.facade.size[0, along]))
    if not joined:
        raise FacadeError("Nothing is left of the facade: keep at least one column or row.")
    starts = np.cumsum([0.0, *(end - begin for begin, end in joined)]).tolist()
    begins, ends = [begin for begin, _ in joined], [end for _, end in joined]
    spans = tuple(
        _Span(begin, end, start - begin, index, before_end, after_begin)
        for index, (begin, end, start, before_end, after_begin) in enumerate(
            zip(begins, ends, starts, [np.inf, *ends], [*begins[1:], np.inf], strict=False)
        )
    )
    composer = _Composer(before.facade, along, solid)
    return _as_variation(before, composer, composer.part(0, spans, 0.0, starts[-1]))


def _joined(intervals: Sequence[Interval], slack: float) -> list[Interval]:
    """The intervals that are longer than a slack, with those joined that continue each other."""
    joined: list[Interval] = []
    for begin, end in intervals:
        if joined and joined[-1][1] == begin:
            joined[-1] = joined[-1][0], end
        elif end - begin > slack:
            joined.append((begin, end))
    return joined


def _as_variation(before: Variation, composer: _Composer, top: _Part) -> Variation:
    facade, along = before.facade, composer.along
    parts: list[_Part] = []
    parent: list[int] = []

    def emit(part: _Part, above: int) -> None:
        index = len(parts)
        parts.append(part)
        parent.append(above)
        for inner in part.parts or []:
            emit(inner, index)

    emit(top, -1)
    node = np.array([composer.look(part, top.high) for part in parts], dtype=np.int64)
    visible = np.tile(WHOLE, (len(node), 1))
    visible[:, [along, along + 2]] = [_visible(composer, part) for part in parts]
    low, high = np.array([(part.low, part.high) for part in parts]).T
    size, position = facade.size[node], facade.position[node]
    size[:, along], position[:, along] = high - low, low + facade.position[0, along]
    is_leaf = np.array([part.parts is None for part in parts])
    axis = np.where(is_leaf, LEAF, facade.axis[node]).astype(np.int8)
    result = take(facade, np.array(parent, dtype=np.int64), axis, node, size, visible)
    result = replace(result, position=position, size=size)
    interval = np.array([part.spans[0].interval for part in parts])
    grids = [_grid(old, facade, node, interval, along) for old in facade.grids]
    result = check(replace(result, grids=tuple(grid for grid in grids if grid is not None)))
    return replace(
        before,
        facade=result,
        source=before.source[node],
        target=size,
        visible=part_of(before.visible[node], visible),
    )


def _visible(composer: _Composer, part: _Part) -> tuple[float, float]:
    """Start and end of the visible part of a leaf's source; all of it if it became longer, or if it is an opening.

    Where an interval lies inside of an opening, the opening is squeezed.
    """
    if part.parts is not None or part.source in composer.is_solid or len(part.spans) != 1:
        return 0.0, 1.0
    span, low, high = part.spans[0], composer.low[part.source], composer.high[part.source]
    begin, end = (span.low - low) / (high - low), (span.high - low) / (high - low)
    return (0.0 if begin < TOLERANCE else begin), (1.0 if end > 1.0 - TOLERANCE else end)


def _grid(grid: Grid, facade: Facade, source: Ints, interval: Ints, along: int) -> Grid | None:
    """A grid with all copies of its elements; the copies of each interval are in lines of their own."""
    element = np.full(len(facade), -1, dtype=np.int64)
    element[grid.node] = np.arange(len(grid.node))
    node = np.flatnonzero(element[source] >= 0)
    if not node.size:
        return None
    elements = element[source[node]]
    old = grid.column if along == X else grid.num_rows - 1 - grid.row
    _, line = np.unique(np.stack([interval[node], old[elements]]), axis=1, return_inverse=True)
    row, column = grid.row[elements], grid.column[elements]
    if along == X:
        return Grid(grid.name, node, np.unique(row, return_inverse=True)[1], line)
    return Grid(grid.name, node, line.max() - line, np.unique(column, return_inverse=True)[1])
