"""What stands on a parcel depends on its own values, its pin and its streets, and on nothing else."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
import shapely

from grammarlab.city.parcel_addresses import Pin, Pins, excluded, pinned, rerolled
from grammarlab.city.parcels import Parcels
from grammarlab.city.plan import Plan, parse_plan
from grammarlab.city.site_making import SiteSources, sites_of
from grammarlab.city.sites import Sites
from grammarlab.city.street_lines import StreetLines
from grammarlab.errors import UsageError
from tests.city.lot_maps import lot_map, parcels_of

PLAN = """
parcels = "lots.gpkg"
seed = 3
[[zones]]
name = "shops"
grammar = "building"
where = "use == 'shop' and area > 150"
attributes = { height = "= area / 10", style = "= use", floors = 3, open = true }
[[zones]]
name = "courts"
grammar = "building"
polygon = "POLYGON ((0 0, 110 0, 110 220, 0 220, 0 0))"
footprint = "ring"
setbacks = { front = 0, side = 0, back = 0 }
[[zones]]
name = "homes"
grammar = "building"
where = "use == 'home'"
attributes = { height = 7.5 }
[ring]
depth = 4
"""
HOMES = """
parcels = "lots.gpkg"
[[zones]]
name = "homes"
grammar = "building"
where = "use == 'home'"
"""


def plan_of(text: str = PLAN) -> Plan:
    return parse_plan(text, Path("town/plan.toml"))


class Slope:
    """A hillside that rises to the north-east, unknown west of 0."""

    def heights(self, east_north: np.ndarray, /) -> np.ndarray:
        return np.where(east_north[:, 0] < 0.0, np.nan, 100.0 + 0.1 * east_north[:, 0] + 0.2 * east_north[:, 1])


def records(sites: Sites, parcels: Parcels) -> dict[str, tuple[object, ...]]:
    """All that is known of each site, by the id of its parcel."""
    fixed = zip(
        *(column.tolist() for column in (sites.zone, sites.seed, sites.model, sites.reroll, sites.start_rule)),
        strict=True,
    )
    return {
        str(parcels.id[sites.parcel[row]]): (
            *values,
            sites.corner[row].tobytes(),
            sites.footprints.polygon(row).tobytes(),
            np.asarray(sites.footprints.widths(row)).tobytes(),
            {name: (column.values[row], column.is_given[row]) for name, column in sites.attributes.items()},
        )
        for row, values in enumerate(fixed)
    }


def widths_of(sites: Sites) -> np.ndarray:
    """Widths of streets along all edges."""
    assert sites.footprints.street_width is not None
    return sites.footprints.street_width


def made(parcels: Parcels, streets: StreetLines | None, pins: Pins | None = None) -> dict[str, tuple[object, ...]]:
    sites, reason = sites_of(plan_of(), parcels, streets, Slope(), pins or Pins())
    assert ((reason == "") == np.isin(np.arange(len(parcels)), sites.parcel)).all()
    return records(sites, parcels)


def changes(before: dict[str, tuple[object, ...]], after: dict[str, tuple[object, ...]]) -> set[str]:
    return {parcel for parcel in before.keys() | after.keys() if repr(before.get(parcel)) != repr(after.get(parcel))}


@pytest.mark.parametrize("has_streets", [True, False])
def test_rows_in_another_order_are_the_same_sites(has_streets: bool):
    quarter = lot_map(4)
    streets = quarter.streets if has_streets else None
    order = np.random.default_rng(1).permutation(len(quarter.parcels))
    assert not changes(made(quarter.parcels, streets), made(quarter.parcels.take(order), streets))


@pytest.mark.parametrize("has_streets", [True, False])
def test_sites_do_not_depend_on_how_many_lots_are_looked_at_together(
    has_streets: bool, monkeypatch: pytest.MonkeyPatch
):
    quarter = lot_map(4)
    streets = quarter.streets if has_streets else None
    together = made(quarter.parcels, streets)
    monkeypatch.setattr("grammarlab.city.packed_outlines.AT_ONCE", 3)
    assert len(together) > 6
    assert not changes(together, made(quarter.parcels, streets))


@pytest.mark.parametrize("has_streets", [True, False])
def test_one_more_parcel_changes_only_its_neighbours(has_streets: bool):
    quarter = lot_map(4)
    parcels, streets = quarter.parcels, quarter.streets if has_streets else None
    whole = made(parcels, streets)
    for row in range(0, len(parcels), 7):
        rest = parcels.take(np.arange(len(parcels)) != row)
        changed = changes(made(rest, streets), whole)
        distance = shapely.distance(parcels.outline[np.isin(parcels.id, list(changed))], parcels.outline[row])
        # Those that it cuts off from a street lie behind it, within the reach of the street.
        assert (distance <= (30.0 if has_streets else 0.3)).all()
        assert len(changed) < len(parcels) // 3


def test_a_new_street_width_in_the_file_replaces_neighbours():
    """With the widths of streets in the file, edges along streets alone still depend on neighbours."""
    quarter = lot_map(4)
    parcels = replace(
        quarter.parcels,
        attributes=quarter.parcels.attributes.append_column("w", pa.array([15.0] * len(quarter.parcels))),
    )
    text = PLAN.replace("seed = 3", 'seed = 3\nstreet_width = "w"')
    sites, _ = sites_of(plan_of(text), parcels, quarter.streets)
    assert set(np.unique(widths_of(sites))) == {0.0, 15.0}


def test_pins_change_one_site():
    quarter = lot_map(4)
    before = made(quarter.parcels, quarter.streets)
    parcel = sorted(before)[5]
    for pins in (
        rerolled(Pins(), parcel),
        pinned(Pins(), parcel, seed=1, model=2, zone="homes"),
        excluded(Pins(), parcel),
        Pins.of([Pin(parcel, zone="homes" if before[parcel][0] != 2 else "courts")]),
        Pins.of([Pin(parcel, reroll=1), Pin("of another map", reroll=1)]),
    ):
        assert changes(before, made(quarter.parcels, quarter.streets, pins)) == {parcel}


def test_every_parcel_has_a_site_or_a_reason():
    lots = [
        shapely.box(0, 0, 20, 30),
        shapely.box(20, 0, 21, 30),
        shapely.box(21, 0, 100, 100),
        shapely.box(0, 30, 20, 33),
        shapely.LineString([(-10, -6), (400, -6)]).buffer(6, cap_style="flat"),
        shapely.box(100, 0, 120, 30),
        shapely.box(120, 0, 135, 30),
        shapely.box(140, 0, 160, 30),
    ]
    parcels = parcels_of(lots, use=["home"] * 7 + ["shop"])
    reasons = parcels.reason.copy()
    reasons[0], reasons[4] = "overlap", "street"
    pins = excluded(Pins(), parcels.id[5])
    sites, reason = sites_of(plan_of(HOMES), replace(parcels, reason=reasons), pins=pins)
    assert reason.tolist() == ["overlap", "small", "large", "small", "street", "excluded", "", "zone"]
    assert sites.parcel.tolist() == [6]


def test_streets_by_a_condition_are_not_those_by_their_shape():
    lots = [shapely.box(0, 0, 20, 30), shapely.box(0, -2, 20, 0), shapely.box(0, -20, 20, -2)]
    parcels = replace(parcels_of(lots, use=["home", "road", "home"]), reason=np.array(["", "", "street"], dtype=object))
    text = HOMES.replace("[[zones]]", "street_plots = \"use == 'road'\"\n[[zones]]")
    sites, reason = sites_of(plan_of(text), parcels)
    assert reason.tolist() == ["", "street", ""]
    assert (widths_of(sites) > 0).all()
    sites, reason = sites_of(plan_of(HOMES), parcels)
    assert reason.tolist() == ["", "zone", "street"]
    assert np.count_nonzero(widths_of(sites)) == 3


def test_origins_are_whole_metres_and_footprints_lie_on_their_parcels():
    quarter = lot_map(4)
    sites, _ = sites_of(plan_of(), quarter.parcels, quarter.streets)
    assert (sites.corner == np.round(sites.corner)).all()
    for row in range(len(sites)):
        polygon = sites.footprints.polygon(row)
        x, y, z = (polygon + sites.corner[row]).T
        outline = shapely.Polygon(np.column_stack([x, -z])).buffer(0)
        parcel = quarter.parcels.outline[sites.parcel[row]]
        assert shapely.area(shapely.difference(outline, shapely.buffer(parcel, 0.1))) < 1e-6
        assert (y == 0.0).all()
        assert shapely.is_ccw(shapely.LinearRing(np.column_stack([x, -z])))
        assert np.abs(polygon).max() < 150.0


def test_the_ground_counts_from_the_middle_of_the_front():
    lot = parcels_of([shapely.box(10, 20, 30, 50)], use=["home"])
    street = StreetLines(np.array([shapely.LineString([(0, 15), (90, 15)])], dtype=object), np.array([10.0]))
    sites, _ = sites_of(plan_of(HOMES), lot, street, Slope())
    south = 23.0
    base = 100.0 + 0.1 * 20.0 + 0.2 * south
    assert sites.corner[0].tolist() == [10.0, pytest.approx(base), -20.0]
    ground = {name: column.values[0] for name, column in sites.attributes.items() if name.startswith("ground")}
    low, high = -0.1 * 8.0, 0.1 * 8.0 + 0.2 * 22.0
    assert ground["groundMin"] == pytest.approx(low, abs=1e-3)
    assert ground["groundMax"] == pytest.approx(high, abs=1e-3)
    assert ground["groundMean"] == pytest.approx((low + high) / 2, abs=0.02)


def test_without_terrain_the_ground_is_that_of_the_parcel():
    lots = parcels_of([shapely.box(0, 0, 20, 30), shapely.box(40, 0, 60, 30)], use=["home", "home"])
    sites, _ = sites_of(plan_of(HOMES), replace(lots, elevation=np.array([7.5, np.nan])))
    assert sites.corner[:, 1].tolist() == [7.5, 0.0]
    assert not sites.attributes["groundMin"].is_given.any()
    west, _ = sites_of(plan_of(HOMES), parcels_of([shapely.box(-90, 0, -70, 30)], use=["home"]), None, Slope())
    assert west.corner[:, 1].tolist() == [0.0]


def test_attributes_are_those_of_the_zone():
    quarter = lot_map(4)
    sites, _ = sites_of(plan_of(), quarter.parcels, quarter.streets)
    area = quarter.parcels.area[sites.parcel]
    height = sites.attributes["height"]
    shop, home = sites.zone == 0, sites.zone == 2
    assert shop.any()
    assert home.any()
    assert np.allclose(height.values[shop], area[shop] / 10)
    assert (height.values[home] == 7.5).all()
    assert (height.is_given == (shop | home)).all()
    assert set(sites.attributes["style"].values[shop]) == {"shop"}
    assert sites.attributes["open"].values.dtype == np.bool_
    assert sites.lots().model.tolist() == sites.model.tolist()


def test_attributes_have_one_kind():
    text = PLAN.replace("height = 7.5", 'height = "high"')
    with pytest.raises(UsageError, match=r"attribute height: .*number and text"):
        sites_of(plan_of(text), lot_map(4).parcels)
    with pytest.raises(UsageError, match="zone 'shops': attribute height: unknown name 'aera'"):
        sites_of(plan_of(PLAN.replace("= area / 10", "= aera / 10")), lot_map(4).parcels)


def test_start_rules_fit_the_lot_where_the_grammar_has_them():
    lots = [
        shapely.box(0, 0, 20, 30),
        shapely.box(20, 0, 40, 30),
        shapely.box(20, 30, 40, 60),
        shapely.box(0, 30, 20, 60),
    ]
    parcels = parcels_of(lots, use=["home"] * 4)
    lines = [shapely.LineString([(-50, -4), (90, -4)]), shapely.LineString([(-4, -50), (-4, 28)])]
    streets = StreetLines(np.array(lines, dtype=object), np.array([8.0, 8.0]))

    def starts(*rules: str, text: str = HOMES) -> list[str]:
        return sites_of(plan_of(text), parcels, streets, sources=SiteSources(start_rules={"homes": rules}))[
            0
        ].start_rule.tolist()

    assert starts() == [""] * 4
    assert starts("Lot", "LotInner", "LotCorner")[:3] == ["LotCorner", "Lot", "LotInner"]
    assert starts("Lot", "Other") == ["Lot"] * 4
    assert starts("Lot", text=HOMES + 'start = "House"') == ["House"] * 4


def test_parks_have_the_whole_parcel_whatever_its_size():
    lots = parcels_of([shapely.box(0, 0, 400, 300), shapely.box(500, 0, 501, 20)], use=["home", "home"])
    sites, reason = sites_of(plan_of(HOMES), lots, sources=SiteSources(parks=("homes",)))
    assert reason.tolist() == ["", ""]
    areas = [shapely.Polygon(sites.footprints.polygon(row)[:, [0, 2]]).area for row in range(2)]
    assert areas == pytest.approx([120_000.0, 20.0])


def test_an_empty_map_has_no_sites():
    nothing = lot_map(4).parcels.take(np.zeros(0, np.int64))
    sites, reason = sites_of(plan_of(), nothing)
    assert (len(sites), len(reason)) == (0, 0)
