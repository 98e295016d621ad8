"""``i``: how a mesh comes into the scope."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.derivation import derive, derive_chunks
from grammarlab.derivation.selection import join_forests
from grammarlab.geometry.meshes.measure import volumes
from grammarlab.language.grammar import Grammar
from tests.derivation.operations.leaves import world_meshes

WEDGE = "v 1 2 3\nv 5 2 3\nv 1 2 5\nv 1 10 3\nf 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n"
"""A tetrahedron from (1, 2, 3), 4 wide, 8 high and 2 deep."""


@pytest.fixture
def assets(tmp_path):
    (tmp_path / "wedge.obj").write_text(WEDGE)
    return tmp_path


@pytest.mark.parametrize(
    ("arguments", "low", "high"),
    [
        ("", (0, 0, 0), (10, 6, 4)),
        (", yUp, alignSizeAndPosition", (0, 0, 0), (10, 6, 4)),
        (", yUp, keepSizeAndPosition", (1, 2, 3), (5, 10, 5)),
        (", yUp, keepSizeAlignPosition, noCleanup", (3, 0, 1), (7, 8, 3)),
        (", zUp, keepSizeAndPosition", (1, 3, -10), (5, 5, -2)),
        (", zUp, keepSizeAlignPosition", (3, 0, -2), (7, 2, 6)),
        (", zUp", (0, 0, 0), (10, 6, 4)),
    ],
)
def test_a_mesh_stands_where_the_mode_says(assets, arguments, low, high):
    text = f'Lot --> s(10, 6, 4) i("wedge.obj"{arguments}) A'
    meshes = world_meshes(derive(Grammar.parse(text), 1, 1, assets=assets))
    assert np.allclose(meshes.bounds(), [[low], [high]])
    assert volumes(meshes)[0] == pytest.approx(np.prod(np.subtract(high, low)) / 6)


@pytest.mark.parametrize("arguments", ["", ", zUp", ", yUp, keepSizeAndPosition", ", yUp, keepSizeAlignPosition"])
@pytest.mark.parametrize("size", ["s(10, 6, 4)", "s(10, 0, 0)", "s(0, 0, 0)"])
def test_a_missing_mesh_is_a_built_in_box(tmp_path, size, arguments):
    missing, box = (
        derive(Grammar.parse(f'Lot --> {size} i("{name}"{arguments}) A'), 1, 1, assets=tmp_path)
        for name in ("house.obj", "builtin:cube")
    )
    for column in ("position", "size", "frame", "mesh"):
        assert np.array_equal(getattr(missing.leaves, column), getattr(box.leaves, column))
    assert [asset.path for asset in missing.missing_assets] == ["house.obj"]
    assert box.missing_assets == ()


def test_missing_meshes_are_named_once_at_their_first_place_in_any_batches(assets):
    rules = 'Lot --> 50%: A else: B\nA --> i("gone.obj") i("wedge.obj")\nB --> i("gone.obj") i("lost" + ".glb")'
    whole = derive(Grammar.parse(rules), 64, seed=3, assets=assets)
    named = [(asset.path, asset.location.line, asset.location.column) for asset in whole.missing_assets]
    assert named == [("gone.obj", 2, 7), ("lost.glb", 3, 21)]
    parts = list(derive_chunks(Grammar.parse(rules), 64, 3, nodes_per_chunk=1, assets=assets))
    assert join_forests(parts).missing_assets == whole.missing_assets


def test_a_file_that_another_file_refers_to_is_no_missing_mesh(assets):
    buffer = '{"uri": "gone.bin", "byteLength": 36}'
    accessor = (
        '{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]}'
    )
    (assets / "half.gltf").write_text(
        f'{{"asset": {{"version": "2.0"}}, "buffers": [{buffer}], "bufferViews": [{{"buffer": 0, "byteLength": 36}}], '
        f'"accessors": [{accessor}], "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}}}]}}], '
        '"nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "scene": 0}'
    )
    (half,) = derive(Grammar.parse('Lot --> i("half.gltf")'), 1, 1, assets=assets).missing_assets
    assert half.path == "half.gltf"
    assert half.reason.startswith('the asset "half.gltf" cannot be read: there is no asset "gone')
