"""The ground of the page: outlines of parcels in the coordinates of the tiles."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import shapely

from grammarlab.city.parcel_addresses import Pins, excluded, rerolled
from grammarlab.errors import UsageError
from grammarlab.pages.city.decisions import Choices, changed_parcels, with_grammar
from grammarlab.pages.city.ground_plan import ground_placement, ground_plan
from grammarlab.pages.city.parcel_facts import ParcelFacts
from grammarlab.pages.city.street_surface import street_triangles
from tests.pages.city.small_city import PLAN, write_city


def test_outlines_lie_as_on_the_map(tmp_path: Path):
    ids = write_city(tmp_path)
    facts = ParcelFacts.read(tmp_path)
    plan = ground_plan(facts, ground_placement(facts, tmp_path, None))
    assert plan
    assert np.diff(plan.offsets).tolist() == [4] * len(ids)
    here = shapely.get_coordinates(shapely.get_exterior_ring(facts.rows.outline)).reshape(len(ids), 5, 2)[:, :4]
    there = plan.corners.reshape(-1, 4, 3)[..., [0, 2]]
    # Distances on the ellipsoid are those of the map but for its scale, and only the axis to the south is turned.
    first, second = (np.linalg.norm(points[:, :1] - points, axis=2) for points in (here, there))
    np.testing.assert_allclose(second, first, rtol=1e-3)
    middle = np.linalg.norm(there.mean((0, 1)) * [1, -1] - here.mean((0, 1)))
    assert middle < 0.5
    np.testing.assert_allclose(plan.corners[:, 1], 0.0, atol=0.01)
    assert plan.built.tolist() == facts.is_built.tolist()
    assert plan.built.sum() == len(ids) - 1


def test_streets_are_what_is_not_parcel():
    outlines = np.array([shapely.box(0, 0, 16, 30), shapely.box(20, 0, 40, 30), None], object)
    triangles, kinds = street_triangles(outlines)
    area = shapely.area(shapely.polygons(triangles))
    blocks = shapely.union_all(outlines[:2])
    pavement = shapely.buffer(blocks, 2, join_style="mitre")
    around = shapely.buffer(blocks, 10, join_style="mitre")
    assert np.bincount(kinds, area) == pytest.approx([around.area - pavement.area, pavement.area - blocks.area])
    assert shapely.area(shapely.intersection(shapely.polygons(triangles), blocks)).max() < 1e-9


def test_a_plan_keeps_all_but_the_grammar_of_one_zone():
    text = with_grammar(PLAN, "offices", "offices-learned.cga")
    assert text == PLAN[::-1].replace('"toy"'[::-1], '"offices-learned.cga"'[::-1], 1)[::-1]
    with pytest.raises(UsageError, match="no zone"):
        with_grammar(PLAN, "parks", "oak")


def test_only_parcels_with_another_pin_have_changed():
    before = rerolled(rerolled(Pins(), "a"), "b")
    after = excluded(rerolled(before, "b"), "c")
    assert changed_parcels(Choices(before, ""), Choices(after, "")) == {"b", "c"}
    assert changed_parcels(Choices(before, "x"), Choices(before, "y")) == frozenset()


class Bowl:
    """A terrain with its lowest point among the parcels, unknown in the far west."""

    def heights(self, east_north: np.ndarray, /) -> np.ndarray:
        east, north = east_north.T
        return np.where(east < east.min() + 30.0, np.nan, 20.0 + 0.001 * (east**2 + north**2))


def test_the_ground_follows_a_terrain(tmp_path: Path):
    write_city(tmp_path)
    facts = ParcelFacts.read(tmp_path)
    level = ground_placement(facts, tmp_path, None)
    plan, flat = (ground_plan(facts, replace(level, terrain=terrain)) for terrain in (Bowl(), None))
    assert plan
    assert flat
    assert len(flat.surfaces) == len(flat.owners) == 0
    # Triangles of parcels cover them, and those of streets the same area as on level ground.
    area = np.bincount(plan.owners, areas(plan.surfaces), len(facts))
    assert area == pytest.approx(facts.rows.area, rel=2e-3)
    for kind in range(2):
        assert areas(plan.streets[plan.kinds == kind]).sum() == pytest.approx(
            areas(flat.streets[flat.kinds == kind]).sum(), rel=2e-3
        )
    assert (plan.kinds == 2).any()
    for corners in (plan.corners, plan.surfaces.reshape(-1, 3), plan.streets.reshape(-1, 3)):
        east, height, south = corners.T.astype(float)
        known = height > 1.0
        expected = 20.0 + 0.001 * (east**2 + south**2)
        assert known.mean() > 0.7
        assert np.abs(height - expected)[known].max() < 0.5
    longest = np.linalg.norm(np.diff(plan.surfaces[:, [0, 1, 2, 0]][..., [0, 2]], axis=1), axis=2).max()
    assert longest < 15 * 2**0.5 + 0.1


def areas(triangles: np.ndarray) -> np.ndarray:
    """[T] areas on the map."""
    first, second, third = triangles[..., [0, 2]].astype(float).transpose(1, 0, 2)
    return np.abs(np.cross(np.pad(second - first, ((0, 0), (0, 1))), np.pad(third - first, ((0, 0), (0, 1))))[:, 2]) / 2
