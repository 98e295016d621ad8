"""Walls with openings of CityGML 2.0 and 3.0 (LoD3): each in its own plane, in metres.

Seen from outside, x points to the right and y up. The name of a wall surface is its `gml:id`, or without one, the id of
the object that it bounds and its number there. Some exporters write wall surfaces with openings and without polygon;
these openings are given to the wall of the same building in whose plane they lie.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
import shapely

from grammarlab.arrays import Floats
from grammarlab.errors import FacadeError, UsageError, shown
from grammarlab.facade.reading.annotation import FARTHEST, BoxAnnotation, annotate
from grammarlab.facade.reading.drawn_shapes import outline_of
from grammarlab.facade.reading.markup import local_name
from grammarlab.facade.reading.source import Source
from grammarlab.xml_text import Node

_Polygon: TypeAlias = list[Floats]
"""Rings [P, 3] without the repeated last corner: the outer one, then holes."""
MOST_POINTS = 10_000_000
"""Largest number of corners of all walls and openings of a file."""
_POLYGONS = ("Polygon", "PolygonPatch", "Rectangle", "Triangle")
_GML_ID = ("{http://www.opengis.net/gml}id", "{http://www.opengis.net/gml/3.2}id", "id")
_HREF = "{http://www.w3.org/1999/xlink}href"
_OPENINGS = {"Window": "window", "Door": "door", "WindowSurface": "window", "DoorSurface": "door"}
_HOLE = "opening"
"""Label of holes in a wall without an opening."""
_MAX_LISTED = 30
"""Largest number of walls in a message."""
_MIN_NORMAL_Z = 0.9
"""Least vertical component of the normal of a surface that is not a wall."""
_MOST_PAIRS = 100_000_000
"""Largest number of pairs of a wall and an opening without one, which bounds the time."""
_MAX_DISTANCE_M = 0.5
"""Largest distance between a wall and its openings, metres."""


def is_citygml(root: Node) -> bool:
    """Whether the outermost element is one of CityGML."""
    return local_name(root) == "CityModel" or any(local_name(node) == "CityModel" for node in root)


def read_citygml(root: Node, source: Source) -> BoxAnnotation:
    """The openings of the wall of a name; it may be left out if there is only one.

    Raises:
        FacadeError: If the file has no walls, or the wall has no vertical plane.
        UsageError: If no wall has that name, or the choice is ambiguous; the message lists the walls.
    """
    wall, walls = source.wall, _walls(root)
    if not walls:
        raise FacadeError("This file has no WallSurface with a polygon.")
    matches = [candidate for candidate in walls if wall in (candidate.name, "")]
    if len(matches) != 1:
        raise UsageError(_listing(walls, wall))
    return _annotation(matches[0])


@dataclass(slots=True)
class _Wall:
    name: str
    building: str
    polygons: list[_Polygon]
    openings: list[_Opening] = field(default_factory=list)


@dataclass(slots=True)
class _Opening:
    label: str
    polygons: list[_Polygon]

    def points(self) -> Floats:
        """[P, 3] corners of all rings."""
        return np.vstack([ring for polygon in self.polygons for ring in polygon])


def _walls(root: Node) -> list[_Wall]:
    """All walls with a polygon, with their openings."""
    polygons_of = _GmlPolygons(root)
    walls: list[_Wall] = []
    orphans: list[tuple[str, _Opening]] = []
    counts: dict[str, int] = {}
    stack = [(root, "")]
    while stack:
        node, inside = stack.pop()
        if local_name(node) == "WallSurface":
            counts[inside] = counts.get(inside, 0) + 1
            name = _identity(node) or f"{inside}/{counts[inside]}"
            openings = _openings(node, polygons_of)
            if polygons := polygons_of.of_element(node, name):
                walls.append(_Wall(name, inside, polygons, openings))
            else:
                orphans += [(inside, opening) for opening in openings]
            continue
        inside = _identity(node) or inside
        stack += [(child, inside) for child in reversed(node)]
    _assign_openings(orphans, walls)
    return walls


class _GmlPolygons:
    """The polygons of a file, read on demand, each time that other elements refer to them.

    Args:
        root: the outermost element.
    """

    def __init__(self, root: Node) -> None:
        self._by_id = {
            _identity(node): node for node in root.iter() if local_name(node) in _POLYGONS and _identity(node)
        }
        self._points_left = MOST_POINTS

    def of_element(self, node: Node, name: str) -> list[_Polygon]:
        """The polygons of a surface or an opening, of its highest level of detail.

        Args:
            node: the element.
            name: name of the element in messages.

        Raises:
            FacadeError: If a ring is not a list of points, or there are too many points.
        """
        levels = [child for child in node if local_name(child)[:3] == "lod"]
        polygons: list[_Polygon] = []
        for part in max(levels, key=local_name).iter() if levels else ():
            polygon = part if local_name(part) in _POLYGONS else self._by_id.get(part.get(_HREF, "").removeprefix("#"))
            if polygon is not None:
                rings = [_ring(ring, name) for ring in polygon.iter() if local_name(ring) == "LinearRing"]
                self._points_left -= sum(map(len, rings))
                if self._points_left < 0:
                    raise FacadeError(f"The walls and openings of this file have more than {MOST_POINTS:,} corners.")
                if rings and len(rings[0]) >= 3:
                    polygons.append([ring for ring in rings if len(ring) >= 3])
        return polygons


def _identity(node: Node) -> str:
    """The `gml:id` of an element, empty without one."""
    return next((node.attrib[key] for key in _GML_ID if key in node.attrib), "")


def _ring(node: Node, name: str) -> Floats:
    texts = [part.text or "" for part in node.iter() if local_name(part) in ("posList", "pos")]
    # GML before 3.2 may separate coordinates by commas.
    texts += [(part.text or "").replace(",", " ") for part in node.iter() if local_name(part) == "coordinates"]
    try:
        values = np.array(" ".join(texts).split(), dtype=np.float64)
    except ValueError as error:
        raise FacadeError(f"{shown(name)}: expected numbers in a ring: {error}.") from error
    if len(values) % 3 or not (np.abs(values) < FARTHEST).all():
        raise FacadeError(f"{shown(name)}: expected finite points of three coordinates in a ring.")
    points = values.reshape(-1, 3)
    closed = len(points) > 1 and (points[0] == points[-1]).all()
    return points[:-1] if closed else points


def _openings(wall: Node, polygons_of: _GmlPolygons) -> list[_Opening]:
    openings = []
    for holder in wall:
        for node in holder if local_name(holder) in ("opening", "fillingSurface") else ():
            label = _OPENINGS.get(local_name(node))
            if label and (polygons := polygons_of.of_element(node, _identity(node) or label)):
                openings.append(_Opening(label, polygons))
    return openings


def _assign_openings(orphans: Sequence[tuple[str, _Opening]], walls: Sequence[_Wall]) -> None:
    """Assigns openings without a wall to the nearest wall of their building in whose plane they lie, if any."""
    if len(orphans) * len(walls) > _MOST_PAIRS:
        raise FacadeError(f"{len(orphans):,} openings belong to none of {len(walls):,} walls: too many to assign.")
    planes = [_plane(wall) for wall in walls] if orphans else []
    flat = [_flat(wall.polygons, *plane) for wall, plane in zip(walls, planes, strict=True)] if orphans else []
    low, high = (np.array([end(corners, axis=0) for corners in flat]).reshape(-1, 2) for end in (np.min, np.max))
    origins = np.array([origin for origin, _ in planes]).reshape(-1, 3)
    axes = np.array([plane_axes for _, plane_axes in planes]).reshape(-1, 3, 3)
    buildings = np.array([wall.building for wall in walls])
    for building, opening in orphans:
        away = np.einsum("wij,wj->wi", axes, opening.points().mean(axis=0) - origins)
        lies_on = np.all((away[:, :2] > low) & (away[:, :2] < high), axis=1) & (buildings == building)
        distance = np.where(lies_on, np.abs(away[:, 2]), np.inf)
        if distance.min(initial=np.inf) < _MAX_DISTANCE_M:
            walls[int(distance.argmin())].openings.append(opening)


def _plane(wall: _Wall) -> tuple[Floats, Floats]:
    """A point [3] of a wall's plane, and unit vectors [3, 3] along x, y and outwards, one per row.

    The normal is the sum over all rings of their area vectors (Newell), which is valid for any polygon.
    """
    origin = wall.polygons[0][0][0]
    normal = np.zeros(3)
    for polygon in wall.polygons:
        ring = polygon[0] - origin
        normal += np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0)
    length = np.linalg.norm(normal)
    if not length > 0.0 or abs(normal[2]) > _MIN_NORMAL_Z * length:
        # No opening lies on such a surface.
        return origin, np.zeros((3, 3))
    normal /= length
    right = np.array([-normal[1], normal[0], 0.0])
    right /= np.linalg.norm(right)
    return origin, np.stack([right, np.cross(normal, right), normal])


def _flat(polygons: Sequence[_Polygon], origin: Floats, axes: Floats) -> Floats:
    """[P, 2] corners of the outer rings, in a plane."""
    return np.vstack([_in_plane(polygon[0], origin, axes) for polygon in polygons])


def _in_plane(ring: Floats, origin: Floats, axes: Floats) -> Floats:
    """[P, 2] corners of a ring, in a plane."""
    return (ring - origin) @ axes[:2].T


def _listing(walls: Sequence[_Wall], wall: str) -> str:
    """A list of the walls, those with most openings first."""
    lines = []
    for wall_entry in sorted(walls, key=lambda wall_entry: -len(wall_entry.openings))[:_MAX_LISTED]:
        across, up = np.ptp(_flat(wall_entry.polygons, *_plane(wall_entry)), axis=0)
        lines.append(f"  {wall_entry.name}  ({across:.1f} x {up:.1f} m, {len(wall_entry.openings)} openings)")
    if len(walls) > _MAX_LISTED:
        lines.append(f"  and {len(walls) - _MAX_LISTED} more")
    head = f"unknown wall {wall!r}" if wall else f"this file has {len(walls)} walls"
    return f"{head}; choose one with `wall=`:\n" + "\n".join(lines)


def _annotation(wall: _Wall) -> BoxAnnotation:
    origin, axes = _plane(wall)
    if not axes.any():
        raise FacadeError(f"The wall {wall.name} has no area, or is horizontal.")
    corners = _flat(wall.polygons, origin, axes)
    bounds = np.stack([corners.min(axis=0), corners.max(axis=0)])
    outlines, names = [], []
    for opening in wall.openings:
        outlines.append(_joined(opening.polygons, origin, axes))
        names.append(opening.label)
    for hole in _holes(wall, origin, axes, outlines):
        outlines.append(hole)
        names.append(_HOLE)
    boxes = np.array([[*outline.min(axis=0), *outline.max(axis=0)] for outline in outlines]).reshape(-1, 4)
    is_on_wall = np.all((boxes[:, :2] < bounds[1]) & (boxes[:, 2:] > bounds[0]), axis=1)
    num_outside = len(boxes) - int(is_on_wall.sum())
    visible = np.flatnonzero(is_on_wall).tolist()
    return annotate(
        boxes[visible],
        [names[index] for index in visible],
        "metres",
        outlines=[outline_of(outlines[index]) for index in visible],
        bounds=bounds,
        wall=outline_of(_joined(wall.polygons, origin, axes)),
        notes=[f"{num_outside} openings outside the wall are left out"] if num_outside else [],
    )


def _joined(polygons: Sequence[_Polygon], origin: Floats, axes: Floats) -> Floats:
    """[P, 2] corners of the union of polygons, seen from outside; of all of them if they are not connected."""
    rings = [shapely.Polygon(_in_plane(polygon[0], origin, axes)) for polygon in polygons]
    union = shapely.unary_union([ring for ring in rings if ring.is_valid and ring.area > 0.0])
    if isinstance(union, shapely.Polygon) and not union.is_empty:
        return shapely.get_coordinates(union.exterior)[:-1]
    corners = _flat(polygons, origin, axes)
    (left, bottom), (right, top) = corners.min(axis=0), corners.max(axis=0)
    return np.array([[left, bottom], [right, bottom], [right, top], [left, top]])


def _holes(wall: _Wall, origin: Floats, axes: Floats, outlines: Sequence[Floats]) -> list[Floats]:
    """Corners of holes of the wall's polygons without an opening."""
    filled = shapely.MultiPoint([outline.mean(axis=0) for outline in outlines])
    holes = []
    for ring in (ring for polygon in wall.polygons for ring in polygon[1:]):
        corners = _in_plane(ring, origin, axes)
        hole = shapely.box(*corners.min(axis=0), *corners.max(axis=0))
        if hole.area > 0.0 and not hole.intersects(filled):
            holes.append(corners)
    return holes
