"""Meshes from files, including invalid ones."""

from pathlib import Path

import pytest

from grammarlab.errors import FacadeError
from grammarlab.facade.examples.mesh.reading import read_mesh


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.stl", "solid", "expected a mesh as .obj"),
        ("a.obj", "", "holds no faces"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "cannot be read|do not exist|holds no faces"),
        ("a.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n", "line 2: expected finite numbers"),
        ("a.obj", "v 0 0 0\nv 90000 0 0\nv 0 1 0\nf 1 2 3\n", "--unit"),
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
