"""Boxes of elements on a facade, found or given, and points on their outlines.

Elements are found at holes of the wall and at points off its plane; outlines are the borders of the wall.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import Delaunay, QhullError

from grammarlab.arrays import Flags, Floats, Ints, offsets_from_counts
from grammarlab.errors import FacadeError, TableError
from grammarlab.matching.elements import FARTHEST, MOST_ELEMENTS, Elements
from grammarlab.matching.scans.repetition import borders, completed, overlapping, repeated, visible_part
from grammarlab.matching.scans.wall_cells import DEEP, Cells, cells_of
from grammarlab.tables import Table, TableRow, read_table

_BORDER_RATIO = 0.36
"""Distance of the border from the outermost points of the wall, in point distances: 0.32 to 0.40 in simulated scans."""
_MIN_POINTS = 4
"""Least number of points of a triangulation."""
_MIN_SIDE_M, _MAX_SIDE_M = 0.25, 6.0
"""Least and largest side of an element, metres."""
_MARGIN_M = 0.12
"""Margin of a box around its element, metres."""
_MARGIN_CELLS = 1.5
"""Least margin in cells: a hole may fill a cell less than it covers on each side, and its outline is noisy."""
_MAX_OUTLINE_CELLS = 2
"""Largest distance of an outline from the empty cells of its hole, in cells: corners have cells with a few points."""
_MIN_VISIBLE_SHARE = 0.7
"""Least visible part of the outline of a box that its element fills; one that is joined with a shadow shows less."""
_SIDES = ("left", "bottom", "right", "top")
"""Columns of a table of boxes."""


@dataclass(frozen=True, eq=False)
class FacadePlane:
    """A facade as points."""

    points: Floats
    """[P, 3] points along the facade, up, out of the wall; metres."""
    edges: Floats
    """[Q, 3] points on sharp edges of a mesh; none for a scan."""


@dataclass(frozen=True, eq=False)
class FoundBoxes:
    """Elements of a facade, and the outlines of all of them."""

    box: Floats
    """[N, 4] left, bottom, right, top, metres."""
    outline: Floats
    """[Q, 2] points on the outlines, metres."""
    num_repeated: int
    """Number of boxes at the end that were found by repetition."""
    spacing: float
    """Distance of the points of the scan between which the outlines lie, metres; 0 for edges of a mesh."""


def find_boxes(surface: FacadePlane) -> FoundBoxes:
    """Elements of a facade, found by depth and by repetition.

    By depth: connected parts, larger than 25 cm, with points behind or in front of the wall, or without points, that do
    not touch its border. By repetition: at least four equal shallow parts in rows or columns, and partly hidden
    elements that a row and a column lack.
    """
    cells = cells_of(surface.points)
    shallow = np.asarray(ndimage.binary_closing(cells.raised | cells.sparse, np.ones((3, 3))), dtype=bool)
    off = cells.empty | shallow
    deep, flat = _parts(cells.empty, cells), _parts(shallow, cells)
    outlined = np.array([visible_part(box, off, cells) >= _MIN_VISIBLE_SHARE for box in deep.box], dtype=bool)
    single, ragged = (deep.box[deep.is_element & is_group] for is_group in (outlined, ~outlined))
    is_repeated = repeated(single, cells.side)
    firm, single = single[is_repeated], single[~is_repeated]
    # A shallow part that repeats is more than a fragment of it that is deep.
    others = np.flatnonzero(flat.is_element & ~overlapping(flat.box, firm))
    others = others[repeated(np.vstack([firm, flat.box[others]]), cells.side)[len(firm) :]]
    single = single[~overlapping(single, flat.box[others])]
    detected = np.vstack([firm, single, flat.box[others]])
    aligned, lacking = completed(detected, deep.box[outlined & ~deep.is_element], off, cells)
    ragged = ragged[~overlapping(ragged, np.vstack([flat.box[others], lacking]))]
    num_deep = len(firm) + len(single)
    boxes = np.vstack([aligned[:num_deep], ragged, aligned[num_deep:], lacking])
    boxes += max(_MARGIN_M, _MARGIN_CELLS * cells.side) * np.array([-1.0, -1.0, 1.0, 1.0])
    outline = surface.edges[:, :2]
    if not len(outline):
        is_deep = np.bincount(flat.label.ravel(), weights=cells.empty.ravel()) > 0
        of_flat = np.vstack([flat.box[others], lacking])
        is_deep[flat.number[others]] = False
        outline = np.vstack([_deep_outlines(surface, cells), borders(of_flat, shallow & ~is_deep[flat.label], cells)])
    spacing = 0.0 if len(surface.edges) else cells.spacing
    return FoundBoxes(boxes, outline, len(others) + len(lacking), spacing)


def outlines(wall: Floats, other: Floats, reach: float, is_hole: Callable[[Floats], Flags]) -> Floats:
    """[R, 2] points on the outlines of elements.

    An outline runs halfway between two points that are nearest to each other, of which one is on the wall and one is
    not, and, at holes without points, a little beyond the outermost points of the wall. Other pairs of neighbours are
    left out: they are farther from the outline, and errors of pairs that share a point are not independent. Points off
    the wall that are not connected with a hole are noise.

    Args:
        wall: [P, 2] points of the wall, metres.
        other: [Q, 2] points behind or in front of it.
        reach: largest distance of neighbours on a wall, metres.
        is_hole: whether places [N, 2] are in a hole of the wall; it may miss places near the border of a hole.
    """
    points = np.vstack([wall, other])
    if len(points) < _MIN_POINTS:
        return np.zeros((0, 2))
    # Qhull loses digits far from the origin.
    origin = points.mean(axis=0)
    try:
        net = Delaunay(points - origin)
    except QhullError:  # all points are on one line
        return np.zeros((0, 2))
    simplices = net.simplices.astype(np.int64)
    corners, edge = points[simplices], np.sort(simplices[:, [[1, 2], [2, 0], [0, 1]]], axis=2)
    step = points[edge[..., 1]] - points[edge[..., 0]]
    length = np.linalg.norm(step, axis=2)
    area = np.abs(step[:, 0, 0] * step[:, 1, 1] - step[:, 0, 1] * step[:, 1, 0]) / 2.0
    hollow = length.prod(axis=1) > 4.0 * reach * area
    spacing = np.sqrt(2.0 * area[~hollow].mean()) if not hollow.all() else 0.0
    of_wall = np.arange(len(points)) < len(wall)
    num_wall = of_wall[edge].sum(axis=2)
    near = length < reach
    by_hole = _connected(edge[near & (num_wall == 0)], ~of_wall & is_hole(points))
    across = near & (num_wall == 1) & by_hole[edge].any(axis=2)
    rim = (num_wall == 2) & ~hollow[:, None] & ((net.neighbors < 0) | hollow[net.neighbors])
    middle = points[edge].mean(axis=2)
    normal = np.stack([step[..., 1], -step[..., 0]], axis=2)
    normal *= np.sign(((middle - corners) * normal).sum(axis=2, keepdims=True))
    normal /= np.maximum(np.linalg.norm(normal, axis=2, keepdims=True), 1e-12)
    pairs = _mutual(edge[across], length[across], len(points))
    return np.vstack([points[pairs].mean(axis=1), (middle + _BORDER_RATIO * spacing * normal)[rim]])


def read_boxes(content: bytes) -> Floats:
    """[N, 4] left, bottom, right, top, metres on the facade, from a table of text (`grammarlab.tables`).

    Without a header the columns are in this order; with one they are found by these names, and others are ignored.

    Raises:
        FacadeError: If it is not such a table, or a row is not a box; the message names the line.
    """
    try:
        table = read_table(content, MOST_ELEMENTS + 1)
    except TableError as error:
        raise FacadeError(f"Boxes: {error}") from error
    if not table.rows:
        raise FacadeError(f"Boxes: found none; expected rows of {', '.join(_SIDES)} in metres.")
    has_header = all(table.number(cell) is None for cell in table.header)
    columns = _columns(table) if has_header else tuple(range(len(_SIDES)))
    boxes = [_box(table, row, columns, exact=not has_header) for row in (table.body if has_header else table.rows)]
    if not boxes:
        raise FacadeError(f"Boxes: found none below the header; expected rows of {', '.join(_SIDES)} in metres.")
    if len(boxes) > MOST_ELEMENTS:
        raise FacadeError(f"Boxes: expected at most {MOST_ELEMENTS:,}.")
    return np.array(boxes)


def cut_out(points: Floats, boxes: Floats, spacing: float = 0.0, notes: tuple[str, ...] = ()) -> Elements:
    """The points of each box, with rows and columns from the positions of the boxes; see `Elements` for the rest."""
    order = np.argsort(points[:, 0], kind="stable")
    across = points[order, 0]
    clouds = []
    for low_x, low_y, high_x, high_y in boxes.tolist():
        column_points = points[order[np.searchsorted(across, low_x) : np.searchsorted(across, high_x, side="right")]]
        clouds.append(column_points[(column_points[:, 1] >= low_y) & (column_points[:, 1] <= high_y)])
    middle = (boxes[:, :2] + boxes[:, 2:]) / 2
    size = np.median(boxes[:, 2:] - boxes[:, :2], axis=0)
    return Elements(
        offsets=offsets_from_counts(np.array([len(cloud) for cloud in clouds], dtype=np.int64)),
        points=np.vstack(clouds),
        low=boxes[:, :2],
        high=boxes[:, 2:],
        row=_lines(-middle[:, 1], float(size[1])),
        column=_lines(middle[:, 0], float(size[0])),
        spacing=spacing,
        notes=notes,
    )


def _parts(off: Flags, cells: Cells) -> _Parts:
    """The connected parts of the cells [W, H] that are not part of the wall."""
    label = np.asarray(ndimage.label(off)[0], dtype=np.int64)  # pyright: ignore[reportIndexIssue] its stub forgets the pair
    extents = ndimage.find_objects(label)[: 10 * MOST_ELEMENTS]
    first, last = (
        np.array([[getattr(side, end) for side in extent] for extent in extents]).reshape(-1, 2)
        for end in ("start", "stop")
    )
    size = (last - first) * cells.side
    large = np.flatnonzero((size >= _MIN_SIDE_M).all(axis=1))
    box = np.hstack([cells.low + first * cells.side, cells.low + last * cells.side])
    fits = np.all((first > 0) & (last < np.array(label.shape)) & (size <= _MAX_SIDE_M), axis=1)
    return _Parts(label, large + 1, box[large], fits[large])


@dataclass(frozen=True, eq=False)
class _Parts:
    """Connected parts of a facade that are not part of the wall, larger than 25 cm."""

    label: Ints
    """[W, H] number of the part of each cell; 0 for the wall."""
    number: Ints
    """[N] number of each part."""
    box: Floats
    """[N, 4] left, bottom, right, top, metres."""
    is_element: Flags
    """[N] whether they have the size of an element and do not touch the border."""


def _deep_outlines(surface: FacadePlane, cells: Cells) -> Floats:
    flat, wall = surface.points[:, :2], np.abs(surface.points[:, 2]) < DEEP
    # Points far inside of a hole or of the wall are left out for speed; then even the wall seems to have holes.
    near = _grown(cells.empty, _MAX_OUTLINE_CELLS + 1) & _grown(~cells.empty, _MAX_OUTLINE_CELLS)
    near = near[cells.indices(flat)]
    points = outlines(
        flat[wall & near], flat[~wall & near], cells.side, lambda positions: cells.empty[cells.indices(positions)]
    )
    return points[_grown(cells.empty, _MAX_OUTLINE_CELLS)[cells.indices(points)]]


def _grown(mask: Flags, steps: int) -> Flags:
    """[W, H] cells at most some steps from some of the cells [W, H]."""
    return np.asarray(ndimage.binary_dilation(mask, np.ones((3, 3)), iterations=steps), dtype=bool)


def _connected(links: Ints, is_start: Flags) -> Flags:
    """[N] whether links [L, 2] connect a node with one of the starts [N]."""
    number = len(is_start)
    graph = coo_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(number, number))
    label = connected_components(graph, directed=False)[1]
    return np.isin(label, label[is_start])


def _mutual(pairs: Ints, length: Floats, number: int) -> Ints:
    """[M, 2] the pairs [L, 2] of points that are nearest to each other."""
    shortest = np.full(number, np.inf)
    np.minimum.at(shortest, pairs, length[:, None])
    return np.unique(pairs[(length[:, None] <= shortest[pairs]).all(axis=1)], axis=0)


def _columns(table: Table) -> tuple[int, ...]:
    """Indices of the columns of the sides."""
    missing = [name for name in _SIDES if table.header.count(name) != 1]
    if missing:
        raise FacadeError(
            f"Boxes, line {table.rows[0].line}: expected the columns {', '.join(_SIDES)} once each, or no header; "
            f"check {', '.join(missing)}; found {', '.join(table.header)[:200]}."
        )
    return tuple(table.header.index(name) for name in _SIDES)


def _box(table: Table, row: TableRow, columns: tuple[int, ...], *, exact: bool) -> list[float]:
    """The sides of a box; if exact, the row has no further cells."""
    cells = [row.cells[column] if column < len(row.cells) else "" for column in columns]
    sides = [value for value in map(table.number, cells) if value is not None and abs(value) <= FARTHEST]
    surplus = exact and any(row.cells[len(_SIDES) :])
    if surplus or len(sides) != len(_SIDES) or sides[0] >= sides[2] or sides[1] >= sides[3]:
        raise FacadeError(
            f"Boxes, line {row.line}: expected {', '.join(_SIDES)} in metres with left < right "
            f"and bottom < top, found {list(row.cells[:5])}."
        )
    return sides


def _lines(position: Floats, size: float) -> Ints:
    """[N] index of the line of each, ascending: a new one begins after a gap wider than half an element."""
    order = np.argsort(position, kind="stable")
    number = np.cumsum(np.append(0, np.diff(position[order]) > size / 2))
    index = np.empty(len(position), dtype=np.int64)
    index[order] = number
    return index
