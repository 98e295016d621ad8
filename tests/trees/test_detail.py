"""Levels of detail of one tree, leaves, cards, and files of all of them."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
import trimesh

from grammarlab.errors import UsageError
from grammarlab.export.save import Reuse, SaveOptions, save
from grammarlab.randomness import root_keys
from grammarlab.scene import Scene, triangles
from grammarlab.trees.detail import DETAILS, SHARES
from grammarlab.trees.growth import grow
from grammarlab.trees.leaf_shapes import NUM_SHAPES, blossom_mesh, leaf_mesh, mesh_area, with_stalk
from grammarlab.trees.scene import realize_trees
from grammarlab.trees.skeleton import Skeleton
from grammarlab.trees.species import Look, drawn
from grammarlab.trees.species_file import parse
from grammarlab.trees.tree_materials import BLOSSOM, LEAF
from tests.cases import some
from tests.trees.meshes import areas, extent
from tests.trees.rows import ASPEN, random_row, row, tree_keys

FILES = sorted((Path(__file__).parents[2] / "grammars" / "species").glob("*.toml"))
BLOOMING = {**ASPEN, "scale": 6.0, "branches_1": 20.0, "branches_2": 8.0, "leaves": 6.0, "blossom_rate": 0.4}


def blooming(num: int = 1) -> Skeleton:
    return grow(np.tile(row(**BLOOMING), (num, 1)), tree_keys(num))


def detailed(skeleton: Skeleton, detail: str, look: Look | None = None) -> Scene:
    return realize_trees(skeleton, look or Look(), detail)  # ty: ignore[invalid-argument-type]  # pyright: ignore[reportArgumentType]


@cache
def cards() -> Scene:
    return detailed(blooming(), "cards")


def leaf_areas(scene: Scene) -> dict[int, float]:
    """Area of leaves and of blossoms of one tree."""
    batch = triangles(scene)
    material, area = batch.material_of_triangle(), areas(batch)
    return {kind: float(area[material == kind].sum()) for kind in (LEAF, BLOSSOM)}


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_coarser_species_have_the_same_box_and_their_share_of_triangles(path: Path):
    species = parse(path.read_text(encoding="utf-8"), path.stem)
    skeleton = grow(drawn(species, root_keys(5, np.arange(1)))[0], root_keys(5, np.arange(1)))
    batches = {detail: triangles(detailed(skeleton, detail, species.look)) for detail in SHARES}
    low, high = extent(batches["full"])
    size = (high - low).max()
    for detail, share in SHARES.items():
        batch = batches[detail]
        for end, expected in zip(extent(batch), (low, high), strict=True):
            np.testing.assert_allclose(end, expected, atol=0.02 * size)
        assert len(batch.triangles) == pytest.approx(share * len(batches["full"].triangles), rel=0.1)


@pytest.mark.parametrize("seed", some(range(30)))
def test_coarser_trees_keep_their_box_and_their_leaves_area(seed: int):
    skeleton = grow(random_row(seed)[None], tree_keys(1, seed))
    if len(skeleton.leaves) < 50:
        return
    batches = {detail: triangles(detailed(skeleton, detail)) for detail in SHARES}
    low, high = extent(batches["full"])
    assert len(batches["low"].triangles) < len(batches["medium"].triangles) < len(batches["full"].triangles)
    for batch in batches.values():
        for end, expected in zip(extent(batch), (low, high), strict=True):
            np.testing.assert_allclose(end, expected, atol=0.04 * (high - low).max())


def test_leaves_and_blossoms_keep_their_total_areas():
    skeleton = grow(row(**BLOOMING, leaf_stem_len=0.0)[None], tree_keys(1))
    full = leaf_areas(detailed(skeleton, "full"))
    assert full[LEAF] > 0.0
    assert full[BLOSSOM] > 0.0
    for detail in ("medium", "low"):
        assert leaf_areas(detailed(skeleton, detail)) == pytest.approx(full, rel=1e-5)


@pytest.mark.parametrize("shape", range(NUM_SHAPES))
def test_leaves_of_all_details_have_one_area_and_face_up(shape: int):
    meshes = [leaf_mesh(shape, detail) for detail in range(3)]
    np.testing.assert_allclose([mesh_area(mesh) for mesh in meshes], mesh_area(meshes[0]))
    assert [len(mesh.triangles) for mesh in meshes] == sorted((len(mesh.triangles) for mesh in meshes), reverse=True)
    share = len(meshes[1].triangles) / len(meshes[0].triangles), len(meshes[2].triangles) / len(meshes[0].triangles)
    assert share[0] >= 0.4
    assert share[1] >= 0.14
    for mesh in (*meshes, with_stalk(meshes[0], 0.5)):
        a, b, c = mesh.points[mesh.triangles].transpose(1, 0, 2)
        assert (np.cross(b - a, c - a)[:, 1] > 0.0).all()
        assert ((mesh.coordinates >= 0.0) & (mesh.coordinates <= 1.0)).all()
        np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0)


@pytest.mark.parametrize("shape", [1, 2, 3])
def test_blossoms_of_all_details_have_one_area_and_open_forward(shape: int):
    meshes = [blossom_mesh(shape, detail) for detail in range(3)]
    np.testing.assert_allclose([mesh_area(mesh) for mesh in meshes], mesh_area(meshes[0]))
    for mesh in meshes:
        a, b, c = mesh.points[mesh.triangles].transpose(1, 0, 2)
        assert (np.cross(b - a, c - a)[:, 2] > 0.0).all()


def test_a_tree_is_the_same_in_a_batch_at_any_detail():
    batch = blooming(3)
    for detail in SHARES:
        together = triangles(detailed(batch, detail))
        for index in range(3):
            alone = triangles(detailed(grow(row(**BLOOMING)[None], tree_keys(3)[index : index + 1]), detail))
            np.testing.assert_array_equal(together.model(index).vertices, alone.vertices)


def test_leaves_of_coarser_trees_are_leaves_of_finer_ones():
    """Tips stay where they are, and what low detail shows, medium detail shows too."""
    skeleton = blooming()
    tips = []
    for detail in SHARES:
        scene = detailed(skeleton, detail)
        rows = np.flatnonzero(scene.material == LEAF)
        z = scene.frames[scene.frame[rows]][:, :, 2]
        stalk = 0.5 if detail == "full" else 0.0
        tips.append(scene.position[rows] + ((1.0 + stalk) * scene.size[rows, 2:]) * z)
    for finer, coarser in pairwise(tips):
        distance = np.abs(coarser[:, None] - finer[None]).max(axis=2).min(axis=1)
        # Stems with fewer cross-sections bend a little less.
        assert np.quantile(distance, 0.9) < 0.05


def test_cards_are_eight_triangles_in_the_box_of_the_tree_with_holes():
    scene = cards()
    batch = triangles(scene)
    assert len(batch.triangles) == 8
    for end, expected in zip(extent(batch), extent(triangles(detailed(blooming(), "full"))), strict=True):
        np.testing.assert_allclose(end, expected, atol=0.02 * 6.0)
    assert scene.materials.cut_out == scene.materials.pictures.keys() == set(scene.materials.textures)
    assert batch.coordinates is not None
    assert ((batch.coordinates >= 0.0) & (batch.coordinates <= 1.0)).all()


@pytest.mark.parametrize("suffix", ["glb", "obj", "ply"])
@pytest.mark.parametrize("detail", ["full", "low", "cards"])
def test_files_have_the_same_triangles(suffix: str, detail: str, tmp_path: Path):
    scene = cards() if detail == "cards" else detailed(blooming(), detail)
    path = save(scene, tmp_path / f"tree.{suffix}")
    mesh: Any = trimesh.load(path, force="mesh", process=False)
    batch = triangles(scene)
    assert len(mesh.faces) == len(batch.triangles)
    corners = np.sort(batch.vertices[batch.triangles].reshape(-1, 9), axis=0)
    np.testing.assert_allclose(np.sort(mesh.vertices[mesh.faces].reshape(-1, 9), axis=0), corners, atol=1e-5)


@pytest.mark.parametrize("reuse", get_args(Reuse))
def test_files_with_instances_have_the_same_surface_and_pictures(reuse: str, tmp_path: Path):
    assets = FILES[0].parent / "assets"
    look = Look(bark="bark_smooth.jpg", leaf="leaf.jpg", blossom="blossom.jpg")
    scene = detailed(blooming(), "low", look)
    options = SaveOptions(reuse=reuse, assets=assets)  # ty: ignore[invalid-argument-type]  # pyright: ignore[reportArgumentType]
    path = save(scene, tmp_path / "tree.glb", options=options)
    content = path.read_bytes()
    for name in ("bark_smooth.jpg", "leaf.jpg", "blossom.jpg"):
        assert (assets / name).read_bytes() in content
    if reuse == "instancing":
        assert (
            path.stat().st_size
            < 0.7 * save(scene, tmp_path / "m.glb", options=SaveOptions(assets=assets)).stat().st_size
        )
        return
    file: Any = trimesh.load(path, force="scene", process=False)
    loaded = file.to_mesh()
    batch = triangles(scene)
    assert len(loaded.faces) == len(batch.triangles)
    corners = [
        np.sort(points.reshape(-1, 9), axis=0)
        for points in (loaded.vertices[loaded.faces], batch.vertices[batch.triangles])
    ]
    np.testing.assert_allclose(corners[0], corners[1], atol=1e-4)


def test_cut_out_pictures_are_marked_in_files(tmp_path: Path):
    scene = cards()
    glb = save(scene, tmp_path / "card.glb").read_bytes()
    assert b'"alphaMode":"MASK"' in glb
    (picture,) = scene.materials.pictures.values()
    assert picture in glb
    save(scene, tmp_path / "card.obj")
    assert "map_d card_texture_0.png" in (tmp_path / "card.mtl").read_text()
    assert (tmp_path / "card_texture_0.png").read_bytes() == picture


def test_texture_coordinates_are_in_files(tmp_path: Path):
    scene = cards()
    batch = triangles(scene)
    for suffix in ("glb", "obj"):
        mesh: Any = trimesh.load(save(scene, tmp_path / f"card.{suffix}"), force="mesh", process=False)
        used = mesh.visual.uv[mesh.faces]
        assert batch.coordinates is not None
        np.testing.assert_allclose(used, batch.coordinates[batch.triangles], atol=1e-6)


@pytest.mark.parametrize("detail", DETAILS)
def test_no_trees_are_an_empty_scene(detail: str):
    scene = detailed(grow(np.tile(row(), (0, 1)), tree_keys(0)), detail)
    assert (scene.num_models, len(scene)) == (0, 0)


def test_trees_have_their_own_looks_in_the_order_of_bark_leaf_and_blossom():
    red = Look(bark_color=(1.0, 0.0, 0.0))
    scene = realize_trees(blooming(3), [Look(), red, Look()])
    colors = [scene.materials.color[scene.material[scene.model == tree]] for tree in range(3)]
    assert [part[0].tolist() for part in colors] == [list(look.bark_color) for look in (Look(), red, Look())]
    for part in colors:
        assert part[1].tolist() == list(Look().leaf_color)
        assert part[-1].tolist() == list(Look().blossom_color)


def test_unknown_details_are_refused():
    with pytest.raises(UsageError, match="unknown detail 'fine'; choose one of full, medium, low, cards"):
        detailed(blooming(), "fine")


def test_looks_are_counted():
    with pytest.raises(UsageError, match="expected one look, or 2"):
        realize_trees(blooming(2), [Look()])
