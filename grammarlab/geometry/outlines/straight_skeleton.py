"""Weighted straight skeleton of any simple polygon, with or without holes: the plan of a roof.

`sweep` moves every edge inwards at its own speed and returns the area swept by each: with unit speeds and no time
limit these are the faces of the straight skeleton, and the time of a node is its height over the polygon under slopes
of 45 degrees. With a time limit they are the border of an offset; an edge with speed 0 does not move (a gable, or
an edge that is not set back).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely

from grammarlab.arrays import Floats
from grammarlab.geometry.outlines.wavefront import TOLERANCE, Wavefront

Loop = tuple[int, ...]
"""Node indices around an area, counter-clockwise around solid ground, clockwise around a hole."""

_MAX_AREA_ERROR = 1e-6
"""Largest error of the sum of swept and remaining areas, as a share of the area, before a sweep counts as failed."""

_JITTER = 1e-7
"""Displacement of corners after a failed sweep, as a share of the size."""


@dataclass(frozen=True, slots=True)
class Sweep:
    """Subdivision of a polygon into the areas swept by its edges."""

    xy: Floats
    """[N, 2] nodes in metres; the corners of the polygon come first, loop after loop."""
    time: Floats
    """[N] time at which the wavefront reached each node; 0 for the corners."""
    faces: tuple[tuple[Loop, ...], ...]
    """Area swept by each edge, beginning with the edge; empty if it swept nothing or has length 0."""
    rest: tuple[Loop, ...]
    """Area not swept before the time limit."""
    rest_edges: tuple[tuple[int, ...], ...]
    """Edge that leaves each node, for each loop of `rest`."""

    def rest_from_first_edge(self, order: Sequence[int]) -> list[Loop]:
        """The loops of `rest`, each beginning at a piece of the first edge that it has, by their ranks [E]."""
        loops = []
        for loop, edges in zip(self.rest, self.rest_edges, strict=True):
            first = min(range(len(loop)), key=lambda i: order[edges[i]])
            loops.append(loop[first:] + loop[:first])
        return loops


def sweep(
    loops: Sequence[Floats], speeds: Sequence[float], until: float = math.inf, bisector_cuts: bool = False
) -> Sweep | None:
    """Move the edges of a polygon inwards.

    Args:
        loops: outlines [n, 2] in metres with the inside to the left: counter-clockwise outline, clockwise holes; a
            clockwise outline alone is swept outwards and needs a time limit.
        speeds: speed of the edge that leaves each corner, loop after loop, metres per unit of time, 0 or more.
        until: time to stop; infinite until everything is swept.
        bisector_cuts: whether cuts are along bisectors, see `Wavefront`.

    Returns:
        The subdivision, or None if the loops do not bound a simple polygon.
    """
    if not loops or min(map(len, loops)) < 3:
        return None
    points = np.concatenate(loops)
    if not np.isfinite(points).all():
        return None
    low, high = points.min(axis=0), points.max(axis=0)
    size = float((high - low).max())
    if size <= 0.0 or not math.isfinite(size):
        return None
    if not shapely.Polygon(loops[0], list(loops[1:])).is_valid:
        return None
    # A power of two loses no digits.
    scale = 2.0 ** math.frexp(size)[1]
    fastest = max(speeds, default=0.0)
    if fastest <= 0.0:
        return _standstill(loops, points)
    unit_speeds = [speed / fastest for speed in speeds]
    limit = until * fastest / scale
    unit = (points - low) / scale
    for shake in (0.0, _JITTER, 10 * _JITTER):
        result = _attempt(unit + shake * _jitter(len(unit)), loops, unit_speeds, limit, bisector_cuts)
        if result is not None:
            xy = result.xy * scale + low
            xy[: len(points)] = points
            return replace(result, xy=xy, time=result.time * (scale / fastest))
    return None


def merge(faces: Sequence[Loop]) -> list[Loop]:
    """The outlines of areas that share edges: an outline of their union, and one around each hole."""
    arcs = [(a, b) for face in faces for a, b in zip(face, face[1:] + face[:1], strict=True)]
    return trace(arcs)


def trace(arcs: Sequence[tuple[int, int]]) -> list[Loop]:
    """The closed loops that directed arcs form, after arcs that run both ways have cancelled."""
    remaining: dict[tuple[int, int], int] = {}
    for a, b in arcs:
        if remaining.get((b, a), 0):
            remaining[b, a] -= 1
        else:
            remaining[a, b] = remaining.get((a, b), 0) + 1
    following: dict[int, list[int]] = {}
    for (a, b), times in remaining.items():
        following.setdefault(a, []).extend([b] * times)
    loops: list[Loop] = []
    for start, targets in following.items():
        while targets:
            loops += _walk(start, following)
    return loops


def _walk(start: int, following: dict[int, list[int]]) -> list[Loop]:
    """The loops on one closed walk from a node; a loop is set aside whenever the walk meets itself."""
    path, loops = [start], []
    position = {start: 0}
    while following.get(path[-1]):
        node = following[path[-1]].pop(0)
        first = position.get(node)
        if first is None:
            position[node] = len(path)
            path.append(node)
            continue
        loop = tuple(path[first:])
        for passed in loop[1:]:
            del position[passed]
        del path[first + 1 :]
        if len(loop) > 2:
            loops.append(loop)
        if first == 0:
            break
    return loops


def _attempt(
    unit: Floats, loops: Sequence[Floats], speeds: Sequence[float], limit: float, bisector_cuts: bool
) -> Sweep | None:
    """A sweep of a polygon of unit size, or None if the swept areas do not fit together."""
    front = Wavefront(bisector_cuts)
    first = 0
    numbers: list[int] = []
    for loop in loops:
        rows = _without_repeats(unit, range(first, first + len(loop)))
        first += len(loop)
        if len(rows) < 3:
            return None
        front.add_loop([(float(x), float(y)) for x, y in unit[rows]], [speeds[row] for row in rows], rows)
        numbers += rows
    num_kept = len(numbers)
    rest = front.run(limit)
    new_nodes = range(len(unit), len(unit) + len(front.nodes) - num_kept)
    numbers += new_nodes
    nodes = np.zeros((len(unit) + len(new_nodes), 3))
    nodes[: len(unit), :2] = unit
    nodes[numbers] = front.nodes
    by_edge: list[list[tuple[int, int]]] = [[] for _ in unit]
    for index, a, b in front.arcs:
        by_edge[index].append((numbers[a], numbers[b]))
    faces = tuple(_faces_of(arcs) for arcs in by_edge)
    areas = [(tuple(numbers[node] for node, _ in loop), tuple(edge for _, edge in loop)) for loop in rest]
    solid = [pair for pair in areas if _has_area(nodes, pair[0])]
    remaining = tuple(loop for loop, _ in solid), tuple(edges for _, edges in solid)
    result = Sweep(nodes[:, :2], nodes[:, 2], faces, *remaining)
    if limit == math.inf:
        # At equal speeds every edge keeps its area in one piece.
        torn = min(speeds) == max(speeds) and any(len(faces[edge]) != 1 for edge in numbers[:num_kept])
        if result.rest or torn:
            return None
    return result if _is_subdivision(result, loops, numbers[:num_kept]) else None


def _faces_of(arcs: Sequence[tuple[int, int]]) -> tuple[Loop, ...]:
    """The area behind an edge, whose own arc comes first."""
    if not arcs:
        return ()
    start, end = arcs[0]
    loops = trace(arcs)
    for i, loop in enumerate(loops):
        if start in loop and loop[(loop.index(start) + 1) % len(loop)] == end:
            first = loop.index(start)
            return (loop[first:] + loop[:first], *loops[:i], *loops[i + 1 :])
    return tuple(loops)


def _without_repeats(unit: Floats, rows: range) -> list[int]:
    """Corners of a loop without corners that coincide with the next one."""
    points = unit[rows.start : rows.stop].tolist()
    selected: list[int] = []
    for i in reversed(range(len(rows))):
        after = selected[-1] if selected else 0
        near = all(abs(a - b) <= 10 * TOLERANCE for a, b in zip(points[i], points[after], strict=True))
        if i == after or not near:
            selected.append(i)
    return [rows[i] for i in reversed(selected)]


def _is_subdivision(result: Sweep, loops: Sequence[Floats], corners: Sequence[int]) -> bool:
    """Whether swept and remaining areas are all positive and add up to the polygon."""
    whole, first = 0.0, 0
    corner_set = set(corners)
    for loop in loops:
        whole += loop_area(result.xy, [row for row in range(first, first + len(loop)) if row in corner_set])
        first += len(loop)
    swept = [loop_area(result.xy, loop) for faces in result.faces for loop in faces]
    remaining = [loop_area(result.xy, loop) for loop in result.rest]
    size = max(abs(whole), 1e-9)
    missing = abs(whole - sum(swept) - sum(remaining))
    return (
        missing <= _MAX_AREA_ERROR * max(size, sum(swept))
        and min(swept, default=0.0) >= -_MAX_AREA_ERROR * size
        and whole != 0.0
    )


def loop_area(xy: Floats, loop: Sequence[int]) -> float:
    """Signed area within a loop of nodes, positive where it runs counter-clockwise."""
    points = xy[list(loop)].tolist()
    x0, y0 = points[0]
    twice, px, py = 0.0, 0.0, 0.0
    for x, y in points[1:]:
        dx, dy = x - x0, y - y0
        twice += px * dy - dx * py
        px, py = dx, dy
    return 0.5 * twice


def _has_area(nodes: Floats, loop: Loop) -> bool:
    return len(loop) > 2 and abs(loop_area(nodes[:, :2], loop)) > TOLERANCE


def _standstill(loops: Sequence[Floats], points: Floats) -> Sweep:
    """The sweep of a polygon none of whose edges moves."""
    ends = np.cumsum([len(loop) for loop in loops]).tolist()
    rest = tuple(tuple(range(end - len(loop), end)) for loop, end in zip(loops, ends, strict=True))
    return Sweep(points, np.zeros(len(points)), tuple(() for _ in points), rest, rest)


def _jitter(num_points: int) -> Floats:
    """Fixed, evenly spread displacements [N, 2] below one (multiples of the golden and silver ratios)."""
    steps = np.arange(1, num_points + 1)[:, None] * np.array([0.6180339887498949, 0.4142135623730951])
    return np.mod(2.0 * steps, 2.0) - 1.0
