"""Images in files lie where the maps of shapes put them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from grammarlab.derivation import derive
from grammarlab.export import SaveOptions, save
from grammarlab.language.grammar import Grammar
from grammarlab.scene import Scene, realize, triangles
from grammarlab.scene.instances import scene_of_model
from grammarlab.scene.layout import grid, model_bounds
from tests.export.gltf import Surface, read_glb, world
from tests.export.test_formats import text_of
from tests.export.test_reuse import assert_same

REUSES = ("merged", "nodes", "instancing")

FACADE = """
attr width = rand(4, 9)
Lot --> s(width, '1, 5) extrude(3) comp(f) { front : Wall | top : Flat | right : Plain }
Wall --> texture("wall.png") setupProjection(0, scope.xy, 2, 1.5) projectUV(0) translateUV(0, 0.25, 0.5)
         split(x) { ~1 : Tile | ~2 : t(0, 0, 1) r(0, 20, 0) Tile }
Flat --> texture("wall.png") A
Plain --> color("#ff0000") projectUV(0) B
"""


@pytest.fixture
def assets(tmp_path) -> Path:
    folder = tmp_path / "assets"
    folder.mkdir()
    Image.new("RGB", (8, 8), (200, 100, 50)).save(folder / "wall.png")
    return folder


def facades(num_models: int) -> Scene:
    return realize(derive(Grammar.parse(FACADE), num_models, 3))


def surface_of(scene: Scene, path: Path, assets: Path, reuse: str = "merged") -> Surface:
    return world(read_glb(save(scene, path, options=SaveOptions(reuse=reuse, assets=assets))))  # type: ignore[arg-type, ty:invalid-argument-type]


@pytest.mark.parametrize("reuse", REUSES)
def test_walls_carry_their_projections_and_other_surfaces_metres(tmp_path, assets, reuse):
    scene = facades(1)
    has_image = np.array(scene.materials.textures) != ""
    width = scene.size[(scene.texture_map >= 0) & has_image[scene.material]][:, 0].sum()
    surface = surface_of(scene, tmp_path / "model.glb", assets, reuse)
    is_flat = np.abs(surface.normals[:, 0, 1]) > 0.9
    textured = np.isfinite(surface.coordinates[:, 0, 0])
    walls, flat = textured & ~is_flat, textured & is_flat
    assert (walls.sum(), flat.sum(), (~textured).sum()) == (4, 2, 2)
    corners = surface.coordinates[flat].reshape(-1, 2)
    assert corners[:, 0] == pytest.approx(surface.corners[flat].reshape(-1, 3)[:, 0], abs=1e-5)
    # u goes on from one tile to the next although the second was moved and turned; v points down in glTF.
    found = np.unique(surface.coordinates[walls].reshape(-1, 2).round(4), axis=0)
    u = 0.25 + np.array([0.0, width / 3, width]) / 2
    expected = [[value, -v] for value in u for v in (0.5, 2.5)]
    np.testing.assert_allclose(found, sorted(np.round(expected, 4).tolist()), atol=2e-4)


def test_every_corner_has_the_coordinates_of_its_map(tmp_path, assets):
    """Models on a grid, shape by shape: a shape's file alone holds its map applied to its corners."""
    scene = facades(4)
    batch = triangles(scene)
    shift = grid(*model_bounds(batch), batch.origins).offsets
    together = surface_of(scene, tmp_path / "all.glb", assets)
    known = {
        (*np.round(corner, 3), *np.round(normal, 3)): coordinates
        for row in range(len(together.corners))
        for corner, normal, coordinates in zip(
            together.corners[row], together.normals[row], together.coordinates[row], strict=True
        )
    }
    for model in range(4):
        alone = surface_of(scene_of_model(scene, model), tmp_path / "one.glb", assets)
        for row in range(len(alone.corners)):
            for corner, normal, coordinates in zip(
                alone.corners[row], alone.normals[row], alone.coordinates[row], strict=True
            ):
                moved = known[(*np.round(corner + shift[model], 3), *np.round(normal, 3))]
                np.testing.assert_allclose(moved, coordinates, atol=1e-3)


@pytest.mark.parametrize("reuse", REUSES[1:])
def test_shared_meshes_have_the_coordinates_of_merged_ones(tmp_path, assets, reuse):
    scene = facades(3)
    merged = surface_of(scene, tmp_path / "merged.glb", assets)
    assert_same(surface_of(scene, tmp_path / "shared.glb", assets, reuse), merged)


def test_an_obj_has_the_same_coordinates_with_v_upwards(tmp_path, assets):
    scene = facades(2)
    merged = surface_of(scene, tmp_path / "merged.glb", assets)
    textured = np.isfinite(merged.coordinates[:, 0, 0])
    coordinates = merged.coordinates[textured].reshape(-1, 2) * (1, -1)
    save(scene, tmp_path / "model.obj", options=SaveOptions(assets=assets))
    lines = [line.split() for line in (tmp_path / "model.obj").read_text().splitlines()]
    corners = [word.split("/") for line in lines if line[0] == "f" for word in line[1:]]
    used = np.array([corner[:2] for corner in corners if corner[1]], int) - 1
    pairs = np.hstack([text_of(tmp_path / "model.obj", name)[used[:, k]] for k, name in enumerate(("v", "vt"))])
    expected = np.hstack([merged.corners[textured].reshape(-1, 3), coordinates])
    np.testing.assert_allclose(
        np.unique(np.round(pairs, 4), axis=0), np.unique(np.round(expected, 4), axis=0), atol=2e-4
    )


def test_coordinates_too_large_for_a_file_are_cut_off(tmp_path, assets):
    scene = facades(1)
    huge = replace(scene, texture_maps=np.full_like(scene.texture_maps, 1e300))
    surface = surface_of(huge, tmp_path / "model.glb", assets)
    # Cut off, nothing varies any more; and whole repeats are left out.
    assert (surface.coordinates[:, :, 0] == 0.0).all(axis=1).sum() == 4


@pytest.mark.parametrize("shift", [0.0, 1e6 + 0.25, -3e7 + 0.25])
def test_images_far_from_their_beginning_lie_as_well_as_near_ones(tmp_path, assets, shift):
    """Only whole repeats are left out, one triangle like another: so much that steps of 32 bits cannot be seen."""
    scene = facades(1)
    maps = scene.texture_maps.copy()
    maps[:, :, 3] += shift
    near = surface_of(scene, tmp_path / "near.glb", assets)
    far = surface_of(replace(scene, texture_maps=maps), tmp_path / "far.glb", assets)
    walls = np.isfinite(near.coordinates).all(axis=(1, 2)) & (np.abs(near.normals[:, 0, 1]) < 0.9)
    assert walls.sum() == 4
    moved = (far.coordinates - near.coordinates)[walls] - shift % 1.0 * np.array([1.0, -1.0])
    assert np.abs(moved - np.rint(moved)).max() < 1e-4
    assert np.ptp(np.rint(moved), axis=1).max() == 0.0
