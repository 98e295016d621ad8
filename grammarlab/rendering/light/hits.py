"""Hits of rays, and the interface of what finds them."""

from __future__ import annotations

import abc
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.floating]


@dataclass(frozen=True, slots=True)
class Hits:
    """The nearest hits of N rays."""

    triangle: NDArray[np.int32]
    """[N] triangle, -1 for none."""
    distance: Floats
    """[N] distance along the ray; huge without a hit."""
    u: Floats
    """[N] weight of the triangle's second corner."""
    v: Floats
    """[N] weight of its third."""


class AbstractScene(abc.ABC):
    """At least one triangle for at least one ray; origins and directions are contiguous [N, 3], in single precision."""

    @abc.abstractmethod
    def first_hit(self, origins: Floats, directions: Floats) -> Hits:
        """The nearest triangle in front of each ray."""

    @abc.abstractmethod
    def is_blocked(self, origins: Floats, directions: Floats, reach: float | None) -> NDArray[np.bool_]:
        """[N] whether a triangle lies on each ray, no farther than `reach`."""
