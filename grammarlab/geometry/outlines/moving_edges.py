"""Moving edges and corners of a wavefront, and relations between them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

TOLERANCE = 1e-9
"""Largest distance of corners that count as met, in a polygon of about unit size."""

PARALLEL = 1e-9
"""Largest cross product of the directions of parallel edges."""


@dataclass(slots=True, eq=False)
class Edge:
    """A moving line: the points p with ``normal . p == start + speed * time``."""

    index: int
    """Number of the edge whose swept area it bounds."""
    dx: float
    dy: float
    start: float
    speed: float
    corners: dict[Corner, None] = field(default_factory=dict)
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
class Corner:
    """A corner of the wavefront, from its birth at a node until its event."""

    before: Edge
    after: Edge
    node: int
    x: float
    y: float
    time: float
    vx: float = 0.0
    vy: float = 0.0
    is_stuck: bool = False
    """Whether its edges coincide, so that it does not move."""
    alive: bool = True
    previous: Corner = field(init=False)
    next: Corner = field(init=False)

    def at(self, time: float) -> tuple[float, float]:
        """Position of the corner at a time."""
        passed = time - self.time
        return self.x + self.vx * passed, self.y + self.vy * passed


def velocity(before: Edge, after: Edge) -> tuple[float, float] | None:
    """Motion of the corner between two edges; None if they coincide."""
    cross = before.dx * after.dy - before.dy * after.dx
    dot = before.dx * after.dx + before.dy * after.dy
    if before.speed == after.speed and dot >= 0:
        pace = before.speed / (1.0 + dot)
        return pace * (before.nx + after.nx), pace * (before.ny + after.ny)
    if abs(cross) < PARALLEL:
        return None if dot < 0 else (before.speed * before.nx, before.speed * before.ny)
    return (
        (before.speed * after.dx - after.speed * before.dx) / cross,
        (before.speed * after.dy - after.speed * before.dy) / cross,
    )


def just_parted(first: Corner, second: Corner, time: float) -> bool:
    """Whether two corners come from the same event, and no time has passed since."""
    return first is not second and first.node == second.node and time <= second.time + TOLERANCE


def reaches(start: Corner, x: float, y: float, time: float) -> bool:
    """Whether the piece of an edge that leaves a corner contains a place at a time, ends included."""
    edge = start.after
    if abs(edge.ahead(x, y, time)) > TOLERANCE:
        return False
    (x1, y1), (x2, y2) = start.at(time), start.next.at(time)
    before = (x - x1) * edge.dx + (y - y1) * edge.dy
    after = (x2 - x) * edge.dx + (y2 - y) * edge.dy
    return before >= -TOLERANCE and after >= -TOLERANCE


def outer_direction(arriving: Edge, leaving: Edge) -> float:
    """Angle of the middle of the swept side between an edge that ends at a place and one that begins there."""
    inbound = math.atan2(-arriving.dy, -arriving.dx)
    outbound = math.atan2(leaving.dy, leaving.dx)
    width = (outbound - inbound) % math.tau
    # Coincident edges enclose nothing: everything around them has been swept.
    return math.remainder(inbound + 0.5 * (width if width > PARALLEL else math.tau), math.tau)
