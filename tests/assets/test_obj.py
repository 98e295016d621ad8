"""Faces of OBJ files: the same surface for every reader."""

import io

import numpy as np
import pytest
import shapely
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.assets import obj
from grammarlab.assets.meshes import load_asset
from grammarlab.assets.obj import plain_faces
from grammarlab.errors import AssetError

NOTCHED = [(0, 0), (2, 0), (2, 2), (3, 2), (3, 0), (5, 0), (5, 3), (0, 3)]
"""A wall of 5 x 3 m around a door of 1 x 2 m."""


def obj_text(ring, corner="{0}", origin=(0.0, 0.0, 0.0)):
    points = "".join(f"v {x + origin[0]!r} {y + origin[1]!r} {origin[2]!r}\n" for x, y in ring)
    coordinates = "".join(f"vt {x} {y}\n" for x, y in ring)
    count = len(ring)
    face = "f " + " ".join(corner.format(k + 1, k - count) for k in range(count))
    return (points + coordinates + face + "\n").encode()


def mesh_of(content):
    return trimesh.load_mesh(io.BytesIO(content), file_type="obj", process=False)


def covered(mesh):
    """What triangles cover in the plane of x and y; they may not overlap."""
    triangles = [shapely.Polygon(corners[:, :2]) for corners in np.asarray(mesh.triangles)]
    union = shapely.union_all(triangles)
    assert union.area == pytest.approx(sum(each.area for each in triangles))
    return union


@pytest.mark.parametrize("corner", ["{0}", "{0}/{0}", "{1}", "{1}/{1}", "{0}//", "{0}/{1}"])
def test_a_wall_around_a_door_leaves_the_door_free(corner):
    found = covered(mesh_of(plain_faces(obj_text(NOTCHED, corner))))
    assert found.symmetric_difference(shapely.Polygon(NOTCHED)).area < 1e-9


@given(st.lists(st.floats(0.2, 1.0), min_size=4, max_size=14), st.booleans())
def test_any_star_is_covered_once_and_looks_to_the_same_side(radii, turned):
    angles = np.linspace(0.0, 2.0 * np.pi, len(radii), endpoint=False)
    ring = [(float(r * np.cos(a)), float(r * np.sin(a))) for r, a in zip(radii, angles, strict=True)]
    mesh = mesh_of(plain_faces(obj_text(ring[::-1] if turned else ring)))
    assert covered(mesh).symmetric_difference(shapely.Polygon(ring)).area < 1e-6
    assert (mesh.face_normals[mesh.area_faces > 1e-6][:, 2] * (-1.0 if turned else 1.0) > 0.99).all()


def test_a_wall_in_national_coordinates_leaves_the_door_free():
    mesh = mesh_of(plain_faces(obj_text(NOTCHED, origin=(4_400_000.0, 5_400_000.0, 300.0))))
    assert mesh.area == pytest.approx(13.0)


def test_negative_numbers_count_from_their_own_line():
    square = "v {0} 0 0\nv {1} 0 0\nv {1} 1 0\nv {0} 1 0\nf -4 -3 -2 -1\n"
    mesh = mesh_of(plain_faces((square.format(0, 1) + square.format(5, 7)).encode()))
    assert mesh.area == pytest.approx(3.0)
    assert mesh.bounds[:, 0].tolist() == [0.0, 7.0]


def test_texture_coordinates_stay_with_their_corners():
    mesh = mesh_of(plain_faces(obj_text(NOTCHED, "{0}/{0}")))
    assert getattr(mesh.visual, "uv", None) == pytest.approx(np.asarray(mesh.vertices)[:, :2])


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 # a triangle",
        b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4",
        b"v 0 0 0\nf 1 x 3 4 5",
        b"v 0 0 0\nf 1 2 3 4 9999999999999999999999",
        b"v 0 0 0\nf -5 -6 -7 -8",
        b"v a b c\nv 1 0 0\nf 1 2 1 2",
        b"f\nfoo 1 2 3 4 5\nv\n\xff\xfe f 1 2 3 4",
    ],
)
def test_other_content_stays(content):
    assert plain_faces(content) == content


@given(st.binary(max_size=200), st.lists(st.sampled_from([b"f 1 2 3 4", b"v 0 0 1", b"f -1 -2 -3 -1", b"v 1 2"])))
def test_any_content_ends_without_an_error(content, lines):
    assert isinstance(plain_faces(b"\n".join([*lines, content, *lines])), bytes)


def test_faces_of_too_many_corners_are_refused(monkeypatch):
    monkeypatch.setattr(obj, "MOST_WORK", 63)
    with pytest.raises(AssetError, match="up to 8 each"):
        plain_faces(obj_text(NOTCHED))


def test_an_asset_has_the_notches_of_its_faces(tmp_path):
    (tmp_path / "door.obj").write_bytes(obj_text(NOTCHED))
    meshes = load_asset("door.obj", tmp_path).meshes
    corners = meshes.points[meshes.corners.reshape(-1, 3)]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2.0
    assert areas.sum() == pytest.approx(13.0 / 15.0)
