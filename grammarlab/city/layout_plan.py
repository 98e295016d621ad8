"""The layout of a plan: an area that is divided into parcels where there is no map.

```toml
[layout]
size = "600x400"
field = "radial"
style = "suburb"
[layout.parcels]
area = 300
[layout.blocks.b2f]
use = "park"
```
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path

import shapely

from grammarlab.city.direction_field import FIELD_KINDS, DirectionField
from grammarlab.city.layout_request import BLOCK_USES, NO_PLACE, STYLES, BlockEdit, LayoutRequest, ParcelSizes
from grammarlab.city.plan_tables import Keys, PlanTables
from grammarlab.errors import UsageError, shown
from grammarlab.geometry.footprints.frame import Frame

DEFAULT_SIZE = (600.0, 400.0)
"""Width to the east and depth to the north of the area in metres."""
_DEFAULTS = LayoutRequest(outline=shapely.box(0.0, 0.0, *DEFAULT_SIZE))
_KEYS = (
    *("size", "outline", "seed", "field", "angle", "centre", "widths", "edge_width", "block_area", "park_share"),
    *("variation", "style", "parcels", "blocks"),
)
_SIZE_KEYS = tuple(entry.name for entry in fields(ParcelSizes))
_MOST_WIDTHS = 16
_MOST_STREET = 200.0
"""Largest width of a street in metres."""
_MOST_WIDTH = 1_000.0
"""Largest frontage of a parcel in metres."""
_MOST_SIDE = 50_000.0
"""Largest side of the area in metres."""
_MOST_AREA = 1e8
"""Largest area of a block in square metres."""
_SIZE = re.compile(r"\s*(\d{1,9}(?:\.\d{1,9})?)\s*[xX×]\s*(\d{1,9}(?:\.\d{1,9})?)\s*")


@dataclass(frozen=True, slots=True, kw_only=True)
class LayoutPlan:
    """An area and how it is divided; see `LayoutRequest` for the values."""

    size: tuple[float, float] | None = DEFAULT_SIZE
    """Width to the east and depth to the north in metres; None if there is a file."""
    outline: Path | None = None
    """File with the outline of the area; None if there is a size."""
    seed: int = 0
    field: DirectionField = _DEFAULTS.field
    """Its centre is in metres from the south-west corner of the area."""
    widths: tuple[float, ...] = _DEFAULTS.widths
    edge_width: float | None = None
    block_area: tuple[float, float] = _DEFAULTS.block_area
    sizes: ParcelSizes = _DEFAULTS.sizes
    park_share: float = _DEFAULTS.park_share
    variation: float = _DEFAULTS.variation
    edits: Mapping[str, BlockEdit]

    def request(
        self, outline: shapely.Polygon | shapely.MultiPolygon | None = None, frame: Frame = NO_PLACE
    ) -> LayoutRequest:
        """The request to divide an area.

        Args:
            outline: the area of the file in metres of the frame; left out for a size.
            frame: frame of the area.

        Raises:
            UsageError: If the area is in a file and there is no outline.
        """
        if outline is None and self.size is None:
            raise UsageError(f"layout: expected the outline of {self.outline}")
        area = outline if outline is not None else shapely.box(0.0, 0.0, *(self.size or DEFAULT_SIZE))
        field = self.field
        if field.centre is not None and not area.is_empty:
            west, south, _, _ = area.bounds
            field = replace(field, centre=(field.centre[0] + west, field.centre[1] + south))
        return LayoutRequest(
            frame=frame,
            outline=area,
            seed=self.seed,
            field=field,
            widths=self.widths,
            edge_width=self.edge_width,
            block_area=self.block_area,
            sizes=self.sizes,
            park_share=self.park_share,
            variation=self.variation,
            edits=self.edits,
        )


def layout_plan(tables: PlanTables, folder: Path, seed: int) -> LayoutPlan | None:
    """The layout of a plan; None if it has none.

    Args:
        tables: tables of the plan, which collect the mistakes.
        folder: folder that paths are relative to.
        seed: seed of the plan, for a layout without its own.
    """
    keys = ("layout",)
    if tables.value(keys) is None:
        return None
    tables.table(keys, _KEYS)
    outline = tables.text((*keys, "outline"))
    if outline and tables.value((*keys, "size")) is not None:
        tables.report("conflict", "expected either a size or an outline, found both", (*keys, "size"))
    low, high = tables.numbers((*keys, "block_area"), _DEFAULTS.block_area, 200.0, _MOST_AREA)
    if low > high:
        tables.report("wrong-value", "expected the smaller area of a block first", (*keys, "block_area"))
    sizes = _sizes(tables)
    return LayoutPlan(
        size=None if outline else _size(tables),
        outline=folder / outline if outline else None,
        seed=tables.integer((*keys, "seed"), seed, 0, 2**64 - 1),
        field=_field(tables),
        widths=tables.numbers((*keys, "widths"), _DEFAULTS.widths, 2.0, _MOST_STREET, most=_MOST_WIDTHS),
        edge_width=tables.optional_number((*keys, "edge_width"), 0.0, _MOST_STREET),
        block_area=(low, high),
        sizes=sizes,
        park_share=tables.number((*keys, "park_share"), _DEFAULTS.park_share, 0.0, 1.0),
        variation=tables.number((*keys, "variation"), _DEFAULTS.variation, 0.0, 0.2),
        edits={name: _edit(tables, (*keys, "blocks", name), sizes) for name in tables.table((*keys, "blocks"), None)},
    )


def _size(tables: PlanTables) -> tuple[float, float]:
    text = tables.text(("layout", "size"))
    match = _SIZE.fullmatch(text)
    width, depth = (float(match[1]), float(match[2])) if match else (0.0, 0.0)
    if text and not (0.0 < width <= _MOST_SIDE and 0.0 < depth <= _MOST_SIDE):
        message = f'expected size = "600x400", metres up to {_MOST_SIDE:,.0f}, found {shown(text)}'
        tables.report("wrong-value", message, ("layout", "size"))
    return (width, depth) if text else DEFAULT_SIZE


def _field(tables: PlanTables) -> DirectionField:
    centre = None
    if tables.value(("layout", "centre")) is not None:
        east, north = tables.numbers(("layout", "centre"), (300.0, 200.0), -1e7, 1e7)
        centre = (east, north)
    return DirectionField(
        kind=tables.choice(("layout", "field"), FIELD_KINDS) or _DEFAULTS.field.kind,
        angle=tables.optional_number(("layout", "angle"), -360.0, 360.0),
        centre=centre,
    )


def _sizes(tables: PlanTables) -> ParcelSizes:
    """Sizes of parcels: those of the style, but for those that are given."""
    keys = ("layout", "parcels")
    tables.table(keys, _SIZE_KEYS)
    style = tables.choice(("layout", "style"), tuple(STYLES))
    return _read_sizes(tables, keys, STYLES[style] if style else _DEFAULTS.sizes)


def _read_sizes(tables: PlanTables, keys: Keys, default: ParcelSizes) -> ParcelSizes:
    return ParcelSizes(
        area=tables.number((*keys, "area"), default.area, 5.0, _MOST_AREA),
        spread=tables.number((*keys, "spread"), default.spread, 0.0, 3.0),
        frontage=tables.number((*keys, "frontage"), default.frontage, 1.0, _MOST_WIDTH),
        aspect=tables.number((*keys, "aspect"), default.aspect, 1.0, 100.0),
        aspect_spread=tables.number((*keys, "aspect_spread"), default.aspect_spread, 0.0, 3.0),
    )


def _edit(tables: PlanTables, keys: Keys, sizes: ParcelSizes) -> BlockEdit:
    table = tables.table(keys, ("seed", "use", *_SIZE_KEYS))
    has_sizes = any(name in table for name in _SIZE_KEYS)
    return BlockEdit(
        seed=tables.integer((*keys, "seed"), 0, 0, 2**64 - 1) if "seed" in table else None,
        use=tables.choice((*keys, "use"), BLOCK_USES),
        sizes=_read_sizes(tables, keys, sizes) if has_sizes else None,
    )
