"""The operations with a block: what pieces one shape is divided into."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from grammarlab.geometry.meshes.clip import slabs
from grammarlab.language.syntax.syntax_tree import Block, Group, Name, Part
from tests.oracle import splits
from tests.oracle.components import SELECTORS, components, joined_faces, picks
from tests.oracle.expressions import Scope, evaluate
from tests.oracle.operations import argument, extruded
from tests.oracle.shape import AXES, Mesh, Shape, rectangle


@dataclass(frozen=True)
class Piece:
    """A shape that one part of a block is carried out on."""

    part: int
    """Which part of the block, through the text."""
    number: int
    """Which of all pieces of the shape."""
    shape: Shape


def flat_parts(block: Block) -> list[Part]:
    """The parts of a block in the order of the text."""

    def walk(group: Group) -> Iterator[Part]:
        for part in group.parts:
            if isinstance(part, Part):
                yield part
            else:
                yield from walk(part)

    return list(walk(block.group))


def split(block: Block, scope: Scope) -> list[Piece]:
    """``split(axis) { size : … }``: slabs across one axis of the scope."""
    shape = scope.shape
    axis = AXES.index(getattr(block.arguments[0], "identifier", ""))
    numbers = iter(range(len(flat_parts(block))))

    def size(part: Part) -> splits.Size:
        head = argument(part.head, scope)
        return splits.Size(next(numbers), head.length(shape.size[axis]), head.floating)

    def elements(group: Group) -> list[splits.Size | splits.Repeat]:
        result: list[splits.Size | splits.Repeat] = []
        for part in group.parts:
            if isinstance(part, Part):
                result.append(size(part))
            else:
                result += elements(part)
        if group.repeated:
            sizes = [e.sizes if isinstance(e, splits.Repeat) else (e,) for e in result]
            return [splits.Repeat(tuple(size for some in sizes for size in some))]
        return result

    pieces = splits.divide(float(shape.size[axis]), elements(block.group))
    keep_scope = any(getattr(node, "identifier", "") == "noAdjust" for node in block.arguments)
    parts = [(piece.part, slab(shape, axis, piece.start, piece.extent, keep_scope)) for piece in pieces]
    total = float(len(parts))
    return [
        Piece(part, number, with_state(piece, {"split.index": float(number), "split.total": total}))
        for number, (part, piece) in enumerate(parts)
    ]


def with_state(shape: Shape, state: dict) -> Shape:
    return replace(shape, state={**shape.state, **state})


def box(size: np.ndarray) -> Mesh:
    """The solid that fills a scope."""
    return extruded(rectangle(size[0], size[2]), np.array([0.0, size[1], 0.0]))


def lying(size: np.ndarray) -> Mesh:
    return rectangle(size[0], size[2])


def standing(size: np.ndarray) -> Mesh:
    """The rectangle that fills the front of a scope; its first edge is the lower one."""
    corners = [(0.0, 0.0, 0.0), (size[0], 0.0, 0.0), (size[0], size[1], 0.0), (0.0, size[1], 0.0)]
    return Mesh(tuple(np.array(c) for c in corners), ((0, 1, 2, 3),))


def is_same(one: Mesh, other: Mesh) -> bool:
    if [len(face) for face in one.faces] != [len(face) for face in other.faces]:
        return False
    pairs = zip(one.polygons(), other.polygons(), strict=True)
    return all(np.allclose(a, b, rtol=0.0, atol=1e-9) for a, b in pairs)


def slab(shape: Shape, axis: int, start: float, extent: float, keep_scope: bool) -> Shape:
    """What of a shape lies between two planes across an axis. Parts of boxes are boxes, of rectangles rectangles."""
    offset = np.zeros(3)
    offset[axis] = start
    size = shape.size.copy()
    size[axis] = extent
    part = replace(shape.shifted(offset), size=size)
    for whole in (box, lying, standing):
        if is_same(shape.mesh, whole(shape.size)) and (whole, axis) not in ((lying, 1), (standing, 2)):
            return replace(part, mesh=whole(size))
    ends = np.array([start]), np.array([start + extent])
    cut = slabs(shape.mesh.to_columns(), np.array([0]), axis, *ends)
    part = replace(part, mesh=Mesh.from_columns(cut).moved(lambda p: p - offset))
    return part if keep_scope else part.fitted()


def comp(block: Block, scope: Scope) -> list[Piece]:
    """``comp(kind) { selector : … | selector = … }``: each component goes to the first selector that picks it."""
    shape, root = scope.shape, scope.model.root
    kind = getattr(block.arguments[0], "identifier", "")
    found = components(shape, kind)
    free = list(range(len(found)))
    pieces: list[Piece] = []
    for place, part in enumerate(flat_parts(block)):
        if isinstance(part.head, Name) and part.head.identifier in SELECTORS:
            name = part.head.identifier
            taken = [i for i in free if picks(name, found[i], shape, root)]
        else:
            index = evaluate(part.head, scope)
            name = ""
            taken = [i for i in free if index is True or (not isinstance(index, bool) and i == index)]
        free = [i for i in free if i not in taken]
        shapes = [found[i].shape for i in taken]
        if part.inclusive and taken:
            shapes = [joined_faces(shape, taken)]
        for index, selected in enumerate(shapes):
            state = {"comp.index": float(index), "comp.total": float(len(shapes)), "comp.sel": name}
            number = taken[index]
            pieces.append(Piece(place, number, with_state(selected, state)))
    return pieces


BLOCKS: dict[str, Callable[[Block, Scope], list[Piece]]] = {"split": split, "comp": comp}
