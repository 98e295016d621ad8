"""Widths of streets in a column of a map, for all edges of a parcel or for each."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely

from grammarlab.city.lot_survey import LotSurvey, surveyed_lots
from grammarlab.city.parcel_map import read_parcels
from grammarlab.city.plan import parse_plan
from grammarlab.errors import UsageError
from tests.city.lot_maps import parcels_of
from tests.city.parcel_files import UTM, moved, write_map

LOTS = [
    # Clockwise, with a corner that is left out, and beside its neighbour.
    shapely.Polygon([(0, 0), (0, 30), (10, 30.01), (20, 30), (20, 0)]),
    shapely.Polygon([(20, 0), (40, 0), (40, 30), (20, 30)]),
]
MAPPED = moved([shapely.Polygon([(0, 0), (20, 0), (20, 30), (0, 30)]), LOTS[1]], UTM)
PLAN = parse_plan('parcels = "x"\nstreet_width = "w"\n[[zones]]\nname = "a"\ngrammar = "building"', Path("plan.toml"))


def by_side(lots: LotSurvey) -> list[dict[str, float]]:
    """Widths of each lot by the side that an edge looks to."""
    edges = lots.edges
    names = np.select(
        [edges.normal[:, 0] > 0.9, edges.normal[:, 0] < -0.9, edges.normal[:, 1] > 0], ["e", "w", "n"], "s"
    )
    return [
        {str(names[row]): float(lots.street_width[row]) for row in np.flatnonzero(edges.outline == lot)}
        for lot in range(len(lots))
    ]


def widths(column: list[object]) -> list[dict[str, float]]:
    return by_side(surveyed_lots(PLAN, parcels_of(LOTS, w=column), None))


def test_a_number_is_the_width_of_all_streets_of_a_parcel():
    assert widths([12.0, None]) == [
        {"w": 12.0, "n": 12.0, "e": 0.0, "s": 12.0},
        {"s": 8.0, "e": 8.0, "n": 8.0, "w": 0.0},
    ]
    assert widths(["12", ""]) == widths([12.0, None])
    assert widths([0.0, 0.0]) == [dict.fromkeys("wnes", 0.0)] * 2


def test_a_list_has_the_edges_as_they_are_drawn():
    first, second = widths(["5;6;6;7;0", "[1, 2, 3.5, 4]"])
    assert first == {"w": 5.0, "n": 6.0, "e": 7.0, "s": 0.0}
    assert second == {"s": 1.0, "e": 2.0, "n": 3.5, "w": 4.0}


def test_a_list_of_another_length_is_left_out():
    first, second = widths(["5;6;7;0", "1 2 3 4"])
    assert first == {"w": 8.0, "n": 8.0, "e": 0.0, "s": 8.0}
    assert second == {"s": 1.0, "e": 2.0, "n": 3.0, "w": 4.0}


@pytest.mark.parametrize("suffix", [".geojson", ".gpkg", ".fgb"])
def test_lists_of_maps_are_texts_of_maps(tmp_path: Path, suffix: str):
    texts, lists = ["5;6;7;0", "1;2;3.5;4"], [[5.0, 6.0, 7.0, 0.0], [1.0, 2.0, 3.5, 4.0]]
    drawn = [
        read_parcels(write_map(tmp_path / f"{name}{suffix}", MAPPED, UTM, id=["a", "b"], w=column)).parcels
        for name, column in (("texts", texts), ("lists", lists), ("other", texts[::-1]))
    ]
    first, second, other = (by_side(surveyed_lots(PLAN, parcels, None)) for parcels in drawn)
    assert first == second != other
    assert first == [{"s": 5.0, "e": 6.0, "n": 7.0, "w": 0.0}, {"s": 1.0, "e": 2.0, "n": 3.5, "w": 4.0}]


def test_numbers_and_lists_of_a_map_are_in_one_column(tmp_path: Path):
    path = write_map(tmp_path / "map.geojson", MAPPED, UTM, id=["a", "b"], w=["NUMBER", "LIST"])
    path.write_text(path.read_text().replace('"NUMBER"', "12").replace('"LIST"', "[1, 2, 3.5, 4]"))
    first, second = by_side(surveyed_lots(PLAN, read_parcels(path).parcels, None))
    assert first == {"s": 12.0, "e": 0.0, "n": 12.0, "w": 12.0}
    assert second == {"s": 1.0, "e": 2.0, "n": 3.5, "w": 4.0}


@pytest.mark.parametrize("suffix", [".geojson", ".gpkg", ".fgb"])
def test_lists_follow_the_ring_wherever_it_begins_and_however_it_turns(tmp_path: Path, suffix: str):
    """Outlines are kept drawn in one way, which is not the way of the map."""
    corners = [(0, 0), (20, 0), (20, 30), (0, 30)]
    by_edge = {frozenset((corners[row - 1], corners[row])): [1.0, 2.0, 3.5, 0.0][row - 1] for row in range(4)}
    rings = [turned[start:] + turned[:start] for turned in (corners, corners[::-1]) for start in range(4)]
    drawn = [[*zip(ring, [*ring[1:], ring[0]], strict=True)] for ring in rings]
    column = [[by_edge[frozenset(edge)] for edge in edges] for edges in drawn]
    apart = [shapely.Polygon([(x + 100 * row, y) for x, y in ring]) for row, ring in enumerate(rings)]
    path = write_map(tmp_path / f"map{suffix}", moved(apart, UTM), UTM, id=[*"abcdefgh"], w=column)
    found = by_side(surveyed_lots(PLAN, read_parcels(path).parcels, None))
    assert found == [{"s": 1.0, "e": 2.0, "n": 3.5, "w": 0.0}] * 8


def test_the_list_of_an_outline_that_is_cut_is_left_out(tmp_path: Path):
    """What is left has four edges, but they are not those of the map."""
    outlines = moved([shapely.box(0, 0, 20, 30), shapely.box(15, -1, 40, 31), shapely.box(15, 40, 40, 70)], UTM)
    path = write_map(tmp_path / "map.gpkg", outlines, UTM, id=["b", "a", "c"], w=[[1.0, 2.0, 3.0, 4.0]] * 3)
    parcels = read_parcels(path).parcels
    assert parcels.area.tolist() == pytest.approx([800, 450, 750])
    widths = [set(lot.values()) for lot in by_side(surveyed_lots(PLAN, parcels, None))]
    assert widths == [{1.0, 2.0, 3.0, 4.0}, {0.0, 8.0}, {1.0, 2.0, 3.0, 4.0}]


def test_with_lists_other_parcels_do_not_matter():
    alone = surveyed_lots(PLAN, parcels_of(LOTS[:1], w=["5;6;6;7;0"]), None)
    both = surveyed_lots(PLAN, parcels_of(LOTS, w=["5;6;6;7;0", "1;2;3;4"]), None)
    assert alone.street_width.tolist() == both.street_width[both.edges.outline == 0].tolist()


def test_an_unknown_field_is_named():
    with pytest.raises(UsageError, match=r"plan\.toml: street_width: unknown field 'w'"):
        surveyed_lots(PLAN, parcels_of(LOTS, v=[1.0, 2.0]), None)
