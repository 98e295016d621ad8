"""Values of attributes of the rules on sites: those of the plan, and the ground below each footprint."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from grammarlab.arrays import Flags, Ints
from grammarlab.city.ground_heights import GroundHeights
from grammarlab.city.plan import FieldFormula, Plan, PlanValue
from grammarlab.city.plan_fields import FieldColumn, PlanFields
from grammarlab.derivation.lots import AttributeColumn
from grammarlab.errors import UsageError

GROUND_LEVEL = "groundMin"
"""Attribute with the lowest height of the ground; rules that have it reach down to the ground by themselves."""
GROUND = (GROUND_LEVEL, "groundMax", "groundMean")
"""Attributes with the lowest, highest and mean height of the ground below the outline, in metres above the base."""


def site_attributes(
    plan: Plan, zone: Ints, fields: PlanFields, row: Ints, ground: GroundHeights
) -> Mapping[str, AttributeColumn]:
    """Values of attributes by name.

    Args:
        plan: the plan.
        zone: [S] zone of each site.
        fields: fields of the parcels.
        row: [S] row of each site among the fields.
        ground: heights of the ground of the sites.

    Raises:
        UsageError: If a formula cannot be evaluated, or zones have values of different kinds for an attribute.
    """
    columns = {
        name: AttributeColumn(values - ground.base, ~np.isnan(values))
        for name, values in zip(GROUND, (ground.lowest, ground.highest, ground.mean), strict=True)
    }
    names = dict.fromkeys(name for entry in plan.zones for name in entry.attributes)
    return columns | {name: _column(plan, name, zone, fields, row) for name in names}


def _column(plan: Plan, name: str, zone: Ints, fields: PlanFields, row: Ints) -> AttributeColumn:
    """The values of one attribute in all zones."""
    parts: list[tuple[Flags, FieldColumn, Flags]] = []
    for number, entry in enumerate(plan.zones):
        if name in entry.attributes:
            try:
                values, is_given = _values(entry.attributes[name], fields, row)
            except UsageError as error:
                raise UsageError(f"{plan.path}: zone {entry.name!r}: attribute {name}: {error}") from error
            parts.append((zone == number, values, is_given))
    kinds = {_kind(values) for _, values, _ in parts}
    if len(kinds) > 1:
        raise UsageError(
            f"{plan.path}: attribute {name}: expected one kind of value in all zones, found "
            f"{' and '.join(sorted(kinds))}"
        )
    is_given = np.zeros(len(row), np.bool_)
    column = np.zeros(len(row), parts[0][1].dtype)
    for is_here, values, has_value in parts:
        column[is_here], is_given[is_here] = values[is_here], has_value[is_here]
    if column.dtype == np.object_:
        column[~is_given] = ""
        return AttributeColumn(column.astype(np.str_), is_given)
    return AttributeColumn(np.where(is_given, column, np.zeros(1, column.dtype)), is_given)


def _values(value: PlanValue | FieldFormula, fields: PlanFields, row: Ints) -> tuple[FieldColumn, Flags]:
    """[S] values of an attribute in one zone, and whether there are any."""
    if isinstance(value, FieldFormula):
        values, is_given = fields.formula(value.text)
        return values[row], is_given[row]
    constant = np.full(len(row), value, object if isinstance(value, str) else type(value))
    return constant, np.ones(len(row), np.bool_)


def _kind(values: FieldColumn) -> str:
    return {"O": "text", "b": "flag"}.get(values.dtype.kind, "number")
