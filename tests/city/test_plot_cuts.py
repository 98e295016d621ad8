from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
import shapely
from shapely.ops import split

from grammarlab.arrays import offsets_from_counts
from grammarlab.city.plot_cuts import Plots, cuts_along, parts_of, smallest_boxes

RNG = np.random.default_rng(2)


def plots_of(polygons: Sequence[Any]) -> Plots:
    rings = [np.array(shapely.orient_polygons(polygon).exterior.coords)[:-1] for polygon in polygons]
    corners = np.concatenate(rings)
    return Plots(corners, RNG.random(len(corners)) < 0.5, offsets_from_counts(np.array([len(ring) for ring in rings])))


def stars(num: int) -> list[shapely.Polygon]:
    """Simple polygons, mostly concave, of 3 to 9 corners."""
    polygons = []
    for _ in range(num):
        angle = np.sort(RNG.uniform(0, 2 * np.pi, RNG.integers(5, 10)))
        radius = RNG.uniform(10, 40, len(angle))
        points = np.round(np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1), 3)
        polygons.append(shapely.Polygon(points))
    return [polygon for polygon in polygons if polygon.is_valid and polygon.area > 20]


def test_columns_equal_shapely():
    polygons = stars(60)
    plots = plots_of(polygons)
    assert plots.area == pytest.approx(shapely.area(polygons))
    assert shapely.equals(plots.outline, np.array(polygons)).all()
    everywhere = Plots(plots.corners, np.ones(len(plots.corners), dtype=bool), plots.offsets)
    assert everywhere.frontage == pytest.approx(shapely.length(polygons))
    rows = np.array([3, 0, 3])
    assert plots.take(rows).area.tolist() == plots.area[rows].tolist()


def test_smallest_boxes_are_not_larger_than_any_turned_box():
    polygons = np.array(stars(60), dtype=object)
    boxes = smallest_boxes(polygons)
    for degrees in range(0, 90, 7):
        turned = shapely.bounds([shapely.affinity.rotate(polygon, degrees) for polygon in polygons])
        areas = (turned[:, 2] - turned[:, 0]) * (turned[:, 3] - turned[:, 1])
        assert (boxes.length * boxes.breadth <= areas * (1 + 1e-9)).all()
    assert (boxes.length >= boxes.breadth).all()
    assert (boxes.axis[:, 0] >= 0).all()


def test_parts_of_a_cut_fill_the_plot_and_divide_its_frontage():
    polygons = stars(200)
    plots = plots_of(polygons)
    angle = RNG.uniform(0, 2 * np.pi, len(polygons))
    origin = shapely.get_coordinates([polygon.representative_point() for polygon in polygons])
    cuts = cuts_along(plots, origin, np.stack([np.cos(angle), np.sin(angle)], axis=1))
    assert cuts.row.tolist() == list(range(len(polygons)))
    right, left = parts_of(plots, cuts)
    assert shapely.is_valid(right.outline).all()
    assert shapely.is_valid(left.outline).all()
    # Ends are rounded to millimetres: on 80 m that is 0.04 m².
    assert right.area + left.area == pytest.approx(plots.area, abs=0.04)
    assert right.frontage + left.frontage == pytest.approx(plots.frontage, abs=0.01)
    assert shapely.area(shapely.intersection(right.outline, left.outline)).max() < 0.04


def test_a_convex_plot_is_cut_as_by_shapely():
    polygons = [shapely.convex_hull(shapely.MultiPoint(RNG.uniform(0, 50, (7, 2)).round(3))) for _ in range(40)]
    plots = plots_of(polygons)
    angle = RNG.uniform(0, 2 * np.pi, len(polygons))
    step = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    middle = shapely.get_coordinates(shapely.centroid(polygons))
    right, left = parts_of(plots, cuts_along(plots, middle, step))
    for row, polygon in enumerate(polygons):
        line = shapely.LineString([middle[row] - 200 * step[row], middle[row] + 200 * step[row]])
        areas = sorted(part.area for part in split(polygon, line).geoms)
        assert sorted([right.area[row], left.area[row]]) == pytest.approx(areas, abs=0.05)
