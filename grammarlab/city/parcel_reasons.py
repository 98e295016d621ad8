"""Reasons why nothing is built on a parcel of a map: short words that files and programs can rely on."""

from __future__ import annotations

GEOMETRY = "geometry"
COORDINATES = "coordinates"
CORNERS = "corners"
TILTED = "tilted"
INVALID = "invalid"
DUPLICATE = "duplicate"
OVERLAP = "overlap"
STREET = "street"
SMALL = "small"
NARROW = "narrow"

REASONS = {
    GEOMETRY: "no polygon: a point, a line, an empty geometry or none",
    COORDINATES: "coordinates that are not finite, or farther than 1,000 km from the middle of the map",
    CORNERS: "more than 10,000 corners",
    TILTED: "a face in space, inclined by more than 30 degrees",
    INVALID: "it crosses itself, and its area would change by more than 5 % if it did not",
    DUPLICATE: "the same outline as a parcel with a smaller id",
    OVERLAP: "less than 1 m² that no parcel with a smaller id covers",
    STREET: "a street: more than 500 m², long and narrow (4πA/P² < 0.1)",
    SMALL: "less than 30 m²",
    NARROW: "a side of the smallest box around it below 2 m",
}
"""What each reason means. If several apply, the first one is given."""
