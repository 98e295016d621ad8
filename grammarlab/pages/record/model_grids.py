"""Shown models in grids, and checks of foreign names and addresses."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from grammarlab.errors import UsageError, shown
from grammarlab.learning.designs.addresses import Address

PAIRS = "pairs"
"""The strategy that shows two models at a time: those at the same place of two grids."""
MAX_SIDE, MAX_GRIDS = 10, 2
"""Rows and columns of a grid as it is chosen, and grids, at most."""
MAX_GRID = 200
"""Largest number of models of a grid; further ones are shown below those that were chosen first."""
MAX_MODELS = 20_000
"""Largest number of models in one event."""
MAX_NAME = 60
"""Largest number of characters of a name."""
MAX_TITLE = 120
"""Largest number of characters of the title of a grid, which may name several kinds of models."""

_CONTROL = re.compile(r"[\x00-\x1f\x7f]")

Body = Mapping[str, Any]
"""Content of an event."""


@dataclass(frozen=True, slots=True)
class GridLayout:
    """Number and layout of shown models."""

    grids: int = 2
    rows: int = 4
    columns: int = 4

    @property
    def models(self) -> int:
        """Number of models in all grids."""
        return self.grids * self.rows * self.columns


@dataclass(frozen=True, slots=True)
class ModelGrid:
    """Models side by side."""

    title: str
    models: tuple[str, ...]

    def as_json(self) -> Body:
        """JSON of the grid in events."""
        return {"title": self.title, "models": list(self.models)}


def checked_models(value: object, most: int = MAX_MODELS) -> list[str]:
    """Addresses of different models.

    Raises:
        UsageError: If they are not addresses, or too many.
    """
    if not isinstance(value, list) or len(value) > most:
        raise UsageError(f"models: expected a list of at most {most:,}, found {shown(value)}.")
    for text in value:
        Address.parse(text)
    if len(set(value)) < len(value):
        raise UsageError("models: expected different ones, found one twice.")
    return value


def checked_name(value: object) -> str:
    """A name for a factor.

    Raises:
        UsageError: If it is not a name.
    """
    if not isinstance(value, str) or not value.strip() or len(value) > MAX_NAME or _CONTROL.search(value):
        raise UsageError(f"name: expected one line of 1 to {MAX_NAME} characters, found {shown(value)}.")
    return value


def check_layout(body: Body) -> None:
    """Check the number of shown models in an event.

    Raises:
        UsageError: If it is not valid.
    """
    for name, most in (("grids", MAX_GRIDS), ("rows", MAX_SIDE), ("columns", MAX_SIDE)):
        value = body.get(name)
        if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= most:
            raise UsageError(f"{name}: expected a number from 1 to {most}, found {shown(value)}.")


def check_shown(body: Body) -> None:
    """Check the shown models in an event.

    Raises:
        UsageError: If they are not valid.
    """
    grids, way = body.get("grids"), body.get("way")
    if not isinstance(way, str) or len(way) > MAX_NAME:
        raise UsageError(f"way: expected a name, found {shown(way)}.")
    if not isinstance(grids, list) or len(grids) > MAX_GRIDS:
        raise UsageError(f"grids: expected at most {MAX_GRIDS}, found {shown(grids)}.")
    for grid in grids:
        title = grid.get("title") if isinstance(grid, dict) else None
        if not isinstance(title, str) or len(title) > MAX_TITLE:
            raise UsageError(f"grids: expected a title and models for each, found {shown(grid)}.")
        checked_models(grid.get("models"), MAX_GRID)
    if way == PAIRS:
        sides = [grid["models"] for grid in grids]
        if len(sides) != MAX_GRIDS or len(sides[0]) != len(sides[1]):
            raise UsageError(f"grids: expected two of as many models for pairs, found {shown(grids)}.")
        for pair in zip(*sides, strict=True):
            checked_models(list(pair))
