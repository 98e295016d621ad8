"""Parts of files say what they are, and models have their pivots where one asks for them."""

from __future__ import annotations

import json

import numpy as np
import pytest
import trimesh

from grammarlab.derivation.derive import derive
from grammarlab.export import SaveOptions, save
from grammarlab.language.grammar import Grammar
from grammarlab.scene import realize
from tests.export.gltf import read_glb, world

RULES = """
attr floors = 3
Lot --> extrude(3 * floors) report("volume", scope.sx) comp(f) { top : Roof | side : Facade }
Facade -->
    split(x) { ~1 : Wall | 1 : color("#a0c4d8") set(material.opacity, 0.5) Window | ~1 : color("#803020") Wall }
"""
FAR = np.array([[2683000.0, 0, -1247000], [2683012, 0, -1247000], [2683012, 0, -1247008], [2683000, 0, -1247008]])
NAMES = {"Roof", "Wall.color_803020", "Wall.color_ffffff", "Window"}


def scene(**options):
    return realize(derive(Grammar.parse(RULES), 2, 1, **options))


@pytest.mark.parametrize("reuse", ["merged", "nodes", "instancing"])
def test_nodes_are_called_by_symbol_and_material_below_their_model(tmp_path, reuse):
    document = read_glb(save(scene(), tmp_path / "a house.glb", options=SaveOptions(reuse=reuse))).document
    nodes, models = document["nodes"], [document["nodes"][root] for root in document["scenes"][0]["nodes"]]
    assert [model["name"] for model in models] == ["model_0", "model_1"]
    for model in models:
        children = [nodes[child] for child in model["children"]]
        assert {child["name"] for child in children} == NAMES
        assert all(document["meshes"][child["mesh"]]["name"] == child["name"] for child in children)
        extras = {child["name"].split(".")[0]: child["extras"] for child in children}
        assert extras["Window"] == {"symbol": "Window", "line": 5}
        assert extras["Roof"] == {"symbol": "Roof", "line": 3}
        assert model["extras"] == {"attributes": {"floors": 3.0}, "reports": {"volume": 20.0}}
    assert {material["name"] for material in document["materials"]} == {
        "color_803020",
        "color_ffffff",
        "glass_a0c4d8",
    }


def test_an_obj_has_the_groups_of_a_glb_and_no_blanks_in_names(tmp_path):
    path = save(scene(), tmp_path / "a house.obj")
    lines = path.read_text().splitlines()
    assert {line.split()[1] for line in lines if line.startswith("g ")} == NAMES
    assert "mtllib a_house.mtl" in lines
    assert len(trimesh.load_scene(path, group_material=True).geometry) == 3


@pytest.mark.parametrize("pivot", ["footprint", "centre"])
def test_a_pivot_moves_the_origin_of_a_model_and_nothing_in_the_world(tmp_path, pivot):
    far = scene(footprint=FAR)
    files = {
        name: read_glb(save(far, tmp_path / f"{name}.glb", options=SaveOptions(pivot=name, in_place=True)))
        for name in ("world", pivot)
    }
    places = [world(glb).corners for glb in files.values()]
    assert np.abs(places[0] - places[1]).max() < 1e-3
    assert np.allclose(places[1].reshape(-1, 3).min(axis=0), [2683000, 0, -1247008], atol=1e-3)
    roots = files[pivot].document
    (origin,) = (roots["nodes"][root] for root in roots["scenes"][0]["nodes"])
    for child in origin["children"]:
        node = roots["nodes"][child]
        middle = np.add(origin["translation"], node.get("translation", 0.0))
        assert middle.tolist() == [2683006, 0 if pivot == "footprint" else 4.5, -1247004]


@pytest.mark.parametrize(("pivot", "middle"), [("footprint", [0, 4.5, 0]), ("centre", [0, 0, 0])])
def test_a_model_without_a_place_stands_on_the_origin_in_every_format(tmp_path, pivot, middle):
    """Parts for a game engine: what is imported is at the pivot of what one places, and the file says where it was."""
    usd, geometry = pytest.importorskip("pxr.Usd"), pytest.importorskip("pxr.UsdGeom")
    one, options = realize(derive(Grammar.parse(RULES), 1, 1)), SaveOptions(pivot=pivot)
    for suffix in ("obj", "glb", "stl"):
        loaded = trimesh.load_scene(save(one, tmp_path / f"one.{suffix}", options=options))
        upright = loaded.bounds if suffix != "stl" else loaded.bounds[:, [0, 2, 1]]
        assert np.allclose(upright.mean(axis=0), middle, atol=1e-5), suffix
    document = read_glb(tmp_path / "one.glb").document
    (origin,) = (document["nodes"][root] for root in document["scenes"][0]["nodes"])
    assert origin["extras"] == {"origin": [10.0, 0.0 if pivot == "footprint" else 4.5, 10.0]}
    stage = usd.Stage.Open(str(save(one, tmp_path / "one.usd", options=options)))
    box = geometry.BBoxCache(usd.TimeCode.Default(), ["default"]).ComputeWorldBound(stage.GetPseudoRoot())
    assert np.allclose(box.ComputeAlignedRange().GetMidpoint(), middle, atol=1e-5)


def test_a_model_alone_counts_from_its_pivot_in_every_format(tmp_path):
    one = realize(derive(Grammar.parse(RULES), 1, 1))
    obj = trimesh.load_mesh(save(one, tmp_path / "one.obj", options=SaveOptions(pivot="footprint")), process=False)
    assert np.allclose(obj.bounds, [[-10, 0, -10], [10, 9, 10]])
    assert "# origin 10.0 0.0 10.0" in (tmp_path / "one.obj").read_text()
    ply = (tmp_path / "one.ply", save(one, tmp_path / "one.ply"))[1].read_bytes()
    assert b"comment grammarlab: metres, y up" in ply
    assert json.dumps(sorted(one.labels.attributes)) == '["floors"]'  # type: ignore[union-attr, ty:missing-union-attribute]
