"""Numbers of annotations: finite and bounded, so that sums and rotations of them are finite too."""

from __future__ import annotations

import math
from typing import Any

from grammarlab.errors import FacadeError
from grammarlab.facade.boxes.annotation import FARTHEST
from grammarlab.facade.values import shown

_MAX_DIGITS = 400
"""Longest text that is read as a number."""


def coordinate(value: Any, where: str) -> float:
    """A number, or the text of a number, as a coordinate.

    Args:
        value: the value in the file.
        where: its position in messages.

    Raises:
        FacadeError: If it is not a finite number, or is beyond `FARTHEST`.
    """
    number = _number(value)
    if not math.isfinite(number):
        raise FacadeError(f"{where}: expected a finite number, found {shown(value)}.")
    if abs(number) > FARTHEST:
        raise FacadeError(f"{where}: expected at most {FARTHEST:g}, found {shown(value)}.")
    return number


def known_size(width: Any, height: Any) -> tuple[float, float] | None:
    """Width and height of a picture in pixels; None if they are missing, zero or negative, as some programs write."""
    size = _number(width), _number(height)
    return size if all(0.0 < side <= FARTHEST for side in size) else None


def _number(value: Any) -> float:
    """The value as a number; not a number for anything else."""
    if isinstance(value, str) and len(value) <= _MAX_DIGITS and "_" not in value:
        try:
            return float(value)
        except ValueError:
            return math.nan
    if isinstance(value, int | float) and not isinstance(value, bool):
        try:
            return float(value)
        except OverflowError:
            return math.inf
    return math.nan
