"""Matrices that put tiles in their place on the earth.

A map projection turns and stretches: grid north is up to degrees away from north, and a metre of the map is 0.9996 to
1.001 metres on the ground. So each tile has its own matrix, the derivative of the projection at its origin; within a
tile of 128 m, what is left is the curvature of the earth, below 1 mm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.extras import named_extras
from grammarlab.geometry.footprints.frame import Frame

_STEP = 32.0
"""Metres between a point and its neighbours for differences; their error, of third order, is far below 1 mm."""
UPWARDS = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
"""[4, 4] from x east, y up, z south, as in glTF, to x east, y north, z up, as in 3D Tiles."""


@dataclass(frozen=True, slots=True)
class EarthPlacement:
    """Place of the tiles of a city: on the earth, or in metres at an unknown place."""

    frame: Frame
    geoid_height: float = 0.0
    """Metres from the ellipsoid of WGS 84 up to height 0 of the frame."""

    def root_transform(self) -> Floats | None:
        """[4, 4] from metres to the grid's east, its north and up at the frame's origin to ECEF metres (EPSG:4978).

        It is a rotation and a translation. None if the place is unknown.

        Raises:
            UsageError: If the extra ``city`` is missing.
        """
        if not self.frame.has_place:
            return None
        (derivative,), (origin,) = self._derivatives(np.zeros((1, 3)))
        east, _, up = derivative.T
        up = up / np.linalg.norm(up)
        north = np.cross(up, east)
        north /= np.linalg.norm(north)
        root = np.eye(4)
        root[:3] = np.column_stack((np.cross(north, up), north, up, origin))
        return root

    def tile_matrices(self, origins: Floats) -> Floats:
        """[n, 4, 4] from the axes of tiles to those of the root, both x east, y up, z south, in metres.

        Args:
            origins: [n, 3] origins of the tiles in the frame, x east, y up, z south.

        Raises:
            UsageError: If the extra ``city`` is missing.
        """
        matrices = np.tile(np.eye(4), (len(origins), 1, 1))
        root = self.root_transform()
        if root is None:
            matrices[:, :3, 3] = origins
            return matrices
        derivatives, places = self._derivatives(origins)
        matrices[:, :3, :3] = root[:3, :3].T @ derivatives
        matrices[:, :3, 3] = (places - root[:3, 3]) @ root[:3, :3]
        return UPWARDS.T @ matrices @ UPWARDS

    def ecef(self, positions: Floats) -> Floats:
        """[n, 3] ECEF metres (EPSG:4978) of positions [n, 3] in the frame, x east, y up, z south.

        Raises:
            UsageError: If the extra ``city`` is missing.
        """
        with named_extras():
            from pyproj import Transformer  # noqa: PLC0415  # an extra
        longitude, latitude = self.frame.longitude_latitude(positions[:, [0, 2]] * (1.0, -1.0)).T
        transformer = Transformer.from_crs("EPSG:4979", "EPSG:4978", always_xy=True)
        return np.column_stack(transformer.transform(longitude, latitude, positions[:, 1] + self.geoid_height))

    def _derivatives(self, positions: Floats) -> tuple[Floats, Floats]:
        """[n, 3, 3] derivatives of `ecef` to the east, to the north and up as columns, and its values [n, 3]."""
        steps = _STEP * np.array([[0, 0, 0], [1, 0, 0], [-1, 0, 0], [0, 0, -1], [0, 0, 1], [0, 1, 0], [0, -1, 0]])
        values = self.ecef((positions[:, None] + steps).reshape(-1, 3)).reshape(-1, len(steps), 3)
        return np.swapaxes(values[:, 1::2] - values[:, 2::2], 1, 2) / (2.0 * _STEP), values[:, 0]
