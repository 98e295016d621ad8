"""Paths from the top of a project or a workspace are found in one asset folder."""

import pytest

from grammarlab.assets.mesh_files import find_asset
from grammarlab.errors import AssetError


@pytest.mark.parametrize(
    ("path", "found"),
    [
        ("trees/oak.obj", "trees/oak.obj"),
        ("assets/trees/oak.obj", "trees/oak.obj"),
        ("/City/assets/trees/oak.obj", "trees/oak.obj"),
        ("/oak.obj", "oak.obj"),
        ("assets/pine.obj", "assets/pine.obj"),
        ("/City/models/oak.obj", "oak.obj"),
    ],
)
def test_folders_above_the_asset_folder_are_left_out(tmp_path, path, found):
    for name in ("trees/oak.obj", "oak.obj", "assets/pine.obj", "pine.obj"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("v 0 0 0")
    assert find_asset(path, tmp_path) == (tmp_path / found).resolve()


@pytest.mark.parametrize("path", ["other/oak.obj", "trees/trees/oak.obj", "/City/assets/elm.obj", "assets", "/", ""])
def test_other_folders_are_not_left_out(tmp_path, path):
    (tmp_path / "oak.obj").write_text("v 0 0 0")
    with pytest.raises(AssetError, match="there is no asset"):
        find_asset(path, tmp_path)


@pytest.mark.parametrize("path", ["/City/../../oak.obj", "assets/../../oak.obj", "../oak.obj"])
def test_a_way_out_of_the_folder_is_refused(tmp_path, path):
    (tmp_path / "assets").mkdir()
    (tmp_path / "oak.obj").write_text("v 0 0 0")
    with pytest.raises(AssetError, match="outside"):
        find_asset(path, tmp_path / "assets")
