"""Spatial queries: whether a shape lies inside, overlaps or touches others; distances to, ranks among, labelled ones.

Which shapes they see is stated in `grammarlab.derivation.state.surroundings`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.derivation.calls.calls import Builtin, FunctionCall
from grammarlab.derivation.state.mesh_table import right_handed, upright
from grammarlab.derivation.state.shapes import Shapes, Value, kind_of
from grammarlab.derivation.state.surroundings import Surroundings, world_meshes
from grammarlab.errors import DerivationError
from grammarlab.geometry.meshes.edges import is_closed_surface, joined
from grammarlab.geometry.meshes.measure import areas
from grammarlab.language.syntax.keywords import KEYWORDS

if TYPE_CHECKING:  # imported by the first query, since few grammars have any
    from shapely import STRtree

    from grammarlab.geometry.meshes.contact import Body

_TARGETS = KEYWORDS["target"]
_MOST_PAIRS = 5_000_000
"""Largest number of pairs of shapes that one derivation compares."""
_SAME = 1e-6
"""Difference, in metres or square metres, up to which shapes have the same rank."""

Measure = Callable[[Surroundings, NDArray[np.int64]], Floats]


class _Query(NamedTuple):
    """One shape that asks."""

    row: int
    label: str
    rows: NDArray[np.int64]
    """Rows of the shapes that it may see."""


def _occlusion(compare: Callable[[Body, Body], bool], needs_volume: bool) -> Builtin:
    """``overlaps(target, label)`` and similar: whether the relation holds to a closed shape that is no relative.

    Args:
        compare: the relation of a body to a closed one.
        needs_volume: whether a closed body must have a volume in common with the other.
    """

    def evaluate(call: FunctionCall) -> Value:
        surroundings = call.workspace.surroundings
        if surroundings is None:
            return False
        from grammarlab.geometry.meshes.contact import CONTACT, Body  # noqa: PLC0415

        shapes, result = _settled(call), np.zeros(call.shapes.num, dtype=bool)
        origins, frames = call.workspace.origins, call.workspace.frames
        meshes = world_meshes(shapes, origins, call.workspace.meshes, frames)
        low, high = meshes.bounds()
        lineage = call.workspace.recorder.lineage
        others_low, others_high = surroundings.bounds
        is_solid = is_closed_surface(joined(meshes)) & needs_volume
        near = _Nearby(others_low, others_high, surroundings.is_closed, CONTACT)
        for query in _queries(call, surroundings, is_near=True):
            rows = near.rows(query.rows, low[query.row], high[query.row])
            if is_solid[query.row]:
                common = np.minimum(high[query.row], others_high[rows]) - np.maximum(low[query.row], others_low[rows])
                rows = rows[(common > CONTACT).all(axis=1)]
            if len(rows) and lineage is not None:
                node = call.shapes.node[query.row]
                rows = rows[surroundings.unrelated(rows, int(lineage.nearest[node]), bool(lineage.is_same[node]))]
            if len(rows) == 0 or meshes.mesh_faces[query.row] == meshes.mesh_faces[query.row + 1]:
                continue
            _count_pairs(call, len(rows))
            body = Body(meshes.take(np.array([query.row])))
            result[query.row] = any(compare(body, surroundings.body(row)) for row in rows.tolist())
        return result

    return Builtin(evaluate, (0, 2), keywords=_TARGETS)


class _Nearby:
    """Closed shapes whose bounding boxes meet another one."""

    def __init__(self, low: Floats, high: Floats, is_closed: NDArray[np.bool_], reach: float) -> None:
        self._low, self._high, self._is_closed, self._reach = low, high, is_closed, reach
        self._trees: dict[int, tuple[STRtree, NDArray[np.int64]]] = {}

    def rows(self, visible: NDArray[np.int64], low: Floats, high: Floats) -> NDArray[np.int64]:
        """Those of the visible rows whose boxes meet the box from ``low`` to ``high``, ascending."""
        from shapely import STRtree, box  # noqa: PLC0415

        # Many shapes ask about the same rows, which are then the same array.
        if id(visible) not in self._trees:
            closed = visible[self._is_closed[visible]]
            boxes = box(*self._low[closed][:, [0, 2]].T, *self._high[closed][:, [0, 2]].T)
            self._trees[id(visible)] = STRtree(boxes), closed
        tree, closed = self._trees[id(visible)]
        reach = self._reach
        meets = tree.query(box(low[0] - reach, low[2] - reach, high[0] + reach, high[2] + reach))
        rows = np.sort(closed[meets])
        gap = np.maximum(low - self._high[rows], self._low[rows] - high)
        return rows[(gap <= reach).all(axis=1)]


def _minimum_distance(call: FunctionCall) -> Value:
    """``minimumDistance(target, label)``: metres between the scopes; infinite without a labelled shape."""
    surroundings, shapes = call.workspace.surroundings, _settled(call)
    result = np.full(shapes.num, np.inf)
    if surroundings is None:
        return result
    from grammarlab.geometry.meshes.contact import distances_to_boxes  # noqa: PLC0415

    position = shapes.position + call.workspace.origins[shapes.model]
    axes = call.workspace.frames.rotations(shapes.frame)
    for query in _labelled(call, surroundings):
        rows = query.rows
        _count_pairs(call, len(rows))
        box = (position[query.row], shapes.size[query.row], axes[query.row])
        others = (surroundings.position[rows], surroundings.size[rows], surroundings.axes[rows])
        result[query.row] = distances_to_boxes(box, others).min(initial=np.inf)
    return result


def _count(call: FunctionCall) -> Value:
    """``contextCount(target, label)``: the number of shapes with the label."""
    surroundings, result = call.workspace.surroundings, np.zeros(call.shapes.num)
    for query in () if surroundings is None else _labelled(call, surroundings):
        result[query.row] = len(query.rows)
    return result


def _compare(call: FunctionCall) -> Value:
    """``contextCompare(target, label, world.highest)``: the number of labelled shapes that rank before this one."""
    surroundings, result = call.workspace.surroundings, np.zeros(call.shapes.num)
    if surroundings is None:
        return result
    word = str(call.arguments[2])
    shapes = _settled(call)
    meshes = world_meshes(shapes, call.workspace.origins, call.workspace.meshes, call.workspace.frames)
    ranks = _ranks(word, *meshes.bounds(), areas(meshes))
    others = _ranks(word, *surroundings.bounds, surroundings.area)
    for query in _labelled(call, surroundings):
        result[query.row] = (others[query.rows] < ranks[query.row] - _SAME).sum()
    return result


_BOUNDS = {
    "world.northernmost": (2, "low"),
    "world.southernmost": (2, "high"),
    "world.westernmost": (0, "low"),
    "world.easternmost": (0, "high"),
    "world.lowest": (1, "low"),
    "world.highest": (1, "high"),
}
"""Axis and end of the bounding box that shapes are ranked by; from the highest value for ``high``."""


def _ranks(word: str, low: Floats, high: Floats, area: Floats) -> Floats:
    """Values of shapes [N] that are the smaller the better they rank."""
    if word.startswith("area."):
        return area if word == "area.smallest" else -area
    axis, end = _BOUNDS[word]
    return low[:, axis] if end == "low" else -high[:, axis]


def _settled(call: FunctionCall) -> Shapes:
    """The shapes in right-handed scopes of positive height."""
    meshes, frames = call.workspace.meshes, call.workspace.frames
    return right_handed(upright(call.shapes, meshes, frames), meshes, frames)


def _labelled(call: FunctionCall, surroundings: Surroundings) -> Iterator[_Query]:
    """Queries to labelled shapes; an empty label names none."""
    return (query for query in _queries(call, surroundings, is_near=False) if query.label)


def _queries(call: FunctionCall, surroundings: Surroundings, is_near: bool) -> Iterator[_Query]:
    """The shapes one by one, with the shapes that they may see."""
    target = str(call.arguments[0]) if call.arguments else "all"
    if target not in _TARGETS:
        raise DerivationError(f"{call.name} expects intra, inter or all first, found {target}", call.location)
    labels = call.arguments[1] if len(call.arguments) > 1 else ""
    if kind_of(labels) != "string":
        raise DerivationError(f"{call.name} expects a label, found a {kind_of(labels)}", call.location)
    visible: dict[tuple[int, str], NDArray[np.int64]] = {}
    for row, model in enumerate(call.shapes.model.tolist()):
        label = call.workspace.strings[int(labels[row])] if isinstance(labels, np.ndarray) else str(labels)
        if (model, label) not in visible:
            rows = surroundings.rows(model, target, is_near)
            if label:
                rows = np.intersect1d(rows, surroundings.labelled.get(label, rows[:0]), assume_unique=True)
            visible[model, label] = rows
        yield _Query(row, label, visible[model, label])


def _count_pairs(call: FunctionCall, count: int) -> None:
    call.workspace.compared_pairs += count
    if call.workspace.compared_pairs > _MOST_PAIRS:
        message = f"{call.name} would compare more than {_MOST_PAIRS:,} pairs of shapes"
        raise DerivationError(message, call.location, "query labelled shapes, or derive fewer models at once")


BUILTINS: dict[str, Builtin] = {
    "contextCompare": Builtin(_compare, (3, 3), keywords=_TARGETS | KEYWORDS["comparison"]),
    "contextCount": Builtin(_count, (2, 2), keywords=_TARGETS),
    "inside": _occlusion(lambda body, other: body.is_inside(other), needs_volume=True),
    "minimumDistance": Builtin(_minimum_distance, (2, 2), keywords=_TARGETS),
    "overlaps": _occlusion(lambda body, other: body.overlaps(other), needs_volume=True),
    "touches": _occlusion(lambda body, other: body.touches(other), needs_volume=False),
}
