"""Polygons of GML elements."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.boxes.annotation import FARTHEST
from grammarlab.facade.reading.markup import Node, local_name
from grammarlab.facade.tree import Floats
from grammarlab.facade.values import shown

Polygon: TypeAlias = list[Floats]
"""Rings [P, 3] without the repeated last corner: the outer one, then holes."""

MOST_POINTS = 10_000_000
_POLYGONS = ("Polygon", "PolygonPatch", "Rectangle", "Triangle")
_GML_ID = ("{http://www.opengis.net/gml}id", "{http://www.opengis.net/gml/3.2}id", "id")
_HREF = "{http://www.w3.org/1999/xlink}href"


def identity(node: Node) -> str:
    """The `gml:id` of an element, empty without one."""
    return next((node.attrib[key] for key in _GML_ID if key in node.attrib), "")


class GmlPolygons:
    """The polygons of a file, read on demand, each time that other elements refer to them.

    Args:
        root: the outermost element.
    """

    def __init__(self, root: Node) -> None:
        self._by_id = {identity(each): each for each in root.iter() if local_name(each) in _POLYGONS and identity(each)}
        self._points_left = MOST_POINTS

    def of(self, node: Node, name: str) -> list[Polygon]:
        """The polygons of a surface or an opening, of its highest level of detail.

        Args:
            node: the element.
            name: name of the element in messages.

        Raises:
            FacadeError: If a ring is not a list of points, or there are too many points.
        """
        levels = [child for child in node if local_name(child)[:3] == "lod"]
        found: list[Polygon] = []
        for part in max(levels, key=local_name).iter() if levels else ():
            meant = part if local_name(part) in _POLYGONS else self._by_id.get(part.get(_HREF, "").removeprefix("#"))
            if meant is not None:
                rings = [_ring(ring, name) for ring in meant.iter() if local_name(ring) == "LinearRing"]
                self._points_left -= sum(map(len, rings))
                if self._points_left < 0:
                    raise FacadeError(f"The walls and openings of this file have more than {MOST_POINTS:,} corners.")
                if rings and len(rings[0]) >= 3:
                    found.append([ring for ring in rings if len(ring) >= 3])
        return found


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
