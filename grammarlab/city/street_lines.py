"""Streets as centre lines with widths, in the frame of a city."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.errors import UsageError


@dataclass(frozen=True, slots=True, eq=False)
class StreetLines:
    """M streets."""

    line: NDArray[np.object_]
    """[M] lines of shapely, x to the east and y to the north of the frame's origin, in metres."""
    width: Floats
    """[M] metres between the parcels on both sides, > 0; NaN if unknown."""

    def __post_init__(self) -> None:
        if self.line.shape != self.width.shape or self.line.ndim != 1:
            raise UsageError(f"streets: expected a width for each of {len(self.line)} lines, found {len(self.width)}")

    def __len__(self) -> int:
        return len(self.line)

    @property
    def length(self) -> Floats:
        """[M] metres."""
        return shapely.length(self.line)
