from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from PIL import Image

from grammarlab.derivation import derive
from grammarlab.export.save import SaveOptions, save
from grammarlab.facade.grammar.exact_grammar import write_exact
from grammarlab.facade.looks import THICKNESS, look_of
from grammarlab.facade.scene import realize_facade
from grammarlab.facade.tree import Facade, Picture
from grammarlab.language.grammar import Grammar
from grammarlab.scene import realize, triangles
from tests.facade.grammar.houses import house
from tests.facade.strategies import trees


def volume_of(facade: Facade) -> float:
    batch = triangles(realize_facade(facade))
    return float(trimesh.Trimesh(batch.vertices, batch.triangles, process=False).volume)


def with_outline(facade: Facade, leaf: int, outline: np.ndarray) -> Facade:
    offsets = np.where(np.arange(len(facade) + 1) > leaf, len(outline), 0)
    return replace(facade, outline_offsets=offsets, outline_points=outline)


def expected_volume(facade: Facade) -> float:
    depth = [THICKNESS + look_of(facade.name_of(leaf)).front for leaf in facade.leaves]
    return float((facade.size[facade.leaves].prod(axis=1) * depth).sum())


@settings(max_examples=25)
@given(trees())
def test_the_boxes_have_the_volume_of_the_leaves(facade: Facade) -> None:
    assert np.isclose(volume_of(facade), expected_volume(facade), rtol=1e-4)


@settings(max_examples=10)
@given(trees())
def test_the_grammar_of_a_facade_derives_its_scene(facade: Facade) -> None:
    ours, derived = realize_facade(facade), realize(derive(Grammar.parse(write_exact(facade).text), 1, seed=0))

    def boxes(scene) -> np.ndarray:
        rows = np.concatenate([scene.position, scene.size, scene.materials.channels[scene.material]], axis=1)
        return rows[np.lexsort(rows.round(6).T)]

    assert np.allclose(boxes(ours), boxes(derived), atol=1e-9)


ARCH = np.array(
    [
        [0, 0],
        [1, 0],
        [1, 0.5],
        *[[0.5 + 0.5 * np.cos(a), 0.5 + 0.5 * np.sin(a)] for a in np.linspace(0.1, 3.0, 9)],
        [0, 0.5],
    ]
)
DIAMOND = np.array([[0.5, 0.1], [0.9, 0.5], [0.5, 0.9], [0.1, 0.5]])


@pytest.mark.parametrize("outline", [ARCH, DIAMOND, np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=float)])
def test_an_outline_leaves_the_rest_of_its_box_to_the_wall(outline: np.ndarray) -> None:
    facade = house(columns=1, rows=2)
    leaf = next(leaf for leaf in facade.leaves.tolist() if facade.name_of(leaf) == "window")
    x, y = outline.T
    share = 0.5 * float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
    wall = facade.size[leaf].prod() * (1.0 - share) * (look_of("").front - look_of("window").front)
    assert np.isclose(volume_of(with_outline(facade, leaf, outline)), expected_volume(facade) + wall, rtol=1e-4)


def png() -> bytes:
    content = BytesIO()
    Image.fromarray(np.arange(48, dtype=np.uint8).reshape(4, 4, 3)).save(content, "PNG")
    return content.getvalue()


def pictured(facade: Facade) -> Facade:
    low, high = facade.position / facade.size[0], (facade.position + facade.size) / facade.size[0]
    window = np.concatenate([low, high], axis=1)
    return replace(facade, pictures=(Picture("a.png", png()),), picture=np.zeros(len(facade), np.int64), window=window)


@pytest.mark.parametrize("ending", ["glb", "obj", "ply"])
def test_files_open_elsewhere(tmp_path: Path, ending: str) -> None:
    facade = pictured(house(columns=3, rows=2))
    (tmp_path / "a.png").write_bytes(png())
    path = save(realize_facade(facade), tmp_path / f"f.{ending}", options=SaveOptions(assets=tmp_path))
    found: Any = trimesh.load(path, force="mesh", process=False)
    assert np.allclose(found.extents[:2], facade.size[0], atol=1e-4)
    assert found.area > facade.width * facade.height


def test_pictures_lie_where_leaves_show_them(tmp_path: Path) -> None:
    facade = pictured(house(columns=3, rows=2))
    scene = realize_facade(facade)
    ends = np.concatenate([scene.position, np.ones((len(scene), 1))], axis=1)
    corner = np.einsum("nij,nj->ni", scene.texture_maps[scene.texture_map], ends)
    assert np.allclose(corner, scene.position[:, :2] / facade.size[0])
    assert scene.materials.textures == ("a.png",)
