"""Scans and meshes of facades: in any frame, their windows have the original sizes."""

import os

import laspy
import numpy as np
import pytest
import trimesh

from grammarlab.errors import FacadeError, GrammarlabError
from grammarlab.matching.scans import scan as scan_reading
from grammarlab.matching.scans.scan import MESHES, SCANS, read_surfaces
from grammarlab.matching.scans.scan_boxes import outlines, read_boxes
from grammarlab.matching.scans.scan_files import is_elements, load_elements
from grammarlab.matching.scans.wall_cells import cells_of, facades
from tests.assets.documents import BOX, BOX_TRIANGLES, Document
from tests.assets.mutants import mutants

WINDOWS = np.array([[1.0, 1.0, 2.0, 2.5], [3.6, 1.0, 4.6, 2.5], [6.2, 1.0, 7.5, 2.5], [1.0, 4.0, 2.0, 5.5]])
WIDTH, HEIGHT, TURN = 9.0, 7.0, 0.6


def wall(*, depth=0.15, noise=0.003, count=40_000, seed=1):
    """[P, 3] along, up and out of a wall with windows at given depths; a window of depth 0 has no points."""
    random = np.random.default_rng(seed)
    points = np.column_stack([random.uniform(0, [WIDTH, HEIGHT], (count, 2)), np.zeros(count)])
    inside = np.zeros(count, dtype=bool)
    for left, bottom, right, top in WINDOWS:
        inside |= ((points[:, :2] > [left, bottom]) & (points[:, :2] < [right, top])).all(axis=1)
    points[inside, 2] = -depth
    kept = points if depth else points[~inside]
    return kept + random.normal(0, noise, kept.shape)


def turned(points, shift=(0.0, 0.0, 0.0)):
    """A scan: z is up, and the wall is rotated."""
    along, out = np.array([np.cos(TURN), np.sin(TURN), 0]), np.array([np.sin(TURN), -np.cos(TURN), 0])
    return points[:, :1] * along + points[:, 1:2] * [0, 0, 1] + points[:, 2:] * out + np.array(shift)


def sides(elements):
    """[N, 4] medians of the outermost quarter of the points at each side."""
    found = []
    for element in range(len(elements)):
        points, middle = elements.points_of(element)[:, :2], (elements.low[element] + elements.high[element]) / 2
        reach = elements.high[element] - middle
        near = (points - middle) / reach
        inner = np.abs(near) < 0.5
        left, right = (points[inner[:, 1] & (sign * near[:, 0] > 0.5), 0] for sign in (-1, 1))
        bottom, top = (points[inner[:, 0] & (sign * near[:, 1] > 0.5), 1] for sign in (-1, 1))
        found.append([np.median(each) for each in (left, bottom, right, top)])
    return np.array(sorted(found, key=lambda each: (round(each[1]), each[0])))


@pytest.mark.parametrize("depth", [0.15, 0.0])
def test_outlines_of_a_scan_lie_where_the_wall_ends(tmp_path, depth):
    trimesh.PointCloud(turned(wall(depth=depth))).export(tmp_path / "wall.ply")
    elements = load_elements(tmp_path / "wall.ply")
    assert np.abs(sides(elements) - WINDOWS).max() < 0.02
    assert elements.row.max() == 1
    assert elements.column.max() == 2


def test_scans_in_national_coordinates_keep_their_millimetres(tmp_path):
    points = turned(wall(), (5e5, 5.4e6, 400.0))
    header = laspy.LasHeader(point_format=3, version="1.2")
    header.scales, header.offsets = np.full(3, 0.001), np.array([500_000, 5_400_000, 0])
    scan = laspy.LasData(header)
    scan.x, scan.y, scan.z = points.T
    scan.write(str(tmp_path / "wall.las"))
    assert np.abs(sides(load_elements(tmp_path / "wall.las")) - WINDOWS - [0, 400, 0, 400]).max() < 0.02
    trimesh.PointCloud(points).export(tmp_path / "wall.ply")
    with pytest.raises(FacadeError, match=r"wall\.ply: .* exact to 0\.5 m"):
        load_elements(tmp_path / "wall.ply")


FRAME: list[tuple[float, float, float, float]] = [
    (0, 9, 0, 1),
    (0, 9, 5.5, 7),
    (0, 9, 2.5, 4),
    (0, 1, 1, 2.5),
    (0, 1, 4, 5.5),
    (2, 9, 4, 5.5),
]
FRAME += [(2, 3.6, 1, 2.5), (4.6, 6.2, 1, 2.5), (7.5, 9, 1, 2.5)]
"""Left, right, bottom and top of the parts of a wall around its windows."""


def test_a_wall_of_instances_is_read_from_its_front(tmp_path):
    document = Document()
    parts = np.array([(*each, 0.4) for each in FRAME] + [(0, 9, 0, 7, 0.1)], np.float32)
    low = np.column_stack([parts[:, 0], parts[:, 2], np.zeros(len(parts), np.float32)])
    size = np.column_stack([parts[:, 1] - parts[:, 0], parts[:, 3] - parts[:, 2], parts[:, 4]])
    places = {"TRANSLATION": document.accessor(low), "SCALE": document.accessor(size)}
    instanced = {"EXT_mesh_gpu_instancing": {"attributes": places}}
    document.show(document.add("nodes", {"mesh": document.mesh(BOX, BOX_TRIANGLES), "extensions": instanced}))
    (tmp_path / "wall.glb").write_bytes(document.glb())
    assert np.abs(sides(load_elements(tmp_path / "wall.glb")) - WINDOWS).max() < 0.03


@pytest.mark.parametrize("ending", ["obj", "glb"])
def test_a_mesh_is_read_from_its_front_whichever_axis_goes_up(tmp_path, ending):
    parts = []
    for (left, right, bottom, top), thick in [(each, 0.4) for each in FRAME] + [((0, 9, 0, 7), 0.1)]:
        part = trimesh.creation.box((right - left, top - bottom, thick))
        part.apply_translation(((left + right) / 2, (bottom + top) / 2, thick / 2))
        parts.append(part)
    mesh = trimesh.util.concatenate(parts)
    if ending == "obj":
        mesh.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, (1, 0, 0)))
    mesh.export(tmp_path / f"wall.{ending}")
    elements = load_elements(tmp_path / f"wall.{ending}")
    assert np.abs(sides(elements) - WINDOWS).max() < 0.03


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.ones((1, 3)), "at least 3 points"),
        (np.ones((50, 3)), "No vertical plane"),
        (np.outer(np.arange(50.0), [1, 2, 3]), "No vertical plane"),
        (np.random.default_rng(0).uniform(0, 9, (500, 3)) * [1, 1, 0], "No element|No vertical plane"),
        (turned(wall(depth=0.01)), "No element was found"),
        (turned(wall()) * 1000, "millimetre"),
        (np.full((9, 3), np.nan), "finite"),
    ],
)
def test_scans_without_a_facade_are_refused_with_the_reason(tmp_path, points, message):
    trimesh.PointCloud(points).export(tmp_path / "scan.ply")
    with pytest.raises(FacadeError, match=message):
        load_elements(tmp_path / "scan.ply")


def test_boxes_are_metres_from_the_left_end_of_the_wall(tmp_path):
    trimesh.PointCloud(turned(wall(), (40, -20, 0))).export(tmp_path / "scan.ply")
    boxes = tmp_path / "boxes.csv"
    boxes.write_text("left,bottom,right,top\n0.8,0.8,2.2,2.7\n")
    assert np.abs(sides(load_elements(tmp_path / "scan.ply", boxes)) - WINDOWS[:1]).max() < 0.02
    boxes.write_text("100,100,102,103\n")
    with pytest.raises(FacadeError, match="in any of the boxes"):
        load_elements(tmp_path / "scan.ply", boxes)
    for text in (b"nan,0,1,1", b"1,0,1,1", b"0,1,1,0", b"", b"\xff"):
        with pytest.raises(FacadeError, match="Boxes"):
            read_boxes(text)


@pytest.mark.parametrize(
    "text", ["left;bottom;right;top\n0,8;0,8;2,2;2,7\n", "sep=;\n0.8;0.8;2.2;2.7\n;;;\n", "0.8\t0.8\t2.2\t2.7\n"]
)
def test_boxes_are_read_as_spreadsheets_write_them(text):
    for encoding in ("utf-8-sig", "utf-16"):
        assert read_boxes(text.encode(encoding)).tolist() == [[0.8, 0.8, 2.2, 2.7]]


def test_a_stray_point_far_away_makes_cells_coarser_and_not_more():
    points = np.vstack([wall(count=5_000), [[1e6, 2.0, 0.5]], [[3.0, -1e6, 0.5]]])
    cells = cells_of(points)
    assert cells.empty.size < 5_000_000
    assert cells_of(points[:-2]).side == pytest.approx(_cell_side(points[:-2]))


def _cell_side(points):
    """2.2 times the distance of points on the wall."""
    on_wall = points[np.abs(points[:, 2]) < 0.04]
    return 2.2 * np.sqrt(np.ptp(on_wall[:, :2], axis=0).prod() / len(on_wall))


def test_a_plane_is_found_to_the_millimetre_on_a_long_facade_with_rooms_behind():
    random = np.random.default_rng(3)
    plane = np.column_stack([random.uniform(0, [120, 9], (8000, 2)), random.normal(0, 0.004, 8000)])
    rooms = np.column_stack([random.uniform(0, [120, 9], (2000, 2)), random.uniform(-12, -1, 2000)])
    found = next(facades(turned(np.vstack([plane, rooms]), (900, -70, 3))))
    assert np.abs(found[:8000] - plane - [0, 3, 0])[:, 1:].max() < 0.025
    assert abs(found[:8000, 2].mean()) < 0.002
    assert found[8000:, 2].max() < -0.5


def test_outlines_of_a_line_or_of_nothing_are_none():
    line = np.column_stack([np.arange(9.0), np.zeros(9)])
    for wall_points in (line, line[:1], line[:0]):
        assert outlines(wall_points, line[:0], 2.0, lambda places: np.zeros(len(places), dtype=bool)).shape == (0, 2)


def test_a_mesh_opens_no_other_file(tmp_path, monkeypatch):
    opened, usual = [], open

    def recorded(file, *options, **more):
        opened.append(str(file))
        return usual(file, *options, **more)

    monkeypatch.setattr("builtins.open", recorded)
    (tmp_path / "wall.mtl").write_text("newmtl a\n")
    corners = "v 0 0 0\nv 9 0 0\nv 9 0 7\nv 0 0 7\n"
    (tmp_path / "wall.obj").write_text(f"mtllib wall.mtl\n{corners}usemtl a\nf 1 2 3\nf 1 3 4\n")
    with pytest.raises(FacadeError, match="No element was found"):
        load_elements(tmp_path / "wall.obj")
    assert not any("wall.mtl" in each for each in opened)


def test_mutants_of_meshes_end_in_facades_or_in_words(tmp_path, monkeypatch):
    monkeypatch.setattr(scan_reading, "_MAX_SAMPLES", 1_000)
    messages = []
    for suffix, content in mutants(MESHES, 2):
        path = tmp_path / f"wall{suffix}"
        path.write_bytes(content)
        try:
            _, surface = next(read_surfaces(path))
        except FacadeError as error:
            messages.append(str(error))
        else:
            assert np.isfinite(surface.points).all()
    assert len(messages) > 20
    assert all(message.startswith("wall.") for message in messages)


@pytest.mark.parametrize("ending", ["las", "laz"])
def test_mutants_of_scans_end_in_facades_or_in_words(tmp_path, ending):
    header = laspy.LasHeader(point_format=3, version="1.2")
    header.scales = np.full(3, 0.001)
    scan = laspy.LasData(header)
    scan.x, scan.y, scan.z = turned(wall(count=100)).T
    path = tmp_path / f"wall.{ending}"
    scan.write(str(path))
    content, random = path.read_bytes(), np.random.default_rng(5)
    path.write_bytes(content[:107] + (2**32 - 1).to_bytes(4, "little") + content[111:])  # its number of points
    with pytest.raises(FacadeError, match="announces 4,294,967,295 points"):
        load_elements(path)
    messages = []
    for _ in range(30):
        place, bit = int(random.integers(400 if random.random() < 0.7 else len(content))), int(random.integers(8))
        flipped = bytearray(content)
        flipped[place] ^= 1 << bit
        path.write_bytes(bytes(flipped) if bit else content[:place])
        try:
            _, surface = next(read_surfaces(path))
        except FacadeError as error:
            messages.append(str(error))
        else:
            assert np.isfinite(surface.points).all()
    assert len(messages) > 2
    assert all(message.startswith("wall.") for message in messages)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
@pytest.mark.parametrize("suffix", [*MESHES, *SCANS])
def test_pipes_and_large_files_are_refused_without_reading_them(tmp_path, suffix):
    large, pipe = tmp_path / f"large{suffix}", tmp_path / f"pipe{suffix}"
    with large.open("wb") as file:
        file.truncate(1 << 33)
    os.mkfifo(pipe)
    with pytest.raises(FacadeError, match=r"at most [0-9,]+ bytes"):
        load_elements(large)
    for read in (load_elements, is_elements) if suffix == ".ply" else (load_elements,):
        with pytest.raises(GrammarlabError, match="found a pipe or a device"):
            read(pipe)
