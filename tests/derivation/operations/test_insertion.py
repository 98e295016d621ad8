"""``i``: how a mesh comes into the scope."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.geometry.measure import volumes
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
