"""Options for the unit and the up axis of meshes and scans."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer


class Up(StrEnum):
    """Up axis of a file."""

    auto = "auto"
    y = "y"
    z = "z"

    @property
    def axis(self) -> str:
        """The axis; empty if it is to be detected."""
        return "" if self is Up.auto else self.value


class Unit(StrEnum):
    """Unit of length of a file."""

    m = "m"
    cm = "cm"
    mm = "mm"
    ft = "ft"


UpOption = Annotated[Up, typer.Option("--up", help="Up axis of the file.")]
UnitOption = Annotated[Unit, typer.Option("--unit", help="Unit of the coordinates of the file.")]
