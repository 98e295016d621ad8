"""The faces of a roof made from its plan: underside, slopes and gables, and overhangs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.geometry.meshes.mesh import Indices
from grammarlab.geometry.outlines.roof_plan import Plan
from grammarlab.geometry.outlines.straight_skeleton import Loop, sweep

_PARALLEL = 1e-9
"""Largest cross product of the normals of edges that count as parallel."""

_MARGIN = 0.999
"""Largest overhang, as a share of the overhang at which slopes meet."""


@dataclass(frozen=True, slots=True)
class Sheet:
    """A roof over a plan. Its nodes are those of the plan, then the border nodes pushed out by overhangs.

    A node is at ``xy[source] + eave * push_eave + gable * push_gable`` and, for slopes of 45 degrees, at the height
    ``time[source] + eave * rise_eave + gable * rise_gable``, where eave and gable are overhangs in the plan.
    """

    source: Indices
    """[S] node of the plan that each node comes from."""
    push: Floats
    """[S, 2, 2] displacement in the plan per metre of overhang, at eaves and at gables."""
    rise: Floats
    """[S, 2] change of height per metre of overhang, at eaves and at gables."""
    faces: tuple[Loop, ...]
    """The underside, then slopes and gables in the order of the edges."""


@dataclass(frozen=True, slots=True)
class _Border:
    """A piece of the border of the slopes."""

    end: int
    edge: int
    """The edge that it is over: its eave or its gable."""
    roof: int
    """The edge whose slope it bounds."""


def build(plan: Plan, has_eaves: bool, has_verges: bool) -> Sheet:
    """The faces over a plan.

    Args:
        plan: the plan.
        has_eaves: whether slopes hang over at the bottom, or begin above it.
        has_verges: whether slopes hang over gables, or end before them.
    """
    borders = _borders(plan)
    arriving = {border.end: start for start, border in borders.items()}
    moves = {edge: has_verges if edge in plan.gables else has_eaves for edge in range(len(plan.edges))}
    pushed = {
        node: len(plan.xy) + i
        for i, node in enumerate(
            node for node, border in borders.items() if moves[border.edge] or moves[borders[arriving[node]].edge]
        )
    }
    faces: list[Loop] = []
    faces.append((plan.bottom[1], plan.bottom[0], *plan.bottom[:1:-1]))
    for edge, loops in enumerate(plan.faces):
        faces += loops if edge in plan.gables else [_pushed_out(loop, borders, moves, pushed) for loop in loops]
    push = np.zeros((len(plan.xy) + len(pushed), 2, 2))
    rise = np.zeros((len(push), 2))
    for node, index in pushed.items():
        push[index] = _push(plan, borders[arriving[node]], borders[node])
        normal = _inward(plan, borders[node].roof)
        rise[index] = push[index] @ normal
    source = np.concatenate([np.arange(len(plan.xy)), np.array(list(pushed), np.int64)])
    return Sheet(source, push, rise, tuple(faces))


def _borders(plan: Plan) -> dict[int, _Border]:
    """The border of the slopes: for each node on it the piece that leaves it."""
    roof_of, gable_of = {}, {}
    for edge, loops in enumerate(plan.faces):
        arcs = {arc: edge for loop in loops for arc in zip(loop, loop[1:] + loop[:1], strict=True)}
        (gable_of if edge in plan.gables else roof_of).update(arcs)
    return {
        a: _Border(b, gable_of.get((b, a), edge), edge) for (a, b), edge in roof_of.items() if (b, a) not in roof_of
    }


def _pushed_out(loop: Loop, borders: dict[int, _Border], moves: dict[int, bool], pushed: dict[int, int]) -> Loop:
    """A slope extended to the overhangs; pieces of its border that do not move are kept."""
    result = []
    for node, following in zip(loop, loop[1:] + loop[:1], strict=True):
        result.append(pushed.get(node, node))
        border = borders.get(node)
        if border is not None and border.end == following and not moves[border.edge]:
            result += [end for end in (node, following) if end in pushed]
    return tuple(result)


def _inward(plan: Plan, edge: int) -> Floats:
    """[2] the unit normal of an edge that points into the polygon."""
    start, end = plan.edges[edge]
    x, y = plan.xy[end] - plan.xy[start]
    return np.array([-y, x]) / np.hypot(x, y)


def _push(plan: Plan, before: _Border, after: _Border) -> Floats:
    """[2, 2] displacement of a border node per metre of overhang, at eaves and at gables."""
    first, second = _inward(plan, before.edge), _inward(plan, after.edge)
    displacement = np.zeros((2, 2))
    displacement[int(before.edge in plan.gables), 0] = -1.0
    displacement[int(after.edge in plan.gables), 1] = -1.0
    if before.edge == after.edge:
        # The tip of a gable follows the ridge between the two slopes that meet there.
        second = _inward(plan, before.roof) - _inward(plan, after.roof)
        displacement[:, 1] = 0.0
    cross = float(first[0] * second[1] - first[1] * second[0])
    if abs(cross) <= _PARALLEL:
        return displacement[:, :1] * first
    return (
        np.stack(
            [
                displacement[:, 0] * second[1] - displacement[:, 1] * first[1],
                displacement[:, 1] * first[0] - displacement[:, 0] * second[0],
            ],
            axis=1,
        )
        / cross
    )


def free_overhang(plan: Plan, eave: float, verge: float) -> float:
    """The share, 0..1, of overhangs (in the plan, in metres) up to which slopes do not intersect."""
    if eave <= 0.0 and verge <= 0.0:
        return 1.0
    preceding = {end: (start, edge) for edge, (start, end) in enumerate(plan.edges)}
    share = 1.0
    while preceding:
        node = next(iter(preceding))
        ring, speeds = [], []
        while node in preceding:
            before, edge = preceding.pop(node)
            ring.append(node)
            speeds.append(verge if edge in plan.gables else eave)
            node = before
        result = sweep([plan.xy[ring]], speeds, 1.0)
        if result is None:
            return 0.0
        event_times = result.time[(result.time > 0.0) & (result.time < 1.0 - _PARALLEL)]
        share = min(share, _MARGIN * float(event_times.min(initial=1.0 / _MARGIN)))
    return share
