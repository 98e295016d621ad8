"""Sites: parcels with all that decides about their buildings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.derivation.lots import Footprints


@dataclass(frozen=True, eq=False, kw_only=True)
class Sites:
    """S places to build on, in the order of their parcels; at most one per parcel."""

    parcel: Ints
    """[S] row of the parcel."""
    zone: Ints
    """[S] number of the zone in the plan."""
    seed: NDArray[np.uint64]
    """[S] seed: the city's, or that of a pin."""
    model: NDArray[np.uint64]
    """[S] index of the model under the seed (`grammarlab.city.addresses`)."""
    reroll: Ints
    """[S] how often the parcel was rerolled, >= 0."""
    corner: Floats
    """[S, 3] origin of the footprint in the world: x and z in whole metres from the frame's origin, y the height of
    the ground at the front."""
    footprints: Footprints
    """S footprints in metres from their corners: one per site, edge 0 along the widest street; with the widths of the
    streets along their edges."""

    def __len__(self) -> int:
        return len(self.parcel)
