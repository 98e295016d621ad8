"""One way to read meshes of all formats."""

from __future__ import annotations

import logging

import numpy as np
import pytest

from grammarlab.assets.mesh_files import PART_FORMATS, read_parts, without_neighbours
from grammarlab.errors import AssetError
from tests.assets.mutants import mutants, whole_files


@pytest.mark.parametrize(("suffix", "content"), list(whole_files()))
def test_every_format_has_finite_points_and_triangles_over_them(suffix, content):
    parts = read_parts(content, suffix, without_neighbours, 1_000)
    for part in parts:
        assert np.isfinite(part.points).all()
        assert np.unique(part.triangles).tolist() == list(range(len(part.points)))
    with pytest.raises(AssetError, match="at most"):
        read_parts(content, suffix, without_neighbours, 1)


def test_broken_files_of_every_format_end_in_parts_or_in_words():
    for suffix, content in mutants(PART_FORMATS, 40):
        try:
            parts = read_parts(content, suffix, without_neighbours, 100_000)
        except AssetError:
            continue
        assert all(np.isfinite(part.points).all() for part in parts)


def test_warnings_of_libraries_about_broken_files_stay_off_the_terminal(monkeypatch, capsys):
    monkeypatch.setattr(logging.root, "handlers", [])  # those of pytest
    corners = b"outer loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
    content = b"solid a\nfacet normal x y z\n" + corners + b"endfacet\nendsolid"
    (part,) = read_parts(content, ".stl", without_neighbours, 100)
    assert part.triangles.shape == (1, 3)
    assert capsys.readouterr() == ("", "")
