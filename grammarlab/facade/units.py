"""Units of length and up axes of meshes and scans from other programs."""

from __future__ import annotations

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "ft": 0.3048}
"""Length of units of files, metres."""
UP_AXES = {"z": [0, 1, 2], "y": [2, 0, 1]}
"""For each axis that may be up, the columns of points [P, 3] in the order along, across and up."""
