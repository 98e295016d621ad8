"""Requests for streets and parcels where there is no map."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from dataclasses import field as dataclass_field
from typing import Literal, TypeAlias

import shapely

from grammarlab.city.direction_field import DirectionField
from grammarlab.geometry.footprints.frame import Frame

BlockUse: TypeAlias = Literal["lots", "park", "open"]
"""What a block is divided into: parcels to build on, one parcel that is a park, or no parcels at all."""
BLOCK_USES: tuple[BlockUse, ...] = ("lots", "park", "open")
NO_PLACE = Frame("", (0.0, 0.0))
"""The frame of metres at an unknown place."""
GRID = DirectionField()
"""A grid along the outline."""


@dataclass(frozen=True, slots=True)
class ParcelSizes:
    """Sizes that parcels have where their block allows it."""

    area: float = 370.0
    """Median area in square metres."""
    spread: float = 1.1
    """Standard deviation of the logarithm of the area, >= 0."""
    frontage: float = 6.0
    """Shortest length along a street in metres."""
    aspect: float = 5.0
    """Largest ratio of the sides of the smallest box around a parcel."""


@dataclass(frozen=True, slots=True)
class BlockEdit:
    """A change to one block; it changes no other block."""

    seed: int | None = None
    """Seed of the parcels of the block instead of the seed of the layout."""
    use: BlockUse | None = None
    """Use of the block instead of the one that is drawn."""
    sizes: ParcelSizes | None = None
    """Sizes of its parcels instead of those of the layout."""


@dataclass(frozen=True, kw_only=True)
class LayoutRequest:
    """An area to divide into blocks by streets, and blocks into parcels."""

    frame: Frame = NO_PLACE
    outline: shapely.Polygon | shapely.MultiPolygon
    """The area in metres of the frame; holes are water, railways and the like, with a street around them."""
    seed: int = 0
    """Seed of all splits, 0 <= seed < 2**64."""
    field: DirectionField = GRID
    widths: tuple[float, ...] = (24.0, 16.0, 10.0)
    """Widths of streets in metres, the main ones first."""
    edge_width: float | None = None
    """Width of the street along the outline in metres, half of which is inside; 0 for no street; None for the second
    of `widths`."""
    block_area: tuple[float, float] = (4_000.0, 20_000.0)
    """Smallest and largest area of a block in square metres."""
    sizes: ParcelSizes = ParcelSizes()
    park_share: float = 0.05
    """Share of the area of blocks that is parks, 0 to 1."""
    edits: Mapping[str, BlockEdit] = dataclass_field(default_factory=dict)
    """Changes by the id of the block, ``b2f``."""
