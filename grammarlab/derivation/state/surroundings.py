"""Shapes that spatial queries compare with: closed leaves, shapes divided by ``comp`` or ``offset``, labelled shapes.

A grammar with such queries is derived twice, as in CityEngine. In the first derivation every query has its default
value; the queries of the second one see the shapes of the first.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.derivation.frames import FrameTable
from grammarlab.derivation.state.lineage import Lineage, Tree, intervals
from grammarlab.derivation.state.mesh_table import MeshTable, right_handed, scaled, upright
from grammarlab.derivation.state.shapes import EMPTY, Ids, Shapes
from grammarlab.geometry.meshes.edges import is_closed_surface, joined
from grammarlab.geometry.meshes.measure import areas
from grammarlab.geometry.meshes.mesh import Meshes

if TYPE_CHECKING:  # imported by the first query, since few grammars have any
    from grammarlab.geometry.meshes.contact import Body

_NEIGHBOURHOOD = 1.0
"""Metres around the bounding box of an initial shape in which other initial shapes are its neighbours."""


@dataclass(slots=True)
class Collector:
    """Shapes of a first derivation, as they are made."""

    lineage: Lineage = field(default_factory=Lineage)
    chunks: list[tuple[Shapes, str]] = field(default_factory=list)
    """Shapes and their label, empty for those without one."""

    def add(self, shapes: Shapes, label: str = "") -> None:
        """Collect shapes."""
        if shapes.num:
            self.chunks.append((shapes, label))


@dataclass(frozen=True)
class Surroundings:
    """The K collected shapes of a first derivation, in the world."""

    tree: Tree
    """Nodes of the first derivation."""
    node: Ids
    """[K] node of each shape."""
    model: Ids
    """[K] model of each shape; ascending."""
    labels: tuple[str, ...]
    """[K] labels; empty for shapes without one."""
    position: Floats
    """[K, 3] origins of their scopes, metres in the world."""
    size: Floats
    """[K, 3] sizes of their scopes, metres."""
    axes: Floats
    """[K, 3, 3] axes of their scopes, as columns."""
    meshes: Meshes
    """[K] their geometry in the world."""
    is_closed: NDArray[np.bool_]
    """[K] whether their surfaces are closed."""
    roots: tuple[Floats, Floats]
    """Lowest and highest corners [N, 3] of the initial shapes of all models in the world."""
    stand_together: bool
    """Whether the models stand beside each other, so that queries of one see the shapes of others."""

    @classmethod
    def of(
        cls, collector: Collector, roots: Shapes, origins: Floats, meshes: MeshTable, frames: FrameTable, together: bool
    ) -> Surroundings:
        """The shapes of a finished first derivation.

        Args:
            collector: its shapes.
            roots: [N] initial shapes.
            origins: [N, 3] origins of the models' positions in the world.
            meshes: table of meshes of that derivation.
            frames: its table of orientations.
            together: whether the models stand beside each other.
        """
        placed = [_Placed.of(shapes, origins, meshes, frames) for shapes, _ in collector.chunks]
        labels = [label for shapes, label in collector.chunks for _ in range(shapes.num)]
        model = np.concatenate([np.zeros(0, np.int32), *(shapes.model for shapes, _ in collector.chunks)])
        order = np.argsort(model, kind="stable")
        node = np.concatenate([np.zeros(0, np.int32), *(shapes.node for shapes, _ in collector.chunks)])
        nothing = meshes.take(np.zeros(1, np.int64)).take(np.zeros(0, np.int64))
        whole = Meshes.concatenate([nothing, *(part.meshes for part in placed)]).take(order)
        return cls(
            tree=collector.lineage.tree(),
            node=node[order],
            model=model[order],
            labels=tuple(labels[row] for row in order.tolist()),
            position=np.concatenate([np.zeros((0, 3)), *(part.position for part in placed)])[order],
            size=np.concatenate([np.zeros((0, 3)), *(part.size for part in placed)])[order],
            axes=np.concatenate([np.zeros((0, 3, 3)), *(part.axes for part in placed)])[order],
            meshes=whole,
            is_closed=is_closed_surface(joined(whole)),
            roots=_Placed.of(roots, origins, meshes, frames).meshes.bounds(),
            stand_together=together,
        )

    @cached_property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lowest and highest corners [K, 3]."""
        return self.meshes.bounds()

    @cached_property
    def area(self) -> Floats:
        """[K] areas in square metres."""
        return areas(self.meshes)

    @cached_property
    def labelled(self) -> dict[str, NDArray[np.int64]]:
        """Rows of the shapes with each label."""
        texts = np.array(self.labels, dtype=object)
        return {label: np.flatnonzero(texts == label) for label in dict.fromkeys(self.labels) if label}

    @cached_property
    def _intervals(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        begin, end = intervals(self.tree)
        return begin, end

    @cached_property
    def _bodies(self) -> dict[int, Body]:
        return {}

    def body(self, row: int) -> Body:
        """The shape at a row as a body."""
        from grammarlab.geometry.meshes.contact import Body  # noqa: PLC0415

        if row not in self._bodies:
            self._bodies[row] = Body(self.meshes.take(np.array([row])))
        return self._bodies[row]

    def rows(self, model: int, target: str, is_near: bool) -> NDArray[np.int64]:
        """Rows of the shapes that a query of one model may see.

        Args:
            model: the model.
            target: ``intra``, ``inter`` or ``all``.
            is_near: whether only neighbours count among other models.
        """
        first, end = np.searchsorted(self.model, [model, model + 1])
        own_rows = np.arange(first, end)
        if target == "intra" or not self.stand_together:
            return own_rows if target != "inter" else own_rows[:0]
        low, high = self.roots
        reach = _NEIGHBOURHOOD if is_near else np.inf
        gap = np.maximum(low - high[model], low[model] - high)[:, [0, 2]].max(axis=1)
        neighbours = np.flatnonzero(gap <= reach)
        rows = np.flatnonzero(np.isin(self.model, neighbours[neighbours != model]))
        return rows if target == "inter" else np.union1d(own_rows, rows)

    def unrelated(self, rows: NDArray[np.int64], nearest: int, is_same: bool) -> NDArray[np.bool_]:
        """[R] whether shapes are neither ancestors nor descendants of a node of the second derivation.

        Args:
            rows: rows of shapes.
            nearest: the node of the first derivation in its place, or the nearest ancestor that exists there.
            is_same: whether a node exists in its place.
        """
        begin, end = self._intervals
        node = self.node[rows]
        is_ancestor = (begin[node] <= begin[nearest]) & (begin[nearest] < end[node])
        is_descendant = (begin[nearest] <= begin[node]) & (begin[node] < end[nearest]) & is_same
        return ~(is_ancestor | is_descendant)


@dataclass(frozen=True, slots=True)
class _Placed:
    """Shapes [N] in the world."""

    position: Floats
    size: Floats
    axes: Floats
    meshes: Meshes

    @classmethod
    def of(cls, shapes: Shapes, origins: Floats, table: MeshTable, frames: FrameTable) -> _Placed:
        shapes = right_handed(upright(shapes, table, frames), table, frames)
        position = shapes.position + origins[shapes.model]
        return cls(position, shapes.size, frames.rotations(shapes.frame), world_meshes(shapes, origins, table, frames))


def world_meshes(shapes: Shapes, origins: Floats, table: MeshTable, frames: FrameTable) -> Meshes:
    """The geometry of shapes [N] in the world; their scopes are right-handed and of positive height.

    Args:
        shapes: the shapes.
        origins: [M, 3] origins of the models' positions in the world.
        table: table of meshes.
        frames: table of orientations.
    """
    local = scaled(table.take(shapes.mesh), shapes.size)
    owner = local.mesh_of_point()
    turned = np.einsum("pij,pj->pi", frames.rotations(shapes.frame)[owner], local.points)
    return local.with_points(turned + (shapes.position + origins[shapes.model])[owner])


def visible(shapes: Shapes) -> Shapes:
    """The shapes with geometry."""
    return shapes if (shapes.mesh != EMPTY).all() else shapes.take(np.flatnonzero(shapes.mesh != EMPTY))
