"""``comp``: a shape divided into its faces, edges or vertices.

The faces of boxes and rectangles are table look-ups; every other geometry goes through
`grammarlab.geometry.components`. A component selected by one part is not available to later parts.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property, partial
from itertools import repeat
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import (
    Flags,
    Floats,
    distinct_counts,
    distinct_lists,
    distinct_pairs,
    lists_are_compared,
    narrow,
    offsets_from_counts,
    ranked,
    row_lengths,
    row_of_value,
    same_bits,
    take_rows,
)
from grammarlab.derivation.calls.calls import BlockOperation, BoundCall, BoundPart, Head, selected
from grammarlab.derivation.calls.texture_transfer import with_pivot
from grammarlab.derivation.frames import CUBE, cube_index
from grammarlab.derivation.functions.shape_measures import alike_meshes, local_meshes, oriented
from grammarlab.derivation.functions.shape_tags import COMPONENT_TAGS
from grammarlab.derivation.functions.street_sides import (
    OLDER_SELECTORS,
    OutwardLines,
    by_streets,
    face_sides,
    line_sides,
    picked_by,
)
from grammarlab.derivation.state.box_orders import kinds
from grammarlab.derivation.state.face_tags import sets_of_components
from grammarlab.derivation.state.mesh_table import add_faces, normalized
from grammarlab.derivation.state.shapes import BOX, FACE, FOOTPRINT, Ids, Shapes
from grammarlab.derivation.state.tag_table import TagTable
from grammarlab.derivation.state.trim_planes import NONE, TRIM, with_trim_ids
from grammarlab.geometry import components as parts_of
from grammarlab.geometry.components import connected_faces, face_edges, face_vertices, joined, unaligned, upwards
from grammarlab.geometry.lot_sides import Sides
from grammarlab.geometry.meshes.primitives import BOX_ROTATIONS, TOP
from grammarlab.geometry.meshes.vectors import apply
from grammarlab.geometry.selectors import SELECTORS, classify, nearest_axis, select

Rows = NDArray[np.int64]

_CUBE_NORMALS = CUBE[:, :, 2].copy()
_CUBE_AXES = np.abs(CUBE).argmax(axis=1)
"""[24, 3] axis of the box along each axis of a face with that frame."""
_LYING = cube_index(BOX_ROTATIONS[TOP])
_MAKERS = {
    "f": parts_of.faces,
    "e": parts_of.edges,
    "v": parts_of.vertices,
    "fe": face_edges,
    "fv": face_vertices,
}
_CLIMBING = frozenset({"hip", "valley", "ridge"})
"""Selectors of roof edges that are directed upwards, independent of the face they were found on."""


class ComponentShapes(NamedTuple):
    """K component shapes: their scopes and geometry."""

    row: Rows
    """[K] the shape each one comes from, ascending."""
    position: Floats
    size: Floats
    frame: Ids
    mesh: Ids
    first: Rows
    """[K] index of the chosen component that each one is, or begins with."""
    pivot: Floats
    """[K, 3] its first corner, new_shape may differ from the corner of its bounding box; world metres."""


Join = Literal["each", "all", "connected"]
"""Groups of components by the operators ``:``, ``=`` and ``=:``: one per component, of all, per connected set."""


class AbstractComponents(ABC):
    """All components of N shapes, ordered by shape, before any is chosen."""

    row: Rows
    """[K] the shape that each component belongs to."""

    @abstractmethod
    def numbers(self, chosen: Rows) -> Rows:
        """[C] the numbers of chosen components within their shapes."""

    @abstractmethod
    def picked(self, selector: str) -> Flags:
        """[K] the components that a selector names."""

    @abstractmethod
    def tags(self, part: str) -> Ids:
        """[K] sets of tags of the components; with ``e`` or ``v`` of all that shares an edge or a corner with them."""

    @abstractmethod
    def shapes_of(self, chosen: Rows, join: Join, aligned: bool, selector: str = "") -> ComponentShapes:
        """The shapes that chosen components make.

        Args:
            chosen: [C] components, ascending.
            join: grouping of the components into shapes.
            aligned: whether the shapes get their own axes, or keep those of the original shape.
            selector: the selector; it directs roof edges upwards.
        """


class _BoxFaces(AbstractComponents):
    """The six faces of boxes, or the one face of rectangles."""

    def __init__(self, call: BoundCall, shapes: Shapes, kind: int) -> None:
        self._call, self._shapes, self._kind = call, shapes, kind
        if kind == BOX:
            boxes = call.workspace.meshes.boxes
            self._order = np.maximum(-shapes.mesh, 0)
            self._cubes, self._origins = boxes.cubes, boxes.origins
        else:
            self._order = np.zeros(shapes.num, np.int32)
            self._cubes = np.array([[_LYING if kind == FOOTPRINT else 0]], dtype=np.int32)
            self._origins = np.array([[[0.0, 0.0, 1.0 if kind == FOOTPRINT else 0.0]]])
        count = self._cubes.shape[1]
        self.row = np.repeat(np.arange(shapes.num), count)

    def numbers(self, chosen: Rows) -> Rows:
        return chosen % self._cubes.shape[1]

    def picked(self, selector: str) -> Flags:
        if selector in ("all", "border", "inside"):
            whole = selector == "all" or (selector == "border") == (self._kind != BOX)
            return np.full(len(self.row), whole)
        if selector in ("eave", "hip", "valley", "ridge"):
            return np.zeros(len(self.row), dtype=bool)
        if "." not in selector:
            return classify(_CUBE_NORMALS, selector)[self._cubes][self._order].ravel()
        normals = _CUBE_NORMALS[self._cubes[self._order].ravel()]
        flags = oriented(selector, normals, self.row, self._shapes, self._call.workspace)
        return by_streets(selector, lambda: self._sides, flags, self.row, self._shapes, self._call.workspace)

    def tags(self, part: str) -> Ids:
        return np.zeros(len(self.row), np.int32)

    @cached_property
    def _sides(self) -> Sides:
        workspace = self._call.workspace
        return face_sides(local_meshes(self._shapes, workspace), self._shapes, workspace)

    def shapes_of(self, chosen: Rows, join: Join, aligned: bool, selector: str = "") -> ComponentShapes:
        if join != "each" or not aligned:
            return _MeshComponents(self._call, self._shapes, "f").shapes_of(chosen, join, aligned)
        shapes, frames = self._shapes, self._call.workspace.frames
        row, face = self.row[chosen], self.numbers(chosen)
        whole = shapes.size[row]
        parent = shapes.frame[row]
        mesh = np.full(len(row), np.int32(FACE))
        component = np.arange(len(chosen))
        order = self._order[row]
        cubes = self._cubes[order, face]
        if len(cubes) and (cubes == cubes[0]).all():
            frame = frames.turned(parent, int(cubes[0]))
            size = whole[:, _CUBE_AXES[cubes[0]]]
        else:
            frame = frames.turned_each(parent, cubes)
            size = np.take_along_axis(whole, _CUBE_AXES[cubes], axis=1)
        size[:, 2] = 0.0
        position = shapes.position[row]
        if self._kind != FACE:
            position = position + frames.to_world(parent, self._origins[order, face] * whole)
        return ComponentShapes(
            row=row, position=position, size=size, frame=frame, mesh=mesh, first=component, pivot=position
        )


class _MeshComponents(AbstractComponents):
    """Components of any kind, of any geometry; shapes of equal geometry share theirs."""

    def __init__(self, call: BoundCall, shapes: Shapes, kind: str) -> None:
        self._call, self._shapes, self._kind = call, shapes, kind
        self._meshes, self._first, self._number = alike_meshes(shapes, call.workspace)
        self._components = _MAKERS[kind](self._meshes)
        counts = np.bincount(self._components.mesh, minlength=len(self._meshes))
        self._source, offsets = take_rows(offsets_from_counts(counts), self._number)
        self.row = row_of_value(row_lengths(offsets))

    def numbers(self, chosen: Rows) -> Rows:
        return self._components.index.take(self._source.take(chosen))

    def picked(self, selector: str) -> Flags:
        frames, shapes = self._call.workspace.frames, self._shapes
        prefix = selector.partition(".")[0]
        if prefix in ("world", "object", "street"):
            axes = frames.rotations(shapes.frame) if prefix == "world" else _to_object(self._call, shapes)
            directions = self._components.direction.take(self._source, axis=0)
            flags = classify(apply(axes.take(self.row, axis=0), directions), selector)
        else:
            flags = select(self._components, selector).take(self._source)
        return by_streets(selector, lambda: self._sides, flags, self.row, shapes, self._call.workspace)

    def tags(self, part: str) -> Ids:
        table = self._call.workspace.tags
        sets = sets_of_components(self._meshes, TagTable() if table is None else table, self._kind, part)
        return sets.take(self._source)

    @cached_property
    def _sides(self) -> Sides:
        if self._kind == "f":
            return face_sides(self._meshes.take(self._number), self._shapes, self._call.workspace)
        parts = self._components.take(self._source)
        outward = parts.direction
        if self._kind == "e":
            # An edge at the border of a face that lies flat looks out of the face, not up.
            lies_flat = nearest_axis(apply(_to_object(self._call, self._shapes)[self.row], outward)) == 1
            outward = np.where((lies_flat & parts.is_border)[:, None], parts.rotation[:, :, 1], outward)
        lines = OutwardLines(parts.origin, parts.rotation[:, :, 0] * parts.size[:, :1], outward, self.row)
        return line_sides(lines, self._shapes, self._call.workspace)

    def shapes_of(self, chosen: Rows, join: Join, aligned: bool, selector: str = "") -> ComponentShapes:
        source, row = self._source.take(chosen), self.row.take(chosen)
        if join == "each":
            used, number = ranked(source, len(self._components))
            components = self._components.take(used)
            components = upwards(components) if selector in _CLIMBING else components
            return self._placed(components, number, row, np.arange(len(chosen)), aligned)
        rows, counts, alike, number = self._lists(source, row)
        starts = offsets_from_counts(counts)
        joined_rows, offsets = take_rows(starts, alike)
        components, first = self._joined(source[joined_rows], row_lengths(offsets), join)
        owner = np.searchsorted(offsets, first, side="right") - 1
        num_sets = np.bincount(owner, minlength=len(alike))
        which, of_row = take_rows(offsets_from_counts(num_sets), number)
        owners = row_of_value(row_lengths(of_row))
        first_chosen = starts[owners] + (first - offsets[owner])[which]
        return self._placed(components, which, rows[owners], first_chosen, aligned)

    def _lists(self, source: Rows, row: Rows) -> tuple[Rows, Rows, Rows, Rows]:
        """Chosen components as lists, one for each shape that has some.

        Args:
            source: [C] the components, ascending by shape.
            row: [C] their shapes.

        Returns:
            The shapes [L], the lengths [L] of the lists, the first [K] of each different list, and the number [L] of
            each among these.
        """
        is_chosen = np.zeros(len(self._components), dtype=bool)
        is_chosen[source] = True
        if np.count_nonzero(is_chosen.take(self._source)) == len(source):
            # Shapes of equal geometry have equal lists, which need not be compared.
            counts = np.bincount(self._components.mesh[is_chosen], minlength=len(self._meshes))
            rows = np.flatnonzero(counts.take(self._number))
            number = self._number.take(rows)
            lengths = counts.take(number)
            if lists_are_compared(lengths):
                used = counts > 0
                first = np.searchsorted(rows, self._first[used])
                return rows, lengths, first, (np.cumsum(used) - 1).take(number)
        rows, counts = distinct_counts(row, self._shapes.num)
        return rows, counts, *distinct_lists(source, counts)

    def _joined(self, source: Rows, sizes: Rows, join: Join) -> tuple[parts_of.ComponentMeshes, Rows]:
        """Components of lists of components, and the index among all of the first component of each.

        Args:
            source: components, list after list; those of a list belong to one mesh, ascending.
            sizes: number of components of each list.
            join: ``all`` or ``connected``.
        """
        if self._kind != "f":
            if join == "connected":
                raise self._call.error("comp with =: joins faces only", "use : or = for edges and vertices")
            return joined(self._components.take(source), sizes), np.cumsum(sizes) - sizes
        meshes = self._meshes.take(self._components.mesh[source[np.cumsum(sizes) - sizes]])
        chosen = self._components.index[source] + np.repeat(meshes.mesh_faces[:-1], sizes)
        faces = chosen
        if join == "connected":
            faces, sizes = connected_faces(meshes, chosen)
        first = np.searchsorted(chosen, faces[np.cumsum(sizes) - sizes])
        return parts_of.face_sets(meshes, faces, sizes), first

    def _placed(
        self, components: parts_of.ComponentMeshes, number: Rows, row: Rows, first: Rows, aligned: bool
    ) -> ComponentShapes:
        """Components [K] of shapes, each with the geometry of its number [K], as shapes."""
        shapes, workspace = self._shapes, self._call.workspace
        frames = workspace.frames
        components = components if aligned else unaligned(components)
        corner = shapes.position.take(row, axis=0)
        unit, _, _ = normalized(components.shapes)
        # Of many shapes few have different axes.
        frame, which, pair = distinct_pairs(shapes.frame.take(row), number, max(1, len(components)))
        position = frames.to_world(frame, components.origin.take(which, axis=0)).take(pair, axis=0)
        position += corner
        if same_bits(components.pivot, components.origin):
            pivot = position
        else:
            pivot = frames.to_world(frame, components.pivot.take(which, axis=0)).take(pair, axis=0)
            pivot += corner
        return ComponentShapes(
            row=row,
            position=position,
            size=components.size.take(number, axis=0),
            frame=frames.rotated_alike(frame, components.rotation, which).take(pair),
            mesh=add_faces(workspace.meshes, unit).take(number),
            first=first,
            pivot=pivot,
        )


class _MixedComponents(AbstractComponents):
    """Components of shapes of several kinds."""

    def __init__(self, shapes: Shapes, groups: Sequence[tuple[Rows, AbstractComponents]]) -> None:
        self._groups = groups
        row = np.concatenate([rows[group.row] for rows, group in groups])
        self._order = np.argsort(narrow(row), kind="stable")
        self.row = row[self._order]
        numbers = [group.numbers(np.arange(len(group.row))) for _, group in groups]
        self._numbers = np.concatenate(numbers)[self._order]

    def numbers(self, chosen: Rows) -> Rows:
        return self._numbers.take(chosen)

    def picked(self, selector: str) -> Flags:
        return np.concatenate([group.picked(selector) for _, group in self._groups])[self._order]

    def tags(self, part: str) -> Ids:
        return np.concatenate([group.tags(part) for _, group in self._groups])[self._order]

    def shapes_of(self, chosen: Rows, join: Join, aligned: bool, selector: str = "") -> ComponentShapes:
        turn = np.full(len(self.row), -1, np.int64)
        turn[self._order[chosen]] = np.arange(len(chosen))
        placed, start = [], 0
        for rows, group in self._groups:
            turns = turn[start : start + len(group.row)]
            chosen_of_group = np.flatnonzero(turns >= 0)
            start += len(group.row)
            if len(chosen_of_group):
                part = group.shapes_of(chosen_of_group, join, aligned, selector)
                placed.append(part._replace(row=rows[part.row], first=turns[chosen_of_group][part.first]))
        columns = [np.concatenate(column) for column in zip(*placed, strict=True)]
        order = np.argsort(narrow(columns[0]), kind="stable")
        return ComponentShapes._make(column[order] for column in columns)


def comp(call: BoundCall, heads: tuple[Head, ...]) -> list[BoundPart]:
    """``comp(f|e|v|fe|fv, zUp|noAlign) { selector : ... | selector = ... | selector =: ... }``: a shape's components.

    With ``:`` every component is a shape, with ``=`` all of one shape together are one, with ``=:`` each connected set
    of faces is. With ``noAlign`` the components keep the axes of the shape. A condition in place of a selector, such
    as ``top || geometry.area > 3``, is evaluated on each component not selected yet, in the axes of the shape.
    """
    kind = call.words[0] if call.words else ""
    if kind not in _MAKERS:
        raise call.error(f"comp expects f, e, v, fe or fv, found {kind or 'something else'}")
    components = _components(call, kind)
    selections = _selections(call, components, heads)
    return [
        _bare_part(call, components, chosen, head) if is_bare else _part(call, components, chosen, head)
        for (head, chosen), is_bare in zip(selections, call.bare or repeat(False), strict=False)
    ]


class SelectedComponents(NamedTuple):
    """C components selected by one part, and the K shapes they make."""

    shapes: Shapes
    number: Rows
    """[K] index of each shape's first component."""
    row: Rows
    """[C] the shape that contains each component."""
    component: Rows
    """[C] number of each component in that shape."""
    new_shape: Rows
    """[C] the new shape that contains each component."""


def select_components(call: BoundCall, heads: tuple[Head, ...]) -> tuple[list[SelectedComponents], Rows]:
    """Components selected by each part of ``comp``, and the number of components of each shape [N].

    Raises:
        DerivationError: If the operator is ``=:``.
    """
    kind = call.words[0] if call.words else ""
    if kind not in _MAKERS or any(head.connected for head in heads):
        raise call.error("comp as a value expects f, e, v, fe or fv, and : or = between selectors and values")
    components = _components(call, kind)
    selections = []
    for head, chosen in _selections(call, components, heads):
        part, row = _part(call, components, chosen, head), components.row[chosen]
        new_shape = np.unique(row, return_inverse=True)[1] if head.joined else np.arange(len(chosen))
        selections.append(
            SelectedComponents(part.shapes, part.number.astype(np.int64), row, components.numbers(chosen), new_shape)
        )
    return selections, np.bincount(components.row, minlength=call.shapes.num)


def _components(call: BoundCall, kind: str) -> AbstractComponents:
    shapes = call.shapes
    if kind != "f":
        return _MeshComponents(call, shapes, kind)
    mesh = kinds(shapes.mesh)
    first = int(mesh[0])
    if first in (BOX, FOOTPRINT, FACE) and (mesh == first).all():
        return _BoxFaces(call, shapes, first)
    groups: list[tuple[Rows, AbstractComponents]] = []
    for simple in (BOX, FOOTPRINT, FACE):
        rows = np.flatnonzero(mesh == simple)
        if len(rows):
            groups.append((rows, _BoxFaces(call, shapes.take(rows), simple)))
    rows = np.flatnonzero(mesh > FACE)
    if len(rows) == shapes.num:
        return _MeshComponents(call, shapes, kind)
    if len(rows):
        groups.append((rows, _MeshComponents(call, shapes.take(rows), kind)))
    return _MixedComponents(shapes, groups) if groups else _MeshComponents(call, shapes, kind)


def _selections(call: BoundCall, components: AbstractComponents, heads: Sequence[Head]) -> Iterator[tuple[Head, Rows]]:
    """Each part with its selected components, without those selected by earlier parts."""
    available = np.ones(len(components.row), dtype=bool)
    for head in heads:
        chosen = _chosen(call, components, head, available)
        available[chosen] = False
        yield head, chosen


def _chosen(call: BoundCall, components: AbstractComponents, head: Head, available: Flags) -> Rows:
    """Available components selected by the head of a part: by a selector, a condition or a number."""
    if head.condition is not None:
        candidates = np.flatnonzero(available)
        if len(candidates) == 0:
            return candidates
        placed = components.shapes_of(candidates, "each", aligned=False)
        shapes, number = call.shapes.parts(*placed[:5]), components.numbers(candidates)
        if call.workspace.tags is not None:
            names = {part: COMPONENT_TAGS + (f".{part}" if part else "") for part in ("", "e", "v")}
            tags = {name: components.tags(part)[candidates] for part, name in names.items()}
            shapes = shapes._replace(state={**shapes.state, **tags})
        flags = selected(call, head.condition, shapes, number, lambda word: _picked(call, components, word)[candidates])
        return candidates[flags]
    value = head.argument.value
    if head.argument.keyword:
        return np.flatnonzero(available & _picked(call, components, str(value)))
    # Numbers go round: of six faces, 6 is the first and -1 the last one.
    count = np.maximum(np.bincount(components.row, minlength=call.shapes.num), 1)
    target_index = np.rint(call.column(head.argument)) % count
    numbers = components.numbers(np.arange(len(components.row)))
    return np.flatnonzero(available & (numbers == target_index[components.row]))


def _picked(call: BoundCall, components: AbstractComponents, selector: str) -> Flags:
    """[K] the components that a selector, or one of older rule files, names."""
    return picked_by(selector, components.picked, components.row, call.shapes, call.workspace)


def _part(call: BoundCall, components: AbstractComponents, chosen: Rows, head: Head) -> BoundPart:
    shapes = call.shapes
    if len(chosen) == 0:
        return BoundPart(shapes.take(chosen), chosen)
    join: Join = "connected" if head.connected else "all" if head.joined else "each"
    aligned = "noAlign" not in call.words
    placed = components.shapes_of(chosen, join, aligned, head.text)
    parts = shapes.parts(*placed[:5])
    parts = with_pivot(parts, placed.pivot, parts.frame, call.workspace) if aligned else parts
    parts = _with_planes(call, parts, placed.row, partial(components.numbers, chosen), join)
    return BoundPart(_indexed(call, parts, placed.row, head), components.numbers(chosen.take(placed.first)))


def _bare_part(call: BoundCall, components: AbstractComponents, chosen: Rows, head: Head) -> BoundPart:
    """The shapes of a part without geometry."""
    if head.joined or head.connected:
        part = _part(call, components, chosen, head)
        return part._replace(shapes=part.shapes.bare())
    row = components.row[chosen]
    return BoundPart(_indexed(call, call.shapes.bare_parts(row), row, head), components.numbers(chosen))


def _with_planes(call: BoundCall, parts: Shapes, row: Rows, numbers: Callable[[], Rows], join: Join) -> Shapes:
    """Components with the trim planes of their faces, numbered within the shapes; other ones have none."""
    if TRIM not in parts.state:
        return parts
    alone = (call.shapes.mesh == FACE) | (call.shapes.mesh == FOOTPRINT)
    if call.words[0] != "f" or join != "each" or alone.all() or "noAlign" in call.words:
        return with_trim_ids(parts, NONE)
    return with_trim_ids(parts, call.workspace.trim_planes.add(call.shapes, row, numbers(), parts))


def _indexed(call: BoundCall, parts: Shapes, row: Rows, head: Head) -> Shapes:
    """Components with their index, total and selector, if the grammar reads them."""
    names = call.workspace.state_names & {"comp.index", "comp.total", "comp.sel"}
    if not names or not call.has_index:
        return parts
    counts = np.bincount(row, minlength=call.shapes.num)
    first = np.cumsum(counts) - counts
    values = {
        "comp.index": (np.arange(len(row)) - first[row]).astype(np.float64),
        "comp.total": counts[row].astype(np.float64),
        "comp.sel": head.text,
    }
    return parts._replace(state={**parts.state, **{name: values[name] for name in names}})


def _to_object(call: BoundCall, shapes: Shapes) -> Floats:
    """[N, 3, 3] from the axes of each shape to those of its model's initial shape."""
    frames = call.workspace.frames
    initial = frames.rotations(call.workspace.roots.frame[shapes.model])
    return np.einsum("nji,njk->nik", initial, frames.rotations(shapes.frame))


def edges_of_faces(call: BoundCall) -> tuple[Shapes, Rows]:
    """Every edge of every face of shapes as a shape in their axes, and its number within its shape."""
    components = _MeshComponents(call, call.shapes, "fe")
    placed = components.shapes_of(np.arange(len(components.row)), "each", aligned=False)
    return call.shapes.parts(*placed[:5]), components.numbers(np.arange(len(components.row)))


_COMPONENTS = BlockOperation(
    comp, frozenset({*_MAKERS, "zUp", "noAlign"}), (1, 2), frozenset({*SELECTORS, *OLDER_SELECTORS})
)
BLOCKS: dict[str, BlockOperation] = {"comp": _COMPONENTS, "modify": _COMPONENTS}
