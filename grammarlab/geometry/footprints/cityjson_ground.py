"""Footprints of CityJSON objects: where they stand on the ground.

The outline of an object is the union of its ground surfaces and of those of its parts, seen from above, in the finest
level of detail that has any. Objects without them have their lowest faces instead.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from grammarlab.arrays import Floats
from grammarlab.errors import AssetError, UsageError
from grammarlab.files import open_regular, read_bounded
from grammarlab.geometry.footprints.attribute_columns import NOT_USED, columns_of, united
from grammarlab.geometry.footprints.footprint import Remark
from grammarlab.geometry.footprints.geojson_features import well_formed
from grammarlab.geometry.footprints.map_layer import MAX_FEATURES, MAX_MAP_BYTES, MapLayer, bodies_of
from grammarlab.printable import printable

_MAX_FILE_BYTES = 256 << 20
"""Largest size of a CityJSON file, which is read as a whole."""
_MAX_LINE_BYTES = 16 << 20
"""Longest line of a CityJSON text sequence."""
_MAX_FACES = 100_000
"""Largest number of faces of an object."""
_MAX_PARTS = 1_000
"""Largest number of objects in an object."""
_BLOCK = 8192
"""Objects whose geometries are kept together."""
_STEP = 0.5
"""Units of height above the lowest face up to which faces count as lowest."""
_MIN_SLOPE = np.cos(np.radians(30.0))
"""Smallest vertical part of the normal of a face that may be on the ground."""
_SOLID_DEPTH = {"MultiSurface": 0, "CompositeSurface": 0, "Solid": 1, "MultiSolid": 2, "CompositeSolid": 2}
"""How many lists are around the lists of surfaces in the boundaries of a geometry."""
_GROUND = "GroundSurface"
_PREFERRED = ("Building", "LandUse")
"""Kinds of objects that are read if no layer is named, and if a file has several."""
ID = "id"


@dataclass(frozen=True, slots=True)
class _Face:
    """One flat surface."""

    rings: list[Floats]
    """The outline and its holes, each [n, 3]."""
    is_ground: bool

    @property
    def lowest(self) -> float:
        return float(self.rings[0][:, 2].min())

    @property
    def is_level(self) -> bool:
        """Whether it is not steeper than 30 degrees."""
        ring = self.rings[0] - self.rings[0][0]
        normal = np.cross(ring[1:-1], ring[2:]).sum(axis=0)
        length = float(np.linalg.norm(normal))
        return length > 0 and abs(float(normal[2])) >= _MIN_SLOPE * length


class _Reading:
    """What has been read of a file.

    Args:
        path: the file.
        kind: type of the objects that are read.
    """

    def __init__(self, path: Path, kind: str) -> None:
        self.path = path
        self.kind = kind
        self.ids: list[str] = []
        self.geometry: list[shapely.Geometry | None] = []
        self.attributes: list[Mapping[str, Any]] = []
        self.num_damaged = 0

    def add(self, objects: Mapping[str, Any], vertices: Floats) -> None:
        """Add the outermost objects of the kind."""
        for name, value in objects.items():
            if not isinstance(value, dict) or value.get("parents") or value.get("type") != self.kind:
                continue
            if len(self.ids) == MAX_FEATURES:
                raise AssetError(f"{self.path}: expected at most {MAX_FEATURES:,} objects. Cut out a smaller area.")
            attributes = value.get("attributes")
            self.ids.append(well_formed(name))
            self.attributes.append(attributes if isinstance(attributes, dict) else {})
            self.geometry.append(_outline(_family(name, objects), vertices))


def read_cityjson_layer(path: Path, layer: str | None = None) -> MapLayer:
    """The footprints of the objects of a CityJSON file or text sequence, with their ids as attribute ``id``.

    Args:
        path: a file; ``.jsonl`` has a feature a line.
        layer: type of the objects, ``Building`` or ``LandUse``; None for one that is there.

    Raises:
        AssetError: If the file is broken or too large.
        UsageError: If it has no objects of this type.
    """
    try:
        if path.suffix.lower() == ".jsonl":
            return _read_sequence(path, layer)
        document = json.loads(read_bounded(path, _MAX_FILE_BYTES))
        objects, vertices = _objects(document), _vertices(document, document)
    except (KeyError, TypeError, ValueError, RecursionError) as error:
        raise AssetError(f"{path}: expected CityJSON, but it is broken: {printable(repr(error))[:200]}.") from error
    reading = _Reading(path, _kind_of_objects(path, [objects], layer))
    reading.add(objects, vertices)
    return _layer(reading, document)


def _read_sequence(path: Path, layer: str | None) -> MapLayer:
    """The footprints of a CityJSON text sequence."""
    with open_regular(path, MAX_MAP_BYTES) as file:
        header = json.loads(file.readline(_MAX_LINE_BYTES))
    if not isinstance(header, dict):
        raise TypeError("expected an object in its first line")
    groups = (feature.get("CityObjects") for feature in _features(path) if isinstance(feature, dict))
    reading = _Reading(path, _kind_of_objects(path, groups, layer))
    for feature in _features(path):
        try:
            reading.add(_objects(feature), _vertices(feature, header))
        except (KeyError, TypeError, ValueError):
            reading.num_damaged += 1
    return _layer(reading, header)


def _features(path: Path) -> Iterator[Any]:
    """The values of the lines of a text sequence behind the first one, None for those that are not JSON.

    Raises:
        AssetError: If a line is too long.
    """
    with open_regular(path, MAX_MAP_BYTES) as file:
        file.readline(_MAX_LINE_BYTES)
        while line := file.readline(_MAX_LINE_BYTES + 1):
            if len(line) > _MAX_LINE_BYTES:
                raise AssetError(f"{path}: expected lines of at most {_MAX_LINE_BYTES:,} bytes.")
            if not line.strip():
                continue
            try:
                yield json.loads(line)
            except (ValueError, RecursionError):
                yield None


def _objects(document: Any) -> Mapping[str, Any]:
    objects = document.get("CityObjects") if isinstance(document, dict) else None
    if not isinstance(objects, dict):
        raise TypeError("expected an object under 'CityObjects'")
    return objects


def _kind_of_objects(path: Path, groups: Iterable[Any], layer: str | None) -> str:
    """The kind of objects to read.

    Args:
        path: the file, for messages.
        groups: objects by name, of the whole file or of each feature.
        layer: name of the kind, if any.

    Raises:
        UsageError: If there is none of this name, or several without a preferred one.
        AssetError: If there are no objects.
    """
    outermost = {
        value["type"]
        for objects in groups
        for value in (objects.values() if isinstance(objects, dict) else ())
        if isinstance(value, dict) and isinstance(value.get("type"), str) and not value.get("parents")
    }
    kinds = sorted(outermost)
    if not kinds:
        raise AssetError(f"{path}: expected city objects, found none.")
    listing = ", ".join(printable(kind)[:60] for kind in kinds[:20])
    if layer is None:
        preferred = [kind for kind in _PREFERRED if kind in kinds]
        if preferred or len(kinds) == 1:
            return (preferred or kinds)[0]
        raise UsageError(f"{path}: expected objects of one type, found {listing}. Name one: {path.name}:TYPE")
    if layer not in kinds:
        raise UsageError(f"{path}: no objects of type {layer[:80]!r}; its types are {listing}.")
    return layer


def _vertices(document: Mapping[str, Any], header: Mapping[str, Any]) -> Floats:
    """[V, 3] points of a document, by the transform of its header."""
    points = np.array(document.get("vertices") or np.empty((0, 3)), dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError("expected vertices of three numbers")
    transform = header.get("transform")
    if isinstance(transform, dict):
        scale, translate = (np.array(transform[name], dtype=np.float64) for name in ("scale", "translate"))
        if scale.shape != (3,) or translate.shape != (3,):
            raise ValueError("expected three numbers of a transform")
        points = points * scale + translate
    return points


def _family(name: str, objects: Mapping[str, Any]) -> list[Any]:
    """The geometries of an object and of its parts, at most so many."""
    geometries: list[Any] = []
    names, seen = [name], {name}
    while names and len(seen) <= _MAX_PARTS:
        value = objects.get(names.pop())
        if not isinstance(value, dict):
            continue
        geometry, children = value.get("geometry"), value.get("children")
        geometries += geometry if isinstance(geometry, list) else []
        for child in children if isinstance(children, list) else ():
            if isinstance(child, str) and child not in seen:
                seen.add(child)
                names.append(child)
    return geometries


def _outline(geometries: Sequence[Any], vertices: Floats) -> shapely.Geometry | None:
    """Where geometries stand on the ground, with the height of the lowest point; None if they have no faces."""
    levels: dict[float, list[_Face]] = {}
    num_faces = 0
    for geometry in geometries:
        level = _level(geometry)
        for face in _faces(geometry, vertices):
            num_faces += 1
            if num_faces > _MAX_FACES:
                return None
            levels.setdefault(level, []).append(face)
    for level in sorted(levels, reverse=True):
        ground = [face for face in levels[level] if face.is_ground]
        if ground:
            return _union(ground)
    if not levels:
        return None
    faces = levels[min(levels)] if min(levels) < 1.0 else levels[max(levels)]
    faces = [face for face in faces if face.is_level]
    lowest = min((face.lowest for face in faces), default=0.0)
    return _union([face for face in faces if face.lowest <= lowest + _STEP])


def _union(faces: Sequence[_Face]) -> shapely.Geometry | None:
    if not faces:
        return None
    polygons = [shapely.Polygon(face.rings[0][:, :2], [ring[:, :2] for ring in face.rings[1:]]) for face in faces]
    shape = polygons[0] if len(polygons) == 1 else shapely.union_all(shapely.make_valid(np.array(polygons)))
    return shapely.force_3d(shape, min(face.lowest for face in faces))


def _level(geometry: Any) -> float:
    """The level of detail of a geometry, a text or a number."""
    try:
        return float(geometry.get("lod", 0))
    except (AttributeError, TypeError, ValueError):
        return 0.0


def _faces(geometry: Any, vertices: Floats) -> Iterator[_Face]:
    """The faces of a geometry, without those of cavities; none of a kind that has no faces."""
    depth = _SOLID_DEPTH.get(str(geometry.get("type"))) if isinstance(geometry, dict) else None
    if depth is None:
        return
    semantics = geometry.get("semantics")
    semantics = semantics if isinstance(semantics, dict) else {}
    surfaces = semantics.get("surfaces")
    grounds = {
        index
        for index, surface in enumerate(surfaces if isinstance(surfaces, list) else ())
        if isinstance(surface, dict) and surface.get("type") == _GROUND
    }
    for rings, index in _surfaces(geometry.get("boundaries"), semantics.get("values"), depth):
        points = _rings(rings, vertices)
        if points is not None:
            yield _Face(points, isinstance(index, int) and index in grounds)


def _surfaces(boundaries: Any, values: Any, depth: int) -> Iterator[tuple[Any, Any]]:
    """The surfaces of boundaries with their semantic values."""
    if not isinstance(boundaries, list):
        return
    if depth == 1:  # the outer shell of a solid
        boundaries = boundaries[:1]
    for index, inner in enumerate(boundaries):
        value = values[index] if isinstance(values, list) and index < len(values) else None
        if depth == 0:
            yield inner, value
        else:
            yield from _surfaces(inner, value, depth - 1)


def _rings(rings: Any, vertices: Floats) -> list[Floats] | None:
    """The points of the rings of a surface; None if they are not those of a polygon."""
    points = []
    for ring in rings if isinstance(rings, list) else ():
        try:
            indices = np.array(ring, dtype=np.int64)
        except (TypeError, ValueError, OverflowError):
            return None
        if indices.ndim != 1 or len(indices) < 3 or indices.min() < 0 or indices.max() >= len(vertices):
            if points:
                continue
            return None
        points.append(vertices[indices])
    return points if points and all(np.isfinite(ring).all() for ring in points) else None


def _layer(reading: _Reading, header: Mapping[str, Any]) -> MapLayer:
    columns, unread = columns_of(reading.attributes)
    columns.pop(ID, None)
    ids, _ = columns_of([{ID: name} for name in reading.ids])
    geometry = np.empty(len(reading.ids), dtype=object)
    geometry[:] = reading.geometry
    path = reading.path
    remarks = []
    if reading.num_damaged:
        remarks.append(Remark(str(path), "record", f"{reading.num_damaged:,} lines are not CityJSON"))
    if unread:
        names = ", ".join(sorted(unread)[:8])
        remarks.append(Remark(str(path), "property", f"{NOT_USED}: {names}"))
    return MapLayer(
        name=str(path),
        bodies=[bodies_of(geometry[start : start + _BLOCK]) for start in range(0, len(geometry), _BLOCK)],
        attributes=united([columns | ids], [len(geometry)]),
        crs=_crs(header),
        remarks=tuple(remarks),
    )


def _crs(header: Mapping[str, Any]) -> str | None:
    metadata = header.get("metadata")
    system = metadata.get("referenceSystem") if isinstance(metadata, dict) else None
    return well_formed(system) if isinstance(system, str) and system.strip() else None
