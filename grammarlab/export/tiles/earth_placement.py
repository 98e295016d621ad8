"""Matrices that put tiles in their place on the earth."""

from __future__ import annotations

from dataclasses import dataclass

from grammarlab.arrays import Floats
from grammarlab.geometry.footprints.frame import Frame


@dataclass(frozen=True, slots=True)
class Placement:
    """Place of the tiles of a city: on the earth, or in metres at an unknown place."""

    frame: Frame
    geoid_height: float = 0.0
    """Metres from the ellipsoid up to height 0 of the frame."""

    def root_transform(self) -> Floats | None:
        """[4, 4] from metres along the frame's east, north and up at its origin to ECEF metres (EPSG:4978).

        None if the place is unknown.

        Raises:
            UsageError: If the extra ``city`` is missing.
        """
        raise NotImplementedError

    def tile_matrix(self, origin: Floats) -> Floats:
        """[4, 4] from the axes of a tile to those of the root, both x east, y up, z south, in metres.

        Args:
            origin: [3] origin of the tile in the frame, x east, y up, z south.
        """
        raise NotImplementedError
