import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.geometry.components import edges, faces, vertices
from grammarlab.geometry.meshes.measure import area_vectors
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.primitives import box, sphere
from grammarlab.geometry.selectors import ORIENTATIONS, SELECTORS, TIE, classify, select
from tests.geometry.bodies import prism, rotations, solids
from tests.geometry.polygons import LOT_L

QUICK = settings(max_examples=60, deadline=None)
directions = st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1)
QUADRANTS = ("front", "back", "left", "right", "top", "bottom")


def unit(vector):
    return np.array([vector]) / np.linalg.norm(vector)


@pytest.mark.parametrize(
    ("selector", "direction"),
    [
        ("front", (0, 0, 1)),
        ("back", (0, 0, -1)),
        ("right", (1, 0, 0)),
        ("left", (-1, 0, 0)),
        ("top", (0, 1, 0)),
        ("bottom", (0, -1, 0)),
        ("world.south", (0, 0, 1)),
        ("world.north", (0, 0, -1)),
        ("world.east", (1, 0, 0)),
        ("world.west", (-1, 0, 0)),
        ("world.up", (0, 1, 0)),
        ("world.down", (0, -1, 0)),
        ("street.front", (0, 0, 1)),
        ("object.left", (-1, 0, 0)),
    ],
)
def test_axes_have_the_names_that_cga_gives_them(selector, direction):
    axes = np.vstack((np.eye(3), -np.eye(3)))
    assert axes[classify(axes, selector)].tolist() == [list(direction)]


@QUICK
@given(directions)
def test_a_direction_lies_in_the_quadrants_of_its_nearest_axes(direction):
    lengths = np.sort(np.abs(unit(direction)[0]))
    nearest = np.count_nonzero(lengths >= lengths[-1] - TIE)
    assert sum(bool(classify(unit(direction), name)[0]) for name in QUADRANTS) == nearest


@QUICK
@given(directions)
def test_every_direction_has_one_slope(direction):
    kinds = [bool(classify(unit(direction), name)[0]) for name in ("vertical", "horizontal", "aslant", "nutant")]
    assert sum(kinds) == 1
    assert bool(classify(unit(direction), "side")[0]) != kinds[1]


@pytest.mark.parametrize(
    ("degrees", "kind"),
    [
        (90, "horizontal"),
        (79, "horizontal"),
        (78, "aslant"),
        (12, "aslant"),
        (11, "vertical"),
        (0, "vertical"),
        (-11, "vertical"),
        (-12, "nutant"),
        (-78, "nutant"),
        (-79, "horizontal"),
        (-90, "horizontal"),
    ],
)
def test_slopes_change_at_the_angles_of_the_reference(degrees, kind):
    direction = np.array([[np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0.0]])
    assert [name for name in ("vertical", "horizontal", "aslant", "nutant") if classify(direction, name)[0]] == [kind]


@QUICK
@given(directions)
def test_lateral_quadrants_are_the_side_of_a_prefix(direction):
    lateral = any(classify(unit(direction), f"world.{name}")[0] for name in ("south", "north", "east", "west"))
    assert bool(classify(unit(direction), "world.side")[0]) == lateral


def test_ties_belong_to_both_quadrants_whatever_the_rounding():
    for wobble in (-1e-12, 0.0, 1e-12):
        slope = np.array([[0.0, 1.0 + wobble, 1.0]]) / np.sqrt(2.0)
        corner = np.array([[1.0 + wobble, 0.0, 1.0]]) / np.sqrt(2.0)
        assert classify(slope, "top")[0]
        assert classify(slope, "front")[0]
        assert classify(corner, "front")[0]
        assert classify(corner, "right")[0]


@pytest.mark.parametrize("selector", ORIENTATIONS)
def test_faces_without_area_have_no_orientation(selector):
    assert not classify(np.zeros((1, 3)), selector)[0]


def test_selectors_pick_the_faces_of_a_box():
    parts = faces(box())
    picked = {name: np.flatnonzero(select(parts, name)).tolist() for name in SELECTORS}
    assert [picked[name] for name in ("front", "right", "back", "left", "top", "bottom")] == [
        [2],
        [3],
        [4],
        [5],
        [1],
        [0],
    ]
    assert picked["side"] == picked["vertical"] == picked["street.side"] == [2, 3, 4, 5]
    assert picked["horizontal"] == [0, 1]
    assert picked["all"] == picked["inside"] == [0, 1, 2, 3, 4, 5]
    assert picked["border"] == picked["aslant"] == picked["nutant"] == picked["eave"] == []


def test_vertical_edges_of_a_prism_are_its_upright_ones():
    parts = edges(prism(LOT_L, 3.0))
    upright = np.abs(parts.rotation[:, 1, 0]) == 1.0
    assert (select(parts, "vertical") == upright).all()
    assert np.count_nonzero(upright) == 6


def test_the_top_vertices_of_a_box_are_above_the_others():
    parts = vertices(box())
    assert select(parts, "all").all()
    assert (select(parts, "top") == (parts.pivot[:, 1] == 1.0)).all()


@QUICK
@given(st.lists(solids, min_size=1, max_size=3), rotations(), st.sampled_from(["object", "world"]))
def test_prefixes_look_at_the_turned_mesh(batch, rotation, prefix):
    meshes = Meshes.concatenate(batch)
    parts = faces(meshes)
    turned = area_vectors(meshes) @ rotation.T
    turned /= np.linalg.norm(turned, axis=1, keepdims=True)
    for name in [name for name in ORIENTATIONS if name.startswith(prefix)]:
        assert (classify(parts.direction @ rotation.T, name) == classify(turned, name)).mean() > 0.99


def test_the_quadrants_of_a_ball_have_equal_shares():
    parts = faces(sphere(36, 32))
    share = [select(parts, name) @ areas_of(parts) for name in QUADRANTS]
    assert sum(share) == pytest.approx(areas_of(parts).sum())
    assert share == pytest.approx([sum(share) / 6] * 6, rel=0.1)


def areas_of(parts):
    return np.linalg.norm(area_vectors(parts.shapes), axis=1)


def test_an_unknown_selector_is_refused():
    with pytest.raises(KeyError):
        select(faces(box()), "upside")
