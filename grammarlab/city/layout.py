"""Layouts: streets, blocks and parcels where there is no map."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.city.parcels import Outlines, Parcels
from grammarlab.city.street_lines import StreetLines


@dataclass(frozen=True, eq=False)
class Blocks:
    """B areas between streets, ordered by id."""

    id: NDArray[np.object_]
    """[B] different texts: ``b`` and the path of the splits that lead to the block."""
    outline: Outlines
    """[B] polygons in metres of the frame."""
    use: NDArray[np.object_]
    """[B] ``lots``, ``park`` or ``open``."""

    def __len__(self) -> int:
        return len(self.id)


@dataclass(frozen=True, eq=False)
class Layout:
    """Streets, blocks and parcels of an area."""

    parcels: Parcels
    """Parcels with ids such as ``b2f-p07``, by block and path within the block. Attributes: ``block``, the id of the
    block, and ``use``, ``lots`` or ``park``."""
    streets: StreetLines
    """Streets between blocks and along the outline."""
    blocks: Blocks
