"""Surfaces on which square cells have equal areas and addresses that no outline changes.

Outlines in metres lie on a plane: its cells count from the origin of the coordinate reference system. Outlines in
degrees lie on the WGS 84 ellipsoid: its cells are squares of Lambert's cylindrical equal-area map of the whole earth
(J. P. Snyder, *Map Projections: A Working Manual*, 1987, pages 76-85), whose true widths shrink to the poles while
their heights grow. So a cell has one address, however a map is cut.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.geometry.footprints.projection import EQUATOR, SQUARED_ECCENTRICITY

_ECCENTRICITY = SQUARED_ECCENTRICITY**0.5
_AROUND = 2 * np.pi * EQUATOR
"""Width of the map of the earth in metres."""
_STEPS = 5
"""Newton steps to a latitude: the first error is below .002, and each step squares it."""
_SHORTEST_RADIUS = 6.33e6
"""Metres: less than any radius of curvature of the earth."""
_LAST = np.radians(89.9)
"""Last latitude of outlines with their margins."""


class AbstractSurface(ABC):
    """A surface with an equal-area map, in metres."""

    @abstractmethod
    def sides(self, side: float) -> Floats:
        """[2] width and height of cells on the map, with an area of side², such that they close around the earth."""

    @abstractmethod
    def boxes(self, bounds: Floats, margin: float) -> Floats:
        """[n, 2, 2] lowest and highest points on the map of rectangles with a margin.

        Args:
            bounds: [n, 4] west, south, east and north in the coordinates of the source.
            margin: metres on the ground.
        """

    @abstractmethod
    def columns(self, columns: Ints, side: float) -> Ints:
        """[n] numbers of columns of cells as they count once around the earth, from longitude -180 to 180."""

    @abstractmethod
    def coordinates(self, points: Floats) -> Floats:
        """[n, 2] points of the map in the coordinates of the source."""

    @abstractmethod
    def space(self, coordinates: Floats) -> Floats:
        """[n, 2 or 3] positions in metres whose distances are those on the ground, from coordinates [n, 2]."""


class Plane(AbstractSurface):
    """The plane of a map in metres."""

    def sides(self, side: float) -> Floats:
        return np.array([side, side])

    def boxes(self, bounds: Floats, margin: float) -> Floats:
        return bounds.reshape(-1, 2, 2) + np.array([[-margin], [margin]])

    def columns(self, columns: Ints, side: float) -> Ints:
        return columns

    def coordinates(self, points: Floats) -> Floats:
        return points

    def space(self, coordinates: Floats) -> Floats:
        return coordinates


class Ellipsoid(AbstractSurface):
    """The earth, for coordinates in degrees."""

    def sides(self, side: float) -> Floats:
        width = _AROUND / max(1, round(_AROUND / side))
        return np.array([width, side * side / width])

    def boxes(self, bounds: Floats, margin: float) -> Floats:
        west, south, east, north = np.radians(bounds).T
        angle = margin / _SHORTEST_RADIUS
        south, north = np.clip([south - angle, north + angle], -_LAST, _LAST)
        turn = angle / np.minimum(np.cos(south), np.cos(north))
        columns = [EQUATOR * (west - turn), _heights(south), EQUATOR * (east + turn), _heights(north)]
        return np.column_stack(columns).reshape(-1, 2, 2)

    def columns(self, columns: Ints, side: float) -> Ints:
        number = round(_AROUND / float(self.sides(side)[0]))
        return (columns + number // 2) % number - number // 2

    def coordinates(self, points: Floats) -> Floats:
        return np.degrees(np.column_stack([points[:, 0] / EQUATOR, np.arcsin(_sines(points[:, 1]))]))

    def space(self, coordinates: Floats) -> Floats:
        longitude, latitude = np.radians(coordinates).T
        across = EQUATOR / np.sqrt(1 - SQUARED_ECCENTRICITY * np.sin(latitude) ** 2)
        return np.column_stack(
            [
                across * np.cos(latitude) * np.cos(longitude),
                across * np.cos(latitude) * np.sin(longitude),
                across * (1 - SQUARED_ECCENTRICITY) * np.sin(latitude),
            ]
        )


def _heights(latitudes: Floats) -> Floats:
    """[n] heights on the equal-area map of latitudes [n] in radians."""
    return _heights_of_sines(np.sin(latitudes))


def _heights_of_sines(sine: Floats) -> Floats:
    part = sine / (1 - SQUARED_ECCENTRICITY * sine**2) + np.arctanh(_ECCENTRICITY * sine) / _ECCENTRICITY
    return EQUATOR * (1 - SQUARED_ECCENTRICITY) / 2 * part


def _sines(heights: Floats) -> Floats:
    """[n] sines of the latitudes with heights [n] on the equal-area map, by Newton's method."""
    sine = np.clip(heights / _heights_of_sines(np.ones(1)), -1.0, 1.0)
    for _ in range(_STEPS):
        slope = EQUATOR * (1 - SQUARED_ECCENTRICITY) / (1 - SQUARED_ECCENTRICITY * sine**2) ** 2
        sine = np.clip(sine - (_heights_of_sines(sine) - heights) / slope, -1.0, 1.0)
    return sine
