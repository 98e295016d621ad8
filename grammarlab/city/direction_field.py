"""Directions of streets: a cross of two perpendicular directions at every point."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

FieldKind: TypeAlias = Literal["grid", "radial", "mixed"]
"""``grid``: the same directions everywhere; ``radial``: to and around a centre; ``mixed``: radial near the centre,
along the outline near the outline, and a grid between them."""
FIELD_KINDS: tuple[FieldKind, ...] = ("grid", "radial", "mixed")


@dataclass(frozen=True, slots=True)
class DirectionField:
    """A cross of two perpendicular directions at every point of the plane."""

    kind: FieldKind = "grid"
    angle: float | None = None
    """Degrees from the east to one of the directions of the grid, counter-clockwise; None for the direction of the
    smallest box around the outline."""
    centre: tuple[float, float] | None = None
    """Centre in metres of the frame; None for the middle of the outline."""
