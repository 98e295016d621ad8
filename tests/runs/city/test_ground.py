"""Ground of a city: squares fit together, nothing covers anything else, and all surfaces look up."""

from __future__ import annotations

import numpy as np
import shapely

from grammarlab.runs.city.city_ground import KINDS, draped, ground_pieces, ground_scene
from grammarlab.scene import triangles

PARCELS = np.array(
    [
        shapely.box(x * 30, y * 30 + y // 2 * 12, x * 30 + 29.9, y * 30 + 30 + y // 2 * 12)
        for x in range(6)
        for y in range(6)
    ],
    dtype=object,
)
KIND = np.arange(len(PARCELS)) % 2
WHOLE = shapely.box(-100, -100, 400, 400)


def area_by_kind(*cells: shapely.Polygon) -> list[float]:
    areas = np.zeros(len(KINDS))
    for cell in cells:
        pieces = ground_pieces(PARCELS, KIND, cell)
        np.add.at(areas, pieces.kind, shapely.area(pieces.outline))
    return areas.tolist()


def test_pieces_do_not_overlap_and_streets_are_around_parcels():
    pieces = ground_pieces(PARCELS, KIND, WHOLE)
    total = shapely.area(pieces.outline).sum()
    assert np.isclose(shapely.union_all(pieces.outline).area, total, rtol=1e-9)
    assert np.isclose(shapely.area(pieces.outline[: len(PARCELS)]).sum(), shapely.area(PARCELS).sum())
    assert area_by_kind(WHOLE)[KINDS.index("street")] > 0


def test_squares_have_together_what_the_whole_has():
    quarters = [shapely.box(x, y, x + 250, y + 250) for x in (-100, 150) for y in (-100, 150)]
    assert np.allclose(area_by_kind(*quarters), area_by_kind(WHOLE), rtol=1e-9)


def test_surfaces_look_up_and_follow_the_terrain():
    pieces = ground_pieces(PARCELS, KIND, WHOLE)
    scene = ground_scene(pieces, np.array([10.0, 0.0, -20.0]), lambda points: 0.1 * points[:, 0])
    batch = triangles(scene)
    assert batch.normals[:, 1].min() > 0.9
    rise = batch.vertices[:, 1] - 0.1 * (batch.vertices[:, 0] + 10.0)
    assert rise.min() >= -1e-4
    assert rise.max() <= 0.14
    corners = batch.vertices[batch.triangles][:, :, [0, 2]].astype(np.float64)
    sides = corners[:, 1:] - corners[:, :1]
    covered = np.abs(np.linalg.det(sides)).sum() / 2
    assert np.isclose(covered, shapely.area(pieces.outline).sum(), rtol=1e-4)


def test_draped_pieces_are_the_same_ground_at_the_height_of_a_curved_terrain():
    pieces = ground_pieces(PARCELS, KIND, WHOLE, has_land=True)
    whole = draped(pieces)
    for kind in range(len(KINDS)):
        before, after = (shapely.area(part.outline[part.kind == kind]).sum() for part in (pieces, whole))
        assert np.isclose(before, after, rtol=1e-3)
    assert np.isclose(shapely.area(whole.outline).sum(), WHOLE.area, rtol=1e-3)

    def height(points: np.ndarray) -> np.ndarray:
        return 0.002 * (points**2).sum(axis=1)

    batch = triangles(ground_scene(whole, np.zeros(3), height))
    middles = batch.vertices[batch.triangles].astype(np.float64).mean(axis=1)
    # A chord of 5 m below a parabola: .002 (5 / 2)² for each axis.
    assert np.abs(middles[:, 1] - height(middles[:, [0, 2]])).max() < 0.002 * 2 * 2.5**2 + 0.03
