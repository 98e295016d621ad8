"""Shapes under derivation, as columns: argument and result of every operation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.derivation.strings import StringTable
from grammarlab.errors import DerivationError
from grammarlab.randomness import Keys, fold

Ids = NDArray[np.int32]

EMPTY, BOX, FOOTPRINT, FACE = 0, 1, 2, 3
"""Ids of predefined meshes: nothing, the whole box, the rectangle y = 0 seen from above, the rectangle z = 0 seen
from the front. Positive ids above refer to the table of meshes, negative ones are boxes with other orders of faces
(`box_orders`)."""

Value: TypeAlias = (
    "float | bool | str | NDArray[np.float64] | NDArray[np.bool_] | NDArray[np.int32] | NDArray[np.uint32]"
)
"""Value of an expression for N shapes: one constant for all, or a column [N]. Columns of int32 are string ids, those
of uint32 ids of arrays."""

ARRAY = "whole array"
"""Name of the type of arrays in `kind_of`."""

CHILD_LANE, BLOCK_LANE, SITE_LANE, NUM_LANES = 0, 1, 2, 3
"""Keys below one key: words ``NUM_LANES * i + lane`` for the i-th successor, block and random expression."""


_NO_VECTORS = np.zeros((0, 3))
_NO_IDS = np.zeros(0, dtype=np.int32)


class Shapes(NamedTuple):
    """N shapes to which the same operations are applied.

    Shapes whose geometry nothing reads may be bare: position, size, frame, pivot, mesh and material are then empty.
    """

    node: Ids
    """[N] row in the forest of the shape whose rule is being applied; ascending."""
    model: Ids
    """[N] model, from 0 within the batch."""
    key: Keys | None
    """[N] random key; None if nothing below draws."""
    position: Floats
    """[N, 3] origin of the scope in metres along the world's axes, from the origin of its model."""
    size: Floats
    """[N, 3] size of the scope, metres."""
    frame: Ids
    """[N] orientation, an id of the `FrameTable`."""
    pivot: Ids
    """[N] orientation of the pivot, whose axes the angles of ``r`` are about; an id of the `FrameTable`."""
    mesh: Ids
    """[N] geometry within the unit cube of the scope, an id of the `MeshTable`."""
    material: Ids
    """[N] an id of the `MaterialTable`."""
    state: Mapping[str, Value]
    """Attributes set by rules, and shape attributes such as ``split.index``, if the grammar reads them; ids of
    texture maps (`texture_maps`), if it uses texture coordinates."""
    locals: tuple[Value, ...]
    """Parameters of the rule or function being evaluated."""

    @property
    def num(self) -> int:
        """N."""
        return len(self.node)

    def as_children(self, node: Ids, key: Keys | None, parameters: tuple[Value, ...]) -> Shapes:
        """The same shapes as new nodes, with their own keys and parameters."""
        _, model, _, position, size, frame, pivot, mesh, material, state, _ = self
        return Shapes(
            node=node,
            model=model,
            key=key,
            position=position,
            size=size,
            frame=frame,
            pivot=pivot,
            mesh=mesh,
            material=material,
            state=state,
            locals=parameters,
        )

    def rescoped(self, position: Floats, size: Floats, frame: Ids, mesh: Ids) -> Shapes:
        """The same shapes with another scope and geometry."""
        node, model, key, _, _, _, pivot, _, material, state, parameters = self
        return Shapes(
            node=node,
            model=model,
            key=key,
            position=position,
            size=size,
            frame=frame,
            pivot=pivot,
            mesh=mesh,
            material=material,
            state=state,
            locals=parameters,
        )

    def bare(self) -> Shapes:
        """The same shapes without geometry and material."""
        node, model, key, *_, state, parameters = self
        return Shapes(
            node=node,
            model=model,
            key=key,
            position=_NO_VECTORS,
            size=_NO_VECTORS,
            frame=_NO_IDS,
            pivot=_NO_IDS,
            mesh=_NO_IDS,
            material=_NO_IDS,
            state=state,
            locals=parameters,
        )

    def bare_parts(self, rows: NDArray[np.integer]) -> Shapes:
        """Parts of the shapes at these rows, without geometry and material."""
        return self.bare().parts(rows, _NO_VECTORS, _NO_VECTORS, _NO_IDS, _NO_IDS)

    def resized(self, size: Floats) -> Shapes:
        """The same shapes with scopes of another size."""
        return self.rescoped(self.position, size, self.frame, self.mesh)

    def random_key(self) -> Keys:
        """[N] keys of shapes that draw; the compiler guarantees that they have one."""
        return cast("Keys", self.key)

    def take(self, rows: NDArray[np.integer]) -> Shapes:
        """The shapes at these rows, in any order, repeats allowed."""
        if not len(self.mesh):
            return self.bare_parts(rows)
        return self.parts(
            rows,
            self.position.take(rows, axis=0),
            self.size.take(rows, axis=0),
            self.frame.take(rows),
            self.mesh.take(rows),
        )

    def parts(self, rows: NDArray[np.integer], position: Floats, size: Floats, frame: Ids, mesh: Ids) -> Shapes:
        """Parts of the shapes at these rows, with scopes and geometry of their own."""
        return Shapes(
            node=self.node.take(rows),
            model=self.model.take(rows),
            key=None if self.key is None else self.key.take(rows),
            position=position,
            size=size,
            frame=frame,
            pivot=self.pivot.take(rows) if len(self.pivot) else _NO_IDS,
            mesh=mesh,
            material=self.material.take(rows) if len(self.material) else _NO_IDS,
            state={name: take_value(value, rows) for name, value in self.state.items()} if self.state else self.state,
            locals=tuple([take_value(value, rows) for value in self.locals]) if self.locals else (),
        )


def take_value(value: Value, rows: NDArray[np.integer]) -> Value:
    """A value for the shapes at these rows."""
    return value.take(rows) if isinstance(value, np.ndarray) else value


def number_column(value: Value, count: int) -> Floats:
    """A number as a column [count], from a constant or a column."""
    if isinstance(value, np.ndarray):
        return value.astype(np.float64, copy=False)
    return np.full(count, float(value))


def concatenate(chunks: Sequence[Shapes], strings: StringTable) -> Shapes:
    """All shapes of several chunks, in order.

    Their `state` must have the same names, their `locals` the same length.
    """
    if len(chunks) == 1:
        return chunks[0]
    keys = [chunk.key for chunk in chunks if chunk.key is not None]
    counts = [chunk.num for chunk in chunks]
    return Shapes(
        node=np.concatenate([chunk.node for chunk in chunks]),
        model=np.concatenate([chunk.model for chunk in chunks]),
        key=np.concatenate(keys) if len(keys) == len(chunks) else None,
        position=np.concatenate([chunk.position for chunk in chunks]),
        size=np.concatenate([chunk.size for chunk in chunks]),
        frame=np.concatenate([chunk.frame for chunk in chunks]),
        pivot=np.concatenate([chunk.pivot for chunk in chunks]),
        mesh=np.concatenate([chunk.mesh for chunk in chunks]),
        material=np.concatenate([chunk.material for chunk in chunks]),
        state={name: join_values([chunk.state[name] for chunk in chunks], counts, strings) for name in chunks[0].state},
        locals=tuple(
            join_values(list(values), counts, strings)
            for values in zip(*(chunk.locals for chunk in chunks), strict=True)
        ),
    )


def join_values(values: Sequence[Value], counts: Sequence[int], strings: StringTable) -> Value:
    """One value for concatenated shapes.

    Raises:
        DerivationError: If some are numbers and others strings or booleans.
    """
    first = values[0]
    if not isinstance(first, np.ndarray) and all(type(v) is type(first) and v == first for v in values):
        return first
    columns = [as_column(value, count, strings) for value, count in zip(values, counts, strict=True)]
    if len({column.dtype for column in columns}) > 1:
        kinds = sorted({kind_of(value) for value in values})
        raise DerivationError(f"expected values of one type, found {' and '.join(kinds)}")
    return np.concatenate(columns)


def as_column(value: Value, count: int, strings: StringTable) -> NDArray:
    """A value as a column [count] of float64, bool, string ids or ids of arrays."""
    if isinstance(value, np.ndarray):
        return value
    # Many constants are joined for few shapes each: this is two to three times as fast as np.full.
    column = np.empty(count, dtype=np.int32 if isinstance(value, str) else type(value))
    column.fill(strings.id(value) if isinstance(value, str) else value)
    return column


def kind_of(value: Value) -> str:
    """Name of the type in CGA: ``float``, ``bool`` or ``string``, or `ARRAY`."""
    if isinstance(value, np.ndarray):
        return {"f": "float", "b": "bool", "i": "string", "u": ARRAY}[value.dtype.kind]
    return "bool" if isinstance(value, bool) else "string" if isinstance(value, str) else "float"


def child_keys(key: Keys | None, child: int) -> Keys | None:
    """Keys of the shapes that the successor number ``child`` makes."""
    return None if key is None else fold(key, NUM_LANES * child + CHILD_LANE)


def part_keys(key: Keys | None, block: int, part: NDArray[np.integer]) -> Keys | None:
    """Keys of the parts [N] of the block number ``block``; ``part`` counts the parts of one shape from 0."""
    return None if key is None else fold(fold(key, NUM_LANES * block + BLOCK_LANE), part)
