"""``setMaterial``, ``resetMaterial`` and ``getMaterial``: one operation is what single ones are, and undoes itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from grammarlab.assets import mtl_reader
from grammarlab.assets.mesh_parts import color_of
from grammarlab.derivation import Forest, derive
from grammarlab.errors import DerivationError
from grammarlab.language.grammar import Grammar
from tests.derivation.operations.leaves import sampled

ASSET = """mtllib plant.mtl
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0
usemtl red\nf 1 2 3 4\nusemtl blue\nf 2 5 6 3
"""


@pytest.fixture
def assets(tmp_path: Path) -> Path:
    (tmp_path / "plant.obj").write_text(ASSET)
    (tmp_path / "plant.mtl").write_text("newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\nd 0.5\n")
    return tmp_path


def looks(forest: Forest) -> list[list[object]]:
    """Channels and image of each leaf, and the values that rules printed."""
    materials, leaves = forest.materials, forest.leaves
    rows = [[*np.round(materials.channels[m], 9), materials.textures[m]] for m in leaves.material.tolist()]
    return [*rows, [*forest.prints]]


@pytest.mark.parametrize(
    ("array", "singles"),
    [
        ('["color.r", "0.5", "opacity", "0.25"]', "set(material.color.r, 0.5) set(material.opacity, 0.25)"),
        ('["color.rgb", "#336699"; "metallic", "2"]', 'set(material.color.rgb, "#336699") set(material.metallic, 2)'),
        ('["colormap", "a.png"]', 'texture("a.png")'),
        ('["color.a", "0.5", "nonsense", "7"]', "set(material.color.a, 0.5)"),
        ('["name", "brick", "shininess", "9", "doubleSided", "false"]',
         'set(material.name, "brick") set(material.shininess, 9) set(material.doubleSided, false)'),
        ("[]", ""),
    ],
)  # fmt: skip
def test_an_array_sets_what_single_operations_set(array, singles):
    ask = "print(material.name) print(material.shininess) print(material.doubleSided) A"
    text = f"Lot --> split(x) {{ 10 : Part | ~1 : color(1, 0, 0) Part }}\nPart --> {{}} {ask}"
    assert looks(sampled(text.replace("{}", f"setMaterial({array})"))) == looks(sampled(text.replace("{}", singles)))


def test_each_shape_has_the_material_of_its_own_array():
    text = """
    Lot --> split(x) { 2 : setMaterial(look) A }*
    look = case split.index % 2 == 0 : ["color.r", "0", "roughness", "0.1"] else : ["opacity", "0.3"]
    """
    forest = sampled(text)
    channels = forest.materials.channels[forest.leaves.material]
    assert channels[::2, [0, 3, 5]].tolist() == [[0.0, 1.0, 0.1]] * 8
    assert channels[1::2, [0, 3, 5]].tolist() == [[1.0, 0.3, 0.8]] * 7


@pytest.mark.parametrize("changes", ["", "color(0.5, 0.6, 0.7)", 'texture("a.png") set(material.opacity, 0.5)'])
@pytest.mark.parametrize("mode", ["changed", "all"])
def test_a_material_that_was_read_can_be_set_again(changes, mode):
    text = f"Lot --> {changes} Use(getMaterial(used, {mode}))\nUse(look) --> resetMaterial(all) setMaterial(look) A"
    assert looks(sampled(text)) == looks(sampled(f"Lot --> {changes} A"))


def test_what_was_changed_is_read_in_rows_of_names_and_values():
    forest = sampled(
        "Lot --> color(0.5, 0.25, 1) print(getMaterial(used, changed)) print(nRows(getMaterial(used, all)))A"
    )
    assert [line.split() for line in forest.prints[0].splitlines()] == [
        ["(3x2)"],
        ["color.r", "0.5"],
        ["color.g", "0.25"],
        ["color.b", "1"],
    ]
    assert forest.prints[1] == "10"


@pytest.mark.parametrize(
    ("operations", "colors"),
    [
        ('color("#00ff00") i("plant.obj")', [[1, 0, 0, 1], [0, 0, 1, 0.5]]),
        ('i("plant.obj") color("#00ff00") set(material.opacity, 0.75)', [[0, 1, 0, 0.75]] * 2),
        ('i("plant.obj") color("#00ff00") resetMaterial()', [[1, 0, 0, 1], [0, 0, 1, 0.5]]),
        ('i("plant.obj") color("#00ff00") resetMaterial(geometry)', [[0, 1, 0, 1]] * 2),
        ('i("plant.obj") set(material.opacity, 0.25) resetMaterial(geometry)', [[1, 1, 1, 0.25]] * 2),
        ('i("plant.obj") color("#00ff00") resetMaterial(all)', [[1, 1, 1, 1]] * 2),
        ('i("plant.obj") resetMaterial(all) color("#00ff00") resetMaterial()', [[1, 1, 1, 1]] * 2),
        ('i("plant.obj") i("builtin:cube") color("#00ff00") resetMaterial()', [[1, 1, 1, 1]]),
        ('i("plant.obj") Use(getMaterial(geometry, changed))', [[1, 0, 0, 1]]),
        ('i("plant.obj") color("#00ff00") Use(getMaterial(shape, changed))', [[0, 1, 0, 1]]),
    ],
)  # fmt: skip
def test_materials_of_assets_and_changes_of_rules_are_reset_apart(assets, operations, colors):
    grammar = Grammar.parse(f"Lot --> {operations}\nUse(look) --> primitiveQuad() setMaterial(look) A")
    forest = derive(grammar, 1, 1, assets=assets)
    found = forest.materials.channels[forest.leaves.material][:, :4]
    assert np.unique(found, axis=0) == pytest.approx(np.unique(np.array(colors, float), axis=0), abs=0.005)


@pytest.mark.parametrize("array", ['["color.r"]', '["color.r", "red"]', '["color.rgb", "reddish"]'])
def test_what_an_array_says_wrongly_is_left_out_with_a_warning(array):
    forest = sampled(f"Lot --> setMaterial({array}) A")
    assert len(forest.warnings) == 1
    assert forest.materials.channels[forest.leaves.material[0], :3].tolist() == [1.0, 1.0, 1.0]


@pytest.mark.parametrize("before", ["", 'color(1, 0, 1) texture("old.png") set(material.metallic, 1)'])
def test_a_material_from_a_file_is_that_of_a_mesh_with_the_file(tmp_path, before):
    (tmp_path / "looks").mkdir()
    (tmp_path / "looks" / "brick.jpg").write_bytes(b"")
    (tmp_path / "looks" / "brick.mtl").write_text(
        "newmtl none\nnewmtl red\nKd 1 .5 0\nPm .7\nd .5\nmap_Kd brick.jpg\nmap_d hole.png"
    )
    mesh = "mtllib brick.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl red\nf 1 2 3"
    (tmp_path / "looks" / "tile.obj").write_text(mesh)

    def look(operations):
        forest = derive(Grammar.parse(f"Lot --> {operations} A"), 1, 1, assets=tmp_path)
        assert forest.materials.cut_out == {"looks/brick.jpg"}
        return looks(forest)

    set_from_file = look(f'primitiveQuad() {before} setMaterial(readMaterial("looks/brick.mtl"))')
    assert set_from_file == look(f'{before} i("looks/tile.obj")')
    assert set_from_file[0][-1] == "looks/brick.jpg"


@pytest.mark.parametrize("path", ["none.mtl", "plant.obj", "plant.cgamat"])
def test_a_file_without_a_material_changes_nothing_and_is_told(assets, path):
    forest = derive(Grammar.parse(f'Lot --> color(1, 0, 0) setMaterial(readMaterial("{path}")) A'), 1, 1, assets=assets)
    assert looks(forest) == looks(sampled("Lot --> color(1, 0, 0) A"))
    assert [missing.path for missing in forest.missing_assets] == [path]


def test_a_file_whose_materials_have_no_colour_changes_nothing_with_a_warning(assets):
    (assets / "bare.mtl").write_text("newmtl a\nNs 10\nnewmtl b\n")
    rule = 'Lot --> color(1, 0, 0) setMaterial(readMaterial("bare.mtl")) A'
    forest = derive(Grammar.parse(rule), 1, 1, assets=assets)
    assert looks(forest) == looks(sampled("Lot --> color(1, 0, 0) A"))
    assert [warning.message for warning in forest.warnings] == [
        'the file "bare.mtl" has no material with a colour or an image'
    ]


def test_a_file_of_materials_is_read_once_up_to_its_first_one_and_a_large_one_is_told(assets, monkeypatch):
    made = []
    monkeypatch.setattr(mtl_reader, "color_of", lambda words: made.append(words) or color_of(words))
    (assets / "many.mtl").write_text("".join(f"newmtl m{i}\nKd {i} 1 0\n" for i in range(4)))
    (assets / "large.mtl").write_text("newmtl a\nKd 1 0 0\n" + " " * 2**20)
    rules = 'Lot --> setMaterial(readMaterial("many.mtl")) A setMaterial(readMaterial("{}.mtl")) B'
    derive(Grammar.parse(rules.format("many")), 2, 1, assets=assets)
    assert len(made) == 1
    (large,) = derive(Grammar.parse(rules.format("large")), 1, 1, assets=assets).missing_assets
    assert "more than the 1048576 that are read" in large.reason


def test_a_material_outside_of_the_asset_folder_is_refused(assets):
    grammar = Grammar.parse('Lot --> setMaterial(readMaterial("../plant.mtl")) A')
    with pytest.raises(DerivationError, match="outside"):
        derive(grammar, 1, 1, assets=assets)
