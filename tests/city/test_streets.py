import numpy as np
import pytest
import shapely

from grammarlab.city.city_blocks import ring_of
from grammarlab.city.direction_field import FIELD_KINDS, DirectionField, directions_on
from grammarlab.city.streets import SplitRules, StreetNetwork, street_network

OUTLINE = shapely.Polygon([(0, 0), (900, -100), (1100, 400), (800, 800), (500, 500), (100, 900)])


def network_of(kind: str, outline: shapely.Polygon = OUTLINE, seed: int = 3, variation: float = 0.1) -> StreetNetwork:
    rules = SplitRules(
        widths=(24.0, 16.0, 10.0), block_area=(4_000.0, 20_000.0), block_depth=60.0, variation=variation, seed=seed
    )
    return street_network(ring_of(outline, 16.0), directions_on(DirectionField(kind), outline), rules)  # type: ignore[arg-type, ty:invalid-argument-type]


@pytest.mark.parametrize("kind", FIELD_KINDS)
def test_regions_fill_the_outline_without_overlaps(kind: str):
    shapes = [shapely.Polygon(region.ring.corners) for region in network_of(kind).regions]
    assert all(shape.is_valid for shape in shapes)
    # Chords are rounded to millimetres: a millionth of the area is a millimetre along the whole outline.
    assert sum(shape.area for shape in shapes) == pytest.approx(OUTLINE.area, rel=1e-6)
    assert shapely.union_all(shapes).area == pytest.approx(OUTLINE.area, rel=1e-5)


@pytest.mark.parametrize("kind", FIELD_KINDS)
def test_streets_are_the_inner_nodes_of_the_tree_of_regions(kind: str):
    network = network_of(kind)
    leaves = {region.path for region in network.regions}
    assert len(leaves) == len(network.regions)
    nodes = leaves | {street.path for street in network.streets}
    assert {path // 2 for path in nodes if path > 1} == {street.path for street in network.streets}


@pytest.mark.parametrize("kind", FIELD_KINDS)
def test_main_streets_are_wider(kind: str):
    streets = network_of(kind).streets
    width = np.array([street.width for street in streets])
    assert set(width) == {24.0, 16.0, 10.0}
    by_path = {street.path: street.width for street in streets}
    assert all(by_path[path] <= by_path[path // 2] for path in by_path if path > 1)


def test_a_grid_without_variation_is_regular():
    """Splits of equal regions are equal, so that streets go on through the whole square."""
    streets = network_of("grid", shapely.box(0, 0, 800, 800), variation=0.0).streets
    positions = {round(float(line), 2) for street in streets for line in street.points[0] % 100 if 0 < line % 100 < 99}
    assert positions <= {50.0}


def test_seeds_give_other_streets_and_the_same_seed_the_same():
    first, same, other = (network_of("mixed", seed=seed) for seed in (3, 3, 4))
    points = [np.concatenate([street.points for street in network.streets]) for network in (first, same, other)]
    assert points[0].tobytes() == points[1].tobytes()
    assert points[0].tobytes() != points[2].tobytes()
