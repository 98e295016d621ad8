"""Surveys of lots: parcels to build on with their edges along streets."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.city.lot_edges import LotEdges, simplified
from grammarlab.city.parcels import Parcels
from grammarlab.city.plan import Plan
from grammarlab.city.plan_fields import PlanFields
from grammarlab.city.street_edges import street_widths
from grammarlab.city.street_lines import StreetLines
from grammarlab.errors import UsageError

STREET = "street"
"""Reason of parcels that are streets."""
OVERLAP = "overlap"
"""Reason of parcels that lie on another one: they do not cut that one off from its street."""
_STREET_ROUNDNESS = 0.1
"""Largest 4 pi A / P² of a street; a square has .79, a lot 100 m deep and 5 m wide .14."""
_STREET_AREA = 500.0
"""Smallest area of a street in square metres."""


@dataclass(frozen=True, eq=False, kw_only=True)
class LotSurvey:
    """S lots among N parcels."""

    reason: NDArray[np.object_]
    """[N] why a parcel is not a lot; empty for lots."""
    parcel: Ints
    """[S] row of the parcel of each lot, ascending."""
    edges: LotEdges
    """Edges of the lots, P in all, without corners that change little."""
    street_width: Floats
    """[P] width of the street along each edge in metres, 0 for none."""

    def __len__(self) -> int:
        return len(self.parcel)

    @cached_property
    def frontage(self) -> Floats:
        """[S] metres along streets."""
        length = np.where(self.street_width > 0.0, self.edges.length, 0.0)
        return np.bincount(self.edges.outline, length, minlength=len(self)).astype(np.float64)

    @cached_property
    def widest_street(self) -> Floats:
        """[S] width of the widest street in metres, 0 for none."""
        widest = np.zeros(len(self))
        np.maximum.at(widest, self.edges.outline, self.street_width)
        return widest


def surveyed_lots(plan: Plan, parcels: Parcels, streets: StreetLines | None) -> LotSurvey:
    """The lots among parcels.

    Args:
        plan: the plan.
        parcels: N parcels.
        streets: lines of streets; None if they are unknown.

    Raises:
        UsageError: If a field of the plan is unknown or has other values.
    """
    fields = PlanFields(parcels.attributes, {"area": parcels.area})
    is_street = _is_street(plan, parcels, fields)
    reason = np.where(parcels.usable & is_street, STREET, parcels.reason).astype(object)
    parcel = np.flatnonzero(reason == "")
    edges = LotEdges.of(simplified(parcels.outline[parcel]))
    has_no_say = is_street | (parcels.reason == OVERLAP)
    widths = street_widths(edges, parcels.outline, parcel, streets, has_no_say)
    if plan.street_width is not None:
        widths = _replaced(plan, fields, parcel[edges.outline], widths)
    return LotSurvey(reason=reason, parcel=parcel, edges=edges, street_width=widths)


def _is_street(plan: Plan, parcels: Parcels, fields: PlanFields) -> Flags:
    """[N] whether a parcel is a street: by the condition of the plan, or as it is long and thin."""
    if plan.street_plots:
        try:
            return fields.holds(plan.street_plots)
        except UsageError as error:
            raise UsageError(f"{plan.path}: street_plots: {error}") from error
    area, perimeter = parcels.area, shapely.length(parcels.outline)
    roundness = 4.0 * np.pi * area / np.maximum(perimeter, np.finfo(float).tiny) ** 2
    return (roundness < _STREET_ROUNDNESS) & (area > _STREET_AREA)


def _replaced(plan: Plan, fields: PlanFields, parcel: Ints, widths: Floats) -> Floats:
    """[P] widths with those of the field of the plan on edges along streets, where it has any."""
    try:
        known = fields.as_numbers(plan.street_width or "")[parcel]
    except UsageError as error:
        raise UsageError(f"{plan.path}: street_width: {error}") from error
    return np.where(np.isnan(known) | (widths <= 0.0), widths, np.maximum(known, 0.0))
