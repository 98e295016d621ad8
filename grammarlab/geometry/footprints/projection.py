"""Outlines in degrees as metres on the ground.

The centres of outlines are placed by an oblique stereographic map of the WGS 84 ellipsoid around their middle (J. P.
Snyder, *Map Projections: A Working Manual*, 1987, pages 160-163). It keeps angles, and lengths grow by 0.6 mm per
kilometre 10 km from the middle. Around its own centre, each outline is scaled by the radii of curvature there, so that
its area is that on the ground wherever it lies.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from grammarlab.arrays import Floats

EQUATOR = 6378137.0
"""Radius of the equator in metres."""
_FLATTENING = 1 / 298.257223563
SQUARED_ECCENTRICITY = _FLATTENING * (2 - _FLATTENING)
"""Of the meridians of the WGS 84 ellipsoid."""
_ECCENTRICITY = SQUARED_ECCENTRICITY**0.5
LAST_LATITUDE = 89.0
"""Degrees; nearer to a pole, all directions are south and longitudes mean little."""
_STEP = 1e-6
"""Radians to the north by which the direction of north on the map is measured: 6 m."""


@dataclass(frozen=True, slots=True)
class Ground:
    """A map of the ground around a middle."""

    longitude: float
    """Degrees; the middle is the origin of the map."""
    latitude: float

    @classmethod
    def around(cls, centres: Floats) -> Ground:
        """The map around the median of centres [n, 2], longitude and latitude in degrees, across the date line too.

        A median, so that a stray outline far from a town does not move the middle out of it.
        """
        longitudes = np.sort(centres[:, 0] % 360.0)
        gaps = np.diff(longitudes, append=longitudes[0] + 360.0)
        west = longitudes[(int(np.argmax(gaps)) + 1) % len(longitudes)]  # the centres go east from here
        longitude = west + np.median((longitudes - west) % 360.0)
        return cls(float((longitude + 180.0) % 360.0 - 180.0), float(np.median(centres[:, 1])))

    def metres(self, polygons: Sequence[shapely.Polygon]) -> list[shapely.Polygon]:
        """Polygons in degrees as polygons in metres east and north of the middle."""
        centres = centres_of(polygons)
        angles, step = np.radians(centres), np.array([0.0, _STEP])
        positions, north = self.projected(angles), self.projected(angles + step) - self.projected(angles - step)
        north /= np.hypot(*north.T)[:, None]
        scales = _metres_per_degree(centres[:, 1])
        rows = zip(polygons, centres, positions, north, scales, strict=True)
        return [_moved(*row) for row in rows]

    def projected(self, points: Floats) -> Floats:
        """Points [n, 2] in radians on the stereographic map, in metres."""
        middle = np.radians(self.latitude)
        sphere, first = _conformal(points[:, 1]), _conformal(middle)
        turn = points[:, 0] - np.radians(self.longitude)
        factor = 2 * EQUATOR * np.cos(middle) / np.sqrt(1 - SQUARED_ECCENTRICITY * np.sin(middle) ** 2)
        share = np.sin(first) * np.sin(sphere) + np.cos(first) * np.cos(sphere) * np.cos(turn)
        with np.errstate(divide="ignore"):  # the opposite of the middle is infinitely far
            scale = factor / (np.cos(first) * (1 + share))
        east = scale * np.cos(sphere) * np.sin(turn)
        return np.column_stack(
            [east, scale * (np.cos(first) * np.sin(sphere) - np.sin(first) * np.cos(sphere) * np.cos(turn))]
        )


def centres_of(polygons: Sequence[shapely.Polygon]) -> Floats:
    """[n, 2] centroids of polygons, which make the error of their linear scale one of second order."""
    return shapely.get_coordinates(shapely.centroid(np.array(polygons, dtype=object)))


def without_jumps(polygon: shapely.Polygon) -> shapely.Polygon | None:
    """A polygon in degrees without jumps at the date line, beyond 180 if need be; None if it goes around a pole."""
    rings = [shapely.get_coordinates(ring) for ring in (polygon.exterior, *polygon.interiors)]
    if all(np.abs(np.diff(ring[:, 0])).max(initial=0.0) <= 180.0 for ring in rings) and len(rings) == 1:
        return polygon
    first = rings[0][0, 0]
    for ring in rings:
        turns = np.round(np.diff(ring[:, 0]) / 360.0)
        if turns.sum() != 0:
            return None
        ring[1:, 0] -= 360.0 * np.cumsum(turns)
        ring[:, 0] -= 360.0 * np.round((ring[0, 0] - first) / 360.0)
    return shapely.Polygon(rings[0], rings[1:])


def _conformal(latitude: Floats | np.float64) -> Floats | np.float64:
    """Conformal latitudes in radians: those on a sphere with the same angles."""
    sine = np.sin(latitude)
    return np.arctan(np.sinh(np.arctanh(sine) - _ECCENTRICITY * np.arctanh(_ECCENTRICITY * sine)))


def _metres_per_degree(latitude: Floats) -> Floats:
    """[n, 2] metres per degree of longitude and of latitude on the ellipsoid, at latitudes [n] in degrees."""
    curvature = 1 - SQUARED_ECCENTRICITY * np.sin(np.radians(latitude)) ** 2
    east = EQUATOR / np.sqrt(curvature) * np.cos(np.radians(latitude))
    return np.radians(np.column_stack([east, EQUATOR * (1 - SQUARED_ECCENTRICITY) / curvature**1.5]))


def _moved(polygon: shapely.Polygon, centre: Floats, position: Floats, north: Floats, scale: Floats) -> shapely.Polygon:
    """A polygon in degrees, scaled around its centre, turned to the north of the map and moved to its place."""
    turn = np.array([[north[1], -north[0]], north])

    def transform(points: Floats) -> Floats:
        return ((points - centre) * scale) @ turn + position

    return shapely.transform(polygon, transform)
