"""The table of all parcels of a built city: what stands on each, or why it is empty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Ints, offsets_from_counts
from grammarlab.city.packed_outlines import row_blocks
from grammarlab.city.sites import Sites
from grammarlab.export.tiles.tile_grid import TileGrid
from grammarlab.runs.city.parcel_rows import ParcelRows
from grammarlab.runs.city.parcel_table import ParcelTableWriter
from grammarlab.runs.city.site_store import SiteStore
from grammarlab.runs.city.survey import Survey, lot_outlines
from grammarlab.runs.city.zone_rules import ZoneRules

TILES = "t"
"""Folder of the tiles, by level and column."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ParcelListing:
    """What the rows of the table are made from."""

    survey: Survey
    zones: Sequence[ZoneRules]
    """Rules of the zones of the plan, by number."""
    grid: TileGrid
    store: SiteStore
    """All sites."""
    reason: NDArray[np.object_]
    """[N] why a parcel is empty; empty for those that are built."""
    reports: Mapping[str, Mapping[str, float]]
    """Sums of reported values by the ids of parcels, then by key."""

    def write(self, path: Path) -> None:
        """Write the table."""
        parcels = self.survey.parcels
        keys = sorted({key for report in self.reports.values() for key in report})
        is_without = np.ones(len(parcels), np.bool_)
        with ParcelTableWriter(path, parcels.frame) as writer:
            for number in range(len(self.store)):
                sites = self.store[number]
                is_without[sites.parcel] = False
                for rows in row_blocks(len(sites)):
                    writer.add(self._rows(sites.parcel[rows], sites.take(rows), keys))
            rest, no_sites = np.flatnonzero(is_without), self.survey.sites.take(np.zeros(0, np.int64))
            for rows in row_blocks(len(rest)):
                writer.add(self._rows(rest[rows], no_sites, keys))

    def _rows(self, parcel: Ints, sites: Sites, keys: Sequence[str]) -> ParcelRows:
        """The rows of parcels, of which the first have sites."""
        reason, num, row = self.reason[parcel], len(parcel), np.arange(len(sites))
        zone, grammar, tile, lot = (np.full(num, value, object) for value in ("", "", "", None))
        names, hashes = (np.array([getattr(rules, name) for rules in self.zones], object) for name in ("zone", "hash"))
        zone[row], grammar[row], lot[row] = names[sites.zone], hashes[sites.zone], lot_outlines(sites)
        is_park = np.array([rules.is_park for rules in self.zones], np.bool_)[sites.zone]
        level = self.grid.leaf_level
        tiles = [f"{TILES}/{level}/{x}/{y}.glb" for x, y in self.grid.leaves(sites.corner).tolist()]
        tile[row] = np.where(is_park, "", np.array(tiles, object)) if tiles else ""
        grammar[reason != ""], tile[reason != ""] = "", ""
        seed, model = np.full(num, self.survey.plan.seed, np.uint64), np.zeros(num, np.uint64)
        reroll, counts = np.zeros(num, np.int64), np.zeros(num, np.int64)
        seed[row], model[row], reroll[row] = sites.seed, sites.model, sites.reroll
        widths = sites.footprints.street_width
        if widths is not None:
            counts[row] = np.diff(sites.footprints.offsets)
        part = self.survey.parcels.take(parcel)
        found = [self.reports.get(name, {}) for name in part.id.tolist()]
        return ParcelRows(
            id=part.id,
            outline=part.outline,
            lot=lot,
            zone=zone,
            reason=reason,
            seed=seed,
            model=model,
            reroll=reroll,
            grammar=grammar,
            area=part.area,
            street_width=np.zeros(0) if widths is None else widths,
            lot_edges=offsets_from_counts(counts),
            tile=tile,
            reports={key: np.array([report.get(key, np.nan) for report in found]) for key in keys},
        )
