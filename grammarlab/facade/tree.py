"""A facade: a wall divided recursively into rectangles, down to windows, doors and pieces of wall.

Every facade has the total decomposition property: children that are laid out along x fill the width of their parent and
have its height; along y they fill its height and have its width (paper 000, section 3). `check` verifies it; functions
that make a facade call it or keep the property by construction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints, offsets_from_counts
from grammarlab.errors import FacadeError
from grammarlab.facade.grid import Grid

LEAF = -1
X, Y = 0, 1
SHORTEST, LONGEST = 1e-9, 1e6
"""Smallest and largest width or height of a part, metres: areas and ratios of sizes are finite numbers."""
TOLERANCE = 1e-9
"""Largest gap between children and the sides of their parent, as a fraction of the facade's width or height."""


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture of which leaves show parts."""

    name: str
    """File name without folder, such as `front.png`."""
    content: bytes
    """Content of a PNG or JPEG file."""


@dataclass(frozen=True, eq=False)
class Facade:
    """N nodes of a decomposition tree, parents before their children, each subtree contiguous (preorder).

    Children are in the order of their positions: from the left to the right, or from the bottom to the top. A node is
    never divided along the axis of its parent, and never into a single part.

    >>> import grammarlab as gl
    >>> arcade = gl.load_facade(gl.examples_folder() / "facades" / "arcade.json")
    >>> len(arcade), len(arcade.leaves), arcade.width, arcade.height
    (66, 57, 21.0, 12.4)
    """

    parent: Ints
    """[N] parent of each node; -1 for the first."""
    axis: NDArray[np.int8]
    """[N] axis along which its children are laid out: 0 for x, 1 for y; -1 for leaves."""
    position: Floats
    """[N, 2] lower left corner relative to that of the facade, metres; x to the right, y up."""
    size: Floats
    """[N, 2] width and height, metres, > 0."""
    label: Ints
    """[N] index into `labels`; -1 for nodes without a label, such as most inner nodes."""
    labels: tuple[str, ...]
    """Labels: `window`, `wall`, ..."""
    outline_offsets: Ints
    """[N + 1] offsets of the points of each node's outline; no points for rectangles."""
    outline_points: Floats
    """[P, 2] corners, anticlockwise, as fractions of the node's width and height: 0 to 1."""
    pictures: tuple[Picture, ...] = ()
    picture: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """[N] index into `pictures`, -1 for nodes without a picture."""
    window: Floats = field(default_factory=lambda: np.zeros((0, 4)))
    """[N, 4] part of the picture that a leaf shows: left, bottom, right, top as fractions of the picture, v up."""
    grids: tuple[Grid, ...] = ()

    def __len__(self) -> int:
        return len(self.parent)

    @property
    def width(self) -> float:
        """Width, metres."""
        return float(self.size[0, X])

    @property
    def height(self) -> float:
        """Height, metres."""
        return float(self.size[0, Y])

    @cached_property
    def leaves(self) -> Ints:
        """[L] nodes without children, ascending."""
        return np.flatnonzero(self.axis == LEAF)

    @cached_property
    def end(self) -> Ints:
        """[N] the node after the subtree of each: the subtree of i is i, ..., end[i] - 1."""
        end = np.arange(1, len(self) + 1)
        for node in range(len(self) - 1, 0, -1):
            end[self.parent[node]] = max(end[self.parent[node]], end[node])
        return end

    @cached_property
    def children(self) -> tuple[Ints, ...]:
        """[N] children of each node, in their order."""
        order = 1 + np.argsort(self.parent[1:], kind="stable")
        counts = np.bincount(self.parent[1:], minlength=len(self)) if len(self) > 1 else np.zeros(len(self), np.int64)
        return tuple(np.split(order, offsets_from_counts(counts)[1:-1]))

    def outline(self, node: int) -> Floats:
        """[P, 2] corners of a node's outline as fractions of its box; empty for a rectangle."""
        return self.outline_points[self.outline_offsets[node] : self.outline_offsets[node + 1]]

    def name_of(self, node: int) -> str:
        """The label of a node, empty for none."""
        return self.labels[self.label[node]] if self.label[node] >= 0 else ""


def plain(parent: Ints, axis: NDArray[np.int8], position: Floats, size: Floats, names: Sequence[str]) -> Facade:
    """A facade of rectangles, without pictures and grids.

    Args:
        parent: [N] value of `Facade.parent`.
        axis: [N] value of `Facade.axis`.
        position: [N, 2] value of `Facade.position`.
        size: [N, 2] value of `Facade.size`.
        names: [N] label of each node, empty for none.
    """
    labels = tuple(sorted(set(names) - {""}))
    number = {name: index for index, name in enumerate(labels)} | {"": -1}
    return Facade(
        parent=np.asarray(parent, dtype=np.int64),
        axis=np.asarray(axis, dtype=np.int8),
        position=np.asarray(position, dtype=np.float64).reshape(-1, 2),
        size=np.asarray(size, dtype=np.float64).reshape(-1, 2),
        label=np.array([number[name] for name in names], dtype=np.int64),
        labels=labels,
        outline_offsets=np.zeros(len(parent) + 1, dtype=np.int64),
        outline_points=np.zeros((0, 2)),
        picture=np.full(len(parent), -1, dtype=np.int64),
        window=np.tile([0.0, 0.0, 1.0, 1.0], (len(parent), 1)),
    )


def laid_out(parent: Ints, axis: NDArray[np.int8], target: Floats) -> tuple[Floats, Floats]:
    """Positions and sizes [N, 2] of a tree from the target sizes of its leaves.

    Sizes of parts in a row are added, and parts are stretched to the largest one across the row; the result has the
    total decomposition property, as an initial value for the solution of sizes.

    Args:
        parent: [N] value of `Facade.parent`.
        axis: [N] value of `Facade.axis`.
        target: [N, 2] target sizes, metres, > 0; those of inner nodes are ignored.
    """
    size, num_nodes = np.array(target, dtype=np.float64), len(parent)
    size[axis != LEAF] = 0.0
    for node in range(num_nodes - 1, 0, -1):
        above, along = parent[node], axis[parent[node]]
        size[above, along] += size[node, along]
        size[above, 1 - along] = max(size[above, 1 - along], size[node, 1 - along])
    position, stretched, start = np.zeros_like(size), size.copy(), np.zeros(num_nodes)
    for node in range(1, num_nodes):
        above, along = parent[node], axis[parent[node]]
        stretched[node] = stretched[above]
        stretched[node, along] = size[node, along] * stretched[above, along] / size[above, along]
        position[node] = position[above]
        position[node, along] += start[above]
        start[above] += stretched[node, along]
    return position, stretched


def check(facade: Facade) -> Facade:
    """The facade itself, if it is valid.

    Raises:
        FacadeError: If columns disagree, numbers are not finite, sizes are not positive or the total decomposition
            property does not hold; with the node and the error.
    """
    _check_columns(facade)
    _check_tree(facade)
    misses, nodes = decomposition_misses(facade)
    worst = np.unravel_index(int(misses.argmax()), misses.shape) if misses.size else None
    if worst is not None and misses[worst] > TOLERANCE:
        raise FacadeError(
            f"The parts of node {nodes[worst[0]]} miss its {'width' if worst[1] == X else 'height'} by "
            f"{misses[worst]:.3g} of that of the facade; expected at most {TOLERANCE:g}."
        )
    return facade


def decomposition_misses(facade: Facade) -> tuple[Floats, Ints]:
    """[K, 2] largest error of the children of each inner node [K], as a fraction of the facade's size."""
    inner = np.flatnonzero(facade.axis != LEAF)
    if not inner.size:
        return np.zeros((0, 2)), inner
    part = 1 + np.argsort(facade.parent[1:], kind="stable")
    above = facade.parent[part]
    first = np.append(True, above[1:] != above[:-1])
    along = (facade.axis[above, None] == np.arange(2)).astype(bool)
    last = np.roll(first, -1)
    low, size = facade.position[part], facade.size[part]
    low_above, size_above = facade.position[above], facade.size[above]
    # Along its axis, each part begins at the end of the previous one, and the last ends at the end of its parent.
    starts = np.where(along & ~first[:, None], np.roll(low + size, 1, axis=0), low_above)
    ends = np.where(last[:, None], np.abs(low + size - low_above - size_above), 0.0)
    misses = np.maximum(np.abs(low - starts), np.where(along, ends, np.abs(size - size_above)))
    return np.maximum.reduceat(misses, np.flatnonzero(first)) / facade.size[0], inner


def _check_columns(facade: Facade) -> None:
    num_nodes = len(facade)
    shapes = {
        "axis": (num_nodes,),
        "position": (num_nodes, 2),
        "size": (num_nodes, 2),
        "label": (num_nodes,),
        "outline_offsets": (num_nodes + 1,),
        "picture": (num_nodes,),
        "window": (num_nodes, 4),
    }
    for name, shape in shapes.items():
        if getattr(facade, name).shape != shape:
            raise FacadeError(f"Column {name}: expected shape {shape}, found {getattr(facade, name).shape}.")
    if not num_nodes:
        raise FacadeError("A facade needs at least one node, found none.")
    for name in ("position", "size", "outline_points", "window"):
        if not np.isfinite(getattr(facade, name)).all():
            raise FacadeError(f"Column {name}: expected finite numbers.")
    outside = np.flatnonzero(((facade.size < SHORTEST) | (facade.size > LONGEST)).any(axis=1))
    if outside.size:
        raise FacadeError(
            f"Node {outside[0]}: expected a width and height above 0, from {SHORTEST:g} to {LONGEST:,.0f} m, found "
            f"{facade.size[outside[0]].tolist()}."
        )
    for name, limit in (("label", len(facade.labels)), ("picture", len(facade.pictures))):
        column = getattr(facade, name)
        if ((column < -1) | (column >= limit)).any():
            raise FacadeError(f"Column {name}: expected indices below {limit}, or -1, found {column.max()}.")


def _check_tree(facade: Facade) -> None:
    parent, axis = facade.parent, facade.axis
    if parent[0] != -1 or (parent[1:] < 0).any() or (parent[1:] >= np.arange(1, len(facade))).any():
        raise FacadeError("Column parent: expected -1 for the first node and earlier nodes for all others.")
    # In preorder, the parent of a node is the node before it or an ancestor of that.
    ancestors: list[int] = []
    for node, above in enumerate(parent.tolist()):
        while ancestors and ancestors[-1] != above:
            ancestors.pop()
        if node and not ancestors:
            raise FacadeError(f"Node {node}: the subtree of node {above} is not contiguous.")
        ancestors.append(node)
    counts = np.bincount(parent[1:], minlength=len(facade))
    wrong = np.flatnonzero(np.where(axis == LEAF, counts != 0, counts < 2) | ~np.isin(axis, (LEAF, X, Y)))
    if wrong.size:
        raise FacadeError(f"Node {wrong[0]}: axis {axis[wrong[0]]} with {counts[wrong[0]]} parts.")
    same_axis = 1 + np.flatnonzero((axis[1:] != LEAF) & (axis[1:] == axis[parent[1:]]))
    if same_axis.size:
        raise FacadeError(f"Node {same_axis[0]} is divided along the same axis as its parent {parent[same_axis[0]]}.")
