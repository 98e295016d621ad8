import numpy as np
import pytest
from scipy import ndimage

from grammarlab.synthesis.analysis.unit_kinds import _without_details
from grammarlab.synthesis.analysis.wall_elements import MIN_SIDE_M
from grammarlab.synthesis.analysis.walls import filled_above_ground, walls_of
from grammarlab.synthesis.mesh.surface import Surface
from grammarlab.synthesis.mesh.views import FRONT, seen_from


def rectangles(*sides: tuple[float, float, float]) -> Surface:
    """Rectangles 10 m wide that face z; each by its lower and upper end and its depth, metres."""
    points = [(x, y, z) for low, high, z in sides for y in (low, high) for x in (0.0, 10.0)]
    triangles = [(4 * k + a, 4 * k + b, 4 * k + c) for k in range(len(sides)) for a, b, c in ((0, 1, 3), (0, 3, 2))]
    return Surface(np.array(points), np.array(triangles), np.zeros(len(triangles), dtype=np.int64))


@pytest.mark.parametrize(("gap", "lowest"), [(0.0, 0.0), (0.03, 0.0), (0.5, 3.5)])
def test_a_ground_floor_belongs_to_the_wall_above_it_also_across_a_crack(gap: float, lowest: float) -> None:
    wall = walls_of(rectangles((0.0, 3.0, -0.1), (3.0 + gap, 12.0, 0.0)), FRONT)[0]
    assert wall.depth == pytest.approx(0.0, abs=1e-6)
    assert wall.low == pytest.approx([0.0, lowest], abs=0.1)
    assert wall.high == pytest.approx([10.0, 12.0], abs=0.1)


@pytest.mark.parametrize("rise", [-0.08, 0.003, 0.06])
def test_the_tilt_of_a_wall_is_its_slope_and_no_noise(rise: float) -> None:
    flat = rectangles((0.0, 12.0, 0.0), (3.0, 5.0, 0.2))
    surface = flat.moved(flat.points + np.outer(flat.points[:, 0] * rise / 10.0, [0.0, 0.0, 1.0]))
    wall = walls_of(surface, FRONT)[0]
    assert wall.slope == pytest.approx(rise / 10.0, rel=1e-6)
    assert wall.noise < 1e-6
    square, corners = wall.squared(seen_from(FRONT, surface.points)[surface.triangles])
    relief = square.map.depth[square.mask] - wall.depth
    assert np.minimum(np.abs(relief), np.abs(relief - 0.2)).max() < 1e-3
    assert np.ptp(corners[:2, :, 2]) < 1e-9
    assert np.ptp(corners[2:, :, 2]) < 1e-9


def test_a_square_wall_has_no_slope_and_is_compared_as_it_is() -> None:
    surface = rectangles((0.0, 12.0, 0.0), (3.0, 5.0, 0.2))
    wall = walls_of(surface, FRONT)[0]
    corners = seen_from(FRONT, surface.points)[surface.triangles]
    assert wall.slope == wall.tilt(0.0) == 0.0
    assert wall.squared(corners)[0] is wall


def test_wings_some_centimetres_apart_have_depths_of_their_own() -> None:
    """The largest one is not that of most pixels."""
    depths = [0.0, 0.02, 0.02]
    wings = [rectangles((0.0, height, depth)) for height, depth in zip((12.0, 9.0, 8.5), depths, strict=True)]
    points = np.concatenate([wing.points + np.array([14.0 * number, 0.0, 0.0]) for number, wing in enumerate(wings)])
    triangles = np.concatenate([wing.triangles + 4 * number for number, wing in enumerate(wings)])
    walls = walls_of(Surface(points, triangles, np.zeros(len(triangles), dtype=np.int64)), FRONT)
    assert [wall.depth for wall in walls] == pytest.approx(depths, abs=1e-6)


@pytest.mark.parametrize("shape", [(0, 0), (1, 1), (1, 9), (9, 1), (20, 30), (40, 25)])
def test_what_walls_enclose_is_what_scipy_fills_above_a_row_of_ground(shape: tuple[int, int]) -> None:
    random = np.random.default_rng(7)
    for share in np.linspace(0.0, 1.0, 21):
        mask = random.random(shape) < share
        ground = np.concatenate([np.ones((1, shape[1]), dtype=bool), mask])
        np.testing.assert_array_equal(filled_above_ground(mask), np.asarray(ndimage.binary_fill_holes(ground))[1:])


@pytest.mark.parametrize("pixels", [1, 2, 3, 6, 7])
def test_details_are_what_a_closing_and_an_opening_by_a_square_remove(pixels: int) -> None:
    random = np.random.default_rng(8)
    square = np.ones((pixels, pixels), dtype=bool)
    for share in (0.0, 0.02, 0.1, 0.5, 0.9):
        differs = random.random((30, 40)) < share
        closed = ndimage.binary_closing(np.pad(differs, pixels), square)
        wide = np.asarray(ndimage.binary_opening(closed, square), dtype=np.bool_)[pixels:-pixels, pixels:-pixels]
        np.testing.assert_array_equal(_without_details(differs, MIN_SIDE_M / pixels), wide & differs)
