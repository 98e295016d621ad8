"""Leaves that are not rectangles as rules: meshes in the folder of assets, fitted into the box of the leaf."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from zlib import crc32

import numpy as np

from grammarlab.facade.looks import THICKNESS, look_of
from grammarlab.facade.prisms import prisms
from grammarlab.facade.tree import Facade, Floats
from grammarlab.facade.writing.rule_text import AROUND, leaf_body, number
from grammarlab.files import write_text
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.triangulate import triangulate

_WHOLE = 1e-9
"""Largest gap between an outline and the sides of its box, as a fraction; larger ones are written as boxes."""
_DIGITS = 9


@dataclass(frozen=True, slots=True)
class Shape:
    """A mesh, and the part of a leaf's box that it fills."""

    file: str
    """File name in the folder of assets, derived from its content."""
    text: str
    """OBJ text."""
    low: Floats
    """[2] left and bottom, as fractions of the box."""
    size: Floats
    """[2] width and height, as fractions of the box."""


@dataclass(frozen=True, slots=True)
class OutlinedLeaf:
    """Meshes of a leaf with an outline."""

    shape: Shape
    around: Shape | None
    """The rest of the box around the outline; None for no rest."""

    def body(self, label: str, *, pictured: bool) -> str:
        """CGA that makes the leaf from a rectangle, and the wall around it."""
        body = leaf_body(label, pictured=pictured, made=f'i("{self.shape.file}")')
        # The area outside of a wall stays empty.
        if self.around is None or look_of(label).gives:
            return body
        low, size = self.around.low.tolist(), self.around.size.tolist()
        place = f"t('{number(low[0], _DIGITS)}, '{number(low[1], _DIGITS)}, 0)"
        scope = f"s('{number(size[0], _DIGITS)}, '{number(size[1], _DIGITS)}, {number(THICKNESS, 3)})"
        wall = leaf_body("", pictured=pictured, made=f'i("{self.around.file}")', scope=scope)
        return f"[ {place} {wall} {AROUND}. ] {body}"


def outlined_leaves(facade: Facade) -> dict[int, OutlinedLeaf]:
    """Meshes of each leaf with an outline that reaches all sides of its box; equal ones are shared."""
    found: dict[int, OutlinedLeaf] = {}
    made: dict[bytes, OutlinedLeaf | None] = {}
    for leaf in facade.leaves[np.diff(facade.outline_offsets)[facade.leaves] > 0].tolist():
        outline = facade.outline(leaf)
        key = outline.tobytes()
        if key not in made:
            made[key] = outlined_leaf(outline)
        if (one := made[key]) is not None:
            found[leaf] = one
    return found


def outlined_leaf(outline: Floats) -> OutlinedLeaf | None:
    """What a leaf with an outline [P, 2] is made of; None if the outline misses a side of the box."""
    inside, rest = (_shape(each) for each in prisms(outline))
    if inside is None or np.abs([inside.low, inside.size - 1.0]).max() > _WHOLE:
        return None
    return OutlinedLeaf(inside, rest)


def store_shapes(leaves: Iterable[OutlinedLeaf], folder: Path) -> None:
    """Write the meshes of leaves into a folder of assets."""
    shapes = {each.file: each.text for leaf in leaves for each in (leaf.shape, leaf.around) if each is not None}
    for file, text in shapes.items():
        write_text(folder / file, text)


def _shape(pieces: Meshes) -> Shape | None:
    """Prisms of `prisms` as one mesh in the unit cube, with y up and z to the front; None if there are none."""
    if not len(pieces):
        return None
    points = np.column_stack([pieces.points[:, 0], 1.0 - pieces.points[:, 2], pieces.points[:, 1]])
    low = points.min(axis=0)
    size = np.ptp(points, axis=0)
    lines = [f"v {' '.join(number(value, _DIGITS) for value in point)}" for point in ((points - low) / size).tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (triangulate(pieces)[0] + 1).tolist()]
    text = "\n".join(lines) + "\n"
    return Shape(f"outline_{crc32(text.encode()):08x}.obj", text, low[:2], size[:2])
