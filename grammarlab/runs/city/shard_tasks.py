"""Tasks of all shards of a city, each made when it is asked for, as it holds all sites of its shard."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grammarlab.export.cityjson import Level
from grammarlab.export.tiles.earth_placement import EarthPlacement
from grammarlab.export.tiles.tile_grid import TileCell, TileGrid
from grammarlab.runs.city.quad_buildings import SitesOfShard
from grammarlab.runs.city.shard import ShardTask
from grammarlab.runs.city.site_store import SiteStore
from grammarlab.runs.city.zone_rules import ZoneRules


@dataclass(frozen=True, eq=False, kw_only=True)
class ShardTasks:
    """Tasks of the shards that have sites for buildings, in Morton order."""

    folder: Path
    """Folder of the city."""
    grid: TileGrid
    placement: EarthPlacement
    zones: tuple[ZoneRules, ...]
    """Rules of the zones of the plan, by number."""
    store: SiteStore
    """The sites."""
    ids: NDArray[np.object_]
    """[N] ids of all parcels."""
    cityjson: tuple[Level, ...]
    """Levels of detail of the lines of CityJSON, which are not written if there are none."""

    @cached_property
    def _is_park(self) -> NDArray[np.bool_]:
        return np.array([rules.is_park for rules in self.zones], np.bool_)

    @cached_property
    def _numbers(self) -> list[int]:
        """Shards with sites for buildings."""
        return [number for number, zones in enumerate(self.store.zones) if not self._is_park[zones].all()]

    @property
    def cells(self) -> tuple[TileCell, ...]:
        """The shards of the tasks."""
        return tuple(self.store.cells[number] for number in self._numbers)

    def __len__(self) -> int:
        return len(self._numbers)

    def __getitem__(self, index: int) -> ShardTask:
        """The task of a shard."""
        number = self._numbers[index]
        sites = self.store[number]
        sites = sites.take(np.flatnonzero(~self._is_park[sites.zone]))
        ids = self.ids[sites.parcel].tolist()
        return ShardTask(
            folder=self.folder,
            cell=self.store.cells[number],
            placement=self.placement,
            source=SitesOfShard(grid=self.grid, zones=self.zones, sites=sites, ids=ids),
            cityjson=self.cityjson,
        )

    def __iter__(self) -> Iterator[ShardTask]:
        return (self[index] for index in range(len(self)))
