"""The attribute ``streetWidth``, which CGA maps to the widths of the streets along the edges of a lot."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Ints
from grammarlab.derivation.lots import Lots
from grammarlab.derivation.state.array_table import ArrayTable, Table
from grammarlab.geometry.lot_sides import is_bridge

STREET_WIDTH = "streetWidth"
"""Name of the attribute."""
StreetWidth = Literal["none", "widest", "edges"]
"""What an attribute takes from lots: nothing, the width of the widest street, or an array of a width for each edge."""


def has_widths(lots: Lots, kind: StreetWidth) -> Flags:
    """[N] whether an attribute takes its value from a lot."""
    widths, offsets = lots.footprints.street_width, lots.footprints.offsets
    if widths is None or kind == "none":
        return np.zeros(len(lots), dtype=bool)
    return ~np.isnan(widths[offsets[:-1][lots.footprint]])


def widths_of_models(lots: Lots, rows: Ints, kind: StreetWidth, tables: ArrayTable) -> NDArray:
    """[K] values of the attribute for models at these rows, whose widths are known.

    Args:
        lots: [N] lots.
        rows: [K] rows of models.
        kind: what the attribute takes; arrays have the order in which ``comp(fe)`` numbers the edges of the initial
            shape.
        tables: arrays of the derivation.
    """
    footprints = lots.footprints
    used, index = np.unique(lots.footprint[rows], return_inverse=True)
    columns = [np.asarray(footprints.widths(lot)) for lot in used.tolist()]
    if kind != "edges":
        return np.array([column.max() for column in columns])[index]
    is_edge = ~is_bridge(footprints.points[:, [0, 2]], footprints.offsets)
    edges = [is_edge[slice(*footprints.offsets[lot : lot + 2])] for lot in used.tolist()]
    cells = [tuple(column[chosen].tolist()) for column, chosen in zip(columns, edges, strict=True)]
    return tables.ids([Table("float", 1, len(row), row) for row in cells])[index]
