import numpy as np
import pytest

from grammarlab.synthesis.analysis.walls import walls_of
from grammarlab.synthesis.mesh.surface import Surface
from grammarlab.synthesis.mesh.views import FRONT


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
