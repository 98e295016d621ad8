"""Weights of the parts of a layout's energy."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from grammarlab.errors import FacadeError


@dataclass(frozen=True, slots=True)
class Weights:
    """The energy of a layout is omega * errors of columns + merge * merged letters + sizing * error of sizes."""

    omega: float = 1.0
    """Energy per metre of error of columns (Equation 9)."""
    merge: float = 0.05
    """Energy per letter of an element beyond its first: without it, one column for all would often be best."""
    sizing: float = 1.0
    """Energy per square metre of the sum of squared deviations from preferred sizes."""

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and 0.0 <= value <= 1e6):
                raise FacadeError(f"Weight {field.name}: expected a number from 0 to 1,000,000, found {value}.")
