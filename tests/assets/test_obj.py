"""Faces of OBJ files: the same surface for every reader."""

import numpy as np
import pytest
import shapely
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.assets import mesh_parts
from grammarlab.assets.mesh_files import load_asset, without_neighbours
from grammarlab.assets.mtl_reader import read_mtl
from grammarlab.assets.obj_reader import read_obj
from grammarlab.errors import AssetError
from grammarlab.geometry.meshes.measure import face_areas

NOTCHED = [(0, 0), (2, 0), (2, 2), (3, 2), (3, 0), (5, 0), (5, 3), (0, 3)]
"""A wall of 5 x 3 m around a door of 1 x 2 m."""


def obj_text(ring, corner="{0}", origin=(0.0, 0.0, 0.0)):
    points = "".join(f"v {x + origin[0]!r} {y + origin[1]!r} {origin[2]!r}\n" for x, y in ring)
    coordinates = "".join(f"vt {x} {y}\n" for x, y in ring)
    count = len(ring)
    face = "f " + " ".join(corner.format(k + 1, k - count) for k in range(count))
    return (points + coordinates + face + "\n").encode()


def mesh_of(content):
    (part,) = read_obj(content, without_neighbours)
    return trimesh.Trimesh(part.points, part.triangles, process=False)


def covered(mesh):
    """What triangles cover in the plane of x and y; they may not overlap."""
    triangles = [shapely.Polygon(corners[:, :2]) for corners in np.asarray(mesh.triangles)]
    union = shapely.union_all(triangles)
    assert union.area == pytest.approx(sum(each.area for each in triangles))
    return union


@pytest.mark.parametrize("corner", ["{0}", "{0}/{0}", "{1}", "{1}/{1}", "{0}//", "{0}/{1}"])
def test_a_wall_around_a_door_leaves_the_door_free(corner):
    found = covered(mesh_of(obj_text(NOTCHED, corner)))
    assert found.symmetric_difference(shapely.Polygon(NOTCHED)).area < 1e-9


@given(st.lists(st.floats(0.2, 1.0), min_size=4, max_size=14), st.booleans())
def test_any_star_is_covered_once_and_looks_to_the_same_side(radii, turned):
    angles = np.linspace(0.0, 2.0 * np.pi, len(radii), endpoint=False)
    ring = [(float(r * np.cos(a)), float(r * np.sin(a))) for r, a in zip(radii, angles, strict=True)]
    mesh = mesh_of(obj_text(ring[::-1] if turned else ring))
    assert covered(mesh).symmetric_difference(shapely.Polygon(ring)).area < 1e-6
    assert (mesh.face_normals[mesh.area_faces > 1e-6][:, 2] * (-1.0 if turned else 1.0) > 0.99).all()


def test_a_wall_in_national_coordinates_leaves_the_door_free():
    mesh = mesh_of(obj_text(NOTCHED, origin=(4_400_000.0, 5_400_000.0, 300.0)))
    assert mesh.area == pytest.approx(13.0)


def test_negative_numbers_count_from_their_own_line():
    square = "v {0} 0 0\nv {1} 0 0\nv {1} 1 0\nv {0} 1 0\nf -4 -3 -2 -1\n"
    mesh = mesh_of((square.format(0, 1) + square.format(5, 7)).encode())
    assert mesh.area == pytest.approx(3.0)
    assert mesh.bounds[:, 0].tolist() == [0.0, 7.0]


SQUARE = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


@pytest.mark.parametrize(
    ("content", "area"),
    [
        (SQUARE + b"f 1 2 3 # half of it", 0.5),
        (SQUARE + b"f 1 2 3 4", 1.0),
        (SQUARE + b"f 1 2 3 \\\n4", 1.0),
        (SQUARE + b"f 1 2 \\\n3 \\\n4\\", 1.0),
        (SQUARE.replace(b"\n", b"\r\n") + b"f 1 2 \\\r\n3 4\r\n", 1.0),
        (SQUARE.replace(b"\n", b"\r") + b"f 1 2 3 4\r", 1.0),
        (SQUARE.replace(b" 0\n", b" 0 1.0\n") + b"f 1 2 3 4", 1.0),
        (SQUARE.replace(b" 0\n", b" 0 0.5 0.5 0.5\n") + b"f 1 2 3 4", 1.0),
        (b"v 9 9 9 1 0 0 1\n" + SQUARE + b"f 2 3 4 5", 1.0),
        (SQUARE + b"l 1 2\np 3\nf 1 2\nf 1\nf\nfoo 1 2 3 4 5\n\xff\xfe f 1 2 3 4\n\0\nf 1 2 3 4", 1.0),
        (b"  " + SQUARE + b"\tf\t1//  2// 3//\t4//", 1.0),
        (b"mtllib no.mtl\nusemtl a\n" + SQUARE + b"f 1 2 3\nusemtl b\nf 1 3 4", 1.0),
    ],
)
def test_every_form_of_points_and_faces_is_read(content, area):
    mesh = mesh_of(content)
    assert mesh.area == pytest.approx(area)
    assert np.ptp(mesh.vertices, axis=0).tolist() == [1.0, 1.0, 0.0]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"v 0 0\nv 1 0\nv 1 1\nf 1 2 3", "line 1: expected v x y z, found 'v 0 0'"),
        (b"v 0 0 0\nv 1 0 # 0\n", "line 2: expected v x y z"),
        (b"v 0 0 0\nv 1,5 0 0\n", "line 2: expected finite numbers .*1,5"),
        (b"v 0 0 0\nv 0 inf 0\n", "line 2: expected finite numbers"),
        (b"v 0 0 0\nv 0 1e300 0\n", "line 2: expected finite numbers"),
        (SQUARE + b"f 1 2 x 4 5", "line 5: expected numbers of points"),
        (SQUARE + b"f 1 2 3\nf 1 2 5", "line 6: a face has corners that do not exist; the file has 4 points"),
        (SQUARE + b"f 0 1 2", "line 5: a face has corners"),
        (SQUARE + b"f -5 -2 -1", "line 5: a face has corners"),
        (SQUARE + b"f 1 2 3 9999999999999999999999", "line 5: a face has corners"),
        (SQUARE + b"f 1 2 \\\n 3\nf 1 2 9", "line 7: a face has corners"),
        (b"v 0 0 0\ncstype bezier\nsurf 0 1 0 1 1\nend", "free-form geometry .surf.; export it as polygons"),
        (b"v 0 0 0\nv " + b"9" * 5000 + b" 0 0", "line 2"),
        (SQUARE + b"f 1 2 " + b"9" * 5000, "line 5"),
    ],
)
def test_lines_that_cannot_be_read_are_named(content, message):
    with pytest.raises(AssetError, match=message):
        read_obj(content, without_neighbours)


@given(
    st.binary(max_size=200), st.lists(st.sampled_from([b"f 1 2 3 4", b"v 0 0 1", b"f -1 -2 -3 -1", b"v 1 2", b"\\"]))
)
def test_any_content_ends_in_parts_or_in_words(content, lines):
    try:
        parts = read_obj(b"\n".join([*lines, content, *lines]), without_neighbours)
    except AssetError:
        return
    assert all(np.isfinite(part.points).all() for part in parts)


def test_points_without_faces_are_a_scan():
    (part,) = read_obj(SQUARE, without_neighbours)
    assert part.points.shape == (4, 3)
    assert part.triangles.shape == (0, 3)


def test_each_color_of_a_library_is_a_part():
    library = (
        b"newmtl wall paint\nKd 1 0.5 0\nnewmtl pane\r\nKd 0 0 1\r\nd 0.4\nnewmtl same\nKd 0 0 1\nd 0.4\nnewmtl none\n"
    )
    faces = b"usemtl wall paint\nf 1 2 3\nusemtl pane\nf 1 3 4\nusemtl same\nf 2 3 4\nusemtl none\nf 1 2 4\n"
    parts = read_obj(b"mtllib some colors.mtl\n" + SQUARE + faces, {"some colors.mtl": library}.__getitem__)
    assert [part.color for part in parts] == [(1.0, 0.502, 0.0, 1.0), (0.0, 0.0, 1.0, 0.4), None]
    assert [len(part.triangles) for part in parts] == [1, 2, 1]


@pytest.mark.parametrize(
    ("kd", "color"),
    [(b"0.00 0.00 0.00", (1.0, 1.0, 1.0)), (b"0.1 0 0", (0.1, 0.0, 0.0)), (b"0.5 0.25 0.25", (0.5, 0.25, 0.25))],
)
def test_a_black_color_beside_an_image_leaves_the_image_as_it_is(kd, color):
    """Measured with CityEngine's runtime; without an image black is black."""
    with_image = read_mtl(b"newmtl a\nKd " + kd + b"\nmap_Kd bricks.jpg")[b"a"]
    without = read_mtl(b"newmtl a\nKd 0 0 0")[b"a"]
    assert with_image is not None
    assert without is not None
    assert with_image.color[:3] == pytest.approx(color, abs=0.005)
    assert without.color[:3] == (0.0, 0.0, 0.0)


def test_faces_of_too_many_corners_are_refused(monkeypatch):
    monkeypatch.setattr(mesh_parts, "MOST_WORK", 63)
    with pytest.raises(AssetError, match="up to 8 each"):
        mesh_of(obj_text(NOTCHED))


def test_an_asset_keeps_its_polygons_as_they_are(tmp_path):
    door, square = obj_text(NOTCHED), b"v 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf -4 -3 -2 -1\nf -4 -3 -2\n"
    (tmp_path / "door.obj").write_bytes(door + square)
    asset = load_asset("door.obj", tmp_path)
    corners = asset.meshes.points[asset.meshes.corner_points()] * asset.size + asset.low
    faces = [face.tolist() for face in np.split(corners, asset.meshes.face_offsets[1:-1])]
    one = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0]]
    assert np.round(faces[0], 12).tolist() == [[x, y, 0.0] for x, y in NOTCHED]
    assert faces[1:] == [one, one[:3]]
    assert face_areas(asset.meshes.with_points(asset.meshes.points * asset.size)) == pytest.approx([13.0, 1.0, 0.5])


def test_an_asset_has_no_faces_whose_corners_lie_on_a_line(tmp_path):
    line = b"v 0 0 9\nv 0.3 0.1 9\nv 0.9 0.3 9\nv 0.6 0.2 9\nf -4 -3 -2 -1\nf -4 -3 -2\n"
    (tmp_path / "door.obj").write_bytes(line + obj_text(NOTCHED, "{1}") + line)
    (tmp_path / "line.obj").write_bytes(line)
    door, alone = (load_asset(name, tmp_path) for name in ("door.obj", "line.obj"))
    assert face_areas(door.meshes.with_points(door.meshes.points * door.size)) == pytest.approx([13.0])
    assert door.size.tolist() == [5.0, 3.0, 0.0]
    assert alone.meshes.num_faces == 2


@pytest.mark.parametrize("first", range(4))
def test_a_face_that_crosses_itself_is_no_line(tmp_path, first):
    """Its halves may have the same area, so that it has no normal."""
    corners = b"f " + b" ".join(b"%d" % (1 + (first + i) % 4) for i in range(4))
    bow_tie = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n" + corners
    (tmp_path / "tie.obj").write_bytes(bow_tie + b"\nv 0 0 9\nv 0 1 9\nv 0 0 5\nf 5 6 7\n")
    asset = load_asset("tie.obj", tmp_path)
    assert asset.meshes.num_faces == 2
    assert asset.size.tolist() == [1.0, 1.0, 9.0]


def test_the_second_half_of_a_quadrilateral_begins_with_its_third_corner():
    (part,) = read_obj(b"v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nv 1 2 0\nf 1 2 3 4\nf 4 3 5\n", lambda name: b"")
    assert part.triangles.tolist() == [[0, 1, 2], [2, 3, 0], [3, 2, 4]]


def test_a_file_of_very_many_materials_is_refused_at_once():
    names = [b"m%d" % number for number in range(20_000)]
    library = b"\n".join(b"newmtl %s\nmap_Kd %s.png" % (name, name) for name in names)
    faces = b"\n".join(b"usemtl %s\nf 1 2 3" % name for name in names)
    with pytest.raises(AssetError, match="20,000 different materials"):
        read_obj(b"mtllib a.mtl\n" + SQUARE + faces, {"a.mtl": library}.__getitem__)
