"""Selectors of ``comp``: ``front``, ``world.up``, ``aslant``, ``border``, ``ridge`` and others."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats
from grammarlab.geometry.components import EAVE, HIP, RIDGE, VALLEY, ComponentMeshes

TIE = 1e-6
"""Tolerance for equal components of a unit normal: on the border of two quadrants a normal is in both."""

STEEP, GENTLE = np.sin(np.radians(11.25)), np.sin(np.radians(78.75))
"""Height of a unit normal at the thresholds of ``vertical`` and ``horizontal``."""

_QUADRANTS = {"top": (1, 1), "bottom": (1, -1), "front": (2, 1), "back": (2, -1), "right": (0, 1), "left": (0, -1)}
_WORLD = {"up": "top", "down": "bottom", "south": "front", "north": "back", "east": "right", "west": "left"}
_ROOF = {"eave": EAVE, "hip": HIP, "valley": VALLEY, "ridge": RIDGE}

ORIENTATIONS: tuple[str, ...] = (
    *_QUADRANTS,
    "side",
    *(f"object.{name}" for name in (*_QUADRANTS, "side")),
    *(f"world.{name}" for name in (*_WORLD, "side")),
    *(f"street.{name}" for name in ("front", "back", "left", "right", "side")),
)
"""Selectors that classify a normal; ``geometry.isOriented`` and ``geometry.area`` accept the same ones."""

SELECTORS: tuple[str, ...] = (
    *ORIENTATIONS,
    "vertical",
    "horizontal",
    "aslant",
    "nutant",
    "border",
    "inside",
    *_ROOF,
    "all",
)
"""All selectors of `select`."""


def select(components: ComponentMeshes, selector: str) -> Flags:
    """[K] whether a selector picks each component, in the axes of its mesh: prefixes such as ``world`` change nothing.

    Args:
        components: result of `faces`, `edges` or `vertices`.
        selector: one of `SELECTORS`.

    Raises:
        KeyError: If the selector does not exist.
    """
    if selector == "all":
        return np.ones(len(components), bool)
    if selector in ("border", "inside"):
        return components.is_border if selector == "border" else ~components.is_border
    if selector in _ROOF:
        return components.roof_edge == _ROOF[selector]
    return classify(components.direction, selector)


def classify(directions: Floats, selector: str) -> Flags:
    """[K] whether a selector picks each normal; zero vectors are never picked.

    A quadrant has the directions that no other axis is nearer to than its own: x is right, y top, z front; for the
    world east, up and south. A direction between two axes is in both quadrants, as in CityEngine.

    Args:
        directions: [K, 3] unit vectors or zero, in the axes that the selector's prefix names.
        selector: one of `ORIENTATIONS`, or ``vertical``, ``horizontal``, ``aslant``, ``nutant``.

    Raises:
        KeyError: If the selector does not exist.
    """
    prefix, _, name = selector.rpartition(".")
    solid = directions.any(axis=1)
    height = directions[:, 1]
    if name == "side":
        # Without a prefix CGA selects all except horizontal faces; with one, the four lateral quadrants.
        lateral = _in_quadrant(directions, 0) | _in_quadrant(directions, 2)
        return solid & (lateral if prefix else np.abs(height) <= GENTLE)
    if not prefix and name in ("vertical", "horizontal", "aslant", "nutant"):
        return solid & _by_slope(height, name)
    quadrant = _WORLD[name] if prefix == "world" else name
    axis, sign = _QUADRANTS[quadrant]
    return solid & _in_quadrant(directions, axis) & (directions[:, axis] * sign > 0.0)


def _in_quadrant(directions: Floats, axis: int) -> Flags:
    """[K] whether no other axis is nearer to each direction."""
    lengths = np.abs(directions)
    return lengths[:, axis] >= lengths.max(axis=1) - TIE


def nearest_axis(directions: Floats) -> NDArray[np.int64]:
    """[K] the axis that each direction is nearest to; of equal ones y comes first, then z."""
    x, y, z = np.abs(directions).T
    lateral = np.where(z >= x - TIE, 2, 0)
    return np.where(y >= np.maximum(x, z) - TIE, 1, lateral)


def _by_slope(height: Floats, name: str) -> Flags:
    """[K] whether unit normals of these heights belong to vertical, horizontal, aslant or nutant faces."""
    if name == "horizontal":
        return np.abs(height) > GENTLE
    if name == "vertical":
        return (height > -STEEP) & (height <= STEEP)
    if name == "aslant":
        return (height > STEEP) & (height <= GENTLE)
    return (height > -GENTLE) & (height <= -STEEP)
