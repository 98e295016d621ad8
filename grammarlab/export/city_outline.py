"""Outline of a building on the map: what its walls enclose, by horizontal sections."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats, row_of_value
from grammarlab.export.city_faces import ROOF_HEIGHT, STEEP, CityFaces
from grammarlab.export.city_surfaces import MILLIMETRES, to_grid
from grammarlab.geometry.meshes.ragged import next_in_row

_ABOVE_PLINTH = 1.3
"""Height in metres of the lowest section above the bottom of the building."""
_SHARE = 0.6
"""Height of the other section as a share of the height of the building: floors may stand out."""
_DETAIL = 1.0
"""Half of the largest width in metres of gaps that are closed and of parts that are removed: windows, bays, piers."""
_GAP = 0.02
"""Length in metres by which walls are longer, so that they meet."""
_SNAP = 0.005
"""Grid in metres of the crossings of walls."""
_SMOOTH = 0.2
"""Largest deviation in metres of the simplified outline."""
_SMALLEST = 4.0
"""Smallest area in square metres of a part, or of a court."""
_SAME = 0.03
"""Largest difference of an outline from its footprint, as a share of its area, that counts as none."""


def ground_outline(faces: CityFaces, footprint: shapely.Polygon, ground: float) -> shapely.Polygon:
    """What the walls of a building enclose; the footprint if they fill it, or enclose nothing.

    Args:
        faces: faces of the building.
        footprint: outline of the lot, in metres from the frame's origin.
        ground: height of the bottom in metres.
    """
    height = faces.points[:, 2].max(initial=0) / MILLIMETRES - ground
    upright = faces.select(np.abs(faces.normal[:, 2]) < STEEP)  # eaves stand out
    sections = [_section(faces, ground + _ABOVE_PLINTH), _section(upright, ground + _SHARE * height)]
    walls = _overlapping(np.concatenate(sections))
    lines = shapely.union_all(shapely.linestrings(walls), grid_size=_SNAP)
    cells = shapely.get_parts(shapely.polygonize([lines]))
    largest = _largest_part(_plain(shapely.coverage_union_all(cells[~_is_open(cells, faces, ground)])))
    if largest is None or not _has_most(largest, walls):
        return footprint
    is_same = shapely.symmetric_difference(largest, footprint).area <= _SAME * footprint.area
    return footprint if is_same else largest


def _has_most(outline: shapely.Polygon, walls: Floats) -> bool:
    """Whether most walls [n, 2, 2] are in or along an outline: if they have gaps, a small part may be the largest."""
    middles, lengths = walls.mean(axis=1), np.hypot(*(walls[:, 1] - walls[:, 0]).T)
    inside = shapely.contains_xy(shapely.buffer(outline, _DETAIL), *middles.T)
    return lengths[inside].sum() >= lengths.sum() / 2


def _section(faces: CityFaces, height: float) -> Floats:
    """[S, 2, 2] segments in metres in which faces cross a height in metres."""
    level = height * MILLIMETRES + 0.5  # never at a point
    rows = faces.faces.rows
    start, end = faces.points[rows], faces.points[rows[next_in_row(faces.faces.offsets)]]
    crosses = np.flatnonzero((start[:, 2] < level) != (end[:, 2] < level))
    start, end = start[crosses], end[crosses]
    share = (level - start[:, 2]) / (end[:, 2] - start[:, 2])
    places = (start[:, :2] + share[:, None] * (end - start)[:, :2]) / MILLIMETRES
    # A convex face crosses a height twice; a concave one more often, along one line.
    face = row_of_value(np.diff(faces.faces.offsets))[crosses]
    along = np.column_stack([-faces.normal[face, 1], faces.normal[face, 0]])
    order = np.lexsort((np.einsum("ij,ij->i", places, along), face))
    return places[order].reshape(-1, 2, 2)


def _overlapping(segments: Floats) -> Floats:
    """The different segments [n, 2, 2] (floors repeat them), longer at both ends, so that walls that touch cross."""
    ends = to_grid(segments)
    backward = (ends[:, 0, 0] > ends[:, 1, 0]) | ((ends[:, 0, 0] == ends[:, 1, 0]) & (ends[:, 0, 1] > ends[:, 1, 1]))
    ends = np.where(backward[:, None, None], ends[:, ::-1], ends).reshape(-1, 4)
    distinct = np.unique(ends, axis=0).reshape(-1, 2, 2) / MILLIMETRES
    along = distinct[:, 1] - distinct[:, 0]
    length = np.hypot(*along.T)
    has_length = length > 0
    longer = along[has_length] / length[has_length, None] * _GAP
    return distinct[has_length] + np.stack([-longer, longer], axis=1)


def _is_open(cells: NDArray[np.object_], faces: CityFaces, ground: float) -> Flags:
    """[n] whether cells [n] are courts or gardens: large, and not below a roof."""
    is_open = shapely.area(cells) > _SMALLEST
    roofs = faces.select((faces.normal[:, 2] > STEEP) & (faces.lowest() > ground + ROOF_HEIGHT)).on_the_map()
    large = np.flatnonzero(is_open)
    below, _ = shapely.STRtree(roofs).query(shapely.point_on_surface(cells[large]), predicate="intersects")
    is_open[large[below]] = False
    return is_open


def _plain(area: shapely.Geometry) -> shapely.Geometry:
    """An area without details: gaps closed, then thin parts removed, then straightened."""
    closed = shapely.buffer(area, _DETAIL, join_style="mitre")
    opened = shapely.buffer(shapely.buffer(closed, -2 * _DETAIL, join_style="mitre"), _DETAIL, join_style="mitre")
    return shapely.simplify(opened, _SMOOTH)


def _largest_part(area: shapely.Geometry) -> shapely.Polygon | None:
    parts = [part for part in shapely.get_parts(area) if isinstance(part, shapely.Polygon) and part.area > _SMALLEST]
    if not parts:
        return None
    largest = max(parts, key=lambda part: part.area)
    courts = [ring for ring in largest.interiors if shapely.Polygon(ring).area > _SMALLEST]
    return shapely.Polygon(largest.exterior, courts)
