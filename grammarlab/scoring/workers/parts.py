"""Visible parts of a viewed model, and their rules."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.errors import UsageError
from grammarlab.learning.designs.design_space import AbstractParts
from grammarlab.scoring.workers.tasks import FoundPart


@dataclass(frozen=True, slots=True)
class PartFinder:
    """Parts of one model."""

    model: str
    """Address."""
    parts: AbstractParts

    def find(self, number: int, is_triangle: bool) -> FoundPart:
        """A part by its number modulo the number of parts, or by the number of one of its triangles.

        Raises:
            UsageError: If there is no such triangle, or no part.
        """
        part_of = self.parts.of_triangles
        if not len(part_of):
            raise UsageError("the model has no visible part.")
        if is_triangle and not 0 <= number < len(part_of):
            raise UsageError(f"triangle: expected 0 to {len(part_of) - 1}, found {number}.")
        num_parts = int(part_of.max()) + 1
        part = int(part_of[number]) if is_triangle else number % num_parts
        triangles = np.flatnonzero(part_of == part)
        return FoundPart(part, num_parts, (int(triangles[0]), int(triangles[-1]) + 1), self.parts.way_to(part))
