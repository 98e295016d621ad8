"""Assets of further projects in a library, found as their rules are."""

import json

import pytest
from PIL import Image

from grammarlab.asset_roots import ProjectAssets, places
from grammarlab.assets.mesh_files import find_asset, load_asset
from grammarlab.assets.texture_files import find_texture
from grammarlab.derivation.derive import derive
from grammarlab.derivation.functions.asset_functions import matching_files
from grammarlab.errors import AssetError, MissingAssetError
from grammarlab.language.grammar import Grammar
from grammarlab.language.presets import RuleChoices
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.rendering.choice import RendererChoice
from grammarlab.runs.learn.from_scenario import put_assets_beside
from grammarlab.runs.sample.checks import check_source, hash_assets
from grammarlab.runs.sample.manifest import read_manifest, write_manifest
from grammarlab.runs.sample.request import SampleRequest
from grammarlab.runs.sample.shipped import assets_folder, find_rules
from grammarlab.runs.sample.sources import load
from grammarlab.scene import realize
from grammarlab.scene.scene_pictures import with_pictures

PLANT = "/ESRI.lib/assets/Plants/x.obj"
RULES = f"""
Lot --> i("{PLANT}") Plant
"""
TRIANGLE = "mtllib x.mtl\nusemtl leaf\nv 0 0 0\nv 2 0 0\nv 0 3 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"


@pytest.fixture
def root(tmp_path):
    """A project without assets of its own, and a library with a plant and two pictures."""
    plants, facades = (tmp_path / "lib" / "ESRI.lib" / "assets" / name for name in ("Plants", "Facades"))
    project = tmp_path / "City"
    for folder in (plants, facades, project / "rules", project / "assets"):
        folder.mkdir(parents=True)
    (plants / "x.obj").write_text(TRIANGLE)
    (plants / "x.mtl").write_text("newmtl leaf\nmap_Kd leaf.png\n")
    Image.new("RGB", (2, 2), (0, 200, 0)).save(plants / "leaf.png")
    for name in ("a.jpg", "b.jpg"):
        Image.new("RGB", (4, 2)).save(facades / name)
    (project / "assets" / "own.txt").write_text("own")
    (project / "rules" / "lot.cga").write_text(RULES)
    return ProjectAssets(project / "assets", tmp_path / "lib")


def rules_of(root):
    return root.folder.parent / "rules" / "lot.cga"


def source_of(root):
    return find_rules(str(rules_of(root)), choices=RuleChoices(root.library))


def test_projects_are_searched_by_name_and_other_files_of_a_library_do_not_count(root):
    for number in range(500):
        (root.library / f"{number}.txt").touch()
    for name in ("B.lib", "A.lib"):
        (root.library / name / "assets").mkdir(parents=True)
        (root.library / name / "assets" / "only.txt").write_text(name)
    assert find_asset("Plants/x.obj", root).name == "x.obj"
    assert find_asset("only.txt", root).read_text() == "A.lib"


@pytest.mark.parametrize("name", [PLANT, PLANT[1:], "Plants/x.obj", "assets/Plants/x.obj"])
def test_a_file_of_a_library_is_found_by_its_project_or_in_the_assets_of_one(root, name):
    assert find_asset(name, root) == root.library / "ESRI.lib" / "assets" / "Plants" / "x.obj"
    with pytest.raises(MissingAssetError):
        find_asset(name, root.folder)


def test_the_projects_own_tree_comes_first_but_a_file_that_merely_has_the_name_does_not(root):
    (root.folder / "x.obj").write_text(TRIANGLE)
    assert find_asset(PLANT, root).is_relative_to(root.library)
    own = root.folder / PLANT[1:]
    own.parent.mkdir(parents=True)
    own.write_text(TRIANGLE)
    assert find_asset(PLANT, root) == own


def test_a_plant_of_a_library_is_inserted_and_its_picture_is_drawn(root):
    asset = load_asset(PLANT, root)
    assert asset.size.tolist() == [2, 3, 0]
    (material,) = asset.materials
    assert material is not None
    forest = derive(load(rules_of(root), RuleChoices(root.library)), 1, 0)
    assert not forest.missing_assets
    pictures = with_pictures(realize(forest), root).materials.pictures
    leaf = root.library / "ESRI.lib" / "assets" / "Plants" / "leaf.png"
    assert pictures == {material.texture: leaf.read_bytes()}


def test_patterns_list_the_files_of_a_project_under_names_that_find_them(root):
    names = matching_files(root, "/ESRI.lib/assets/Facades/*.jpg")
    assert names == ["/ESRI.lib/assets/Facades/a.jpg", "/ESRI.lib/assets/Facades/b.jpg"]
    assert matching_files(root, "Facades/?.jpg") == [name[1:] for name in names]
    for name in names:
        texture = find_texture(name, root)
        assert texture is not None
        assert texture.name == name


@pytest.mark.parametrize(
    "name", ["/ESRI.lib/../../secret.obj", "ESRI.lib/../../secret.obj", "/ESRI.lib/assets/link.obj", "/out/secret.obj"]
)
def test_nothing_outside_the_library_is_read(root, name):
    secret = root.library.parent / "secret.obj"
    secret.write_text(TRIANGLE)
    (root.library / "ESRI.lib" / "assets" / "link.obj").symlink_to(secret)
    (root.library / "out").symlink_to(root.library.parent)
    with pytest.raises(AssetError, match="outside"):
        find_asset(name, root)
    with pytest.raises(AssetError, match="outside"):
        find_texture(name, root)
    pattern = name.replace(".obj", ".*")
    assert matching_files(root, pattern) == []
    assert matching_files(root, f"/{name[:5]}\0/*.obj") == []


def test_a_project_that_is_a_link_out_of_the_library_is_not_searched(root):
    (root.library / "Away").symlink_to(root.folder.parent)
    assert [place.name for place in places("own.txt", ProjectAssets(root.library, root.library))] == [
        "own.txt",
        "ESRI.lib/assets/own.txt",
    ]


def test_check_names_a_missing_asset_of_the_library(root):
    assert not any(file.findings for file in check_source(source_of(root)))
    (root.library / PLANT[1:]).unlink()
    findings = [finding for file in check_source(source_of(root)) for finding in file.findings]
    assert [finding.code for finding in findings] == ["missing-asset"]
    assert PLANT in findings[0].message
    assert str(root.library) in findings[0].message
    assert "library=DIR" not in findings[0].hint
    findings = [finding for file in check_source(find_rules(str(rules_of(root)))) for finding in file.findings]
    assert "library=DIR" in findings[0].hint


def test_a_manifest_names_the_library_and_hashes_its_files(root, tmp_path):
    request = SampleRequest.of(rules_of(root), library=root.library, num_models=1)
    hashes = hash_assets(request)
    assert list(hashes) == [PLANT[1:]]
    run = tmp_path / "run"
    run.mkdir()
    path = write_manifest(run, request, RendererChoice("cast"), hashes)
    assert json.loads(path.read_text())["library"] == "../lib"
    assert read_manifest(path).request.assets.resolve() == root.resolve()


def test_assets_of_a_library_are_copied_beside_a_learned_file_with_their_folder_only(root, tmp_path):
    file = tmp_path / "learned" / "lot.cga"
    file.parent.mkdir()
    put_assets_beside(file, GrammarSpace(Grammar.parse(RULES)), root)
    copies = {path.relative_to(file.parent).as_posix() for path in file.parent.rglob("*") if path.is_file()}
    assert copies == {f"assets/ESRI.lib/assets/Plants/{name}" for name in ("x.obj", "x.mtl", "leaf.png")}
    assert load_asset(PLANT, assets_folder(file)).size.tolist() == [2, 3, 0]
