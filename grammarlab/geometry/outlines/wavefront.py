"""The wavefront of a polygon: its edges move inwards, each at its own speed, until they have swept the inside.

This is the event simulation under the straight skeleton (Aichholzer et al., "A novel type of skeleton for polygons",
1995), with weights. All wavefront corners that meet at one place and time are resolved together, as Kelly and Wonka do
("Interactive architectural modeling with procedural extrusions", TOG 30(2), 2011), so that edge, split and simultaneous
events are one case: sorted around the place, the chains exchange their ends.

The polygon must be scaled to about unit size: `TOLERANCE` is a length.
"""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass, field
from itertools import count, pairwise
from typing import NamedTuple

TOLERANCE = 1e-9
"""Largest distance of corners that count as met, in a polygon of about unit size."""
_PARALLEL = 1e-9
"""Largest cross product of the directions of parallel edges."""
BLUNT_REFLEX = math.sin(math.radians(45.0)) + _PARALLEL
"""Sine of the largest turn of a reflex corner where strips of different depth end on its bisector: measured in
CityEngine's runtime to 0.1 degrees."""
BLUNT_CONVEX = math.sin(math.radians(15.0)) + _PARALLEL
"""The same for convex corners."""


class Wavefront:
    """A moving wavefront. Add closed loops, then call `run` once.

    Args:
        bisector_cuts: whether a fast edge beside a slow one is cut off along the bisector of a corner that turns by at
            most `BLUNT_REFLEX` or `BLUNT_CONVEX`, as in CityEngine; otherwise it always follows the slow edge.
    """

    def __init__(self, bisector_cuts: bool = False) -> None:
        self.nodes: list[tuple[float, float, float]] = []
        """x, y and time of every place where corners were born or met."""
        self.arcs: list[tuple[int, int, int]] = []
        """(edge index, from node, to node): borders of the swept areas, which lie to their left."""
        self._edges: list[_Edge] = []
        self._corners: dict[_Corner, None] = {}
        self._events: list[tuple[float, int, _Corner, _Corner | _Edge]] = []
        self._ticket = count()
        self._bisector_cuts = bisector_cuts

    def add_loop(self, loop: list[tuple[float, float]], speeds: list[float], indices: list[int]) -> None:
        """A closed outline with its inside to the left: corners, and for the edges that leave them speed and index."""
        edges = []
        following = loop[1:] + loop[:1]
        for (x, y), (x2, y2), speed, index in zip(loop, following, speeds, indices, strict=True):
            length = math.hypot(x2 - x, y2 - y)
            dx, dy = (x2 - x) / length, (y2 - y) / length
            edges.append(_Edge(index=index, dx=dx, dy=dy, start=dx * y - dy * x, speed=speed))
        self._edges += edges
        first = len(self.nodes)
        self.nodes += [(x, y, 0.0) for x, y in loop]
        born: list[_Corner] = []
        for i in range(len(loop)):
            born += self._join(edges[i - 1], edges[i], first + i, 0.0)
            self.arcs.append((indices[i], first + i, first + (i + 1) % len(loop)))
        for previous, corner in zip(born[-1:] + born[:-1], born, strict=True):
            previous.next, corner.previous = corner, previous

    def run(self, until: float) -> list[list[tuple[int, int]]]:
        """Move the edges until a time, which may be infinite.

        Returns:
            The loops that are left at that time, inside to the left: each node with the index of the edge that leaves
            it. Loops without area are among them.
        """
        for corner in list(self._corners):
            self._plan(corner)
        budget = 40 * len(self._edges) + 100
        while self._events and budget:
            time, _, corner, partner = heapq.heappop(self._events)
            if time > until + TOLERANCE:
                break
            if corner.alive and self._meet(min(time, until), corner, partner):
                budget -= 1
        return self._stop(until)

    def _join(self, before: _Edge, after: _Edge, node: int, time: float) -> list[_Corner]:
        """New corners, not yet linked, between two edges at a node: one, or two with a cut between."""
        x, y, _ = self.nodes[node]
        cross = before.dx * after.dy - before.dy * after.dx
        dot = before.dx * after.dx + before.dy * after.dy
        fast, slow = max(before.speed, after.speed), min(before.speed, after.speed)
        bluntest = _PARALLEL
        if self._bisector_cuts:
            bluntest = BLUNT_REFLEX if cross < 0.0 else BLUNT_CONVEX
        if slow < fast * (1.0 - _PARALLEL) and dot > 0.0 and abs(cross) <= bluntest:
            first = before.speed == fast
            dx, dy = before.nx + after.nx, before.ny + after.ny
            scale = (-1.0 if first else 1.0) / math.hypot(dx, dy)
            dx, dy = scale * dx, scale * dy
            index = (before if first else after).index
            cut = _Edge(index=index, dx=dx, dy=dy, start=dx * y - dy * x, speed=0.0, is_cut=True)
            self._edges.append(cut)
            pairs = [(before, cut), (cut, after)]
        else:
            pairs = [(before, after)]
        born = []
        for a, b in pairs:
            pace = _velocity(a, b)
            vx, vy = pace or (0.0, 0.0)
            born.append(_Corner(before=a, after=b, node=node, x=x, y=y, time=time, vx=vx, vy=vy, is_stuck=pace is None))
        for corner in born:
            self._corners[corner] = None
            corner.after.corners[corner] = None
        return born

    def _plan(self, corner: _Corner) -> None:
        """Add the next events of a linked corner to the queue."""
        self._plan_collapse(corner.previous, corner)
        self._plan_collapse(corner, corner.next)
        before, after = corner.before, corner.after
        if corner.is_stuck or before.dx * after.dy - before.dy * after.dx > _PARALLEL:
            return
        for edge in self._edges:
            closing = edge.speed - (edge.dx * corner.vy - edge.dy * corner.vx)
            if closing <= _PARALLEL or edge is before or edge is after or not edge.corners:
                continue
            ahead = edge.ahead(corner.x, corner.y, corner.time)
            if ahead >= -TOLERANCE:
                time = corner.time + max(ahead, 0.0) / closing
                heapq.heappush(self._events, (time, next(self._ticket), corner, edge))

    def _plan_collapse(self, start: _Corner, end: _Corner) -> None:
        edge = start.after
        time = max(start.time, end.time)
        (x, y), (x2, y2) = start.position(time), end.position(time)
        length = (x2 - x) * edge.dx + (y2 - y) * edge.dy
        rate = (start.vx - end.vx) * edge.dx + (start.vy - end.vy) * edge.dy
        if rate > _PARALLEL:
            heapq.heappush(self._events, (time + max(length, 0.0) / rate, next(self._ticket), start, end))

    def _meet(self, time: float, corner: _Corner, partner: _Corner | _Edge) -> bool:
        """Process an event if it is still valid; returns whether the wavefront has changed."""
        x, y = corner.position(time)
        met = {corner}
        if isinstance(partner, _Corner):
            if not partner.alive or corner.next is not partner:
                return False
            x2, y2 = partner.position(time)
            x, y = 0.5 * (x + x2), 0.5 * (y + y2)
            met.add(partner)
        elif not any(_reaches(start, x, y, time) for start in partner.corners if start is not corner):
            return False
        near = self._near(x, y, time) | met
        met |= {other for other in near if not other.is_stuck and not _just_parted(other, corner, time)}
        chains, closed = self._chains(met, near, x, y, time)
        if not closed and len(chains) == 1 and len(met) == 1:
            return False
        node = self._node(x, y, time)
        for other in [c for c in self._corners if c in met]:
            self._end(other, node)
        self._reconnect(chains, node, time)
        return True

    def _near(self, x: float, y: float, time: float) -> set[_Corner]:
        near = set()
        for corner in self._corners:
            cx, cy = corner.position(time)
            if abs(cx - x) <= TOLERANCE and abs(cy - y) <= TOLERANCE:
                near.add(corner)
        return near

    def _chains(
        self, met: set[_Corner], near: set[_Corner], x: float, y: float, time: float
    ) -> tuple[list[_CornerRun], bool]:
        """The runs of corners that met and the pieces of edges they hit; whether a whole loop has shrunk to a point."""
        chains = []
        covered = 0
        for start in self._corners:
            if start in met:
                if start.previous in met:
                    continue
                end = start
                covered += 1
                while end.next in met:
                    end = end.next
                    covered += 1
                chains.append(_CornerRun(start.previous, start.before, end.after, end.next))
            elif start not in near and start.next not in near and _reaches(start, x, y, time):
                chains.append(_CornerRun(start, start.after, start.after, start.next))
        for chain in chains:
            chain.direction = _outer_direction(chain.arriving, chain.leaving)
        chains.sort(key=lambda chain: chain.direction)
        return chains, covered < len(met)

    def _reconnect(self, chains: list[_CornerRun], node: int, time: float) -> None:
        """Join each chain's leaving edge to the arriving edge of the next chain around the node."""
        born: list[_Corner] = []
        for chain, following in zip(chains, chains[1:] + chains[:1], strict=True):
            gap = _Gap(following.previous, following.arriving, node, chain.leaving, chain.next)
            if len(chains) == 1:
                gap = self._over_cut(gap, time)
            run = self._join(gap.arriving, gap.leaving, gap.node, time)
            run[0].previous, run[-1].next = gap.previous, gap.next
            for first, second in pairwise(run):
                first.next, second.previous = second, first
            born += run
        for corner in born:
            corner.previous.next = corner
            corner.next.previous = corner
        for corner in born:
            if corner.alive and corner.next.next is corner:
                self._close(corner, time)
        for corner in born:
            if corner.alive:
                self._plan(corner)

    def _over_cut(self, gap: _Gap, time: float) -> _Gap:
        """The gap to join; a moving edge that has come up to a cut in its line takes it along.

        A cut stands where an edge has passed another one, and is no edge of the outline.
        """
        before, after = gap.arriving, gap.leaving
        dot = before.dx * after.dx + before.dy * after.dy
        in_line = abs(before.dx * after.dy - before.dy * after.dx) < _PARALLEL and dot > 0.0
        if not in_line or gap.previous is gap.next or before.speed == after.speed:
            return gap
        if before.is_cut:
            corner = gap.previous
            end = self._place(corner, time)
            self._arc(before.index, gap.node, end)
            self._arc(after.index, end, gap.node)
            gap = _Gap(corner.previous, corner.before, end, after, gap.next)
        elif after.is_cut:
            corner = gap.next
            end = self._place(corner, time)
            self._arc(after.index, end, gap.node)
            self._arc(before.index, gap.node, end)
            gap = _Gap(gap.previous, before, end, corner.after, corner.next)
        else:
            return gap
        self._end(corner, end)
        return gap

    def _close(self, corner: _Corner, time: float) -> None:
        """End a loop of two edges, which coincide."""
        ends = [corner] if corner.next is corner else [corner, corner.next]
        nodes = [self._place(end, time) for end in ends]
        for end, node, other in zip(ends, nodes, nodes[::-1], strict=True):
            self._end(end, node)
            self._arc(end.after.index, other, node)

    def _stop(self, until: float) -> list[list[tuple[int, int]]]:
        """End all corners at their positions, and close the swept areas there."""
        loops = []
        waiting = dict(self._corners)
        while waiting:
            first = next(iter(waiting))
            loop = []
            corner = first
            while corner in waiting:
                del waiting[corner]
                loop.append(corner)
                corner = corner.next
            loops.append(self._stop_loop(loop, until))
        return loops

    def _stop_loop(self, loop: list[_Corner], until: float) -> list[tuple[int, int]]:
        time = until if math.isfinite(until) else max(corner.time for corner in loop)
        positions = [corner.position(time) for corner in loop]
        nodes: list[int] = []
        for i, (x, y) in enumerate(positions):
            px, py = positions[i - 1]
            repeats = i > 0 and abs(x - px) <= TOLERANCE and abs(y - py) <= TOLERANCE
            nodes.append(nodes[-1] if repeats else self._node(x, y, time))
        for i, corner in enumerate(loop):
            self._end(corner, nodes[i])
            self._arc(corner.before.index, nodes[i], nodes[i - 1])
        pairs = zip(nodes, nodes[1:] + nodes[:1], loop, strict=True)
        return [(node, corner.after.index) for node, following, corner in pairs if node != following]

    def _end(self, corner: _Corner, node: int) -> None:
        corner.alive = False
        del self._corners[corner]
        del corner.after.corners[corner]
        self._arc(corner.before.index, corner.node, node)
        self._arc(corner.after.index, node, corner.node)

    def _arc(self, index: int, start: int, end: int) -> None:
        if start != end:
            self.arcs.append((index, start, end))

    def _place(self, corner: _Corner, time: float) -> int:
        """The node where a corner is at a time: that of its birth if it has not moved."""
        x, y = corner.position(time)
        born = self.nodes[corner.node]
        has_moved = abs(x - born[0]) > TOLERANCE or abs(y - born[1]) > TOLERANCE
        return self._node(x, y, time) if has_moved else corner.node

    def _node(self, x: float, y: float, time: float) -> int:
        self.nodes.append((x, y, time))
        return len(self.nodes) - 1


@dataclass(slots=True, eq=False)
class _Edge:
    """A moving line: the points p with ``normal . p == start + speed * time``."""

    index: int
    """Number of the edge whose swept area it bounds."""
    dx: float
    dy: float
    start: float
    speed: float
    is_cut: bool = False
    """Whether it is no edge of the outline but stands where a fast edge has passed a slow one."""
    corners: dict[_Corner, None] = field(default_factory=dict)
    """Live corners at the beginning of pieces of this edge, in order of birth."""

    @property
    def nx(self) -> float:
        return -self.dy

    @property
    def ny(self) -> float:
        return self.dx

    def ahead(self, x: float, y: float, time: float) -> float:
        """Distance that the line must still move to reach a point."""
        return self.dx * y - self.dy * x - self.start - self.speed * time


@dataclass(slots=True, eq=False)
class _Corner:
    """A corner of the wavefront, from its birth at a node until its event."""

    before: _Edge
    after: _Edge
    node: int
    x: float
    y: float
    time: float
    vx: float = 0.0
    vy: float = 0.0
    is_stuck: bool = False
    """Whether its edges coincide, so that it does not move."""
    alive: bool = True
    previous: _Corner = field(init=False)
    next: _Corner = field(init=False)

    def position(self, time: float) -> tuple[float, float]:
        """Position of the corner at a time."""
        passed = time - self.time
        return self.x + self.vx * passed, self.y + self.vy * passed


def _velocity(before: _Edge, after: _Edge) -> tuple[float, float] | None:
    """Motion of the corner between two edges; None if they coincide."""
    cross = before.dx * after.dy - before.dy * after.dx
    dot = before.dx * after.dx + before.dy * after.dy
    if before.speed == after.speed and dot >= 0:
        pace = before.speed / (1.0 + dot)
        return pace * (before.nx + after.nx), pace * (before.ny + after.ny)
    if abs(cross) < _PARALLEL:
        return None if dot < 0 else (before.speed * before.nx, before.speed * before.ny)
    return (
        (before.speed * after.dx - after.speed * before.dx) / cross,
        (before.speed * after.dy - after.speed * before.dy) / cross,
    )


def _reaches(start: _Corner, x: float, y: float, time: float) -> bool:
    """Whether the piece of an edge that leaves a corner contains a place at a time, ends included."""
    edge = start.after
    if abs(edge.ahead(x, y, time)) > TOLERANCE:
        return False
    (x1, y1), (x2, y2) = start.position(time), start.next.position(time)
    before = (x - x1) * edge.dx + (y - y1) * edge.dy
    after = (x2 - x) * edge.dx + (y2 - y) * edge.dy
    return before >= -TOLERANCE and after >= -TOLERANCE


def _just_parted(first: _Corner, second: _Corner, time: float) -> bool:
    """Whether two corners come from the same event, and no time has passed since."""
    return first is not second and first.node == second.node and time <= second.time + TOLERANCE


@dataclass(slots=True)
class _CornerRun:
    """A run of wavefront corners at the place of an event; without corners, a piece of an edge that is hit."""

    previous: _Corner
    arriving: _Edge
    leaving: _Edge
    next: _Corner
    direction: float = 0.0
    """Angle towards the middle of the swept side."""


class _Gap(NamedTuple):
    """A place of the wavefront where two edges are to be joined."""

    previous: _Corner
    arriving: _Edge
    node: int
    leaving: _Edge
    next: _Corner


def _outer_direction(arriving: _Edge, leaving: _Edge) -> float:
    """Angle of the middle of the swept side between an edge that ends at a place and one that begins there."""
    inbound = math.atan2(-arriving.dy, -arriving.dx)
    outbound = math.atan2(leaving.dy, leaving.dx)
    width = (outbound - inbound) % math.tau
    # Coincident edges enclose nothing: everything around them has been swept.
    return math.remainder(inbound + 0.5 * (width if width > _PARALLEL else math.tau), math.tau)
