"""Weights of the parts of a layout's energy."""

from __future__ import annotations

from dataclasses import dataclass, fields

from grammarlab.errors import FacadeError

SMALLEST, LARGEST = 1e-9, 1e6
"""Smallest and largest weight above 0: ratios of weights are finite numbers."""


def is_weight(value: float) -> bool:
    """Whether a number can be a weight."""
    return value == 0.0 or SMALLEST <= value <= LARGEST


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
            if not is_weight(value):
                raise FacadeError(
                    f"Weight {field.name}: expected 0, or a number from {SMALLEST:g} to {LARGEST:,.0f}, found {value}."
                )
