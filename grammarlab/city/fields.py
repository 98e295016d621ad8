"""Fields: numbers about parcels on which zones and attributes may depend, with their places."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.city.packed_outlines import PackedOutlines
from grammarlab.city.parcels import Parcels
from grammarlab.errors import UsageError, shown
from grammarlab.geometry.footprints.frame import Frame

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

METRES_PER_KM = 1000.0
_MIN_SIDE = 0.01
"""Smallest side in metres of the box of an outline, for finite ratios."""
_MAX_NAMED = 12
"""Most fields that a message lists."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ParcelFields:
    """Numbers about N parcels, in the order of the parcels."""

    frame: Frame
    id: NDArray[np.object_]
    """[N] ids of the parcels."""
    east_north: Floats
    """[N, 2] a point inside each parcel, in metres from the frame's origin."""
    name: tuple[str, ...]
    """[F] different names."""
    unit: tuple[str, ...]
    """[F] units: ``m``, ``m²``; empty for plain numbers."""
    values: Floats
    """[N, F] NaN where a value is unknown."""

    def __post_init__(self) -> None:
        shape = (len(self.id), len(self.name))
        if self.values.shape != shape or self.east_north.shape != (shape[0], 2) or len(self.unit) != shape[1]:
            raise UsageError("fields: expected a row per parcel, and a column and a unit per name")
        if len(set(self.name)) != len(self.name):
            raise UsageError(f"fields: expected different names, found {shown(', '.join(self.name))}")

    def __len__(self) -> int:
        return len(self.id)

    def columns(self, names: Sequence[str]) -> Floats:
        """[N, len(names)] columns by their names.

        Raises:
            UsageError: If a field is missing.
        """
        missing = [name for name in names if name not in self.name]
        if missing:
            raise UsageError(
                f"unknown field {shown(missing[0])}; expected one of {', '.join(self.name[:_MAX_NAMED]) or 'none'}. "
                "Name it in the plan, or use a map that has this column."
            )
        return self.values[:, [self.name.index(name) for name in names]]

    def take(self, rows: NDArray[np.integer] | NDArray[np.bool_]) -> ParcelFields:
        """The parcels at these rows (indices or flags), in this order."""
        return replace(self, id=self.id[rows], east_north=self.east_north[rows], values=self.values[rows])

    def with_field(self, name: str, unit: str, values: Floats) -> ParcelFields:
        """These fields and one more [N]."""
        return replace(
            self,
            name=(*self.name, name),
            unit=(*self.unit, unit),
            values=np.column_stack([self.values, np.where(np.isfinite(values), values, np.nan)]),
        )


def parcel_fields(
    parcels: Parcels,
    *,
    frontage: Floats | None = None,
    street_width: Floats | None = None,
    near: Mapping[str, BaseGeometry] | None = None,
    rasters: Mapping[str, Floats] | None = None,
    attributes: Sequence[str] = (),
) -> ParcelFields:
    """The fields of parcels: ``area`` in m², ``aspect`` (long by short side of the smallest box), and given ones.

    Args:
        parcels: N parcels.
        frontage: [N] metres along streets; makes ``frontage``.
        street_width: [N] width in metres of the widest street along a parcel, 0 without one; makes ``street_width``.
        near: points, lines or areas by names of fields, in metres from the frame's origin: the distance in metres from
            a point inside the parcel.
        rasters: [N] values of rasters by names of fields.
        attributes: names of columns of numbers or flags of the map; those with the name of another field are left out.

    Raises:
        UsageError: If an attribute is missing or not numeric, or two fields have one name.
    """
    fields = ParcelFields(
        frame=parcels.frame,
        id=parcels.id,
        east_north=points_inside(parcels.outlines),
        name=("area", "aspect"),
        unit=("m²", ""),
        values=np.column_stack([parcels.area, _aspects(parcels.outlines)]),
    )
    if frontage is not None:
        fields = fields.with_field("frontage", "m", frontage)
    if street_width is not None:
        fields = fields.with_field("street_width", "m", street_width)
    points = shapely.points(fields.east_north)
    for name, geometry in (near or {}).items():
        shapely.prepare(geometry)
        fields = fields.with_field(name, "m", np.asarray(shapely.distance(geometry, points)))
    if np.isfinite(parcels.elevation).any():
        fields = fields.with_field("elevation", "m", parcels.elevation)
    for name, values in (rasters or {}).items():
        fields = fields.with_field(name, "", values)
    for name in [name for name in attributes if name not in fields.name]:
        fields = fields.with_field(name, "", numeric_attribute(parcels, name))
    return fields


def numeric_attribute(parcels: Parcels, name: str) -> Floats:
    """[N] a column of the map as numbers, NaN where there is none.

    Raises:
        UsageError: If the map has no such column of numbers or flags.
    """
    names, numeric = parcels.attributes.column_names, numeric_attributes(parcels)
    if name not in numeric:
        raise UsageError(
            f"attribute {shown(name)}: expected a column of numbers, one of {', '.join(numeric[:_MAX_NAMED]) or 'none'}"
            + (", found a column of texts." if name in names else ".")
        )
    column = pc.cast(parcels.attributes.column(name), pa.float64(), safe=False)
    return column.to_numpy(zero_copy_only=False).astype(np.float64)


def numeric_attributes(parcels: Parcels) -> tuple[str, ...]:
    """Names of the columns of numbers or flags of a map."""
    return tuple(field.name for field in parcels.attributes.schema if _is_numeric(field.type))


def _is_numeric(kind: pa.DataType) -> bool:
    return pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_boolean(kind)


def points_inside(outlines: PackedOutlines) -> Floats:
    """[N, 2] a point inside each outline."""
    points = [shapely.get_coordinates(shapely.point_on_surface(outline)) for _, outline in outlines.blocks()]
    return np.concatenate([np.zeros((0, 2)), *points])


def _aspects(outlines: PackedOutlines) -> Floats:
    """[N] long by short side of the smallest box around each outline, >= 1."""
    return np.concatenate([np.zeros(0), *(_aspect(outline) for _, outline in outlines.blocks())])


def _aspect(outlines: NDArray[np.object_]) -> Floats:
    corners = shapely.get_coordinates(shapely.get_exterior_ring(shapely.oriented_envelope(outlines))).reshape(-1, 5, 2)
    one, other = (np.hypot(*(corners[:, index + 1] - corners[:, index]).T) for index in (0, 1))
    return np.maximum(one, other) / np.maximum(np.minimum(one, other), _MIN_SIDE)
