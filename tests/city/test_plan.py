"""Plans are read as they are written, and every mistake has its line and column."""

from __future__ import annotations

from pathlib import Path

import pytest
import shapely

from grammarlab.city.layout_request import BlockEdit, ParcelSizes
from grammarlab.city.plan import FieldFormula, LotRules, Setbacks, StreetTrees, parse_plan, read_plan
from grammarlab.city.tree_map_plan import TreeMapPlan
from grammarlab.errors import LanguageError, UsageError

SMALL = """parcels = "lots.gpkg"
[[zones]]
name = "all"
grammar = "building"
"""
LARGE = """
parcels = "../maps/lots.gpkg"
crs = "EPSG:2154"
id = "IDU"
seed = 18446744073709551615
streets = "streets.geojson"
street_width = "rue"
terrain = "ground.tif"
geoid_height = 44.6
pins = "chosen.csv"

[setbacks]
front = 0
side = 1.5

[minimum]
area = 40
side = 3
[maximum]
area = 9000
[ring]
depth = 14
court = 100

[[fields]]
name = "centre"
distance = "centre.geojson"

[[zones]]
name = "park"
grammar = "oak"
match = { use = ["park", "garden"], public = true, floors = 3 }
trees_per_hectare = 80

[[zones]]
name = "downtown 1"
grammar = "rules/haussmann.cga"
where = "centre < 400 and use != 'shop'"
polygon = "POLYGON ((0 0, 9 0, 9 9, 0 0))"
density = "quarter.zones.json"
attributes = { height = "= 3 * floors", style = "brick", levels = 5, corner = true }
setbacks = { back = 8 }
footprint = "ring"
start = "LotCorner"

[street_trees]
species = "trees/lime.toml"
spacing = 7

[tree_map]
file = "../maps/trees.gpkg"
field = "botanical"
area = "POLYGON ((0 0, 9 0, 9 9, 0 0))"
species = { oak = ["Quercus", "Ulmus"], "trees/lime.toml" = "Tilia" }
"""


def plan(text: str):
    return parse_plan(text, Path("town/plan.toml"))


def test_a_plan_needs_parcels_and_one_zone():
    small = plan(SMALL)
    assert small.parcels == Path("town/lots.gpkg")
    assert [zone.name for zone in small.zones] == ["all"]
    assert small.lots == LotRules()
    assert small.pins == Path("town/pins.csv")
    assert (small.crs, small.seed, small.street_trees, small.layout) == (None, 0, None, None)


def test_all_keys_of_a_plan_are_read():
    large = plan(LARGE)
    assert (large.parcels, large.crs, large.id_field) == (Path("town/../maps/lots.gpkg"), "EPSG:2154", "IDU")
    assert (large.seed, large.geoid_height, large.street_width) == (2**64 - 1, 44.6, "rue")
    assert (large.streets, large.terrain) == (Path("town/streets.geojson"), Path("town/ground.tif"))
    assert large.pins == Path("town/chosen.csv")
    assert large.lots == LotRules(
        setbacks=Setbacks(0.0, 1.5, 5.0),
        least_area=40.0,
        least_side=3.0,
        most_area=9000.0,
        ring_depth=14.0,
        least_court=100.0,
    )
    assert large.fields[0].distance == Path("town/centre.geojson")
    park, downtown = large.zones
    assert (park.grammar, park.trees_per_hectare) == ("oak", 80.0)
    assert park.match == {"use": ("park", "garden"), "public": (True,), "floors": (3,)}
    assert downtown.grammar == "town/rules/haussmann.cga"
    assert downtown.density == Path("town/quarter.zones.json")
    assert downtown.polygon.startswith("POLYGON")
    assert downtown.attributes == {
        "height": FieldFormula("3 * floors"),
        "style": "brick",
        "levels": 5.0,
        "corner": True,
    }
    assert downtown.setbacks == Setbacks(0.0, 1.5, 8.0)
    assert (downtown.footprint, downtown.start) == ("ring", "LotCorner")
    assert large.street_trees == StreetTrees(species="town/trees/lime.toml", spacing=7.0)
    assert large.tree_map == TreeMapPlan(
        file=Path("town/../maps/trees.gpkg"),
        field="botanical",
        area="POLYGON ((0 0, 9 0, 9 9, 0 0))",
        species={"oak": ("Quercus", "Ulmus"), "town/trees/lime.toml": ("Tilia",)},
    )


def test_a_layout_is_a_request_with_the_seed_of_its_plan():
    text = f"""seed = 7
[layout]
size = "500x300.5"
field = "radial"
centre = [10, 20]
widths = [20, 9]
[layout.parcels]
area = 300
[layout.blocks.b2f]
use = "park"
area = 500
{SMALL.partition(chr(10))[2]}"""
    layout = plan(text).layout
    assert layout is not None
    request = layout.request()
    assert (request.seed, request.outline.bounds, request.widths) == (7, (0.0, 0.0, 500.0, 300.5), (20.0, 9.0))
    assert (request.field.kind, request.field.centre, request.sizes.area) == ("radial", (10.0, 20.0), 300.0)
    assert request.edits == {"b2f": BlockEdit(use="park", sizes=ParcelSizes(area=500.0))}
    outline = plan(text.replace('size = "500x300.5"', 'outline = "town.geojson"')).layout
    assert outline is not None
    assert (outline.size, outline.outline) == (None, Path("town/town.geojson"))
    assert outline.request(shapely.box(0, 0, 9, 9)).outline.area == 81.0


@pytest.mark.parametrize(
    ("text", "line", "column", "message"),
    [
        ("parcels = ", 1, 11, "not TOML"),
        ("parcel" + SMALL[7:], 1, 1, "did you mean parcels"),
        (SMALL.replace("grammar", "grammer"), 4, 1, "did you mean grammar"),
        (SMALL.replace('"lots.gpkg"', "3"), 1, 11, "a text"),
        (SMALL + "setbacks = { front = -1 }", 5, 22, "front from 0 to"),
        (SMALL + "setbacks = { front = true }", 5, 22, "expected a number"),
        (SMALL + 'footprint = "round"', 5, 13, '"setback" or "parcel" or "ring"'),
        (SMALL + "attributes = { height = [1] }", 5, 25, "expression"),
        (SMALL + "match = { use = [] }", 5, 17, "a value or a list of values"),
        (SMALL + "[layout]", 5, 1, "either parcels or"),
        ('[layout]\nsize = "0x9"\n' + SMALL.partition("\n")[2], 2, 8, "600x400"),
        ("[layout]\nblock_area = [9000, 1000]\n" + SMALL.partition("\n")[2], 2, 14, "smaller area"),
        ('[layout]\nfield = "round"\n' + SMALL.partition("\n")[2], 2, 9, '"grid" or "radial"'),
        ("[layout.blocks.b2]\nuse = 3\n" + SMALL.partition("\n")[2], 2, 7, '"lots" or "park"'),
        (SMALL.replace('"lots.gpkg"', '"lots.gpkg"\nseed = -1'), 2, 8, "whole number"),
        (SMALL + SMALL.partition("\n")[2], 6, 8, "exists already"),
        (SMALL.partition("\n")[2], 1, 1, "expected parcels"),
        ('parcels = "a.gpkg"', 1, 1, "expected zones"),
        (SMALL + '[[fields]]\nname = "x"', 5, 3, "either raster"),
        (SMALL + '[street_trees]\nspacing = 0.1\nspecies = "oak"', 6, 11, "from 1 to"),
        (SMALL + "[tree_map]", 5, 2, 'file = "…", a text'),
        (SMALL + '[tree_map]\nfile = "t.gpkg"\nfeild = "art"', 7, 1, "did you mean field"),
        (SMALL + '[tree_map]\nfile = "t.gpkg"\nspecies = { oak = [] }', 7, 19, "names on the map"),
        (SMALL + '[tree_map.species]\noak = "Q"\nbirch = " q "', 7, 9, "name of 'oak' already"),
        (SMALL.replace("building", "a.trees.json") + "trees_per_hectare = 9", 5, 1, "have their own density"),
    ],
)
def test_mistakes_have_line_and_column(text: str, line: int, column: int, message: str):
    with pytest.raises(LanguageError, match=message) as caught:
        plan(text)
    locations = [finding.location for finding in caught.value.findings]
    assert (line, column) in [(location.line, location.column) for location in locations], caught.value


def test_all_mistakes_are_reported_at_once():
    with pytest.raises(LanguageError) as caught:
        plan("crs = 1\nid = 2\nterrain = 3\n" + SMALL)
    assert [finding.location.line for finding in caught.value.findings] == [1, 2, 3]


def test_read_plan_names_the_file(tmp_path: Path):
    with pytest.raises(UsageError, match=r"no plan .*missing\.toml"):
        read_plan(tmp_path / "missing.toml")
    path = tmp_path / "plan.toml"
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(LanguageError, match="UTF-16"):
        read_plan(path)
    path.write_text(SMALL, encoding="utf-8")
    assert read_plan(path).parcels == tmp_path / "lots.gpkg"
