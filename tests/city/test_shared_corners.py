import numpy as np
import shapely

from grammarlab.arrays import offsets_from_counts
from grammarlab.city.plot_cuts import Cuts, Plots
from grammarlab.city.shared_corners import SNAP, snapped, with_shared_corners


def plots_of(*rings: list[tuple[float, float]]) -> Plots:
    corners = np.concatenate([np.array(ring, dtype=float) for ring in rings])
    return Plots(corners, np.ones(len(corners), dtype=bool), offsets_from_counts(np.array([len(r) for r in rings])))


LOWER = [(0.0, 0.0), (20.0, 0.0), (20.0, 10.0), (0.0, 10.0)]
"""A plot with two others above it; their common corner is a millimetre beside its edge."""
ABOVE = (
    [(0.0, 10.0), (9.0, 9.999), (9.0, 20.0), (0.0, 20.0)],
    [(9.0, 9.999), (20.0, 10.0), (20.0, 20.0), (9.0, 20.0)],
)


def test_plots_without_common_corners_become_a_coverage():
    plots = plots_of(LOWER, *ABOVE)
    assert not shapely.coverage_is_valid(plots.outline)
    shared = with_shared_corners(plots)
    assert shapely.coverage_is_valid(shared.outline)
    assert np.diff(shared.offsets).tolist() == [5, 4, 4]
    assert shared.on_street.all()


def test_shared_corners_are_not_added_again():
    shared = with_shared_corners(plots_of(LOWER, *ABOVE))
    again = with_shared_corners(shared)
    assert again.corners.tobytes() == shared.corners.tobytes()
    assert again.offsets.tolist() == shared.offsets.tolist()


def cuts_of(*ends: tuple[float, float]) -> Cuts:
    """Cuts of copies of the lower plot from its upper edge to its lower one."""
    num = len(ends)
    edges = np.array([(4 * row + 2, 4 * row) for row in range(num)])
    points = np.array([[(x, y), (x, 0.0)] for x, y in ends])
    return Cuts(np.arange(num), edges, points)


def test_ends_of_cuts_move_onto_corners_near_them_along_the_edge():
    plots = plots_of(LOWER)
    corners = np.concatenate([plots.corners, [[9.0, 9.999], [12.0, 10.2]]])
    for x, target in ((9.0 + SNAP / 2, 9.0), (9.0 + 2 * SNAP, 9.0 + 2 * SNAP), (12.0, 12.0)):
        moved = snapped(plots, cuts_of((x, 10.0)), corners)
        assert moved.end[0, 0, 0] == target


def test_ends_of_cuts_that_are_near_each_other_meet():
    plots = plots_of(LOWER, LOWER)
    moved = snapped(plots, cuts_of((7.1, 10.0), (7.0, 9.999)), plots.corners)
    assert moved.end[0, 0].tolist() == moved.end[1, 0].tolist() == [7.0, 9.999]
