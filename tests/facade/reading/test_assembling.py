"""Labelled boxes become a facade in metres."""

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import FacadeError
from grammarlab.facade.reading.annotation import BoxAnnotation, Unit, annotate
from grammarlab.facade.reading.assembling import DEFAULT_WIDTH_M, OUTSIDE, assemble
from grammarlab.facade.tree import Facade, Picture
from tests.facade.drawings import drawing
from tests.facade.strategies import trees
from tests.facade.tilings import tiling

AREA = np.array([[0.0, 0.0], [400.0, 200.0]])


def annotation(*boxes: tuple[float, ...], names: str = "", unit: Unit = "metres", **more) -> BoxAnnotation:
    labels = names.split() or ["window"] * len(boxes)
    return annotate(np.array(boxes, dtype=np.float64).reshape(-1, 4), labels, unit, **more)


def leaves_of(facade: Facade, name: str) -> list[int]:
    return [node for node in facade.leaves.tolist() if facade.name_of(node) == name]


@given(trees())
def test_boxes_of_a_facade_give_back_the_facade(facade: Facade) -> None:
    boxes, names = tiling(facade)
    names = [name or "stone" for name in names]
    made = assemble(annotate(boxes, names, "metres"), tolerance=0.0)
    if "wall" not in names or len(set(names)) > 1:
        assert made.moved == 0.0
    area = sum(made.facade.size[leaves_of(made.facade, "window")].prod(axis=1), 0.0)
    assert np.isclose(area, facade.size[leaves_of(facade, "window")].prod(axis=1).sum())


@given(st.integers(0, 10**6))
def test_windows_that_are_drawn_by_hand_come_to_stand_in_rows_and_columns(seed):
    drawn = drawing(seed)
    made = assemble(annotate(drawn.boxes, drawn.names, "pixels"), width=drawn.size[0] / 100, tolerance=0.02)
    windows = leaves_of(made.facade, "window")
    assert len(windows) == drawn.names.count("window")
    assert len(leaves_of(made.facade, "door")) == 1
    assert len(np.unique(made.facade.position[windows, 0])) <= drawn.columns
    assert made.moved <= 0.02 * min(drawn.size) / 100 + 1e-9
    outside = [name for name in made.facade.labels if name not in ("wall", *drawn.names)]
    assert outside == []


def test_a_window_and_wall_around_it():
    made = assemble(annotation((0, 0, 9, 6), (2, 1, 4, 5), names="facade window"))
    facade = made.facade
    assert (facade.width, facade.height, made.moved, made.notes) == (9.0, 6.0, 0.0, ())
    assert [facade.name_of(node) for node in facade.leaves] == ["wall", "wall", "window", "wall", "wall"]
    assert facade.position[leaves_of(facade, "window")].tolist() == [[2, 1]]


@pytest.mark.parametrize(
    ("unit", "given_size", "pixels", "expected", "notes"),
    [
        ("metres", {}, None, (4, 2), 0),
        ("metres", {"width": 8}, None, (8, 4), 0),
        ("metres", {"height": 8}, None, (16, 8), 0),
        ("metres", {"width": 3, "height": 8}, None, (3, 8), 0),
        ("pixels", {}, None, (DEFAULT_WIDTH_M, DEFAULT_WIDTH_M / 2), 1),
        ("pixels", {"width": 8}, None, (8, 4), 0),
        ("parts", {"width": 8}, (100, 300), (8, 12), 0),
        ("parts", {"width": 8}, None, (8, 4), 1),
        ("parts", {"width": 8, "height": 5}, None, (8, 5), 0),
        ("parts", {}, (100, 100), (DEFAULT_WIDTH_M, DEFAULT_WIDTH_M / 2), 1),
    ],
)
def test_the_size_is_what_is_said_or_follows_from_the_picture(unit, given_size, pixels, expected, notes):
    made = assemble(annotation((0, 0, 4, 2), unit=unit), pixels=pixels, **given_size)
    assert np.allclose((made.facade.width, made.facade.height), expected)
    assert len(made.notes) == notes


@pytest.mark.parametrize("size", [{"width": 0.0}, {"width": -1.0}, {"height": 1e9}, {"width": float("nan")}])
def test_a_size_that_no_facade_has_is_refused(size):
    with pytest.raises(FacadeError, match="expected above 0 and at most 10,000 metres"):
        assemble(annotation((0, 0, 4, 2)), **size)
    with pytest.raises(FacadeError, match="metres large"):
        assemble(annotation((0, 0, 4e6, 2)))
    with pytest.raises(FacadeError, match="Tolerance: expected"):
        assemble(annotation((0, 0, 4, 2)), tolerance=float("nan"))


def test_leaves_show_their_parts_of_the_picture():
    boxes = [(40, 20, 360, 180), (100, 60, 200, 120)]
    source = annotation(*boxes, names="facade window", unit="pixels", bounds=AREA, picture="a.png")
    facade = assemble(source, width=16.0, picture=Picture("a.png", b"")).facade
    (window,) = leaves_of(facade, "window")
    assert np.allclose(facade.window[window], [0.25, 0.3, 0.5, 0.6])
    assert (facade.picture[facade.leaves] == 0).all()
    assert facade.picture[0] == -1
    covered = facade.window[facade.leaves]
    assert np.isclose(((covered[:, 2] - covered[:, 0]) * (covered[:, 3] - covered[:, 1])).sum(), 0.8 * 0.8)


def test_an_arch_keeps_its_outline_and_loses_what_a_balcony_hides():
    arch = np.array([[2, 1], [4, 1], [4, 4], [3, 5], [2, 4]], dtype=np.float64)
    boxes, nothing = [(0, 0, 9, 6), (2, 1, 4, 5), (1, 0.5, 5, 2)], np.zeros((0, 2))
    free = assemble(annotation(*boxes[:2], names="facade window", outlines=[nothing, arch])).facade
    (window,) = leaves_of(free, "window")
    parts = np.array([[0, 0], [1, 0], [1, 0.75], [0.5, 1], [0, 0.75]])
    assert shapely.Polygon(free.outline(window)).symmetric_difference(shapely.Polygon(parts)).area < 1e-12
    assert shapely.LinearRing(free.outline(window)).is_ccw
    half = assemble(annotation(*boxes, names="facade window balcony", outlines=[nothing, arch, nothing])).facade
    (window,) = leaves_of(half, "window")
    assert (half.position[window].tolist(), half.size[window].tolist()) == ([2, 2], [2, 3])
    assert np.isclose(shapely.Polygon(half.outline(window)).area, (2 * 2 + 1) / 6)


def test_a_gable_leaves_corners_outside():
    gable = np.array([[0, 0], [8, 0], [8, 4], [4, 8], [0, 4]], dtype=np.float64)
    bounds = np.array([[0.0, 0.0], [8.0, 8.0]])
    made = annotation((1, 1, 2, 7.5), (5, 6.8, 7.5, 7.9), names=f"window {OUTSIDE}", bounds=bounds, wall=gable)
    facade = assemble(made).facade
    assert len(leaves_of(facade, OUTSIDE)) > 1
    assert len(set(facade.labels)) == len(facade.labels)
    walls = [(n, facade.outline(n)) for n in leaves_of(facade, "wall")]
    area = sum(facade.size[n].prod() * (shapely.Polygon(c).area if len(c) else 1.0) for n, c in walls)
    windows = shapely.union(shapely.box(1, 1, 2, 7.5), shapely.box(5, 6.8, 7.5, 7.9))
    assert np.isclose(area, shapely.Polygon(gable).difference(windows).area)


def test_pinwheels_are_named_and_cut_when_asked():
    windmill = [(0, 0, 2, 1), (2, 0, 3, 2), (1, 2, 3, 3), (0, 1, 1, 3)]
    with pytest.raises(FacadeError, match=r"4 rectangles, which form a pinwheel: window 1 at \(0, 0\).*`split=True`"):
        assemble(annotation(*windmill))
    made = assemble(annotation(*windmill), split=True)
    assert len(leaves_of(made.facade, "window")) == 5
    assert "1 boxes of pinwheels are cut into parts: window" in made.notes[0]
    assert len(assemble(annotation(*windmill, names="window sill window pillar")).facade.leaves) == 6


def test_what_lies_behind_everything_is_told():
    made = assemble(annotation((0, 0, 4, 2), (1, 0, 2, 2), (1, 0, 2, 2), names="molding window window"))
    assert made.notes == ("1 boxes that are fully hidden by others are left out",)


@pytest.mark.parametrize(
    ("boxes", "says"),
    [
        ([(0, 0, np.nan, 1)], r"Box 1 \(window: .*not a finite number"),
        ([(0, 0, 1, 1), (0, 0, np.inf, 1)], "Box 2 .*not a finite number"),
        ([(0, 0, -1, 1)], "negative width"),
        ([(0, 0, 1e12, 1)], "beyond 1e"),
        ([(500, 0, 600, 1)], "is outside the picture or wall, from \\(0, 0\\) to \\(400, 200\\)"),
        ([(3, 3, 3, 5)], "no box with a width"),
        ([], "no box with a width"),
    ],
)
def test_boxes_that_mean_nothing_are_explained(boxes, says):
    with pytest.raises(FacadeError, match=says):
        annotation(*boxes, bounds=AREA)


def test_boxes_without_size_are_left_out_and_those_that_jut_out_are_cut_off():
    made = annotation((0, 0, 4, 2), (1, 1, 1, 2), (399, 0, 444, 100), bounds=AREA)
    assert len(made.low) == 2
    assert made.high.max() == 400.0
    assert "1 boxes extend beyond" in made.notes[0]
    assert "1 boxes without width or height are left out: Box 2 (window: from (1, 1) to (1, 2))" in made.notes[1]


def test_a_million_boxes_are_refused_at_once():
    with pytest.raises(FacadeError, match="There are 1,000,000 boxes; a facade has at most 100,000"):
        annotate(np.zeros((1_000_000, 4)), [], "metres")


@pytest.mark.parametrize("unit", ["metres", "pixels", "parts"])
@pytest.mark.parametrize("box", [(0, 0, 1e-320, 3), (0, 0, 3, 1e-320), (0, 0, 1e-300, 1e-300), (0, 0, 1e-7, 1e5)])
def test_boxes_without_extent_are_refused(unit, box):
    with pytest.raises(FacadeError, match=f"{unit}: that is no facade"):
        assemble(annotation(box, unit=unit), width=5.0)
