"""Surveys of lots: parcels to build on with their edges along streets."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.city.lot_edges import LotEdges, simplified
from grammarlab.city.mapped_street_widths import with_mapped_widths
from grammarlab.city.packed_outlines import row_blocks
from grammarlab.city.parcel_reasons import NARROW, SMALL, STREET
from grammarlab.city.parcels import Parcels
from grammarlab.city.plan import Plan
from grammarlab.city.plan_fields import PlanFields
from grammarlab.city.street_edges import street_widths
from grammarlab.city.street_lines import StreetLines
from grammarlab.errors import UsageError

_SOLID = ("", SMALL, NARROW)
"""Reasons of parcels that are ground of their own: others behind them are cut off from the street."""


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

    @property
    def frontage(self) -> Floats:
        """[S] metres along streets."""
        return self._fronts[0]

    @property
    def widest_street(self) -> Floats:
        """[S] width of the widest street in metres, 0 for none."""
        return self._fronts[1]

    @cached_property
    def _fronts(self) -> tuple[Floats, Floats]:
        """`frontage` and `widest_street`, of a few lots at a time, as edges have many columns."""
        frontage, widest = np.zeros(len(self)), np.zeros(len(self))
        for lots in row_blocks(len(self)):
            edges, corners = self.edges.take(lots)
            widths = self.street_width[corners]
            length = np.where(widths > 0.0, edges.length, 0.0)
            frontage[lots] = np.bincount(edges.outline, length, minlength=len(lots))
            np.maximum.at(widest, lots[edges.outline], widths)
        return frontage, widest


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
    reason = parcels.reason if not plan.street_plots else _with_streets(plan, parcels, fields)
    parcel = np.flatnonzero(reason == "")
    lots = parcels.outlines.take(parcel)
    edges = LotEdges.concatenate([LotEdges.of(simplified(outline)) for _, outline in lots.blocks()])
    widths = street_widths(edges, parcels.outlines, parcel, streets, ~np.isin(reason, _SOLID))
    if plan.street_width is not None:
        try:
            widths = with_mapped_widths(edges, widths, parcels, parcel, fields, plan.street_width)
        except UsageError as error:
            raise UsageError(f"{plan.path}: street_width: {error}") from error
    return LotSurvey(reason=reason, parcel=parcel, edges=edges, street_width=widths)


def _with_streets(plan: Plan, parcels: Parcels, fields: PlanFields) -> NDArray[np.object_]:
    """[N] reasons with streets by the condition of the plan, instead of by their shape."""
    try:
        is_street = fields.holds(plan.street_plots)
    except UsageError as error:
        raise UsageError(f"{plan.path}: street_plots: {error}") from error
    reason = np.where(parcels.reason == STREET, "", parcels.reason)
    return np.where((reason == "") & is_street, STREET, reason).astype(object)
