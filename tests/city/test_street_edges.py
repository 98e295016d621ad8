"""Street edges equal those of a slow oracle that looks at points, and change only where a map changes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely

from grammarlab.city.lot_edges import LotEdges, simplified
from grammarlab.city.packed_outlines import Outlines, PackedOutlines
from grammarlab.city.street_edges import DEFAULT_WIDTH, GAP, REACH, street_widths
from grammarlab.city.street_lines import StreetLines
from tests.city.lot_maps import lot_map

SAMPLES = 200


def widths_of(outlines: Outlines, streets: StreetLines | None = None, plots: tuple[int, ...] = ()) -> list[list[float]]:
    """Widths of streets along the edges of each outline, by rows."""
    edges = LotEdges.of(outlines)
    is_plot = np.isin(np.arange(len(outlines)), plots)
    widths = street_widths(edges, PackedOutlines.of(outlines), np.arange(len(outlines)), streets, is_plot)
    return [widths[edges.outline == row].tolist() for row in range(len(outlines))]


def oracle(others: shapely.Geometry, own: Any, edge: np.ndarray, streets: StreetLines | None):
    """Width of the street along an edge [2, 2] by the rules, or None where rounding decides."""
    share = (np.arange(SAMPLES) + 0.5) / SAMPLES
    points = edge[0] + share[:, None] * (edge[1] - edge[0])
    is_open = shapely.distance(shapely.points(points), others) > GAP
    if abs(is_open.mean() - 0.5) < 0.02 or 0.0 < is_open.mean() < 0.02:
        return None
    if is_open.mean() < 0.5:
        return 0.0
    if streets is None:
        return DEFAULT_WIDTH
    runs = np.split(np.arange(SAMPLES), np.flatnonzero(np.diff(is_open)) + 1)
    run = max((run for run in runs if is_open[run[0]]), key=len)
    middle = (points[run[0]] + points[run[-1]]) / 2.0
    along = edge[1] - edge[0]
    outside = np.array([along[1], -along[0]]) / np.hypot(*along)
    seen = []
    for line, width in zip(streets.line, streets.width, strict=True):
        end = shapely.get_coordinates(shapely.shortest_line(shapely.Point(middle), line))[1]
        view = end - middle
        distance = np.hypot(*view)
        if min(abs(distance - REACH), abs(view @ outside - 0.5 * distance)) < 0.05:
            return None
        start = middle + min(GAP / distance, 1.0) * view
        is_blocked = shapely.intersects(shapely.LineString([start, end]), [others, own]).any()
        if distance <= REACH and view @ outside > 0.5 * distance and not is_blocked:
            seen.append((distance, -width))
    near = sorted(seen)
    if len(near) > 1 and near[1][0] - near[0][0] < 0.05 and near[1][1] != near[0][1]:
        return None
    return -near[0][1] if near else 0.0


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("has_lines", [True, False])
def test_streets_are_those_of_a_slow_oracle(seed: int, has_lines: bool):
    quarter = lot_map(seed)
    outlines = simplified(quarter.parcels.outline)
    streets = quarter.streets if has_lines else None
    edges = LotEdges.of(outlines)
    widths = street_widths(
        edges, PackedOutlines.of(outlines), np.arange(len(outlines)), streets, np.zeros(len(outlines), bool)
    )
    corner = np.stack([edges.points, edges.points[edges.next_corner]], axis=1)
    others = [shapely.union_all(np.delete(outlines, row)) for row in range(len(outlines))]
    shapely.prepare(others)
    expected = [
        oracle(others[row], outlines[row], edge, streets)
        for row, edge in zip(edges.outline.tolist(), corner, strict=True)
    ]
    decided = np.array([value is not None for value in expected])
    assert decided.mean() > 0.85
    assert widths[decided].tolist() == [value for value in expected if value is not None]
    assert 0.2 < (widths > 0).mean() < 0.8


def row_of_lots(num: int, gap: float = 0.0) -> Outlines:
    """Lots 10 m wide and 20 m deep from west to east."""
    return np.array([shapely.box(west, 0.0, west + 10.0, 20.0) for west in np.arange(num) * (10.0 + gap)], dtype=object)


def test_parcels_with_a_small_gap_have_no_street_between():
    near, far = widths_of(row_of_lots(3, 0.25))[1], widths_of(row_of_lots(3, 0.35))[1]
    assert sorted(near) == [0.0, 0.0, DEFAULT_WIDTH, DEFAULT_WIDTH]
    assert far == [DEFAULT_WIDTH] * 4


def test_an_edge_is_on_a_street_if_half_of_it_is_open():
    for share, width in ((0.45, DEFAULT_WIDTH), (0.55, 0.0)):
        lots = np.array([shapely.box(0, 0, 10, 20), shapely.box(0, -5, 10 * share, 0)], dtype=object)
        edges = LotEdges.of(lots)
        south = np.flatnonzero((edges.outline == 0) & (edges.normal[:, 1] < -0.5))
        assert street_widths(edges, PackedOutlines.of(lots), np.arange(2), None, np.zeros(2, bool))[south].tolist() == [
            width
        ]


def test_streets_behind_parcels_or_behind_the_lot_do_not_count():
    lots = np.array([shapely.box(0, 0, 10, 10), shapely.box(0, -12, 10, -8)], dtype=object)
    behind = StreetLines(np.array([shapely.LineString([(-5, -16), (15, -16)])], dtype=object), np.array([6.0]))
    assert max(widths_of(lots, behind)[0]) == 0.0
    assert sorted(widths_of(lots[:1], behind)[0]) == [0.0, 0.0, 0.0, 6.0]
    # A parcel that is a street does not block the view.
    assert sorted(widths_of(lots, behind, plots=(1,))[0]) == [0.0, 0.0, 0.0, 6.0]


def test_the_nearest_street_counts_and_an_unknown_width_is_the_default():
    lines = [shapely.LineString([(-50, y), (50, y)]) for y in (-4.0, -9.0, -40.0)]
    streets = StreetLines(np.array(lines, dtype=object), np.array([np.nan, 20.0, 30.0]))
    assert max(widths_of(row_of_lots(1), streets)[0]) == DEFAULT_WIDTH
    assert max(widths_of(row_of_lots(1), StreetLines(streets.line[1:], streets.width[1:]))[0]) == 20.0
    assert max(widths_of(row_of_lots(1), StreetLines(streets.line[2:], streets.width[2:]))[0]) == 0.0


def test_a_parcel_that_reaches_to_the_middle_of_the_street_is_on_it():
    street = StreetLines(np.array([shapely.LineString([(-50, 0), (50, 0)])], dtype=object), np.array([12.0]))
    assert sorted(widths_of(row_of_lots(1), street)[0]) == [0.0, 0.0, 0.0, 12.0]


def test_edges_of_holes_are_on_no_street():
    lot = shapely.Polygon([(0, 0), (40, 0), (40, 40), (0, 40)], [[(10, 10), (30, 10), (30, 30), (10, 30)]])
    widths = widths_of(np.array([lot], dtype=object))[0]
    assert widths == [DEFAULT_WIDTH] * 4 + [0.0] * 4


def test_streets_do_not_depend_on_the_order_of_parcels():
    quarter = lot_map(7)
    outlines = quarter.parcels.outline
    order = np.random.default_rng(0).permutation(len(outlines))
    for streets in (None, quarter.streets):
        shuffled = widths_of(outlines[order], streets)
        straight = widths_of(outlines, streets)
        assert shuffled == [straight[row] for row in order]


def test_streets_do_not_depend_on_which_lots_are_looked_at_together(monkeypatch: pytest.MonkeyPatch):
    quarter = lot_map(7)
    whole = widths_of(quarter.parcels.outline, quarter.streets)
    monkeypatch.setattr("grammarlab.city.packed_outlines.AT_ONCE", 3)
    assert widths_of(quarter.parcels.outline, quarter.streets) == whole


def test_a_new_parcel_changes_those_that_it_touches_or_cuts_off():
    quarter = lot_map(7)
    outlines = quarter.parcels.outline
    for removed in range(0, len(outlines), 5):
        rest = np.delete(outlines, removed)
        for streets in (None, quarter.streets):
            before = widths_of(rest, streets)
            after = widths_of(outlines, streets)
            del after[removed]
            changed = [row for row in range(len(rest)) if before[row] != after[row]]
            distance = shapely.distance(rest[changed], outlines[removed])
            assert (distance <= (GAP if streets is None else REACH)).all()


def test_a_map_without_parcels_or_streets_has_no_edges():
    nothing = np.zeros(0, dtype=object)
    assert widths_of(nothing) == []
    assert widths_of(row_of_lots(1), StreetLines(nothing, np.zeros(0)))[0] == [0.0] * 4
