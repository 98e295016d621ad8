"""The operations with a block: what pieces one shape is divided into."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from grammarlab.geometry.meshes.clip import slabs
from grammarlab.geometry.outlines import setback as strips
from grammarlab.geometry.outlines.setback import REMAINDER
from grammarlab.language.syntax.syntax_tree import Block, Group, Name, Part
from tests.oracle import splits
from tests.oracle.components import SELECTORS, Component, components, joined_faces, picks, segment
from tests.oracle.expressions import Scope, evaluate, number
from tests.oracle.operations import argument
from tests.oracle.shape import AXES, Mesh, Shape, Vector
from tests.oracle.streets import borders, remembering
from tests.oracle.trims import planes_of


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


def slab(shape: Shape, axis: int, start: float, extent: float, keep_scope: bool) -> Shape:
    """What of a shape lies between two planes across an axis."""
    offset = np.zeros(3)
    offset[axis] = start
    size = shape.size.copy()
    size[axis] = extent
    part = replace(shape.shifted(offset), size=size)
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
            turns = 0 if isinstance(index, bool) else round(float(index))
            taken = [i for i in free if index is True or (index is not False and i == turns % len(found))]
        free = [i for i in free if i not in taken]
        shapes = [
            replace(found[i].shape, planes=planes_of(shape, i, found[i].shape) if kind == "f" else ()) for i in taken
        ]
        if part.inclusive and taken:
            shapes = [replace(joined_faces(shape, taken), planes=())]
        for index, selected in enumerate(shapes):
            state = {"comp.index": float(index), "comp.total": float(len(shapes)), "comp.sel": name}
            number = taken[index]
            pieces.append(Piece(place, number, with_state(selected, state)))
    return pieces


def setback(block: Block, scope: Scope) -> list[Piece]:
    """``setback(distance) { selector : … | remainder : … }``; the library cuts, the oracle says which edges move."""
    shape, root = scope.shape, scope.model.root
    distance = number(argument(block.arguments[0], scope).value)
    parts = flat_parts(block)
    names = [getattr(part.head, "identifier", "") for part in parts]
    edges = [border for polygon in shape.mesh.polygons() for border in borders(polygon)]
    groups = [REMAINDER] * len(edges)
    for place, name in enumerate(names):
        for i, (a, b, out) in enumerate(edges):
            line = Component(segment(shape, a, b, out), out, is_border=False, kind="fe")
            if groups[i] == REMAINDER and name != "remainder" and picks(name, line, shape, root):
                groups[i] = place
    moved = [0.0 if group == REMAINDER else distance for group in groups]
    cut = strips.setback(shape.mesh.to_columns(), np.full(len(edges), distance), np.array(groups))
    faces = Mesh.from_columns(cut.meshes)
    pieces: list[Piece] = []
    for place, (part, name) in enumerate(zip(parts, names, strict=True)):
        chosen = np.flatnonzero(cut.group == (REMAINDER if name == "remainder" else place)).tolist()
        for some in [chosen] if part.inclusive and chosen else [[face] for face in chosen]:
            polygons = [faces.polygon(face) for face in some]
            piece = replace(shape, mesh=apart(polygons)).fitted()
            pieces.append(Piece(place, some[0], remembering(piece, shape, root, moved, polygons)))
    return pieces


def apart(polygons: list[list[Vector]]) -> Mesh:
    """Faces that share no points, but each may pass the ends of a bridge to a hole twice."""
    points: list[tuple[float, ...]] = []
    faces: list[tuple[int, ...]] = []
    for polygon in polygons:
        visited = [tuple(point.tolist()) for point in polygon]
        own = list(dict.fromkeys(visited))
        faces.append(tuple(len(points) + own.index(point) for point in visited))
        points += own
    return Mesh(tuple(map(np.array, points)), tuple(faces))


BLOCKS: dict[str, Callable[[Block, Scope], list[Piece]]] = {"split": split, "comp": comp, "setback": setback}
