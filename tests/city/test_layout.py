from dataclasses import replace

import numpy as np
import pytest
import shapely

from grammarlab.city.city_layout import Layout, laid_out
from grammarlab.city.direction_field import FIELD_KINDS, DirectionField
from grammarlab.city.layout_request import STYLES, BlockEdit, LayoutRequest, ParcelSizes
from grammarlab.errors import UsageError
from tests.cases import some

SQUARE = shapely.box(0, 0, 420, 360)
STAR = shapely.Polygon([(0, 0), (400, 120), (800, 0), (640, 380), (760, 760), (380, 560), (0, 800), (150, 400)])
RIVER = shapely.LineString([(0, 0), (400, 200), (700, 100), (1100, 500), (1500, 450)]).buffer(70)
OUTLINES = {
    "square": SQUARE,
    "star": STAR,
    "river": RIVER,
    "lakes": shapely.box(0, 0, 700, 500)
    - shapely.Point(200, 260).buffer(70)
    - shapely.box(430, 300, 445, 320)
    - shapely.Point(560, 120).buffer(20),
    "islands": shapely.MultiPolygon(
        [shapely.box(0, 0, 300, 200), shapely.box(350, -90, 380, -60), shapely.affinity.translate(STAR, 500, 0)]
    ),
    "ring": shapely.Point(0, 0).buffer(350) - shapely.Point(0, 0).buffer(150),
    "island in a lake": (shapely.Point(0, 0).buffer(450) - shapely.Point(0, 0).buffer(250))
    | shapely.Point(0, 0).buffer(130),
    "needle": shapely.Polygon([(0, 0), (900, 40), (0, 90)]),
    "small": shapely.box(0, 0, 60, 45),
    "comb": shapely.union_all(
        [shapely.box(0, 0, 900, 100), *(shapely.box(60 * i, 0, 60 * i + 38, 300) for i in range(15))]
    ),
    "rough": shapely.Polygon(
        [((200 + 30 * (i % 2)) * np.cos(i * np.pi / 180), 300 * np.sin(i * np.pi / 180)) for i in range(360)]
    ),
    "far": shapely.affinity.translate(STAR, 5e5, 5.4e6),
}
TABLE = {
    "paris": ((53, 229, 1890), (1.05, 1.67, 5.0)),
    "suburb": ((17, 370, 1764), (1.14, 2.74, 10.7)),
    "villas": ((465, 996, 6643), (1.03, 1.29, 2.35)),
}
"""5, 50 and 95 % of the areas in square metres and of the aspects of boxes, measured on maps."""


def check_laws(layout: Layout, request: LayoutRequest) -> None:
    parcels, blocks = layout.parcels, layout.blocks
    assert shapely.is_valid(parcels.outline).all()
    assert shapely.coverage_is_valid(parcels.outline)
    assert parcels.id.tolist() == sorted(set(parcels.id.tolist()))
    assert blocks.id.tolist() == sorted(set(blocks.id.tolist()))
    rows = np.searchsorted(blocks.id.astype(str), np.array(parcels.attributes["block"].to_pylist()))
    sums = np.bincount(rows, parcels.area, minlength=len(blocks))
    assert sums[blocks.use != "open"] == pytest.approx(shapely.area(blocks.outline[blocks.use != "open"]), rel=1e-9)
    assert shapely.area(shapely.difference(blocks.outline, shapely.buffer(request.outline, 1.0))).max() < 0.1
    assert parcels.attributes["frontage"].to_numpy().min() >= request.sizes.frontage
    streets = shapely.buffer(layout.streets.line, layout.streets.width / 2 - 0.5, cap_style="flat")
    # Across a sharp notch of the outline, the street along one side may reach into a block at the other.
    covered = shapely.area(shapely.intersection(shapely.union_all(streets), blocks.outline)).sum()
    assert covered < 1e-3 * shapely.area(blocks.outline).sum()
    corners = shapely.get_coordinates(parcels.outline)
    assert (corners == np.round(corners, 3)).all()


@pytest.mark.parametrize("name", some(list(OUTLINES)))
@pytest.mark.parametrize("edge_width", [None, 0.0])
def test_layouts_of_odd_outlines_keep_the_laws(name: str, edge_width: float | None):
    kind = FIELD_KINDS[(len(name) + (edge_width is None)) % 3]
    request = LayoutRequest(outline=OUTLINES[name], edge_width=edge_width, field=DirectionField(kind), seed=4)
    layout = laid_out(request)
    check_laws(layout, request)
    assert shapely.area(layout.blocks.outline).sum() > 0.4 * request.outline.area


@pytest.mark.parametrize(
    "settings",
    [
        {"widths": (2.0,), "block_area": (200.0, 300.0)},
        {"widths": (120.0, 60.0), "block_area": (20_000.0, 20_000.0)},
        {"sizes": ParcelSizes(area=5.0, spread=3.0, frontage=1.0, aspect=1.0, aspect_spread=3.0)},
        {"sizes": ParcelSizes(area=1e8, frontage=1_000.0, aspect=100.0)},
        {"park_share": 1.0, "variation": 0.2},
        {"field": DirectionField("radial", centre=(-9e6, 4e6)), "seed": 2**64 - 1},
    ],
)
def test_extreme_settings_keep_the_laws(settings: dict):
    request = LayoutRequest(outline=SQUARE, **settings)
    layout = laid_out(request)
    streets = np.array(layout.parcels.attributes["frontage"].to_pylist())
    check_laws(layout, replace(request, sizes=replace(request.sizes, frontage=float(min(streets.min(), 1000.0)))))


def bytes_of(layout: Layout) -> dict[str, bytes]:
    return dict(zip(layout.parcels.id.tolist(), shapely.to_wkb(layout.parcels.outline), strict=True))


@pytest.mark.parametrize(
    "edit",
    [BlockEdit(seed=9), BlockEdit(use="park"), BlockEdit(use="open"), BlockEdit(sizes=ParcelSizes(area=900.0))],
)
def test_an_edit_changes_its_block_only(edit: BlockEdit):
    request = LayoutRequest(outline=STAR, seed=2, park_share=0.0)
    before = laid_out(request)
    name = before.blocks.id[7]
    after = laid_out(replace(request, edits={name: edit}))

    def others(layout: Layout) -> dict[str, bytes]:
        return {key: value for key, value in bytes_of(layout).items() if not key.startswith(name)}

    assert others(before) == others(after)
    assert bytes_of(before) != bytes_of(after)
    assert shapely.to_wkb(before.streets.line).tolist() == shapely.to_wkb(after.streets.line).tolist()
    num = sum(key.startswith(name) for key in bytes_of(after))
    assert num == {"park": 1, "open": 0}.get(edit.use or "", num)


def test_the_same_request_gives_the_same_bytes():
    request = LayoutRequest(outline=STAR, field=DirectionField("mixed"), seed=6)
    assert bytes_of(laid_out(request)) == bytes_of(laid_out(request))
    assert bytes_of(laid_out(request)) != bytes_of(laid_out(replace(request, seed=7)))


@pytest.mark.parametrize("style", STYLES)
def test_sizes_are_those_of_the_measured_maps(style: str):
    """At the 5, 50 and 95 % of the map, the distribution of a layout differs by less than 15 %."""
    layout = laid_out(LayoutRequest(outline=shapely.box(0, 0, 1500, 1100), sizes=STYLES[style], park_share=0.0, seed=1))
    corners = shapely.get_coordinates(shapely.oriented_envelope(layout.parcels.outline)).reshape(-1, 5, 2)
    sides = np.linalg.norm(np.diff(corners, axis=1), axis=2)
    aspect = sides.max(axis=1) / sides.min(axis=1)
    for values, quantiles in zip((layout.parcels.area, aspect), TABLE[style], strict=True):
        shares = (values[:, None] < np.array(quantiles)).mean(axis=0)
        assert np.abs(shares - (0.05, 0.5, 0.95)).max() < 0.15
    area = shapely.area(layout.blocks.outline)
    assert ((area >= 4_000) & (area <= 20_000)).mean() > 0.9


def test_a_place_is_open_where_streets_meet():
    layout = laid_out(LayoutRequest(outline=STAR, field=DirectionField("radial", centre=(400, 380))))
    assert shapely.distance(shapely.Point(400, 380), layout.blocks.outline).min() > 25


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"seed": -1}, "0 <= seed"),
        ({"widths": ()}, "1 to 16 widths"),
        ({"widths": (float("nan"),)}, "from 2 to 200"),
        ({"edge_width": 1e9}, "along the outline"),
        ({"block_area": (9_000.0, 4_000.0)}, "smaller area first"),
        ({"block_area": (0.0, 4_000.0)}, "from 200"),
        ({"park_share": 2.0}, "share of parks"),
        ({"variation": "much"}, "variation"),
        ({"outline": shapely.box(0, 0, 1e5, 1e5)}, "room for more than 50,000 blocks"),
        ({"outline": shapely.box(0, 0, 3e3, 3e3), "sizes": ParcelSizes(area=5.0)}, "more than 1,500,000 parcels"),
        ({"outline": shapely.box(0, 0, 1e9, 1)}, "coordinates in metres"),
        ({"outline": shapely.Polygon()}, "corners"),
        ({"outline": shapely.Polygon([(0, 0), (9, 9), (9, 0), (0, 9)])}, "Self-intersection"),
        ({"outline": shapely.LineString([(0, 0), (9, 9)])}, "expected a polygon"),
        ({"field": DirectionField("radial", centre=(float("inf"), 0.0))}, "centre"),
        ({"field": DirectionField(angle=float("nan"))}, "angle"),
    ],
)
def test_hostile_values_are_refused(settings: dict, message: str):
    with pytest.raises(UsageError, match=message):
        LayoutRequest(**{"outline": SQUARE, **settings})


@pytest.mark.parametrize("values", [{"area": 0.0}, {"spread": -1.0}, {"frontage": 0.0}, {"aspect": float("nan")}])
def test_hostile_sizes_are_refused(values: dict):
    with pytest.raises(UsageError, match="expected a number from"):
        ParcelSizes(**values)


def test_an_outline_without_room_is_refused():
    with pytest.raises(UsageError, match="no block fits"):
        laid_out(LayoutRequest(outline=shapely.box(0, 0, 12, 12)))


def test_edits_of_unknown_blocks_name_those_near():
    with pytest.raises(UsageError, match=r"unknown block 'b000z'.* near are b00"):
        laid_out(LayoutRequest(outline=SQUARE, edits={"b000z": BlockEdit(use="park")}))
