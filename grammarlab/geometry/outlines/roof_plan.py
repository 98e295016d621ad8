"""Plans of hip and gable roofs: the part of a polygon that slopes towards each edge, and the gables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.geometry.outlines.patches import rings
from grammarlab.geometry.outlines.straight_skeleton import Loop, Sweep, merge, sweep

AUTOMATIC = -1
"""Gable index for gables chosen by the shape of the polygon."""

_FEWEST_WALLS = 4
"""Fewest walls of a polygon with gables that its shape decides."""

_STRAIGHT = 1e-6
"""Sine of the largest angle between edges of one wall."""

_MAX_COSINE = -0.5
"""Largest cosine between the directions of two edges for which the line where their slopes meet is a ridge."""


@dataclass(frozen=True, slots=True)
class Plan:
    """A roof seen from above."""

    xy: Floats
    """[N, 2] nodes in metres, the corners of the polygon first."""
    time: Floats
    """[N] height over the polygon for slopes of 45 degrees, in metres."""
    corner: tuple[int, ...]
    """The corner of the polygon at each of the first nodes."""
    edges: tuple[tuple[int, int], ...]
    """The nodes at both ends of every edge, in the polygon's order, without the bridges of keyholes."""
    faces: tuple[tuple[Loop, ...], ...]
    """Roof over each edge; for a gable its vertical wall, which has no area in the plan. Empty if the roof of an
    earlier edge on the same line goes on over this one."""
    gables: frozenset[int]
    """Numbers of the edges that are gables."""
    bottom: Loop
    """The polygon itself, keyholes included."""

    @property
    def is_convex(self) -> bool:
        """Whether no corner turns to the right."""
        along = _directions(self)
        return len(self.bottom) == len(along) and all(
            _turn(along[i - 1], along[i]) >= -_STRAIGHT for i in range(len(along))
        )


def hip_plan(xy: Floats, even: bool) -> Plan | None:
    """Straight skeleton of a polygon [n, 2]; None if it has no area or its edges cross."""
    plan = _plan(xy, frozenset())
    if plan is None:
        return None
    return _with_whole_slopes(_with_level_ridges(plan) if even else plan)


def gable_plan(xy: Floats, index: int, even: bool) -> Plan | None:
    """The roof of a polygon [n, 2] with gables.

    Args:
        xy: the polygon.
        index: the edge that becomes a gable together with the next but one, for convex polygons; `AUTOMATIC` and
            concave polygons: every edge, shortest first, between two convex corners over which the hip roof is a
            triangle, unless a neighbour is a gable already.
        even: whether the nodes along a ridge share their mean height, `index` being automatic.

    Returns:
        The plan; None if the polygon has no area or its edges cross.
    """
    plan = _plan(xy, frozenset())
    if plan is None:
        return None
    runs = _walls(plan)
    is_indexed = index != AUTOMATIC and plan.is_convex
    chosen = _pair(runs, index % len(plan.edges)) if is_indexed else _wing_ends(plan, runs)
    gables = frozenset(edge for run in chosen for edge in runs[run])
    gabled = _plan(xy, gables) if gables else plan
    if gabled is None or any(not gabled.faces[edge] for edge in gables):
        return _with_whole_slopes(plan)
    return _with_whole_slopes(_with_level_ridges(gabled) if even and index == AUTOMATIC else gabled)


def _plan(xy: Floats, gables: frozenset[int]) -> Plan | None:
    loops = rings(xy)
    corner = [row for ring in loops for row in ring]
    order = np.argsort(corner).tolist()
    speeds = np.ones(len(corner))
    speeds[[order[edge] for edge in gables]] = 0.0
    result = sweep([xy[ring] for ring in loops], speeds.tolist())
    if result is None:
        return None
    node_at = {point: node for node, point in enumerate(map(tuple, xy[corner].tolist()))}
    bottom = tuple(node_at[point] for point in map(tuple, xy.tolist()))
    return Plan(
        xy=result.xy,
        time=result.time,
        corner=tuple(corner),
        edges=_ends(loops, order),
        faces=_faces(result, order, gables),
        gables=gables,
        bottom=bottom,
    )


def _ends(loops: Sequence[Sequence[int]], order: Sequence[int]) -> tuple[tuple[int, int], ...]:
    pairs, first = [], 0
    for ring in loops:
        pairs += [(first + i, first + (i + 1) % len(ring)) for i in range(len(ring))]
        first += len(ring)
    return tuple(pairs[node] for node in order)


def _faces(result: Sweep, order: Sequence[int], gables: frozenset[int]) -> tuple[tuple[Loop, ...], ...]:
    return tuple(
        tuple(loop for loop in result.faces[node] if edge not in gables or result.time[list(loop)].any())
        for edge, node in enumerate(order)
    )


def _directions(plan: Plan) -> Floats:
    """[E, 2] unit vectors along the edges; zero for edges without length."""
    ends = np.array(plan.edges)
    along = plan.xy[ends[:, 1]] - plan.xy[ends[:, 0]]
    length = np.hypot(along[:, 0], along[:, 1])[:, None]
    return np.divide(along, length, out=np.zeros_like(along), where=length > 0.0)


def _turn(a: Floats, b: Floats) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def _walls(plan: Plan) -> list[list[int]]:
    """The edges with a roof grouped into straight walls."""
    along = _directions(plan)
    leaving = {start: edge for edge, (start, _) in enumerate(plan.edges) if plan.faces[edge]}
    straight = {
        edge: leaving[end]
        for edge, (_, end) in enumerate(plan.edges)
        if plan.faces[edge]
        and end in leaving
        and abs(_turn(along[edge], along[leaving[end]])) < _STRAIGHT
        and along[edge] @ along[leaving[end]] > 0.0
    }
    firsts = [edge for edge in leaving.values() if edge not in straight.values()]
    walls = []
    for edge in sorted(firsts):
        wall = [edge]
        while wall[-1] in straight:
            wall.append(straight[wall[-1]])
        walls.append(wall)
    return walls


def _neighbours(plan: Plan, walls: list[list[int]]) -> list[tuple[int, int]]:
    """The walls before and after each wall."""
    begins = {plan.edges[wall[0]][0]: i for i, wall in enumerate(walls)}
    ends = {plan.edges[wall[-1]][1]: i for i, wall in enumerate(walls)}
    return [
        (ends.get(plan.edges[wall[0]][0], i), begins.get(plan.edges[wall[-1]][1], i)) for i, wall in enumerate(walls)
    ]


def _wing_ends(plan: Plan, walls: list[list[int]]) -> list[int]:
    """Walls that become gables automatically; a triangle has none."""
    if len(walls) < _FEWEST_WALLS:
        return []
    around = _neighbours(plan, walls)
    along = _directions(plan)
    size = float(np.ptp(plan.xy, axis=0).max())
    candidates = []
    for i, wall in enumerate(walls):
        before, after = walls[around[i][0]][-1], walls[around[i][1]][0]
        convex = _turn(along[before], along[wall[0]]) > _STRAIGHT and _turn(along[wall[-1]], along[after]) > _STRAIGHT
        if convex and _has_one_tip(plan, wall):
            start, end = plan.edges[wall[0]][0], plan.edges[wall[-1]][1]
            length = round(float(np.hypot(*(plan.xy[end] - plan.xy[start]))) / size, 9)
            # Of equal walls the first one keeps its eave, so that a square's ridge runs along its first edge.
            candidates.append((length, (i - 1) % len(walls), i))
    chosen: list[int] = []
    for _, _, i in sorted(candidates):
        if not set(around[i]) & set(chosen):
            chosen.append(i)
    return chosen


def _has_one_tip(plan: Plan, wall: list[int]) -> bool:
    """Whether the roof over a wall is a triangle."""
    ends = {node for edge in wall for node in plan.edges[edge]}
    inner = [node for edge in wall for loop in plan.faces[edge] for node in loop if node not in ends]
    if not inner:
        return False
    tip = plan.xy[max(inner, key=lambda node: plan.time[node])]
    slack = _STRAIGHT * float(plan.time[inner].max())
    offsets = []
    for end in (plan.edges[wall[0]][0], plan.edges[wall[-1]][1]):
        side = tip - plan.xy[end]
        relative = plan.xy[inner] - plan.xy[end]
        offsets.append(np.abs(side[0] * relative[:, 1] - side[1] * relative[:, 0]) / max(float(np.hypot(*side)), slack))
    return bool((np.minimum(*offsets) <= slack).all())


def _pair(walls: list[list[int]], index: int) -> list[int]:
    """The wall of an edge and the next but one, which is the opposite one of a rectangle."""
    wall_index = next((i for i, wall in enumerate(walls) if index in wall), 0)
    return [wall_index, (wall_index + 2) % len(walls)]


def _with_level_ridges(plan: Plan) -> Plan:
    """The plan with the same height all along each ridge: the mean of its nodes."""
    along = _directions(plan)
    roof_of: dict[tuple[int, int], int] = {}
    for edge, loops in enumerate(plan.faces):
        if edge not in plan.gables:
            roof_of.update({arc: edge for loop in loops for arc in zip(loop, loop[1:] + loop[:1], strict=True)})
    level = list(range(len(plan.xy)))
    for (a, b), edge in roof_of.items():
        other = roof_of.get((b, a))
        above = plan.time[a] > 0.0 and plan.time[b] > 0.0
        if other is not None and above and along[edge] @ along[other] < _MAX_COSINE:
            low, high = sorted((level[a], level[b]))
            level = [low if group == high else group for group in level]
    groups = np.array(level)
    totals, sizes = np.bincount(groups, plan.time), np.bincount(groups)
    return replace(plan, time=totals[groups] / sizes[groups])


def _with_whole_slopes(plan: Plan) -> Plan:
    """The plan with one slope over edges on one line whose slopes meet above a wing between them: at the first edge."""
    along = _directions(plan)
    slack = _STRAIGHT * float(np.ptp(plan.xy, axis=0).max())
    roof_of = {
        arc: edge
        for edge, loops in enumerate(plan.faces)
        if edge not in plan.gables
        for loop in loops
        for arc in zip(loop, loop[1:] + loop[:1], strict=True)
    }
    faces = list(plan.faces)
    first = list(range(len(faces)))
    for (a, b), edge in roof_of.items():
        other = roof_of.get((b, a), edge)
        if edge >= other or set(plan.edges[edge]) & set(plan.edges[other]):
            continue
        apart = plan.xy[plan.edges[other][0]] - plan.xy[plan.edges[edge][0]]
        is_one_line = along[edge] @ along[other] > 0.0 and abs(_turn(along[edge], along[other])) < _STRAIGHT
        low, high = sorted((first[edge], first[other]))
        if low == high or not is_one_line or abs(_turn(along[edge], apart)) > slack:
            continue
        whole = merge([*faces[low], *faces[high]])
        if len(whole) == 1:
            faces[low], faces[high] = (_begun_at(whole[0], plan.edges[low]),), ()
            first = [low if group == high else group for group in first]
    return replace(plan, faces=tuple(faces))


def _begun_at(loop: Loop, edge: tuple[int, int]) -> Loop:
    """A loop that begins with an edge."""
    start = loop.index(edge[0])
    return loop[start:] + loop[:start]
