"""Sites of a city in a file, shard by shard, so that those of one shard are in memory at a time."""

from __future__ import annotations

from dataclasses import fields
from io import BytesIO
from itertools import pairwise
from typing import IO, Any

import numpy as np

from grammarlab.city.sites import Sites
from grammarlab.derivation.lots import AttributeColumn, Footprints
from grammarlab.export.tiles.tile_grid import TileCell, TileGrid, morton

_PLAIN = tuple(field.name for field in fields(Sites) if field.name not in ("footprints", "attributes", "start_rule"))
"""Columns of sites that are arrays of numbers."""
_VALUES, _IS_GIVEN = "value.", "is_given."
"""Prefixes of the columns of attributes."""


class SiteStore:
    """Sites in the order of their shards, then of their leaves in Morton order, then of their parcels.

    Args:
        file: holds the sites; it must stay open.
        sites: the sites, in the order of their parcels.
        grid: the quadtree.
    """

    def __init__(self, file: IO[bytes], sites: Sites, grid: TileGrid) -> None:
        self._file = file
        leaves = grid.leaves(sites.corner)
        # Rows are ordered by id, and stay so within a leaf; the code of a shard is a prefix of those of its leaves.
        order = np.argsort(morton(leaves), kind="stable")
        cells = grid.shards(leaves[order])
        starts = np.flatnonzero((np.diff(cells, axis=0, prepend=-1) != 0).any(axis=1)).tolist()
        self.cells = tuple(TileCell(grid.shard_level, *cells[start].tolist()) for start in starts)
        """The shards, in Morton order."""
        self.zones = tuple(np.unique(sites.zone[order[a:b]]) for a, b in pairwise([*starts, len(cells)]))
        """The zones of the sites of each shard."""
        self._ends = [0]
        for first, last in pairwise([*starts, len(cells)]):
            self._ends.append(self._ends[-1] + file.write(_packed(sites.take(order[first:last]))))

    def __len__(self) -> int:
        return len(self.cells)

    def __getitem__(self, number: int) -> Sites:
        """The sites of a shard."""
        start, end = self._ends[number : number + 2]
        self._file.seek(start)
        return _unpacked(self._file.read(end - start))


def _packed(sites: Sites) -> bytes:
    columns: dict[str, Any] = {name: getattr(sites, name) for name in _PLAIN}
    columns |= {"points": sites.footprints.points, "offsets": sites.footprints.offsets}
    if sites.footprints.street_width is not None:
        columns["street_width"] = sites.footprints.street_width
    columns["start_rule"] = sites.start_rule.astype(np.str_)
    for name, column in sites.attributes.items():
        columns |= {_VALUES + name: column.values, _IS_GIVEN + name: column.is_given}
    stream = BytesIO()
    np.savez(stream, **columns)
    return stream.getvalue()


def _unpacked(content: bytes) -> Sites:
    with np.load(BytesIO(content), allow_pickle=False) as file:
        columns: dict[str, Any] = dict(file)
    names = [name.removeprefix(_VALUES) for name in columns if name.startswith(_VALUES)]
    return Sites(
        **{name: columns[name] for name in _PLAIN},
        footprints=Footprints(columns["points"], columns["offsets"], columns.get("street_width")),
        attributes={name: AttributeColumn(columns[_VALUES + name], columns[_IS_GIVEN + name]) for name in names},
        start_rule=columns["start_rule"].astype(object),
    )
