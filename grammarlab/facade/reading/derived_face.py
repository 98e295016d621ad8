"""One side of a derived building, as labelled boxes."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.derivation.forest import Forest
from grammarlab.errors import FacadeError, UsageError
from grammarlab.facade.reading.annotation import BoxAnnotation, annotate
from grammarlab.scene import TriangleBatch, realize, triangles
from grammarlab.scene.instances import chosen, leaf_order
from grammarlab.scene.triangles import leaf_of_triangle

FACES = {"front": 0.0, "right": 90.0, "back": 180.0, "left": 270.0}
"""Direction of each side of a building: degrees from +z towards +x."""

APART, BESIDE = 1.0, 0.1
"""Distances between separate walls of one side: in depth, and sideways, metres."""
_MIN_COSINE = 0.99
"""Least cosine of the angle between the axes of a shape and those of the side."""
_MIN_FILL = 0.995
"""Least part of its box that a rectangular shape fills."""


@dataclass(frozen=True, slots=True)
class Face:
    """A side of a building."""

    annotation: BoxAnnotation
    """Boxes of the side, metres from the left and the ground."""
    shapes: TriangleBatch
    """The shapes on it, as one model, whose picture from the front fills the wall."""
    azimuth: float
    """Direction of the side, degrees from +z towards +x."""


def face_of(forest: Forest, face: str, parts: Collection[str], picture: str = "") -> Face:
    """The boxes of a side of the first model of a forest.

    The boxes are the shapes that face this side and are connected in its main plane: one box for each shape of a symbol
    of `parts`, with all of its descendants. A shape that leaves a part of its box free has an outline, which is its
    silhouette from the front; so has the wall.

    Args:
        forest: a forest with at least one model.
        face: one of `FACES`; with the suffix ``:1`` the wall with the second most shapes, and so on.
        parts: symbols, with or without the dot of a leaf; all leaves if empty.
        picture: file name of a picture of the side, of the same width and height.

    Raises:
        UsageError: If the side is unknown.
        FacadeError: If there are no shapes on it, or none of these symbols.
    """
    name, _, rank = face.partition(":")
    if name not in FACES or not re.fullmatch("[0-9]{0,6}", rank):
        raise UsageError(f"unknown side {face[:60]!r}; expected one of {', '.join(FACES)}, with :1, :2, … for others.")
    azimuth = np.radians(FACES[name])
    outwards = np.array([np.sin(azimuth), 0.0, np.cos(azimuth)])
    right = np.array([np.cos(azimuth), 0.0, -np.sin(azimuth)])
    on_side = _on_side(forest, outwards, right, int(rank or 0))
    if not on_side.any():
        raise FacadeError(f"this building has no shapes on its side {face}.")
    owner = _owners(forest, parts)
    on_side |= _belongs(forest, owner, on_side, outwards)
    leaf, flat = _projected(forest, right)
    bounds = _bounds(flat[on_side[leaf]])
    boxes, names, outlines = [], [], []
    for node in np.unique(owner[on_side & (owner >= 0)]).tolist():
        points = flat[(owner[leaf] == node) & on_side[leaf]]
        box = _bounds(points)
        if (box[1] > box[0]).all():
            boxes.append(box.ravel())
            names.append(_label(forest.symbols[forest.nodes.symbol[node]]))
            outlines.append(_outline(points, box))
    if parts and not boxes:
        symbols = sorted({forest.symbols[symbol] for symbol in forest.nodes.symbol[forest.leaves.node[on_side]]})
        raise FacadeError(f"this side has no shape of {', '.join(parts)}; its leaves are {', '.join(symbols[:20])}.")
    wall = _outline(flat[on_side[leaf]], bounds)
    if not len(wall):
        wall = np.stack([bounds[[0, 1, 1, 0], 0], bounds[[0, 0, 1, 1], 1]], axis=1)
    annotation = annotate(
        np.array(boxes).reshape(-1, 4), names, "metres", outlines=outlines, bounds=bounds, picture=picture, wall=wall
    )
    scene = realize(forest)
    instances = np.flatnonzero(on_side[leaf_order(forest)])
    return Face(annotation, triangles(chosen(scene, instances)).model(0), FACES[name])


def _on_side(forest: Forest, outwards: Floats, right: Floats, rank: int) -> NDArray[np.bool_]:
    """[L] whether each leaf of the first model is on a side."""
    leaves = forest.leaves
    facing = forest.frames[leaves.frame][:, :, 2] @ outwards > _MIN_COSINE
    facing &= (forest.nodes.model[leaves.node] == 0) & (leaves.size[:, :2] > 0.0).all(axis=1)
    rows = np.flatnonzero(facing)
    depth, start = leaves.position[rows] @ outwards, leaves.position[rows] @ right
    group = _groups(np.zeros(len(rows), dtype=np.int64), depth, depth, APART)
    group = _groups(group, start, start + leaves.size[rows, 0], BESIDE)
    areas = np.bincount(group, weights=leaves.size[rows, 0] * leaves.size[rows, 1])
    on_side = np.zeros(len(leaves), dtype=bool)
    if rank < len(areas):
        on_side[rows[group == np.argsort(-areas, kind="stable")[rank]]] = True
    return on_side


def _groups(group: Ints, low: Floats, high: Floats, gap: float) -> Ints:
    """Groups [N], divided where the intervals, low [N] to high [N], of one group have a gap above this many metres."""
    order = np.lexsort((low, group))
    result = np.empty(len(order), dtype=np.int64)
    number, reach, last = -1, -np.inf, -1
    for row in order.tolist():
        if group[row] != last or low[row] > reach + gap:
            number, reach, last = number + 1, -np.inf, int(group[row])
        reach = max(reach, high[row])
        result[row] = number
    return result


def _belongs(forest: Forest, owner: Ints, on_side: NDArray[np.bool_], outwards: Floats) -> NDArray[np.bool_]:
    """[L] whether a leaf is a thin, rotated part of an object on the side, such as a piece of an arch."""
    leaves = forest.leaves
    thickness = (np.abs(forest.frames[leaves.frame].transpose(0, 2, 1) @ outwards) * leaves.size).sum(axis=1)
    return np.isin(owner, owner[on_side]) & (owner >= 0) & (thickness < APART)


def _owners(forest: Forest, parts: Collection[str]) -> Ints:
    """[L] the first ancestor of each leaf, or the leaf itself, whose symbol is one of the parts; -1 for none."""
    if not parts:
        return forest.leaves.node.astype(np.int64)
    names = {name.rstrip(".") for name in parts}
    those = [index for index, symbol in enumerate(forest.symbols) if symbol.rstrip(".") in names]
    is_part = np.isin(forest.nodes.symbol, those)
    owner = np.where(is_part, np.arange(len(is_part)), -1)
    for node, above in enumerate(forest.nodes.parent.tolist()):  # parents come first
        if above >= 0 and owner[above] >= 0:
            owner[node] = owner[above]
    return owner[forest.leaves.node]


def _projected(forest: Forest, right: Floats) -> tuple[Ints, Floats]:
    """The leaf of each triangle [T], and its corners [T, 3, 2] as seen from the front."""
    batch = triangles(realize(forest))
    corners = batch.vertices[batch.triangles].astype(np.float64)
    return leaf_of_triangle(forest), np.stack([corners @ right, corners[:, :, 1]], axis=-1).round(5)  # 32-bit vertices


def _bounds(corners: Floats) -> Floats:
    """[2, 2] lower left and upper right corner of triangles [T, 3, 2]."""
    flat = corners.reshape(-1, 2)
    return np.stack([flat.min(axis=0), flat.max(axis=0)])


def _outline(corners: Floats, box: Floats) -> Floats:
    """[P, 2] silhouette of triangles [T, 3, 2], anticlockwise; empty if it fills its box, or has several pieces."""
    pieces = np.asarray(shapely.polygons(corners))
    shape = shapely.union_all(pieces[shapely.area(pieces) > 0.0]).simplify(1e-5)
    if not isinstance(shape, shapely.Polygon) or shape.area >= _MIN_FILL * float(np.prod(box[1] - box[0])):
        return np.zeros((0, 2))
    return shapely.get_coordinates(shapely.geometry.polygon.orient(shape).exterior)[:-1]


def _label(symbol: str) -> str:
    """The label of a symbol: `ShopWindow.` is a shop window."""
    words = re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|\d+", symbol)
    return " ".join(words).lower()
