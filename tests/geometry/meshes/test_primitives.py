import numpy as np
import pytest

from grammarlab.geometry.components import faces
from grammarlab.geometry.meshes import primitives
from grammarlab.geometry.meshes.measure import areas, face_areas, face_normals, is_closed, volumes
from grammarlab.geometry.meshes.primitives import BUILTIN_ASSETS, builtin_asset

SOLIDS = [name for name in BUILTIN_ASSETS if name not in ("builtin:quad", "builtin:disk")]


@pytest.mark.parametrize("name", BUILTIN_ASSETS)
def test_primitives_fill_the_unit_cube(name):
    low, high = builtin_asset(name).bounds()
    flat = name not in SOLIDS
    assert low.tolist() == [[0, 0, 0]]
    assert high.tolist() == [[1, 0 if flat else 1, 1]]


@pytest.mark.parametrize("name", SOLIDS)
def test_solid_primitives_are_closed_and_look_outwards(name):
    solid = builtin_asset(name)
    assert is_closed(solid)[0]
    assert volumes(solid)[0] > 0.2


@pytest.mark.parametrize("name", [name for name in SOLIDS if name != "builtin:star"])
def test_every_face_of_a_convex_primitive_looks_away_from_the_middle(name):
    solid = builtin_asset(name)
    first = solid.points[solid.corner_points()[solid.face_offsets[:-1]]]
    middle = np.array([0.5, 0.4, 0.5])
    assert (np.einsum("fk,fk->f", first - middle, face_normals(solid)) > 0.0).all()


def test_flat_primitives_look_up():
    for shape in (primitives.quad(), primitives.disk(7)):
        assert face_normals(shape)[0].tolist() == [0, 1, 0]


def test_the_frames_of_box_faces_are_those_that_comp_finds():
    found = faces(primitives.box())
    assert found.rotation == pytest.approx(primitives.BOX_ROTATIONS)
    assert found.origin == pytest.approx(primitives.BOX_ORIGINS)
    outwards = found.rotation[:, :, 2]
    assert outwards[primitives.FRONT].tolist() == [0, 0, 1]
    assert outwards[primitives.RIGHT].tolist() == [1, 0, 0]
    assert outwards[primitives.BACK].tolist() == [0, 0, -1]
    assert outwards[primitives.LEFT].tolist() == [-1, 0, 0]
    assert outwards[primitives.TOP].tolist() == [0, 1, 0]
    assert outwards[primitives.BOTTOM].tolist() == [0, -1, 0]


@pytest.mark.parametrize("sides", [64, 128])
def test_round_primitives_approach_their_textbook_volumes(sides):
    third = np.pi / 12.0
    assert areas(primitives.disk(sides))[0] == pytest.approx(np.pi / 4, rel=20 / sides**2)
    assert volumes(primitives.cylinder(sides))[0] == pytest.approx(np.pi / 4, rel=20 / sides**2)
    assert volumes(primitives.cone(sides))[0] == pytest.approx(third, rel=20 / sides**2)
    assert volumes(primitives.sphere(sides, sides))[0] == pytest.approx(np.pi / 6, rel=20 / sides**2)


@pytest.mark.parametrize(("sides", "divisions"), [(3, 2), (4, 3), (16, 16)])
def test_spheres_have_as_many_faces_as_asked_for(sides, divisions):
    ball = primitives.sphere(sides, divisions)
    assert ball.num_faces == sides * divisions
    assert (face_areas(ball) > 0.0).all()
    assert is_closed(ball)[0]


@pytest.mark.parametrize("sides", [3, 5, 16])
def test_cones_and_cylinders_have_their_sides_last(sides):
    assert primitives.cone(sides).num_faces == sides + 1
    assert primitives.cylinder(sides).num_faces == sides + 2
    assert (face_normals(primitives.cylinder(sides))[2:, 1] == 0.0).all()
    assert face_normals(primitives.cylinder(sides))[:2, 1] == pytest.approx([1.0, -1.0])
    assert face_normals(primitives.cone(sides))[0, 1] == pytest.approx(-1.0)


def test_names_with_and_without_prefix_are_the_same_asset():
    assert np.array_equal(builtin_asset("cube").points, builtin_asset("builtin:cube").points)
    with pytest.raises(KeyError):
        builtin_asset("builtin:teapot")
