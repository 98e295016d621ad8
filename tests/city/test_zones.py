"""A parcel is in the first zone whose conditions it meets."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely

from grammarlab.city.fields import parcel_fields
from grammarlab.city.plan import Plan, parse_plan
from grammarlab.city.plan_fields import PlanFields
from grammarlab.city.polygon_text import polygon_of_text
from grammarlab.city.zone_density import ZoneDensity
from grammarlab.city.zone_draws import drawn_zones
from grammarlab.city.zones import NO_ZONE, ZoneFields, ZoneSources, named_zones, zones_of
from grammarlab.errors import UsageError
from grammarlab.geometry.footprints.frame import Frame
from tests.city.lot_maps import parcels_of

HOOK = shapely.Polygon([(0, 0), (30, 0), (30, 3), (3, 3), (3, 30), (0, 30)])
PARCELS = parcels_of([HOOK, *(shapely.box(40 * k, 40, 40 * k + 30, 60) for k in range(5))], use=[*"aabbcc"])
FIELDS = ZoneFields(
    plan=PlanFields(
        PARCELS.attributes, {"area": PARCELS.area, "east": shapely.get_x(shapely.centroid(PARCELS.outline))}
    ),
    learned=parcel_fields(PARCELS),
)


def plan_of(*zones: str) -> Plan:
    tables = "".join(f'[[zones]]\nname = "z{k}"\ngrammar = "building"\n{zone}\n' for k, zone in enumerate(zones))
    return parse_plan(f'parcels = "x"\n{tables}', Path("plan.toml"))


def zones(*texts: str, sources: ZoneSources | None = None) -> list[int]:
    return zones_of(plan_of(*texts), FIELDS, sources or ZoneSources()).tolist()


def density(*names: str) -> ZoneDensity:
    return ZoneDensity(
        zones=names,
        frame=PARCELS.frame,
        features=(),
        intercept=np.zeros(len(names)),
        slope=np.zeros((0, len(names))),
        places=np.zeros((0, 2)),
        weights=np.zeros((0, len(names))),
        length=1.0,
        scale=0.0,
        counts=np.zeros((0, len(names))),
        offsets=np.zeros((0, len(names))),
        answers="0" * 64,
    )


def test_the_first_zone_whose_conditions_hold():
    assert zones("match = { use = 'a' }", "where = \"use == 'b'\"") == [0, 0, 1, 1, NO_ZONE, NO_ZONE]
    assert zones("where = 'area > 100'", "") == [0 if area > 100 else 1 for area in PARCELS.area]
    assert zones("match = { use = ['a', 'c'] }\nwhere = 'east > 100'", "") == [1, 1, 1, 1, 0, 0]
    assert zones("", "where = '1'") == [0] * 6


def test_polygons_hold_a_point_inside_the_parcel_and_not_its_centroid():
    inside = shapely.get_coordinates(shapely.point_on_surface(HOOK))[0]
    around = shapely.Point(inside).buffer(1.0)
    assert not around.contains(HOOK.centroid)
    assert zones(f"polygon = '{around.wkt}'") == [0, *[NO_ZONE] * 5]
    centroid = HOOK.centroid.buffer(1.0)
    assert zones(f"polygon = '{centroid.wkt}'") == [NO_ZONE] * 6
    file = ZoneSources(areas={"z0": shapely.box(30, 30, 75, 90)})
    assert zones("polygon = 'centre.geojson'", sources=file) == [NO_ZONE, NO_ZONE, 0, NO_ZONE, NO_ZONE, NO_ZONE]


def test_each_parcel_is_in_the_zone_that_its_density_draws():
    names = ("z2", "z0", "z1")
    sources = ZoneSources(densities={Path("town.zones.json"): density(*names)})
    texts = ["density = 'town.zones.json'"] * 3
    expected = [int(names[k][1]) for k in drawn_zones(density(*names), FIELDS.learned, 0)]
    assert zones(*texts, sources=sources) == expected
    both = zones("density = 'town.zones.json'\nmatch = { use = 'a' }", *texts[1:], "", sources=sources)
    assert both == [3 if zone == 0 and use != "a" else zone for zone, use in zip(expected, "aabbcc", strict=True)]


def test_mistakes_name_the_zone():
    for text, message in (
        ("where = 'aera > 2'", "plan.toml: zone 'z0': unknown name 'aera'"),
        ("match = { us = 'a' }", "zone 'z0': unknown field 'us'; did you mean use"),
        ("polygon = 'POLYGON ((0 0, 1'", "zone 'z0': .*not WKT"),
        ("polygon = 'centre.geojson'", r"zone 'z0': expected the polygon of centre\.geojson"),
        ("polygon = 'SRID=4326;POLYGON ((0 0, 1 0, 1 1, 0 0))'", "place of the parcels is unknown"),
        ("density = 'town.zones.json'", r"expected the learned zones of town\.zones\.json"),
    ):
        with pytest.raises(UsageError, match=message):
            zones(text)
    sources = ZoneSources(densities={Path("town.zones.json"): density("other")})
    with pytest.raises(UsageError, match="no such zone; it has other"):
        zones("density = 'town.zones.json'", sources=sources)


def test_polygons_are_in_the_coordinate_system_of_the_frame_or_in_their_own():
    frame = Frame("EPSG:32631", (448000.0, 5412000.0))
    corner = shapely.Point(*frame.longitude_latitude(np.array([[100.0, 200.0]]))[0])
    degrees = polygon_of_text(f"SRID=4326;{corner.buffer(0.001).wkt}", frame)
    assert degrees.distance(shapely.Point(100.0, 200.0)) == 0.0
    metres = polygon_of_text(shapely.box(448000, 5412000, 448100, 5412100).wkt, frame)
    assert metres.bounds == (0.0, 0.0, 100.0, 100.0)
    with pytest.raises(UsageError, match="unknown coordinate system"):
        polygon_of_text("SRID=999999;POLYGON ((0 0, 1 0, 1 1, 0 0))", frame)
    with pytest.raises(UsageError, match="expected a POLYGON"):
        polygon_of_text("POLYGON EMPTY", frame)


def test_zones_of_pins_are_those_of_the_plan():
    plan = plan_of("", "")
    assert named_zones(plan, np.array(["z1", "", "z0"], object)).tolist() == [1, NO_ZONE, 0]
    with pytest.raises(UsageError, match="unknown zone 'z9'; the plan has z0, z1"):
        named_zones(plan, np.array(["z9"], object))
