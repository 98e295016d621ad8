"""Areas to place things in: the outlines of footprints taken together, with their holes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely

from grammarlab.arrays import Flags, Floats
from grammarlab.geometry.footprints.equal_area import AbstractSurface, Ellipsoid, Plane
from grammarlab.geometry.footprints.footprint import Georeference, Remark
from grammarlab.geometry.footprints.footprint_text import read_source
from grammarlab.geometry.footprints.placing import planned
from grammarlab.geometry.footprints.projection import Ground


@dataclass(frozen=True)
class Area:
    """The union of polygons."""

    polygons: tuple[shapely.Polygon, ...]
    """Valid polygons in the coordinates of their source, holes included; they may overlap."""
    ground: Ground | None = None
    """Map of the ground if these are degrees; None for metres."""
    georeference: Georeference | None = None
    remarks: tuple[Remark, ...] = ()

    @property
    def surface(self) -> AbstractSurface:
        """The surface of its coordinates."""
        return Plane() if self.ground is None else Ellipsoid()

    @cached_property
    def outlines(self) -> tuple[shapely.Polygon, ...]:
        """The polygons in metres, x to the east and y to the north of the origin of the world."""
        return tuple(shapely.transform(polygon, self.east_north) for polygon in self.polygons)

    @cached_property
    def size(self) -> float:
        """Square metres on the ground."""
        parts = self.outlines if self.ground is None else self.ground.metres(self.polygons)
        return float(shapely.union_all(shapely.make_valid(np.array(parts, dtype=object))).area)

    @property
    def bounds(self) -> Floats:
        """[n, 4] west, south, east and north of each polygon in the coordinates of the source."""
        return shapely.bounds(np.array(self.polygons, dtype=object))

    def contains(self, coordinates: Floats) -> Flags:
        """[n] whether points [n, 2] in the coordinates of the source are inside a polygon."""
        inside = np.zeros(len(coordinates), dtype=np.bool_)
        # Outlines across the date line have longitudes beyond 180 degrees.
        for turn in (0.0,) if self.ground is None else (-360.0, 0.0, 360.0):
            points, _ = self._tree.query(shapely.points(coordinates + np.array([turn, 0.0])), predicate="within")
            inside[points] = True
        return inside

    def is_near(self, east_north: Floats, distance: float) -> Flags:
        """[n] whether points [n, 2] in metres are at most so far from an outline in metres, or inside."""
        near = np.zeros(len(east_north), dtype=np.bool_)
        points, _ = self._metric_tree.query(shapely.points(east_north), predicate="dwithin", distance=distance)
        near[points] = True
        return near

    def east_north(self, coordinates: Floats) -> Floats:
        """[n, 2] metres to the east and the north of the origin of the world, of points in source coordinates."""
        return coordinates if self.ground is None else self.ground.projected(np.radians(coordinates))

    @cached_property
    def _tree(self) -> shapely.STRtree:
        return shapely.STRtree(self.polygons)

    @cached_property
    def _metric_tree(self) -> shapely.STRtree:
        return shapely.STRtree(self.outlines)


def read_area(text: str) -> Area:
    """The area that a text describes, by the syntax of `read_footprints`.

    Raises:
        UsageError: If the text is neither a size, WKT nor a file.
        AssetError: If the file or its polygons cannot be used.

    >>> read_area("20x12").size
    240.0
    """
    plan = planned(read_source(text))
    polygons = tuple(outline.polygon for outline in plan.outlines)
    return Area(polygons, plan.ground, plan.georeference, plan.remarks)
