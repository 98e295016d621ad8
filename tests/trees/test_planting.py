"""Planting: laws of areas in each other, distances, densities and outlines, on circles with given radii."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import UsageError
from grammarlab.geometry.footprints.area import Area, read_area
from grammarlab.geometry.footprints.equal_area import Plane
from grammarlab.geometry.footprints.projection import Ground
from grammarlab.randomness import root_keys, uniforms
from grammarlab.trees.arrivals import FULL, candidates_in
from grammarlab.trees.planting import MAX_TREES, Planting, Spacing, decided, planted
from tests.cases import bulk

POTSDAM = (13.04, 52.4)
"""Longitude and latitude of a park."""


def circles(seed=0, low=1.0, high=4.0):
    """Crowns whose radii are spread evenly."""
    return lambda models: low + (high - low) * uniforms(root_keys(seed, models), 3)


SPACING = Spacing(circles(), 5)


def trees(planting: Planting) -> set[tuple[int, float, float]]:
    return {
        (model, radius, *place)
        for model, radius, place in zip(
            planting.model.tolist(), planting.radius.tolist(), planting.coordinates.tolist(), strict=True
        )
    }


def polygon(x, y, size, shares, *, scale=(1.0, 1.0)) -> shapely.Polygon:
    """A star with corners at some shares of its size."""
    angles = np.arange(len(shares)) * 2 * math.pi / len(shares)
    radius = size * np.array(shares)
    return shapely.Polygon(
        np.column_stack([x + scale[0] * radius * np.cos(angles), y + scale[1] * radius * np.sin(angles)])
    )


def degrees(x, y, size, shares) -> Area:
    """A star around a place in degrees, with metres for its size."""
    north = 1 / 111_250
    shape = polygon(x, y, size, shares, scale=(north / math.cos(math.radians(y)), north))
    return Area((shape,), Ground.around(shapely.get_coordinates(shapely.centroid(np.array([shape])))))


def metres(x, y, size, shares) -> Area:
    return Area((polygon(x, y, size, shares),))


stars = st.lists(st.floats(0.3, 1.0), min_size=3, max_size=8)


@given(
    stars, st.lists(st.floats(1.05, 3.0), min_size=8, max_size=8), st.floats(5, 200), st.booleans(), st.integers(0, 9)
)
@bulk(100)
def test_a_larger_area_keeps_the_trees_of_each_smaller_one(shares, factors, density, is_degrees, seed):
    """Bit for bit: their addresses, places and sizes. The larger area has trees inside the smaller one only from it."""
    x, y = POTSDAM if is_degrees else (412_345.0, 5_801_234.5)
    area = degrees if is_degrees else metres
    small = area(x, y, 60.0, shares)
    large = area(x, y, 60.0, [share * factor for share, factor in zip(shares, factors, strict=False)])
    if not large.polygons[0].contains(small.polygons[0]):
        return
    spacing = Spacing(circles(seed), seed)
    few, many = (planted(part, spacing, density=density) for part in (small, large))
    inside = large.contains(few.coordinates)
    assert inside.all()
    again = small.contains(many.coordinates)
    assert trees(few) == {tree for tree, within in zip(_in_order(many), again, strict=True) if within}


def _in_order(planting):
    columns = (planting.model.tolist(), planting.radius.tolist(), planting.coordinates.tolist())
    return [(model, radius, *place) for model, radius, place in zip(*columns, strict=True)]


@given(st.floats(5, 300), st.floats(1.0, 5.0), st.integers(1, 400))
@bulk(40)
def test_a_denser_forest_keeps_the_trees_of_a_sparser_one(density, factor, limit):
    area = metres(0.0, 0.0, 70.0, [1.0, 0.6, 0.9, 0.8])
    sparse, dense = (planted(area, SPACING, density=value) for value in (density, density * factor))
    assert trees(sparse) <= trees(dense)
    first = planted(area, SPACING, density=density * factor, limit=limit)
    assert _in_order(first) == _in_order(dense)[:limit]


@given(stars, st.integers(1, 150), st.integers(0, 5))
@bulk(60)
def test_as_many_trees_stand_as_asked_for_and_their_density_places_them_again(shares, limit, seed):
    area = metres(-300.0, 700.0, 80.0, shares)
    spacing = Spacing(circles(seed), seed)
    planting = planted(area, spacing, limit=limit)
    assert len(planting) == limit or (planting.is_full and len(planting) < limit)
    again = planted(area, spacing, density=planting.density)
    assert _in_order(again) == _in_order(planting)


@pytest.mark.parametrize("gap", [-1.5, 0.0, 3.0])
@pytest.mark.parametrize("area", [metres(1e5, 2e5, 80.0, [1.0] * 6), degrees(*POTSDAM, 80.0, [1.0] * 6)])
def test_no_two_crowns_are_closer_than_the_gap(area, gap):
    """All pairs, by distances on the map in metres."""
    planting = planted(area, Spacing(circles(), 5, gap), density=1e4)
    east_north = planting.position[:, [0, 2]]
    distance = np.sqrt(((east_north[:, None] - east_north) ** 2).sum(axis=2))
    needed = planting.radius[:, None] + planting.radius + gap
    np.fill_diagonal(distance, np.inf)
    assert len(planting) > 100
    assert (distance - needed).min() > -1e-5
    assert (distance - needed).min() < 0.1


def test_trees_stand_as_the_rule_says_candidate_by_candidate():
    """The oracle: candidates in the order of their times, each compared with all trees that stand."""
    box = np.array([[[-60.0, -110.0], [110.0, 60.0]]])
    standing: list[tuple[float, float, float, int]] = []
    for block in candidates_in(Plane(), box, SPACING.side, 5):
        assert len(np.unique(block.model)) == len(block)
        radius = circles()(block.model)
        for row in np.argsort(block.time):
            (x, y), size = block.coordinates[row].tolist(), float(radius[row])
            if all(math.hypot(x - u, y - v) >= size + other for u, v, other, _ in standing):
                standing.append((x, y, size, int(block.model[row])))
    planting = planted(read_area("60x60"), SPACING, density=1e4)
    assert {model for x, y, _, model in standing if 0 < x < 60 and -60 < y < 0} == set(planting.model.tolist())


def test_what_is_decided_in_a_window_is_so_in_a_larger_one():
    """Candidates near the edge of the window stay undecided; if they were decided, some would differ."""
    boxes = np.array([[[0.0, 0.0], [160.0, 160.0]]])
    (everywhere,) = candidates_in(Plane(), boxes, SPACING.side, 5)
    radius = circles()(everywhere.model)
    states = decided(everywhere, everywhere.coordinates, radius, SPACING, np.ones(len(radius), np.bool_))
    distance = np.abs(everywhere.coordinates - 80.0).max(axis=1)
    window = np.flatnonzero(distance < 30.0)
    is_complete = distance[window] < 30.0 - SPACING.reach
    sizes = np.where(is_complete, radius[window], SPACING.largest)
    part = everywhere.take(window)
    known = decided(part, part.coordinates, sizes, SPACING, is_complete)
    is_known = known >= 0
    assert (known[is_known] == states[window][is_known]).all()
    assert 50 < is_known.sum() < len(window) / 2
    careless = decided(part, part.coordinates, radius[window], SPACING, np.ones(len(window), np.bool_))
    assert (careless != states[window]).sum() > 5


@pytest.mark.parametrize("share", [0.03, 0.3, 0.6, 0.9])
def test_the_density_is_near_the_one_asked_for(share):
    """On 36 hectares."""
    spacing = Spacing(circles(), 1)
    highest = spacing.density_at(FULL) * 1e4
    planting = planted(read_area("600x600"), spacing, density=share * highest)
    num = len(planting)
    assert num / 36 == pytest.approx(share * highest, rel=0.05 + 2.5 / math.sqrt(num))
    assert planting.density == share * highest


def test_all_trunks_are_inside_the_outlines_and_holes_stay_empty():
    whole = polygon(0.0, 0.0, 100.0, [1.0, 0.5, 1.0, 0.7, 0.9])
    hole = polygon(0.0, 0.0, 30.0, [1.0] * 12)
    ring = shapely.Polygon(whole.exterior, [hole.exterior])
    area = Area((ring, polygon(300.0, 50.0, 40.0, [1.0] * 5)))
    planting = planted(area, SPACING, density=200)
    points = shapely.points(planting.coordinates)
    assert shapely.contains(shapely.MultiPolygon(area.polygons), points).all()
    assert (shapely.distance(points, shapely.Point(0, 0)) > 25).all()
    assert (planting.coordinates[:, 0] > 200).sum() > 10
    parts = [planted(Area((part,)), SPACING, density=200) for part in area.polygons]
    assert trees(planting) == trees(parts[0]) | trees(parts[1])
    assert (planting.position[:, 1] == 0).all()


@pytest.mark.parametrize("kilometres", [(1, 0), (-3, 7), (400, 5800)])
def test_an_area_whole_kilometres_away_is_as_full(kilometres):
    """Its trees are others, as densely, with coordinates exact to a micrometre."""
    x, y = 1000.0 * np.array(kilometres)
    here, there = (planted(metres(*middle, 150.0, [1.0] * 30), SPACING, density=150) for middle in ((0, 0), (x, y)))
    assert len(there) == pytest.approx(len(here), rel=0.1)
    moved = there.position[:, [0, 2]] - [x, -y]
    assert np.hypot(*moved.T).max() < 151
    assert not trees(here) & trees(there)


def test_two_maps_of_one_park_have_the_same_trees_on_the_earth():
    """A map whose degrees count to 360, and one with another middle, so that metres count from elsewhere."""
    x, y = -0.004, 51.5
    park = degrees(x, y, 80.0, [1.0, 0.7, 0.9, 1.0])
    east = Area((shapely.transform(park.polygons[0], lambda points: points + np.array([360.0, 0.0])),), park.ground)
    other = Area(park.polygons, Ground(x + 0.1, y + 0.05))
    planting, *others = (planted(area, SPACING, density=150) for area in (park, east, other))
    assert len(planting) > 40
    assert [trees(same) for same in others] == [trees(planting)] * 2
    assert np.hypot(*(others[1].position - planting.position)[:, [0, 2]].T).min() > 7000


def test_the_date_line_is_no_line_for_trees():
    """A park across it as one outline, and as two that meet there."""
    whole = degrees(180.0, -16.8, 60.0, [1.0] * 12)
    west = whole.polygons[0].intersection(shapely.box(170, -20, 180, -10))
    east = whole.polygons[0].intersection(shapely.box(180, -20, 190, -10))
    east = shapely.transform(east, lambda points: points - np.array([360.0, 0.0]))
    assert isinstance(west, shapely.Polygon)
    assert isinstance(east, shapely.Polygon)
    planting = planted(whole, SPACING, density=1e4)
    assert trees(planted(Area((west, east), whole.ground), SPACING, density=1e4)) == trees(planting)
    assert set(np.sign(planting.coordinates[:, 0]).tolist()) == {-1.0, 1.0}
    assert np.hypot(planting.position[:, 0], planting.position[:, 2]).max() < 61


def test_seeds_have_other_trees():
    area = read_area("100x100")
    assert not trees(planted(area, SPACING, density=80)) & trees(planted(area, Spacing(circles(), 6), density=80))


def test_a_small_area_may_have_no_tree():
    planting = planted(read_area("0.5x0.5"), SPACING, density=5)
    assert len(planting) == 0
    assert planting.position.shape == (0, 3)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "how many trees"),
        ({"density": 0.0}, "density: expected more than 0"),
        ({"density": math.nan}, "density: expected more than 0"),
        ({"density": -math.inf}, "density: expected more than 0"),
        ({"limit": 0}, "number of trees: expected at least 1"),
        ({"density": 100.0}, f"at most {MAX_TREES:,}"),
        ({"limit": 10**9}, f"at most {MAX_TREES:,}"),
    ],
)
def test_numbers_out_of_range_are_refused(options, message):
    with pytest.raises(UsageError, match=message):
        planted(read_area("19000x19000"), SPACING, **options)


def test_areas_with_too_many_cells_are_refused():
    small = Spacing(circles(0, 0.05, 0.1), 5)
    with pytest.raises(UsageError, match=r"cells of 0.15 m"):
        planted(read_area("19000x19000"), small, limit=10)
    apart = [degrees(x, 50.0, 100.0, [1.0] * 5).polygons[0] for x in (0.0, 60.0)]
    with pytest.raises(UsageError, match="km apart"):
        planted(Area(tuple(apart), Ground(30.0, 50.0)), SPACING, limit=10)


@pytest.mark.parametrize("gap", [-4.0, -9.0, -math.inf, math.nan])
def test_gaps_that_leave_no_distance_are_refused(gap):
    with pytest.raises(UsageError, match="gap: expected"):
        Spacing(circles(), 5, gap)
