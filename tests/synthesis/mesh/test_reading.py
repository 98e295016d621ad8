"""Meshes from files, including invalid ones."""

import os
from pathlib import Path

import numpy as np
import pytest
import shapely

from grammarlab.errors import FacadeError
from grammarlab.synthesis.mesh.building_files import FORMATS, read_mesh, without_sheets
from tests.assets.documents import BOX, BOX_TRIANGLES, Document
from tests.assets.mutants import mutants
from tests.synthesis.houses import house
from tests.synthesis.rectangles import BOXES, WALL, empty_file, with_sheets


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.stl", "solid", "expected a mesh as .obj"),
        ("a.obj", "", "holds no faces"),
        ("a.obj", "v 0 0\nv 1 0\nv 1 1\nv 0 1\nf 1 2 3 4\n", "line 1: expected v x y z, found 'v 0 0'"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "cannot be read|do not exist|holds no faces"),
        ("a.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n", "line 2: expected finite numbers"),
        ("a.obj", "v 0 0 0\nv 90000 0 0\nv 0 1 0\nf 1 2 3\n", "`unit=`"),
        ("a.obj", "v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n", "m large"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "are empty"),
        ("a.glb", "glTF", "cannot be read"),
        ("a.ply", "ply\nformat ascii 1.0\nelement vertex 99999999999\n", "cannot be read"),
    ],
)
def test_broken_files_are_refused_in_words(name: str, content: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text(content)
    with pytest.raises(FacadeError, match=message):
        read_mesh(path)


def test_instances_and_quantised_points_are_read(tmp_path: Path) -> None:
    document = Document()
    places = np.array([[4 * x, 0, 4 * z] for x in range(3) for z in range(9)], np.float32)
    points = document.accessor((BOX * 255).astype(np.uint8), padding=1, normalized=True)
    indices = document.accessor(BOX_TRIANGLES.astype(np.uint8))
    mesh = document.add("meshes", {"primitives": [{"attributes": {"POSITION": points}, "indices": indices}]})
    instanced = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": document.accessor(places)}}}
    document.show(document.add("nodes", {"mesh": mesh, "extensions": instanced}))
    document.json["extensionsRequired"] = ["EXT_mesh_gpu_instancing", "KHR_mesh_quantization"]
    (tmp_path / "boxes.glb").write_bytes(document.glb())
    found = read_mesh(tmp_path / "boxes.glb")
    assert found.num_read == 12 * 27
    assert np.ptp(found.surface.points, axis=0) == pytest.approx([9.0, 1.0, 33.0])


def test_mutants_of_meshes_end_in_a_surface_or_in_words(tmp_path: Path) -> None:
    messages = []
    for suffix, content in mutants(FORMATS):
        path = tmp_path / f"a{suffix}"
        path.write_bytes(content)
        try:
            found = read_mesh(path)
        except FacadeError as error:
            messages.append(str(error))
        else:
            assert np.isfinite(found.surface.points).all()
    assert len(messages) > 20
    assert all(message.startswith("a.") for message in messages)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
@pytest.mark.parametrize("suffix", FORMATS)
def test_pipes_and_large_files_are_refused_without_reading_them(suffix: str, tmp_path: Path) -> None:
    large, pipe = tmp_path / f"large{suffix}", tmp_path / f"pipe{suffix}"
    with large.open("wb") as file:
        file.truncate(1 << 33)
    os.mkfifo(pipe)
    with pytest.raises(FacadeError, match="at most 268,435,456 bytes"):
        read_mesh(large)
    with pytest.raises(FacadeError, match="found a pipe or a device"):
        read_mesh(pipe)


Y_UP, Z_UP = np.eye(3)[1:]
GROUND = [[-30.0, 0.0, -40.0], [-30.0, 0.0, 40.0], [50.0, 0.0, 40.0], [50.0, 0.0, -40.0]]
BACKDROP = [[-30.0, -5.0, -40.0], [50.0, -5.0, -40.0], [50.0, 60.0, -40.0], [-30.0, 60.0, -40.0]]
ROOF = [[-0.6, 12.0, 0.6], [15.0, 12.0, 0.6], [15.0, 12.0, -9.0], [-0.6, 12.0, -9.0]]


def test_ground_planes_and_backdrops_are_left_out_and_roofs_are_not(tmp_path: Path) -> None:
    alone = read_mesh(house(4, 3, 2).write(tmp_path / "house.obj"))
    framed = read_mesh(with_sheets(house(4, 3, 2).write(tmp_path / "framed.obj"), GROUND, BACKDROP))
    building, notes = without_sheets(framed, Y_UP)
    assert sorted(note.split(",")[0] for note in notes) == ["a flat sheet of 80 x 65 m", "a flat sheet of 80 x 80 m"]
    assert np.ptp(building.surface.points, axis=0) == pytest.approx(np.ptp(alone.surface.points, axis=0))
    assert len(building.surface) == len(alone.surface) == building.patches.shape[1]
    for mesh in (alone, read_mesh(with_sheets(house(4, 3, 2).write(tmp_path / "roof.obj"), ROOF))):
        kept, notes = without_sheets(mesh, Y_UP)
        assert kept is mesh
        assert not notes


@pytest.mark.parametrize("gap", [0.0, 0.02])
def test_a_wall_with_boxes_on_it_is_not_a_sheet_unless_it_lies_below_them(gap: float, tmp_path: Path) -> None:
    boxes = (np.array(BOXES) + np.array([0.0, 0.0, gap])).tolist()
    mesh = read_mesh(with_sheets(empty_file(tmp_path / "wall.obj"), WALL, *boxes))
    assert without_sheets(mesh, Y_UP) == (mesh, ())
    assert without_sheets(mesh, -Z_UP) == (mesh, ())
    boxes_alone, notes = without_sheets(mesh, Z_UP)
    assert notes == ("a flat sheet of 20 x 14 m, such as a ground plane, is left out",)
    assert len(boxes_alone.surface) == len(mesh.surface) - 2


def test_a_blank_wall_behind_others_is_not_a_sheet(tmp_path: Path) -> None:
    blank = (np.array(WALL) - np.array([0.0, 0.0, 8.0])).tolist()
    mesh = read_mesh(with_sheets(empty_file(tmp_path / "walls.obj"), WALL, blank, *BOXES))
    assert without_sheets(mesh, Y_UP) == (mesh, ())


def test_no_hull_is_made_for_long_pieces_that_cannot_be_sheets(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    boards = [[[0.0, y, 1.0], [20.0, y, 1.0], [20.0, y + 0.5, 1.0], [0.0, y + 0.5, 1.0]] for y in range(14)]
    mesh = read_mesh(with_sheets(empty_file(tmp_path / "boards.obj"), WALL, *BOXES, *boards))
    monkeypatch.setattr(shapely, "convex_hull", lambda _: pytest.fail("a hull of many points takes long"))
    assert without_sheets(mesh, Y_UP) == (mesh, ())
