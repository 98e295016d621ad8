"""Parcels of made-up quarters: uneven rectangles between streets, with ids."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyarrow as pa
import shapely

from grammarlab.city.packed_outlines import PackedOutlines
from grammarlab.city.parcels import Parcels
from grammarlab.geometry.footprints.frame import Frame

STREET = 12.0


def quarter(num: int, seed: int = 0, **attributes: Any) -> Parcels:
    """`num` rectangular parcels in blocks of two rows, 2 km wide, ordered by id."""
    rng = np.random.default_rng(seed)
    widths = np.exp(rng.normal(np.log(18.0), 0.45, num))
    depths = np.exp(rng.normal(np.log(30.0), 0.2, num))
    west = np.cumsum(widths) - widths
    row = (west // 2000.0).astype(int)
    west -= row * 2000.0
    south = row * 40.0 + row // 2 * STREET
    ids = np.array([f"{index:06d}" for index in range(num)], object)
    return Parcels(
        frame=Frame("EPSG:32631", (448000.0, 5412000.0)),
        id=ids,
        outlines=PackedOutlines.of(shapely.box(west, south, west + widths, south + depths)),
        elevation=np.full(num, np.nan),
        attributes=pa.table(dict(attributes) or {"row": row}),
        first_edge=np.ones(num, np.int32),
        reason=np.full(num, "", object),
    )
