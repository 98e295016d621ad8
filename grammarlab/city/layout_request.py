"""Requests for streets and parcels where there is no map."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from dataclasses import field as dataclass_field
from typing import Literal, TypeAlias

import numpy as np
import shapely

from grammarlab.city.direction_field import DirectionField
from grammarlab.errors import UsageError, shown
from grammarlab.geometry.footprints.frame import Frame

BlockUse: TypeAlias = Literal["lots", "park", "open"]
"""What a block is divided into: parcels to build on, one parcel that is a park, or no parcels at all."""
BLOCK_USES: tuple[BlockUse, ...] = ("lots", "park", "open")
NO_PLACE = Frame("", (0.0, 0.0))
"""The frame of metres at an unknown place."""
MAX_BLOCKS = 50_000
"""Budget: smallest blocks that an area may have room for; as many take about a minute."""
MAX_PARCELS = 1_500_000
"""Budget: parcels of the median area that an area may have room for; a million take about 4 GB."""
MAX_CORNERS = 200_000
"""Budget: corners of an outline."""
MAX_COORDINATE = 1e7
"""Largest coordinate in metres; beyond it, millimetres are lost."""
_MOST_WIDTHS = 16
GRID = DirectionField()
"""A grid along the outline."""


def _check(name: str, value: float, low: float, high: float) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:  # also NaN
        raise UsageError(f"{name}: expected a number from {low:g} to {high:g}, found {shown(value)}")


@dataclass(frozen=True, slots=True)
class ParcelSizes:
    """Sizes that parcels have where their block allows it.

    The default is a dense European city: its areas and aspects are those of the 18th arrondissement of Paris.
    """

    area: float = 190.0
    """Median area in square metres, before parcels are joined that would have no street."""
    spread: float = 0.84
    """Standard deviation of the logarithm of the area, >= 0."""
    frontage: float = 5.0
    """Shortest length along a street in metres."""
    aspect: float = 1.25
    """Median ratio of the sides of the smallest box around a parcel that is aimed at, >= 1."""
    aspect_spread: float = 0.55
    """Standard deviation of the logarithm of that ratio, >= 0."""

    def __post_init__(self) -> None:
        _check("parcel area", self.area, 5.0, 1e8)
        _check("spread of parcel areas", self.spread, 0.0, 3.0)
        _check("frontage", self.frontage, 1.0, 1_000.0)
        _check("aspect", self.aspect, 1.0, 100.0)
        _check("spread of aspects", self.aspect_spread, 0.0, 3.0)

    @property
    def depth(self) -> float:
        """Depth of a typical parcel in metres, its longer side away from the street."""
        return (self.area * self.aspect) ** 0.5


STYLES: Mapping[str, ParcelSizes] = {
    "paris": ParcelSizes(),
    "suburb": ParcelSizes(area=290.0, spread=0.95, frontage=4.0, aspect=2.5, aspect_spread=0.7),
    "villas": ParcelSizes(area=800.0, spread=0.5, frontage=12.0, aspect=1.15, aspect_spread=0.2),
}
"""Sizes measured on maps: Paris, 18th arrondissement; Epinay-sur-Orge, a suburb; Kumasi, detached houses."""


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
    variation: float = 0.1
    """How far from the middle streets divide, as a share of the area: 0 for a regular grid, at most 0.2."""
    edits: Mapping[str, BlockEdit] = dataclass_field(default_factory=dict)
    """Changes by the id of the block, ``b002f``."""

    def __post_init__(self) -> None:
        if isinstance(self.seed, bool) or not 0 <= int(self.seed) < 2**64:
            raise UsageError(f"seed: expected 0 <= seed < 2**64, found {self.seed}")
        _check_outline(self.outline)
        if not 1 <= len(self.widths) <= _MOST_WIDTHS:
            raise UsageError(f"widths: expected 1 to {_MOST_WIDTHS} widths of streets, found {len(self.widths)}")
        for width in self.widths:
            _check("width of a street", width, 2.0, 200.0)
        if self.edge_width is not None and self.edge_width != 0:
            _check("width of the street along the outline", self.edge_width, 2.0, 200.0)
        for area in self.block_area:
            _check("area of a block", area, 200.0, 1e8)
        if self.block_area[0] > self.block_area[1]:
            raise UsageError(f"block area: expected the smaller area first, found {list(self.block_area)}")
        num_blocks = self.outline.area / self.block_area[0]
        if num_blocks > MAX_BLOCKS:
            raise UsageError(
                f"the outline has {self.outline.area / 1e6:,.0f} km², room for more than {MAX_BLOCKS:,} blocks of "
                f"{self.block_area[0]:,.0f} m². Give larger blocks or a smaller area."
            )
        if self.outline.area / self.sizes.area > MAX_PARCELS:
            raise UsageError(
                f"the outline has {self.outline.area / 1e6:,.0f} km², room for more than {MAX_PARCELS:,} parcels of "
                f"{self.sizes.area:,.0f} m². Give larger parcels or a smaller area."
            )
        _check("share of parks", self.park_share, 0.0, 1.0)
        _check("variation", self.variation, 0.0, 0.2)
        if self.field.angle is not None:
            _check("angle", self.field.angle, -1e4, 1e4)
        for coordinate in self.field.centre or ():
            _check("centre", coordinate, -MAX_COORDINATE, MAX_COORDINATE)

    @property
    def outline_street(self) -> float:
        """Width in metres of the street along the outline, 0 for no street."""
        if self.edge_width is not None:
            return self.edge_width
        return self.widths[min(1, len(self.widths) - 1)]


def _check_outline(outline: object) -> None:
    if not isinstance(outline, shapely.Polygon | shapely.MultiPolygon):
        raise UsageError(f"outline: expected a polygon in metres, found {type(outline).__name__}")
    if outline.is_empty or not shapely.get_num_coordinates(outline) <= MAX_CORNERS:
        raise UsageError(f"outline: expected 3 to {MAX_CORNERS:,} corners")
    if not np.isfinite(outline.bounds).all() or np.abs(outline.bounds).max() > MAX_COORDINATE:
        raise UsageError(f"outline: expected coordinates in metres up to {MAX_COORDINATE:,.0f}")
    if not outline.is_valid:
        raise UsageError(
            f"outline: {shapely.is_valid_reason(outline)}; repair it, for instance with shapely.make_valid"
        )
