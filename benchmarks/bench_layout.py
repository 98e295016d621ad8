"""Layouts without a map: time, and distances from measured maps."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from grammarlab.arrays import Floats
from grammarlab.city.city_layout import Layout, laid_out
from grammarlab.city.direction_field import FIELD_KINDS, DirectionField
from grammarlab.city.layout_request import STYLES, LayoutRequest, ParcelSizes

SHARES = (0.05, 0.5, 0.95)
TABLE = {
    "paris": ((53, 229, 1890), (1.05, 1.67, 5.0)),
    "suburb": ((17, 370, 1764), (1.14, 2.74, 10.7)),
    "villas": ((465, 996, 6643), (1.03, 1.29, 2.35)),
}
"""Quantiles of areas in square metres and of aspects: Paris 18e, Epinay-sur-Orge, Kumasi."""
MOST_DISTANCE = 0.15
"""Target: Kolmogorov distance at these quantiles."""


def layout_of(side: float, kind: str, sizes: ParcelSizes) -> Layout:
    outline = shapely.box(0, 0, side, 0.8 * side)
    field = DirectionField(kind)  # type: ignore[arg-type, ty:invalid-argument-type]
    return laid_out(LayoutRequest(outline=outline, field=field, sizes=sizes, park_share=0.0, seed=1))


def distance(values: Floats, quantiles: tuple[float, ...]) -> float:
    """Largest difference from the distribution of a map, at the three points that are known of it."""
    shares = (values[:, None] < np.array(quantiles)).mean(axis=0)
    return float(np.abs(shares - SHARES).max())


@pytest.mark.parametrize("kind", FIELD_KINDS)
def test_lay_out_10000_parcels(benchmark, kind):
    layout = benchmark.pedantic(layout_of, (2_450.0, kind, ParcelSizes()), rounds=3)
    assert len(layout.parcels) > 9_000
    benchmark.extra_info |= {"parcels": len(layout.parcels), "blocks": len(layout.blocks)}


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("kind", FIELD_KINDS)
def test_sizes_of_parcels(benchmark, style, kind):
    layout = benchmark.pedantic(layout_of, (1_500.0, kind, STYLES[style]), rounds=1)
    corners = shapely.get_coordinates(shapely.oriented_envelope(layout.parcels.outline)).reshape(-1, 5, 2)
    sides = np.linalg.norm(np.diff(corners, axis=1), axis=2)
    area, aspect = TABLE[style]
    distances = {
        "area": distance(layout.parcels.area, area),
        "aspect": distance(sides.max(axis=1) / sides.min(axis=1), aspect),
    }
    benchmark.extra_info |= distances
    assert max(distances.values()) <= MOST_DISTANCE
