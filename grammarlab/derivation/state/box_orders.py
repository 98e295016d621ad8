"""Orders of the faces of boxes.

Operations number the faces of a shape, and ``comp`` gives each face the frame of its first edge. A cube and an extruded
rectangle differ in them, and a split changes them: the face that closes a cut comes last, or first if the first face
was cut away. So a box is the whole scope with one of many orders of faces. `BOX` is the cube as it is inserted; other
orders have the ids -1, -2, and so on, and no mesh of their own until a shape needs one.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats
from grammarlab.derivation.frames import CUBE, cube_indices
from grammarlab.derivation.state.shapes import BOX, EMPTY, Ids
from grammarlab.geometry.meshes.extrude import extrude
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.primitives import box, quad

Corner = tuple[int, int, int]
Order = tuple[tuple[Corner, ...], ...]
"""Six faces of the unit cube, each with its corners from the first one on, counter-clockwise seen from outside."""

PRISM, SUNK_PRISM = -1, -2
"""Ids of a rectangle that was extruded along its normal, and of one that was extruded the opposite way."""


class BoxOrders:
    """Orders of one derivation, by number: 0 is that of `BOX`, n that of the id -n."""

    def __init__(self) -> None:
        self._orders: list[Order] = []
        self._numbers: dict[Order, int] = {}
        self._cuts: dict[tuple[int, int, bool, bool], int] = {}
        for order in _predefined():
            self._number(order)

    @property
    def cubes(self) -> Ids:
        """[B, 6] rotation of each face's frame in the axes of the box, an index of `frames.CUBE`."""
        return self._stacked()[0]

    @property
    def origins(self) -> Floats:
        """[B, 6, 3] first corner of each face in the unit cube."""
        return self._stacked()[1]

    def mesh(self, number: int) -> Meshes:
        """The unit cube with its faces in an order."""
        return _mesh(self._orders[number])

    def cut(self, ids: Ids, axis: int, low: Flags, high: Flags) -> Ids:
        """Ids [N] of parts of shapes; those of boxes get the order that the cut leaves, others stay.

        Args:
            ids: [N] meshes of the whole shapes.
            axis: the axis that the cuts are across.
            low: [N] whether a part is cut off at its beginning.
            high: [N] whether a part is cut off at its end.
        """
        rows = np.flatnonzero(is_box(ids) & (low | high))
        if len(rows) == 0:
            return ids
        code = np.maximum(-ids[rows], 0) * 4 + low[rows] * 2 + high[rows]
        different, inverse = (code[:1], np.zeros(len(rows), np.int64)) if (code == code[0]).all() else _unique(code)
        after = [-self._cut(value // 4, axis, bool(value & 2), bool(value & 1)) for value in different.tolist()]
        result = ids.copy()
        result[rows] = np.array([number or BOX for number in after], dtype=np.int32)[inverse]
        return result

    def turned(self, ids: Ids, cubes: Ids) -> Ids:
        """Ids [N] of the same boxes in scopes rotated by [N] rotations of the cube, indices of `frames.CUBE`."""
        code = np.maximum(-ids, 0).astype(np.int64) * len(CUBE) + cubes
        different, inverse = _unique(code)
        numbers = [self._number(_seen_from(self._orders[c // len(CUBE)], c % len(CUBE))) for c in different.tolist()]
        return np.array([-number or BOX for number in numbers], dtype=np.int32)[inverse]

    def _cut(self, number: int, axis: int, low: bool, high: bool) -> int:
        key = number, axis, low, high
        if key not in self._cuts:
            self._cuts[key] = self._number(_after_cut(self._orders[number], axis, low, high))
        return self._cuts[key]

    def _number(self, order: Order) -> int:
        number = self._numbers.setdefault(order, len(self._orders))
        if number == len(self._orders):
            self._orders.append(order)
        return number

    def _stacked(self) -> tuple[Ids, Floats]:
        return _stacked(tuple(self._orders))


def is_box(ids: Ids) -> Flags:
    """[N] whether meshes are the whole box of their scope, with any order of faces."""
    return (ids <= BOX) & (ids != EMPTY)


def kinds(ids: Ids) -> Ids:
    """Ids [N] in which boxes of every order are `BOX`."""
    return np.where(ids < 0, np.int32(BOX), ids)


def _unique(code: NDArray[np.integer]) -> tuple[NDArray[np.integer], NDArray[np.int64]]:
    different, inverse = np.unique(code, return_inverse=True)
    return different, inverse.ravel()


@cache
def _predefined() -> tuple[Order, Order, Order]:
    """The orders of `BOX`, `PRISM` and `SUNK_PRISM`."""
    sunk = extrude(quad(), -np.ones(1))
    raised = sunk.with_points(sunk.points + np.array([0.0, 1.0, 0.0]))
    return _order(box()), _order(extrude(quad(), np.ones(1))), _order(raised)


def _order(mesh: Meshes) -> Order:
    corners = _corners(mesh.points[mesh.corners])
    return tuple(corners[4 * face : 4 * face + 4] for face in range(6))


def _corners(points: Floats) -> tuple[Corner, ...]:
    return tuple((int(x), int(y), int(z)) for x, y, z in np.rint(points))


@cache
def _after_cut(order: Order, axis: int, low: bool, high: bool) -> Order:
    """The order of a part: first the beginning is cut off, then the end, as a split does."""
    for side in [0] * low + [1] * high:
        order = _closed(order, axis, side)
    return order


def _closed(order: Order, axis: int, side: int) -> Order:
    """The order after the face on one side of the box is replaced by one that closes a cut."""
    lost = next(i for i, face in enumerate(order) if all(corner[axis] == side for corner in face))
    others = order[:lost] + order[lost + 1 :]
    edges = ((face[i], face[(i + 1) % 4]) for face in others for i in range(4))
    # It begins with the edge that it shares with the first face that was cut.
    _, begin = next(edge for edge in edges if edge[0][axis] == edge[1][axis] == side)
    first = order[lost].index(begin)
    closing = order[lost][first:] + order[lost][:first]
    return (closing, *others) if lost == 0 else (*others, closing)


@cache
def _seen_from(order: Order, cube: int) -> Order:
    """The order in the axes of a scope that is rotated by a rotation of the cube."""
    rotation = np.rint(CUBE[cube]).astype(np.int64)
    corners = (2 * np.array(order) - 1) @ rotation
    return tuple(_corners(face) for face in (corners + 1) // 2)


@cache
def _mesh(order: Order) -> Meshes:
    prism = extrude(quad(), np.ones(1))
    number = {corner: i for i, corner in enumerate(_corners(prism.points))}
    return Meshes.single(prism.points, [[number[corner] for corner in face] for face in order])


@cache
def _frames(order: Order) -> tuple[Ids, Floats]:
    """Rotations [6], indices of `frames.CUBE`, and first corners [6, 3] of the faces of an order."""
    corners = np.array(order, dtype=np.float64)
    x = corners[:, 1] - corners[:, 0]
    y = corners[:, 3] - corners[:, 0]
    return cube_indices(np.stack((x, y, np.cross(x, y)), axis=2)), corners[:, 0]


@cache
def _stacked(orders: tuple[Order, ...]) -> tuple[Ids, Floats]:
    cubes, origins = zip(*(_frames(order) for order in orders), strict=True)
    return np.stack(cubes), np.stack(origins)
