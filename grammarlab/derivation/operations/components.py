"""``comp``: a shape taken apart into its faces, edges or vertices.

The faces of boxes and rectangles are table look-ups; every other geometry goes through
`grammarlab.geometry.components`. A component that one part has taken is not there for the parts after it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.calls import BlockOperation, Call, Head, Part
from grammarlab.derivation.frames import cube_index
from grammarlab.derivation.functions.geometry import local_meshes
from grammarlab.derivation.meshes import add_faces, normalized
from grammarlab.derivation.shapes import BOX, FACE, FOOTPRINT, Floats, Ids, Shapes
from grammarlab.geometry import components as parts_of
from grammarlab.geometry.mesh import Meshes
from grammarlab.geometry.primitives import BOX_ORIGINS, BOX_ROTATIONS, TOP
from grammarlab.geometry.selectors import SELECTORS, classify, select

Flags = NDArray[np.bool_]
Rows = NDArray[np.int64]

_BOX_CUBES = np.array([cube_index(rotation) for rotation in BOX_ROTATIONS], dtype=np.int32)
_BOX_NORMALS = BOX_ROTATIONS[:, :, 2].copy()
_BOX_AXES = np.abs(BOX_ROTATIONS).argmax(axis=1)
"""[6, 3] along which axis of the box each axis of a face runs."""
_MAKERS = {"f": parts_of.faces, "e": parts_of.edges, "v": parts_of.vertices}


class Placed(NamedTuple):
    """K component shapes: their scopes and geometry."""

    row: Rows
    """[K] the shape each one comes from, ascending."""
    position: Floats
    size: Floats
    frame: Ids
    mesh: Ids


class AbstractComponents(ABC):
    """All components of N shapes, ordered by shape, before any is chosen."""

    row: Rows
    """[K] the shape that each component belongs to."""
    index: Rows
    """[K] its number within the shape."""

    @abstractmethod
    def picked(self, selector: str) -> Flags:
        """[K] the components that a selector names."""

    @abstractmethod
    def place(self, chosen: Rows) -> Placed:
        """The shapes of the chosen components, one each."""

    @abstractmethod
    def place_joined(self, chosen: Rows) -> Placed:
        """The shapes of the chosen components, all those of one shape together."""


class _BoxFaces(AbstractComponents):
    """The six faces of boxes, or the one face of rectangles."""

    def __init__(self, call: Call, shapes: Shapes, kind: int) -> None:
        self._call, self._shapes, self._kind = call, shapes, kind
        self._faces = np.arange(6) if kind == BOX else np.array([TOP if kind == FOOTPRINT else 0])
        self.row = np.repeat(np.arange(shapes.num), len(self._faces))
        self.index = np.tile(np.arange(len(self._faces)), shapes.num)

    def picked(self, selector: str) -> Flags:
        normals = _BOX_NORMALS[self._faces]
        if selector in ("all", "border", "inside"):
            whole = selector == "all" or (selector == "border") == (self._kind != BOX)
            return np.full(len(self.row), whole)
        if selector in ("eave", "hip", "valley", "ridge"):
            return np.zeros(len(self.row), dtype=bool)
        if "." not in selector:
            return np.tile(classify(normals, selector), self._shapes.num)
        return classify(_turned(self._call, self._shapes, selector, self.row, normals[self.index]), selector)

    def place(self, chosen: Rows) -> Placed:
        shapes, frames = self._shapes, self._call.workspace.frames
        row, face = self.row[chosen], self._faces[self.index[chosen]]
        whole = shapes.size[row]
        parent = shapes.frame[row]
        if self._kind == FACE:
            return Placed(row, shapes.position[row], whole * [1.0, 1.0, 0.0], parent, np.full(len(row), np.int32(FACE)))
        first = face[0] if len(face) else 0
        if (face == first).all():
            frame = frames.turned(parent, int(_BOX_CUBES[first]))
            size = whole[:, _BOX_AXES[first]]
        else:
            frame = frames.turned_each(parent, _BOX_CUBES[face])
            size = np.take_along_axis(whole, _BOX_AXES[face], axis=1)
        size[:, 2] = 0.0
        origin = BOX_ORIGINS[face] * whole
        if self._kind == FOOTPRINT:
            origin[:, 1] = 0.0
        position = shapes.position[row] + frames.to_world(parent, origin)
        return Placed(row, position, size, frame, np.full(len(row), np.int32(FACE)))

    def place_joined(self, chosen: Rows) -> Placed:
        return _MeshComponents(self._call, self._shapes, "f").place_joined(chosen)


class _MeshComponents(AbstractComponents):
    """Faces, edges or vertices of any geometry."""

    def __init__(self, call: Call, shapes: Shapes, kind: str) -> None:
        self._call, self._shapes, self._kind = call, shapes, kind
        self._meshes: Meshes = local_meshes(shapes, call.workspace)
        self._components = _MAKERS[kind](self._meshes)
        self.row, self.index = self._components.mesh, self._components.index

    def picked(self, selector: str) -> Flags:
        frames, shapes = self._call.workspace.frames, self._shapes
        prefix = selector.partition(".")[0]
        to_world = frames.rotations(shapes.frame) if prefix == "world" else None
        to_object = _to_object(self._call, shapes) if prefix in ("object", "street") else None
        return select(self._components, selector, to_object, to_world)

    def place(self, chosen: Rows) -> Placed:
        return self._placed(self._components.take(chosen))

    def place_joined(self, chosen: Rows) -> Placed:
        if self._kind != "f":
            raise self._call.error("comp with = joins faces only; use : for edges and vertices")
        sizes = np.unique(self.row[chosen], return_counts=True)[1]
        return self._placed(parts_of.face_sets(self._meshes, chosen, sizes))

    def _placed(self, components: parts_of.Components) -> Placed:
        shapes, workspace = self._shapes, self._call.workspace
        row = components.mesh
        position = shapes.position[row] + workspace.frames.to_world(shapes.frame[row], components.origin)
        frame = workspace.frames.rotated(shapes.frame[row], components.rotation)
        unit, _, _ = normalized(components.shapes)
        return Placed(row, position, components.size, frame, add_faces(workspace.meshes, unit))


class _MixedComponents(AbstractComponents):
    """Components of shapes of several kinds."""

    def __init__(self, shapes: Shapes, groups: Sequence[tuple[Rows, AbstractComponents]]) -> None:
        self._groups = groups
        row = np.concatenate([rows[group.row] for rows, group in groups])
        self._order = np.argsort(row, kind="stable")
        self.row = row[self._order]
        self.index = np.concatenate([group.index for _, group in groups])[self._order]

    def picked(self, selector: str) -> Flags:
        return np.concatenate([group.picked(selector) for _, group in self._groups])[self._order]

    def place(self, chosen: Rows) -> Placed:
        return self._merged(chosen, joined=False)

    def place_joined(self, chosen: Rows) -> Placed:
        return self._merged(chosen, joined=True)

    def _merged(self, chosen: Rows, joined: bool) -> Placed:
        wanted = np.zeros(len(self.row), dtype=bool)
        wanted[self._order[chosen]] = True
        placed, start = [], 0
        for rows, group in self._groups:
            own = np.flatnonzero(wanted[start : start + len(group.row)])
            start += len(group.row)
            if len(own):
                part = group.place_joined(own) if joined else group.place(own)
                placed.append(part._replace(row=rows[part.row]))
        columns = [np.concatenate(column) for column in zip(*placed, strict=True)]
        order = np.argsort(columns[0], kind="stable")
        return Placed(*(column[order] for column in columns))


def comp(call: Call, heads: tuple[Head, ...]) -> list[Part]:
    """``comp(f|e|v) { selector : ... | selector = ... }``: the faces, edges or vertices of a shape.

    With ``:`` every component is a shape, with ``=`` all of one shape are one together.
    """
    kind = call.words[0] if call.words else ""
    if kind not in _MAKERS:
        raise call.error(f"comp expects f, e or v, found {kind or 'something else'}")
    components = _components(call, kind)
    available = np.ones(len(components.row), dtype=bool)
    parts = []
    for head in heads:
        chosen = np.flatnonzero(available & _selected(call, components, head))
        available[chosen] = False
        parts.append(_part(call, components, chosen, head))
    return parts


def _components(call: Call, kind: str) -> AbstractComponents:
    shapes = call.shapes
    if kind != "f":
        return _MeshComponents(call, shapes, kind)
    first = int(shapes.mesh[0])
    if first in (BOX, FOOTPRINT, FACE) and (shapes.mesh == first).all():
        return _BoxFaces(call, shapes, first)
    groups: list[tuple[Rows, AbstractComponents]] = []
    for simple in (BOX, FOOTPRINT, FACE):
        rows = np.flatnonzero(shapes.mesh == simple)
        if len(rows):
            groups.append((rows, _BoxFaces(call, shapes.take(rows), simple)))
    rows = np.flatnonzero(shapes.mesh > FACE)
    if len(rows) == shapes.num:
        return _MeshComponents(call, shapes, kind)
    if len(rows):
        groups.append((rows, _MeshComponents(call, shapes.take(rows), kind)))
    return _MixedComponents(shapes, groups) if groups else _MeshComponents(call, shapes, kind)


def _selected(call: Call, components: AbstractComponents, head: Head) -> Flags:
    """[K] the components that the head of a part asks for: by a selector, a condition or a number."""
    value = head.argument.value
    if head.argument.keyword:
        return components.picked(str(value))
    if isinstance(value, str) or (isinstance(value, np.ndarray) and value.dtype.kind == "i"):
        raise call.error("comp expects selectors, numbers or conditions before the colons, found a string")
    if isinstance(value, bool) or (isinstance(value, np.ndarray) and value.dtype.kind == "b"):
        return np.broadcast_to(value, call.shapes.num)[components.row]
    return components.index == np.rint(np.broadcast_to(value, call.shapes.num))[components.row]


def _part(call: Call, components: AbstractComponents, chosen: Rows, head: Head) -> Part:
    shapes = call.shapes
    if len(chosen) == 0:
        return Part(shapes.take(chosen), chosen)
    placed = components.place_joined(chosen) if head.joined else components.place(chosen)
    number = components.index[chosen]
    if head.joined:
        number = number[np.unique(components.row[chosen], return_index=True)[1]]
    made = shapes.place(*placed)
    return Part(_indexed(call, made, placed.row, head), number)


def _indexed(call: Call, made: Shapes, row: Rows, head: Head) -> Shapes:
    """Components that know their place, number and selector, where the grammar asks."""
    asked = call.workspace.program.state_names & {"comp.index", "comp.total", "comp.sel"}
    if not asked:
        return made
    counts = np.bincount(row, minlength=call.shapes.num)
    first = np.cumsum(counts) - counts
    known = {
        "comp.index": (np.arange(len(row)) - first[row]).astype(np.float64),
        "comp.total": counts[row].astype(np.float64),
        "comp.sel": str(head.argument.value) if head.argument.keyword else "",
    }
    return made._replace(state={**made.state, **{name: known[name] for name in asked}})


def _turned(call: Call, shapes: Shapes, selector: str, row: Rows, normals: Floats) -> Floats:
    """Normals [K, 3] in the axes that a selector's prefix names."""
    if selector.startswith("world."):
        rotations = call.workspace.frames.rotations(shapes.frame)
    else:
        rotations = _to_object(call, shapes)
    return np.einsum("nij,nj->ni", rotations[row], normals)


def _to_object(call: Call, shapes: Shapes) -> Floats:
    """[N, 3, 3] from the axes of each shape to those of its model's initial shape."""
    frames = call.workspace.frames
    initial = frames.rotations(call.workspace.roots.frame[shapes.model])
    return np.einsum("nji,njk->nik", initial, frames.rotations(shapes.frame))


BLOCKS: dict[str, BlockOperation] = {
    "comp": BlockOperation(comp, frozenset({"f", "e", "v", "fe", "fv"}), (1, 2), frozenset(SELECTORS))
}
