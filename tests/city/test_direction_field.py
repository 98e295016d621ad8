import numpy as np
import pytest
import shapely

from grammarlab.city.direction_field import DirectionField, Lattice, directions_on

OUTLINE = shapely.affinity.rotate(shapely.box(0, 0, 900, 500), 20, origin=(0, 0))


def crosses(angle: float) -> complex:
    """A cross as a number that a quarter turn does not change."""
    return np.exp(4j * angle)


def test_a_grid_without_an_angle_follows_the_smallest_box():
    directions = directions_on(DirectionField(), OUTLINE)
    assert abs(crosses(directions.at(3.0, 4.0)) - crosses(np.radians(20))) < 1e-9


def test_a_radial_field_points_away_from_its_centre():
    directions = directions_on(DirectionField("radial", centre=(100.0, 200.0)), OUTLINE)
    for angle in np.linspace(-3, 3, 7):
        x, y = 100 + 50 * np.cos(angle), 200 + 50 * np.sin(angle)
        assert abs(crosses(directions.at(x, y)) - crosses(angle)) < 1e-9


def test_a_mixed_field_is_radial_near_its_centre_and_follows_the_outline_near_the_outline():
    slanted = shapely.Polygon([(0, 0), (3000, 0), (3000, 2500), (1500, 3000), (0, 2000)])
    directions = directions_on(DirectionField("mixed", angle=10.0), slanted)
    x, y = directions.centre
    assert abs(crosses(directions.at(x + 5, y + 12)) - crosses(np.arctan2(12, 5))) < 0.7
    edge = np.arctan2(1000, 1500)
    assert abs(crosses(directions.at(760, 2490)) - crosses(edge)) < 0.7


@pytest.mark.parametrize("point", [(0.0, 0.0), (12.5, 31.0), (74.9, 49.9), (75.0, 50.0)])
def test_a_lattice_is_exact_for_linear_numbers(point: tuple[float, float]):
    x, y = np.meshgrid(np.arange(0.0, 76.0, 25.0), np.arange(0.0, 51.0, 25.0))
    lattice = Lattice((0.0, 0.0), 25.0, 2 * x + 3j * y)
    assert lattice.at(*point) == pytest.approx(2 * point[0] + 3j * point[1])


def test_a_lattice_is_constant_beyond_its_points():
    lattice = Lattice((0.0, 0.0), 1.0, np.array([[1, 2], [3, 4]], dtype=np.complex128))
    assert lattice.at(-5.0, -5.0) == 1
    assert lattice.at(9.0, 9.0) == 4
