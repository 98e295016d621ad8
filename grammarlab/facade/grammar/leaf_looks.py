"""Looks of leaves in rules: parts of pictures, and meshes of leaves that are not rectangles.

Meshes are files in the folder of assets, fitted into the box of the leaf: the element itself, and the rest of its box.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from zlib import crc32

import numpy as np
from numpy.typing import NDArray
from shapely import Polygon, box, make_valid
from shapely.geometry.base import BaseGeometry
from shapely.geometry.polygon import orient

from grammarlab.arrays import Floats
from grammarlab.facade.file import store_pictures
from grammarlab.facade.grammar.rule_text import AROUND, leaf_body, number
from grammarlab.facade.looks import THICKNESS, look_of
from grammarlab.facade.tree import LEAF, Facade
from grammarlab.files import write_text
from grammarlab.geometry.meshes.extrude import extrude
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.triangulate import keyhole, triangulate

_SAME_WINDOW = 1e-7
"""Largest difference of the windows of two leaves that show one picture, as a fraction of the picture."""
_MAP_DIGITS = 12
_MIN_AREA = 1e-9
"""Least area of a piece of a box; smaller pieces are left out."""
UPRIGHT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""[3, 3] rotation of prisms over the plane of x and z to that of x and y, with y towards the viewer."""
_MAX_GAP = 1e-9
"""Largest gap between an outline and the sides of its box, as a fraction; larger ones are written as boxes."""
_MESH_DIGITS = 9


@dataclass(frozen=True, slots=True)
class ShownPictures:
    """The picture that each node shows as a whole, as adjacent leaves of one picture do."""

    picture: NDArray[np.int64]
    """[N] index into the pictures of the facade; -1 for nodes with none, or with several."""
    window: Floats
    """[N, 4] left, bottom, right, top of the picture's part on the whole facade, if the picture were continued."""


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
        body = leaf_body(label, pictured=pictured, geometry=f'i("{self.shape.file}")')
        # The area outside of a wall stays empty.
        if self.around is None or look_of(label).is_flexible:
            return body
        low, size = self.around.low.tolist(), self.around.size.tolist()
        move = f"t('{number(low[0], _MESH_DIGITS)}, '{number(low[1], _MESH_DIGITS)}, 0)"
        scope = f"s('{number(size[0], _MESH_DIGITS)}, '{number(size[1], _MESH_DIGITS)}, {number(THICKNESS, 3)})"
        wall = leaf_body("", pictured=pictured, geometry=f'i("{self.around.file}")', scope=scope)
        return f"[ {move} {wall} {AROUND}. ] {body}"


def shown_pictures(facade: Facade) -> ShownPictures:
    """The picture of every node: a node has the picture of its children, if they share one in one position."""
    picture, window = np.where(facade.axis == LEAF, facade.picture, -1), _extended(facade)
    for node in range(len(facade) - 1, -1, -1):
        parts = facade.children[node]
        if not len(parts) or picture[parts[0]] < 0:
            continue
        if (picture[parts] == picture[parts[0]]).all() and np.ptp(window[parts], axis=0).max() <= _SAME_WINDOW:
            picture[node], window[node] = picture[parts[0]], window[parts[0]]
    return ShownPictures(picture, window)


def picture_file(facade: Facade, picture: int) -> str:
    """The file name of a picture in rules."""
    names = [re.sub(r"[^A-Za-z0-9._-]", "_", entry.name).lstrip(".-") for entry in facade.pictures[: picture + 1]]
    return f"{picture}_{names[-1]}" if names[-1] in names[:-1] else names[-1]


def projection(facade: Facade, shows: ShownPictures, node: int) -> str:
    """The operations that set up a picture on a node, for ``projectUV`` below it; empty if it cannot be shown."""
    offset = (facade.position[node] - facade.position[0]) / facade.size[0]
    part = facade.size[node] / facade.size[0]
    low, whole = shows.window[node, :2], shows.window[node, 2:] - shows.window[node, :2]
    projection = window_projection(low + offset * whole, part * whole, _MAP_DIGITS)
    return f'texture("{picture_file(facade, int(shows.picture[node]))}") {projection}' if projection else ""


def window_projection(first: Floats, extent: Floats, digits: int, rectangle: Floats | None = None) -> str:
    """The operation that lays a window of a picture on a rectangle; empty for one that has no area.

    Args:
        first: [2] left and bottom of the window, as parts of the picture.
        extent: [2] width and height of the window.
        digits: decimals of numbers.
        rectangle: [2] width and height of the rectangle, metres, to write metres; else its parts are written, for
            rectangles that are stretched.
    """
    if (np.abs(extent) < _SAME_WINDOW).any():
        return ""
    mark, unit = ("'", np.ones(2)) if rectangle is None else ("", rectangle)
    # The corner of the picture is to the left of the window and below it.
    lengths = [*(unit / extent).tolist(), *(0.0 - first / extent * unit).tolist()]
    return f"setupProjection(0, scope.xy, {', '.join(mark + number(value, digits) for value in lengths)})"


def store_as_assets(facade: Facade, folder: Path) -> None:
    """Write the pictures of a facade into a folder of assets, under their names in rules and scenes.

    Raises:
        FacadeError: If a file of such a name exists with another picture; nothing is written then.
    """
    names = [picture_file(facade, index) for index in range(len(facade.pictures))]
    store_pictures((replace(picture, name=name) for picture, name in zip(facade.pictures, names, strict=True)), folder)


def prisms(outline: Floats) -> tuple[Meshes, Meshes]:
    """Prisms of height 1 over an outline, and over the rest of the unit square.

    Args:
        outline: [P, 2] corners in 0 to 1, v up; parts outside the square are clipped.

    Returns:
        The meshes of the pieces of each, with u along x and v against z, to be rotated by `UPRIGHT`.
    """
    square = box(0.0, 0.0, 1.0, 1.0)
    inside = make_valid(Polygon(outline)).intersection(square)
    return _prisms_over(inside), _prisms_over(square.difference(inside))


def outlined_leaves(facade: Facade) -> dict[int, OutlinedLeaf]:
    """Meshes of each leaf with an outline that reaches all sides of its box; equal ones are shared."""
    leaves: dict[int, OutlinedLeaf] = {}
    by_outline: dict[bytes, OutlinedLeaf | None] = {}
    for leaf in facade.leaves[np.diff(facade.outline_offsets)[facade.leaves] > 0].tolist():
        outline = facade.outline(leaf)
        key = outline.tobytes()
        if key not in by_outline:
            by_outline[key] = outlined_leaf(outline)
        if (leaf_shape := by_outline[key]) is not None:
            leaves[leaf] = leaf_shape
    return leaves


def outlined_leaf(outline: Floats) -> OutlinedLeaf | None:
    """Meshes of a leaf with an outline [P, 2]; None if the outline misses a side of the box."""
    inside, rest = (_mesh_shape(prism) for prism in prisms(outline))
    if inside is None or np.abs([inside.low, inside.size - 1.0]).max() > _MAX_GAP:
        return None
    return OutlinedLeaf(inside, rest)


def store_shapes(leaves: Iterable[OutlinedLeaf], folder: Path) -> None:
    """Write the meshes of leaves into a folder of assets."""
    shapes = {shape.file: shape.text for leaf in leaves for shape in (leaf.shape, leaf.around) if shape is not None}
    for file, text in shapes.items():
        write_text(folder / file, text)


def _extended(facade: Facade) -> Floats:
    """[N, 4] the window of each node, extended from its box to that of the facade."""
    low, size = facade.window[:, :2], facade.window[:, 2:] - facade.window[:, :2]
    scale = size / facade.size
    first = low - (facade.position - facade.position[0]) * scale
    return np.concatenate([first, first + facade.size[0] * scale], axis=1)


def _prisms_over(shape: BaseGeometry) -> Meshes:
    rings = list(_rings(shape))
    if not rings:
        return Meshes.from_polygons(np.zeros((0, 3)), np.zeros(0, dtype=np.int64))
    flat = np.concatenate(rings)
    points = np.column_stack([flat[:, 0], np.zeros(len(flat)), 1.0 - flat[:, 1]])
    return extrude(Meshes.from_polygons(points, np.array([len(ring) for ring in rings])), np.ones(len(rings)))


def _rings(shape: BaseGeometry) -> Iterator[Floats]:
    """[n, 2] one closed walk around each polygon of a shape and its holes."""
    for piece in getattr(shape, "geoms", [shape]):
        if isinstance(piece, Polygon) and piece.area > _MIN_AREA:
            turned = orient(piece)
            rings = [np.asarray(ring.coords)[:-1] for ring in (turned.exterior, *turned.interiors)]
            yield np.concatenate(rings)[keyhole(rings)]


def _mesh_shape(pieces: Meshes) -> Shape | None:
    """Prisms of `prisms` as one mesh in the unit cube, with y up and z to the front; None if there are none."""
    if not len(pieces):
        return None
    points = np.column_stack([pieces.points[:, 0], 1.0 - pieces.points[:, 2], pieces.points[:, 1]])
    low = points.min(axis=0)
    size = np.ptp(points, axis=0)
    lines = [
        f"v {' '.join(number(value, _MESH_DIGITS) for value in point)}" for point in ((points - low) / size).tolist()
    ]
    lines += [f"f {a} {b} {c}" for a, b, c in (triangulate(pieces)[0] + 1).tolist()]
    text = "\n".join(lines) + "\n"
    return Shape(f"outline_{crc32(text.encode()):08x}.obj", text, low[:2], size[:2])
