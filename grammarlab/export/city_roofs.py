"""Roofs of a building seen from above: its outline divided by the highest large planes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from grammarlab.arrays import Floats, Ints, connected, row_of_value
from grammarlab.export.city_faces import ROOF_HEIGHT, STEEP, CityFaces
from grammarlab.export.city_surfaces import MILLIMETRES, to_grid
from grammarlab.geometry.meshes.ragged import all_rows

_GRID = 1 / MILLIMETRES
_MOST_PLANES = 48
"""Largest number of planes of a building."""
_THICKNESS = 0.02
"""Largest vertical distance in metres of corners from the plane of their roof."""
_HALF_WIDTH = 0.5
"""Half of the smallest width in metres of a roof: parapets, chimneys and sills are none."""
_SMALLEST = 3.0
"""Smallest area in square metres of a roof."""
_RIM = 0.7
"""Largest width in metres of a rim without a roof, such as a parapet, that belongs to the roof along it."""
_STRAIGHT = 0.02
"""Largest deviation in metres of straightened lines between roofs."""
_ROUNDS = 8
"""Largest number of times that small parts are given to their neighbours."""
_NONE = -1
Cells = NDArray[np.object_]
"""Polygons that share the points of their common edges."""


@dataclass(frozen=True, slots=True, eq=False)
class RoofPlane:
    """Heights ``slope @ (east, north) + level`` over an area."""

    slope: Floats
    """[2] rise per metre to the east and to the north."""
    level: float
    """Height in metres at the origin."""
    area: BaseGeometry
    """Where faces of the plane are, in metres."""

    def height(self, places: Floats) -> Floats:
        """[n] heights in metres at places [n, 2]."""
        return places @ self.slope + self.level


@dataclass(frozen=True, slots=True, eq=False)
class RoofMap:
    """The outline of a building divided into roofs."""

    regions: Sequence[shapely.Polygon]
    """Polygons on a grid of millimetres that fill the outline and share the points of their common edges."""
    planes: Sequence[RoofPlane]
    """The plane of each region."""


def roof_map(faces: CityFaces, outline: shapely.Polygon, ground: float) -> RoofMap | None:
    """The roofs over an outline.

    Places without a large roof, such as parapets and chimneys, have the plane of a roof beside them.

    Args:
        faces: faces of the building.
        outline: metres from the origin of the frame.
        ground: height of the bottom in metres.

    Returns:
        The roofs; None if there is none.
    """
    planes = _planes(faces, outline, ground)
    if not planes:
        return None
    cells = _cells([outline.boundary, *(plane.area.boundary for plane in planes)], outline)
    cells, plane = _with_rims(cells, _highest(cells, planes), planes, outline)
    shared = _shared_edges(cells)
    plane = _with_neighbours(cells, plane, shared)
    if (plane == _NONE).any():
        return None
    parts = _parts(plane, shared)
    regions = _straightened([shapely.coverage_union_all(cells[part]) for part in parts])
    polygons = [region for region in regions if isinstance(region, shapely.Polygon)]
    return RoofMap(polygons, [planes[plane[part[0]]] for part in parts]) if len(polygons) == len(parts) else None


def _planes(faces: CityFaces, outline: shapely.Polygon, ground: float) -> list[RoofPlane]:
    """The planes of large roofs above an outline, the largest first."""
    high = faces.select((faces.normal[:, 2] > STEEP) & (faces.lowest() > ground + ROOF_HEIGHT))
    offsets, corners = high.faces.offsets, high.points[high.faces.rows] / MILLIMETRES
    parts = shapely.intersection(high.on_the_map(), outline)
    rest = plan_area = shapely.area(parts)
    planes = []
    for _ in range(_MOST_PLANES):
        if rest.sum() < _SMALLEST:
            break
        largest = int(np.argmax(rest))
        slope = -high.normal[largest, :2] / high.normal[largest, 2]
        level = float(corners[offsets[largest], 2] - corners[offsets[largest], :2] @ slope)
        is_near = np.abs(corners[:, :2] @ slope + level - corners[:, 2]) <= _THICKNESS
        members = (rest > 0) & all_rows(is_near, offsets)
        rest = np.where(members, 0.0, rest)
        if plan_area[members].sum() >= _SMALLEST:
            area = _areas(shapely.union_all(shapely.buffer(parts[members], 0.0), grid_size=_GRID))
            if _is_large(area):
                planes.append(RoofPlane(slope, level, area))
    return planes


def _cells(lines: Sequence[shapely.Geometry], outline: shapely.Polygon) -> Cells:
    """The cells inside an outline into which lines divide it."""
    cells = shapely.get_parts(shapely.polygonize([shapely.union_all(lines, grid_size=_GRID)]))
    return cells[shapely.intersects(outline, shapely.point_on_surface(cells))]


def _highest(cells: Cells, planes: Sequence[RoofPlane]) -> Ints:
    """[n] the highest plane over each cell; `_NONE` if there is none."""
    middles = shapely.point_on_surface(cells)
    heights = np.full((len(planes), len(cells)), -np.inf)
    for index, plane in enumerate(planes):
        over = shapely.intersects(plane.area, middles)
        heights[index, over] = plane.height(shapely.get_coordinates(middles[over]))
    return np.where(np.isinf(heights.max(axis=0)), _NONE, heights.argmax(axis=0))


def _with_rims(cells: Cells, plane: Ints, planes: Sequence[RoofPlane], outline: shapely.Polygon) -> tuple[Cells, Ints]:
    """The cells with their planes, after those without one are divided among the roofs along them."""
    bare = shapely.union_all(cells[plane == _NONE], grid_size=_GRID)
    if bare.is_empty:
        return cells, plane
    roofs = [
        (index, shapely.union_all(cells[plane == index], grid_size=_GRID)) for index in np.unique(plane[plane >= 0])
    ]
    roofs.sort(key=lambda roof: -planes[roof[0]].height(shapely.get_coordinates(shapely.centroid(roof[1])))[0])
    rims, owner = [], []
    for index, area in roofs:
        reach = shapely.buffer(area, _RIM, join_style="bevel")
        rims.append(_areas(shapely.intersection(bare, reach, grid_size=_GRID)))
        owner.append(index)
        bare = _areas(shapely.difference(bare, reach, grid_size=_GRID))
    areas = np.array([*cells[plane >= 0], *rims], dtype=object)
    planes_of_areas = np.array([*plane[plane >= 0], *owner])
    divided = _cells([outline.boundary, *shapely.boundary(areas)], outline)
    pairs = shapely.STRtree(areas).query(shapely.point_on_surface(divided), predicate="intersects")
    result = np.full(len(divided), _NONE)
    result[pairs[0][::-1]] = planes_of_areas[pairs[1][::-1]]
    return divided, result


def _with_neighbours(cells: Cells, plane: Ints, shared: _SharedEdges) -> Ints:
    """The planes, after small parts and those without a plane have that of the longest edge to a large part."""
    plane = plane.copy()
    for _ in range(_ROUNDS):
        parts = _parts(plane, shared)
        number = np.empty(len(cells), np.int64)
        number[np.concatenate(parts)] = row_of_value(np.array([len(part) for part in parts]))
        is_small = np.array([not _is_large(shapely.coverage_union_all(cells[part])) for part in parts])
        is_small |= np.array([plane[part[0]] == _NONE for part in parts])
        outer = is_small[number[shared.one]] & ~is_small[number[shared.other]]
        if not outer.any():
            break
        lengths = np.zeros((len(parts), plane.max() + 1))
        np.add.at(lengths, (number[shared.one[outer]], plane[shared.other[outer]]), shared.length[outer])
        for index in np.flatnonzero(lengths.max(axis=1) > 0):
            plane[parts[index]] = lengths[index].argmax()
    return plane


def _straightened(regions: Sequence[BaseGeometry]) -> Sequence[BaseGeometry]:
    """The regions without points along their common lines that are not needed; as they were if one would be lost."""
    edges = shapely.union_all([region.boundary for region in regions], grid_size=_GRID)
    lines = shapely.simplify(shapely.get_parts(shapely.line_merge(edges)), _STRAIGHT)
    cells = shapely.get_parts(shapely.polygonize([shapely.union_all(lines, grid_size=_GRID)]))
    owner, cell = shapely.STRtree(cells).query(shapely.point_on_surface(regions), predicate="intersects")
    # A cell that is a court belongs to no region.
    is_one_each = np.array_equal(owner, np.arange(len(regions))) and len(np.unique(cell)) == len(regions)
    return cells[cell].tolist() if is_one_each else regions


def _areas(geometry: BaseGeometry) -> BaseGeometry:
    """A geometry without its points and lines."""
    return shapely.MultiPolygon([part for part in shapely.get_parts(geometry) if isinstance(part, shapely.Polygon)])


def _is_large(area: BaseGeometry) -> bool:
    return area.area >= _SMALLEST and not shapely.buffer(area, -_HALF_WIDTH).is_empty


@dataclass(frozen=True, slots=True, eq=False)
class _SharedEdges:
    """E edges between two cells, once in each direction."""

    one: Ints
    """[E] a cell."""
    other: Ints
    """[E] the cell on the other side."""
    length: Floats
    """[E] millimetres."""


def _shared_edges(cells: Cells) -> _SharedEdges:
    rings, of_cell = shapely.get_rings(cells, return_index=True)
    coordinates, ring = shapely.get_coordinates(rings, return_index=True)
    points = to_grid(coordinates)
    first = np.flatnonzero(ring[1:] == ring[:-1])
    ends = np.stack([points[first], points[first + 1]], axis=1)
    forward = (ends[:, 0, 0] < ends[:, 1, 0]) | ((ends[:, 0, 0] == ends[:, 1, 0]) & (ends[:, 0, 1] < ends[:, 1, 1]))
    ends = np.where(forward[:, None, None], ends, ends[:, ::-1])
    order = np.lexsort(ends.reshape(-1, 4).T)
    twice = np.flatnonzero((ends[order[1:]] == ends[order[:-1]]).all(axis=(1, 2)))
    one, other = of_cell[ring[first]][order[twice]], of_cell[ring[first]][order[twice + 1]]
    length = np.hypot(*(ends[order[twice], 1] - ends[order[twice], 0]).T)
    return _SharedEdges(np.append(one, other), np.append(other, one), np.tile(length, 2))


def _parts(plane: Ints, shared: _SharedEdges) -> list[Ints]:
    """The cells of each connected part of one plane, in the order of their first cells."""
    within = plane[shared.one] == plane[shared.other]
    number = connected(len(plane), shared.one[within], shared.other[within])
    order = np.argsort(number, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(number[order])) + 1)
