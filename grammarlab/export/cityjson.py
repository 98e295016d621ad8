"""CityJSONSeq 2.0: a text of one line per building, at three levels of detail, with the kinds of its surfaces.

Level 1 is the outline as a block, level 2 walls and roof, both closed solids; level 3 has the surfaces of the model
(cityjson.org/specs). Where walls and roof would not be closed, level 2 is the block.
A line depends on its building and on the frame only, so lines may be made apart and joined in any order.
"""

from __future__ import annotations

import gc
import json
import math
from collections.abc import Iterable, Iterator, Mapping, Set
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from types import TracebackType
from typing import Literal, Self, TypeAlias, final, get_args

import numpy as np
import shapely

from grammarlab.arrays import Floats, offsets_from_counts
from grammarlab.errors import UsageError
from grammarlab.export.city_faces import CityFaces, SurfaceBase, city_faces, surfaces_of
from grammarlab.export.city_outline import ground_outline
from grammarlab.export.city_roofs import roof_map
from grammarlab.export.city_shell import shell
from grammarlab.export.city_surfaces import MILLIMETRES, CityGeometry, block, distinct_points
from grammarlab.export.model_files import whole_file
from grammarlab.export.reference_system import reference_system_url
from grammarlab.export.surface_labels import SurfaceLabels
from grammarlab.geometry.footprints.frame import Frame
from grammarlab.scene import Scene

Level: TypeAlias = Literal["1", "2", "3"]
LEVELS: tuple[Level, ...] = get_args(Level)
AttributeValue: TypeAlias = str | int | float | bool | None
_SAFE_INTEGER = 2**53
"""Integers from here on are written as texts, since many readers of JSON round them."""


@dataclass(frozen=True, eq=False, kw_only=True)
class CityBuilding:
    """One building in its place."""

    id: str
    """Name of the object in the file, unique: the id of its parcel."""
    footprint: shapely.Polygon
    """Outline of the lot with holes, x to the east and y to the north of the frame's origin, in metres; the outline of
    the building if its walls fill it."""
    ground: float
    """Height of the bottom of the building in metres."""
    scene: Scene
    """The building, one model."""
    corner: Floats
    """[3] where the positions of the scene count from: x, y and z from the frame's origin, in metres; the corner of the
    site and the origin of the model (`Scene.origins`) together."""
    labels: SurfaceLabels
    """Kinds of the surfaces of the instances of the scene."""
    attributes: Mapping[str, AttributeValue]
    """Properties by name, as they will stand in the file; integers beyond 2**53 become texts."""
    plinth: float = 0.0
    """Metres from `ground` down to where the building stands on the terrain; levels 1 and 2 reach down to there."""


@final
class CityJsonWriter:
    """A CityJSONSeq file in the making, which is under its name once it is complete, or not at all.

    Use it in a ``with`` block or call `finish`; memory does not grow with the number of buildings.

    Args:
        path: the file; its folder is made.
        frame: frame of the city.
        levels: levels of detail that are written.

    Raises:
        UsageError: If the path cannot be written to.
    """

    def __init__(self, path: Path, frame: Frame, *, levels: Iterable[Level] = LEVELS) -> None:
        self._levels = tuple(levels)
        with ExitStack() as stack:
            self._output = stack.enter_context(whole_file(path))
            self._output.stream.write(head_line(frame))
            self._stack = stack.pop_all()

    def add(self, building: CityBuilding) -> Self:
        """Add one building."""
        return self.add_lines(building_line(building, self._levels))

    def add_lines(self, lines: bytes) -> Self:
        """Add lines of `building_line`, made elsewhere."""
        self._output.stream.write(lines)
        return self

    def finish(self) -> None:
        """Complete the file."""
        self._stack.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._stack.__exit__(kind, error, traceback)


def head_line(frame: Frame) -> bytes:
    """First line of a file: coordinates are whole millimetres from the origin of the frame.

    >>> head_line(Frame("", (0.0, 0.0)))[:32]
    b'{"type":"CityJSON","version":"2.'
    """
    system = reference_system_url(frame)
    head = {
        "type": "CityJSON",
        "version": "2.0",
        "transform": {"scale": [0.001, 0.001, 0.001], "translate": [*frame.origin, 0.0]},
        **({"metadata": {"referenceSystem": system}} if system else {}),
        "CityObjects": {},
        "vertices": [],
    }
    return _line(head)


def levels_of(text: str) -> tuple[Level, ...]:
    """Levels of detail from a list such as ``1,2``, in ascending order.

    Raises:
        UsageError: If it names none, or others.

    >>> levels_of("3, 1")
    ('1', '3')
    """
    names = [name.strip() for name in text.split(",")]
    if not set(names) <= set(LEVELS):
        raise UsageError(f"expected levels of detail among {', '.join(LEVELS)}, such as 1,2, found {text!r:.40}")
    return tuple(level for level in LEVELS if level in names)


@contextmanager
def _without_collection() -> Iterator[None]:
    """A time without searches for cycles of objects.

    A line is a tree of very many lists, which has none, and the searches take as long as all else.
    """
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


@_without_collection()
def building_line(building: CityBuilding, levels: Iterable[Level] = LEVELS) -> bytes:
    """Line of one building.

    Raises:
        UsageError: If the scene does not have one model, or its labels are not those of its instances.
    """
    if building.scene.num_models != 1 or len(building.labels) != len(building.scene):
        raise UsageError(
            f"building {building.id}: expected a scene of one model with a label for each of its {len(building.scene)} "
            f"instances, found {building.scene.num_models} models and {len(building.labels)} labels"
        )
    geometries = {level: geometry for level, geometry in _geometries(building, set(levels)).items() if geometry}
    points = np.concatenate([np.zeros((0, 3), np.int64), *(part.points for part in geometries.values())])
    vertices, row = distinct_points(points)
    starts = offsets_from_counts(np.array([len(part.points) for part in geometries.values()], dtype=np.int64))
    rows = [row[start:end].tolist() for start, end in pairwise(starts.tolist())]
    feature = {
        "type": "CityJSONFeature",
        "id": building.id,
        "CityObjects": {
            building.id: {
                "type": "Building",
                "attributes": {name: _plain(value) for name, value in building.attributes.items()},
                "geometry": [
                    _member(level, part, vertex) for (level, part), vertex in zip(geometries.items(), rows, strict=True)
                ],
            }
        },
        "vertices": vertices.tolist(),
    }
    return _line(feature)


def _geometries(building: CityBuilding, levels: Set[Level]) -> dict[Level, CityGeometry | None]:
    """The geometries of a building; the block is as high as its walls and roof."""
    faces = city_faces(building.scene, building.corner)
    outline, bottom = _outline(faces, building), building.ground - building.plinth
    geometries: dict[Level, CityGeometry | None] = {}
    if levels & {"1", "2"}:
        walls_and_roof = _walls_and_roof(faces, outline, building)
        highest = (faces if walls_and_roof is None else walls_and_roof).points[:, 2].max(initial=0) / MILLIMETRES
        geometries["1"] = block(outline, bottom, highest)
        geometries["2"] = walls_and_roof or geometries["1"]
    if "3" in levels:
        base = SurfaceBase(ground=building.ground, bottom=bottom)
        geometries["3"] = surfaces_of(faces, building.scene, building.labels, outline, base)
    return {level: geometries[level] for level in LEVELS if level in levels}


def _outline(faces: CityFaces, building: CityBuilding) -> shapely.Polygon:
    with suppress(shapely.GEOSException):  # geometry that defeats its overlays
        return ground_outline(faces, building.footprint, building.ground)
    return building.footprint


def _walls_and_roof(faces: CityFaces, outline: shapely.Polygon, building: CityBuilding) -> CityGeometry | None:
    with suppress(shapely.GEOSException):
        roofs = roof_map(faces, outline, building.ground)
        return None if roofs is None else shell(roofs, building.ground - building.plinth)
    return None


def _member(level: str, geometry: CityGeometry, vertex: list[int]) -> dict[str, object]:
    """A geometry as the object of a file, with the vertices of its points."""
    surfaces = [[[vertex[point] for point in ring] for ring in surface] for surface in geometry.surfaces]
    is_solid = geometry.shape == "Solid"
    return {
        "type": geometry.shape,
        "lod": level,
        "boundaries": [surfaces] if is_solid else surfaces,
        "semantics": {
            "surfaces": [kind.as_dict() for kind in geometry.kinds],
            "values": [list(geometry.kind)] if is_solid else list(geometry.kind),
        },
    }


def _plain(value: AttributeValue) -> AttributeValue:
    """A value that every reader of JSON sees unchanged."""
    if isinstance(value, int) and abs(value) >= _SAFE_INTEGER:
        return str(value)
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _line(value: Mapping[str, object]) -> bytes:
    text = json.dumps(value, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return text.encode(errors="backslashreplace") + b"\n"
