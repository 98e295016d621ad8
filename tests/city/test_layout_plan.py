from pathlib import Path

import shapely

from grammarlab.city.layout_plan import LayoutPlan
from grammarlab.city.layout_request import STYLES
from grammarlab.city.plan import parse_plan

ZONES = '[[zones]]\nname = "all"\ngrammar = "building"\n'


def layout(table: str) -> LayoutPlan:
    layout = parse_plan(f"[layout]\n{table}\n{ZONES}", Path("plan.toml")).layout
    assert layout is not None
    return layout


def test_sizes_are_those_of_the_style_but_for_given_ones():
    read = layout('style = "suburb"\nvariation = 0.05\n[layout.parcels]\narea = 444\n[layout.blocks.b0001]\naspect = 3')
    suburb = STYLES["suburb"]
    assert (read.sizes.area, read.sizes.aspect, read.sizes.aspect_spread) == (444, suburb.aspect, suburb.aspect_spread)
    edited = read.edits["b0001"].sizes
    assert edited is not None
    assert (edited.area, edited.aspect, edited.spread) == (444, 3, suburb.spread)
    assert read.request().variation == 0.05


def test_the_centre_counts_from_the_south_west_corner_of_the_area():
    read = layout('field = "radial"\ncentre = [100, 40]')
    assert read.request().field.centre == (100, 40)
    assert read.request(shapely.box(2_000, -500, 3_000, 500)).field.centre == (2_100, -460)
