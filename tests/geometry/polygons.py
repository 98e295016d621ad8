"""Random simple polygons for the laws of planar operations."""

import math

import numpy as np
import shapely
from hypothesis import assume
from hypothesis import strategies as st

from grammarlab.geometry.meshes.mesh import Meshes


@st.composite
def stars(draw, largest=30):
    """Star-shaped polygons around (0, 0), counter-clockwise, of 3 to `largest` corners and size about 1."""
    count = draw(st.integers(3, largest))
    radii = draw(st.lists(st.floats(0.2, 1.0), min_size=count, max_size=count))
    shifts = draw(st.lists(st.floats(0.0, 0.8 if count > 3 else 0.4), min_size=count, max_size=count))
    angles = 2.0 * math.pi * (np.arange(count) + np.array(shifts)) / count
    return np.array(radii)[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)


@st.composite
def convex(draw, largest=12):
    """Convex polygons of up to `largest` corners, none of them straight."""
    hull = shapely.convex_hull(shapely.MultiPoint(draw(stars(largest))))
    ring = shapely.get_coordinates(shapely.remove_repeated_points(hull, 1e-3))[:-1]
    polygon = shapely.Polygon(ring)
    assume(len(ring) >= 3 and polygon.is_valid and polygon.area > 0.01)
    ring = ring if polygon.exterior.is_ccw else ring[::-1]
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    turn = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    assume((turn > 1e-4).all())
    return ring


@st.composite
def rectilinear(draw, most_boxes=6):
    """Polygons with right angles on a grid, without holes: many events happen at once."""
    corner, size = st.integers(0, 7), st.integers(1, 5)
    boxes = draw(st.lists(st.tuples(corner, corner, size, size), min_size=1, max_size=most_boxes))
    return _outline(shapely.union_all([shapely.box(x, y, x + w, y + h) for x, y, w, h in boxes]))


@st.composite
def combs(draw):
    """Combs with equal teeth and gaps: parallel edges that meet along whole lines."""
    teeth = draw(st.integers(2, 6))
    width, gap, length = (draw(st.integers(1, 3)) for _ in range(3))
    back = shapely.box(0, 0, teeth * width + (teeth - 1) * gap, draw(st.integers(1, 3)))
    return _outline(
        shapely.union_all(
            [back, *(shapely.box(i * (width + gap), 0, i * (width + gap) + width, 4 + length) for i in range(teeth))]
        )
    )


def _outline(area):
    assume(area.geom_type == "Polygon" and not area.interiors)
    ring = shapely.get_coordinates(shapely.Polygon(area.exterior).simplify(0.0))[:-1]
    assume(len(np.unique(ring, axis=0)) == len(ring))
    ring = ring if shapely.LinearRing(ring).is_ccw else ring[::-1]
    return ring.astype(np.float64)


@st.composite
def moved(draw, shapes, smallest=-3, largest=4):
    """The shapes turned, scaled by powers of ten and moved by about their size."""
    ring = draw(shapes)
    turn = draw(st.floats(0.0, 6.28))
    scale = 10.0 ** draw(st.integers(smallest, largest))
    rotation = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
    return (ring @ rotation + draw(st.floats(-5.0, 5.0))) * scale


simple = st.one_of(stars(), rectilinear(), combs(), moved(stars()), moved(rectilinear()), moved(combs()))
"""Simple polygons of every kind, star-shaped ones with up to 30 corners."""


def lots(rings):
    """Polygons [n, 2] on the ground as one-face meshes that look up."""
    points = [np.stack([ring[:, 0], 0.0 * ring[:, 0], -ring[:, 1]], axis=1) for ring in rings]
    return Meshes.from_polygons(np.concatenate(points), np.array([len(ring) for ring in rings]))


def area(ring):
    """Area of a polygon [n, 2]."""
    return shapely.Polygon(ring).area


LOT_L = np.array([(0, 0), (0, -12), (8, -12), (8, -22), (26, -22), (26, 0)], float)
"""An L with wings 12 and 18 wide; on the ground its corners have z 0, 12, 12, 22, 22, 0."""
