"""STL and 3MF files of watertight solids, and USD files with instances, read back by other libraries."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
import pytest
import trimesh
from PIL import Image

from grammarlab.derivation.derive import derive
from grammarlab.errors import UsageError
from grammarlab.export import SaveOptions, printable_solids, save, save_each, stl
from grammarlab.export.printable_solids import Solid, apart, solid_of
from grammarlab.language.grammar import Grammar
from grammarlab.scene import realize
from tests.export.gltf import read_glb, world

RULES = """
Lot --> extrude(6) comp(f) { top : Roof | bottom : Floor | side : Facade }
Facade --> split(x) { ~1 : Wall | 2 : color("#a0c4d8") extrude(0.3) Window | ~1 : color("#803020") Wall }
"""
FAR = np.array([[2683000.0, 0, -1247000], [2683012, 0, -1247000], [2683012, 0, -1247008], [2683000, 0, -1247008]])


def scene(rules: str = RULES, **options):
    return realize(derive(Grammar.parse(rules), 2, 1, **options))


def test_a_house_of_walls_without_thickness_is_one_filled_solid(tmp_path):
    solid = solid_of(realize(derive(Grammar.parse(RULES), 1, 1)))
    mesh = trimesh.Trimesh(solid.points, solid.triangles, process=False)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(20 * 20 * 6 + 4 * 2 * 6 * 0.3, rel=2e-4)
    read: Any = trimesh.load_mesh(save(scene(), tmp_path / "house.stl"))
    assert read.is_watertight
    assert read.volume == pytest.approx(2 * mesh.volume, rel=1e-4)
    assert np.allclose(read.bounds[:, 2], [0, 6], atol=1e-3)


def test_an_open_shell_has_walls_and_stays_hollow():
    solid = solid_of(realize(derive(Grammar.parse("Lot --> extrude(6) comp(f) { side : Wall | top : Roof }"), 1, 1)))
    mesh = trimesh.Trimesh(solid.points, solid.triangles, process=False)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(20 * 20 * 6 - 19.6 * 19.6 * 5.8, rel=5e-3)


@pytest.mark.parametrize("corner", [(9.0, 5.0), (0.0, 0.0)], ids=["one in 32 bits", "one for programs"])
def test_points_that_are_nearly_one_leave_no_holes_in_an_stl(tmp_path, monkeypatch, corner):
    """A tetrahedron with a point on an edge, a nanometre from its end; near 0 that is two numbers of 32 bits."""
    points = np.array([[0.0, 0, 0], [0, 1, 0], [1, 0, 0], [0, 0, 1], [0, 1e-9, 0]])
    points[:, :2] += corner
    triangles = np.array([[0, 4, 2], [4, 1, 2], [0, 3, 4], [4, 3, 1], [1, 3, 2], [3, 0, 2]])
    solid = Solid(points, triangles, np.zeros(6, np.int32))
    assert trimesh.Trimesh(points, triangles, process=False).is_watertight
    monkeypatch.setattr(stl, "solid_of", lambda _scene: solid)
    read: Any = trimesh.load_mesh(save(realize(derive(Grammar.parse(RULES), 1, 1)), tmp_path / "point.stl"))
    assert len(read.faces) == 4
    assert read.is_watertight


def test_programs_that_join_points_of_32_bits_find_a_solid_closed():
    """Windows in two walls that meet have edges of less than a micrometre where they touch."""
    rules = "Lot --> extrude(6) comp(f) { side : Side | all : R } Side --> split(x) { 3 : W | 1 : extrude(0.3) W }*"
    solid = solid_of(realize(derive(Grammar.parse(rules), 1, 1)))
    assert is_watertight(solid.points, solid.triangles)
    assert len(np.unique(solid.points.astype(np.float32), axis=0)) == len(solid.points)


def test_surfaces_that_touch_along_an_edge_draw_back_from_it():
    points = np.array([[0.0, 0, 0], [0, 0, 1], [1, 1, 0], [1, 0, 0], [0, 0, 0], [0, 0, 1], [-1, -1, 0], [-1, 0, 0]])
    one = np.array([[0, 1, 3], [0, 2, 1], [1, 2, 3], [0, 3, 2]])
    triangles = np.concatenate([one, one + 4])
    assert not is_watertight(points, triangles)
    moved = apart(points, triangles)
    assert is_watertight(moved, triangles)
    assert np.abs(moved - points).max() < 1e-4
    assert apart(moved, triangles) is moved


def test_a_folded_surface_without_a_back_is_thick_without_crossing_itself(tmp_path):
    """A panel with a deep frame of 30 mm around a pane, as windows of asset libraries have."""
    rings = [(0.0, 0.0), (0.0, 1.0), (0.03, 1.0), (0.03, 0.0)]
    corners = [(x, y, z) for inset, z in rings for x, y in _square(inset)]
    faces = [
        (4 * ring + i, 4 * ring + (i + 1) % 4, 4 * ring + 4 + (i + 1) % 4, 4 * ring + 4 + i)
        for ring in range(3)
        for i in range(4)
    ]
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [
        "f " + " ".join(str(corner + 1) for corner in face) for face in [*faces, (12, 13, 14, 15)]
    ]
    (tmp_path / "frame.obj").write_text("\n".join(lines))
    rules = Grammar.parse('Lot --> s(1, 2, 0.06) i("frame.obj") Frame')
    solid = solid_of(realize(derive(rules, 1, 1, assets=tmp_path)))
    assert is_watertight(solid.points, solid.triangles)
    # Nothing reaches further behind a face than the frame is deep.
    assert np.allclose(solid.points.min(axis=0), [-0.03, 0.0, -0.06], atol=1e-3)
    assert np.allclose(solid.points.max(axis=0), [1.03, 2.0, 0.06], atol=1e-3)


def test_an_open_surface_is_divided_at_sharp_folds_only_and_its_pieces_are_counted(tmp_path, monkeypatch):
    """Ten folded faces: folds of 0.1 m by 11 degrees, and of 3 m by 143 degrees."""
    monkeypatch.setattr(printable_solids, "_MOST_SHAPES", 4)
    lines = [f"v {x} {x % 2} {z}" for x in range(11) for z in (0, 10)]
    lines += [f"f {2 * x + 1} {2 * x + 2} {2 * x + 4} {2 * x + 3}" for x in range(10)]
    (tmp_path / "folds.obj").write_text("\n".join(lines))

    def folded(height: float):
        rules = Grammar.parse(f'Lot --> s(10, {height}, 10) i("folds.obj") Folds')
        return realize(derive(rules, 1, 1, assets=tmp_path))

    solid = solid_of(folded(0.1))
    assert is_watertight(solid.points, solid.triangles)
    volume = trimesh.Trimesh(solid.points, solid.triangles, process=False).volume
    assert volume == pytest.approx(10 * 10 * 0.2, rel=0.01)
    with pytest.raises(UsageError, match="10 pieces of meshes, between sharp folds, and at most 4 are united"):
        solid_of(folded(3.0))


def test_an_open_mesh_without_a_size_is_left_out(tmp_path):
    (tmp_path / "fold.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 1 0 1\nf 1 2 3\nf 1 4 2\n")
    rules = Grammar.parse('Lot --> [ i("fold.obj") s(0, 0, 0) Fold ] extrude(3) Box')
    solid = solid_of(realize(derive(rules, 1, 1, assets=tmp_path)))
    assert trimesh.Trimesh(solid.points, solid.triangles).volume == pytest.approx(20 * 20 * 3, rel=1e-3)


def _square(inset):
    return [(inset, inset), (1 - inset, inset), (1 - inset, 1 - inset), (inset, 1 - inset)]


def is_watertight(points, triangles):
    """Also for programs that join equal points."""
    mesh = trimesh.Trimesh(points.astype(np.float32), triangles, process=False)
    mesh.merge_vertices()
    return mesh.is_watertight


def test_a_3mf_is_valid_and_has_the_places_colours_and_names_of_its_models(tmp_path):
    lib3mf = pytest.importorskip("lib3mf")
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    path = save(scene(), tmp_path / "houses.3mf")
    reader.ReadFromFile(str(path))
    objects = model.GetMeshObjects()
    names = []
    while objects.MoveNext():
        shape = objects.GetCurrentMeshObject()
        names.append(shape.GetName())
        assert shape.IsManifoldAndOriented()
    assert names == ["model_0", "model_1"]
    groups = model.GetBaseMaterialGroups()
    groups.MoveNext()
    group = groups.GetCurrentBaseMaterialGroup()
    ids = group.GetAllPropertyIDs()
    assert {group.GetName(number) for number in ids} == {"color_803020", "color_a0c4d8", "color_ffffff"}
    assert (model.GetBuildItems().Count(), reader.GetWarningCount(), str(model.GetUnit())) == (2, 0, "5")
    assert path.read_bytes() == save(scene(), tmp_path / "again.3mf").read_bytes()


def test_solids_far_from_the_origin_say_where_they_are_to_a_millimetre(tmp_path):
    far, options = scene(footprint=FAR), SaveOptions(in_place=True)
    expected = np.array([[2682999.7, 1246999.7, 0], [2683012.3, 1247008.3, 6]])
    path = save(far, tmp_path / "far.stl", options=options)
    mesh: Any = trimesh.load_mesh(path)
    assert np.abs(mesh.bounds + numbers("origin (.*)", path.read_bytes()[:80].decode()) - expected).max() < 1e-3
    with ZipFile(save(far, tmp_path / "far.3mf", options=options)) as package:
        text = package.read("3D/3dmodel.model").decode()
    points = np.array(re.findall('<vertex x="(.*?)" y="(.*?)" z="(.*?)"', text), dtype=float)
    place = numbers('transform="1 0 0 0 1 0 0 0 1 (.*?)"', text) + numbers("origin (.*?) metres", text)
    assert np.abs(points.min(axis=0) + place - expected[0]).max() < 1e-3


def properties(prim: Any) -> dict[str, Any]:
    """Properties as programs for people show them."""
    names = [name for name in prim.GetPropertyNames() if name.startswith("userProperties:")]
    return {name.removeprefix("userProperties:"): prim.GetAttribute(name).Get() for name in names}


def test_local_files_name_their_place_and_keep_32_bit_programs_to_a_millimetre(tmp_path):
    """Programs such as Blender place each shape with 32 bits, which have steps of 0.25 m at 2,683,000 m."""
    usd, geometry = pytest.importorskip("pxr.Usd"), pytest.importorskip("pxr.UsdGeom")
    options = SaveOptions(origin=(2683000.0, 0.0, -1247000.0), pivot="local", reuse="nodes")
    far = scene(footprint=FAR)
    glb, path = (save_each(far, tmp_path, kind, options)[0] for kind in ("glb", "usd"))
    read: Any = trimesh.load(glb)
    placed: Any = trimesh.load(save_each(far, tmp_path / "placed")[0])
    assert np.abs(read.bounds + options.origin - placed.bounds).max() < 1e-3
    assert np.abs(read.bounds).max() < 20
    origin = next(node for node in read_glb(glb).document["nodes"] if node.get("name") == "origin")
    assert (origin["extras"], "translation" in origin) == ({"origin": list(options.origin or ())}, False)
    stage = usd.Stage.Open(str(path))
    box = geometry.BBoxCache(usd.TimeCode.Default(), ["default"]).ComputeWorldBound(stage.GetDefaultPrim())
    reach = box.ComputeAlignedRange()
    assert np.abs([reach.GetMin(), reach.GetMax()] - read.bounds).max() < 1e-3
    assert list(properties(stage.GetDefaultPrim())["origin"]) == list(options.origin or ())


def numbers(pattern: str, text: str) -> np.ndarray:
    found = re.search(pattern, text)
    assert found is not None
    return np.array(found[1].split(), dtype=float)


def test_a_stage_shows_the_triangles_of_a_glb_at_their_places_to_a_millimetre(tmp_path):
    usd, geometry = pytest.importorskip("pxr.Usd"), pytest.importorskip("pxr.UsdGeom")
    far = scene(footprint=FAR)
    options = SaveOptions(in_place=True)
    stage = usd.Stage.Open(str(save(far, tmp_path / "far houses.usd", options=options)))
    assert (geometry.GetStageUpAxis(stage), geometry.GetStageMetersPerUnit(stage)) == ("Y", 1.0)
    cache, corners = geometry.XformCache(), []
    for prim in stage.Traverse(usd.TraverseInstanceProxies()):
        if prim.IsA(geometry.Mesh):
            mesh = geometry.Mesh(prim)
            points, rows = np.array(mesh.GetPointsAttr().Get()), np.array(mesh.GetFaceVertexIndicesAttr().Get())
            assert np.allclose(mesh.GetExtentAttr().Get(), [points.min(axis=0), points.max(axis=0)])
            matrix = np.array(cache.GetLocalToWorldTransform(prim))
            corners.append((points @ matrix[:3, :3] + matrix[3, :3])[rows].reshape(-1, 3, 3))
    shown = np.concatenate(corners)
    wanted = world(read_glb(save(far, tmp_path / "far.glb", options=options))).corners
    middles = [np.array(sorted(np.round(part.mean(axis=1), 3).tolist())) for part in (shown, wanted)]
    assert np.abs(middles[0] - middles[1]).max() < 1e-3


def test_a_stage_has_kinds_names_materials_and_instances(tmp_path):
    usd, shade = pytest.importorskip("pxr.Usd"), pytest.importorskip("pxr.UsdShade")
    (tmp_path / "assets").mkdir()
    Image.new("RGB", (8, 8), (200, 100, 50)).save(tmp_path / "assets" / "brick.png")
    rules = RULES.replace("Lot -->", 'attr floors = 2\nLot --> report("area", 5) ') + (
        'Roof --> setupProjection(0, scope.xy, 2, 2) texture("brick.png") projectUV(0) Tiles\n'
    )
    houses = scene(rules, assets=tmp_path / "assets")
    path = save(houses, tmp_path / "two houses.usd", options=SaveOptions(assets=tmp_path / "assets"))
    stage = usd.Stage.Open(str(path))
    kinds = {str(prim.GetPath()): usd.ModelAPI(prim).GetKind() for prim in stage.Traverse()}
    assert (kinds["/World"], kinds["/World/model_0"]) == ("assembly", "component")
    assert kinds["/World/model_1/Wall_color_803020"] == "subcomponent"
    model = stage.GetPrimAtPath("/World/model_0")
    assert properties(model) == {"attributes:floors": 2.0, "reports:area": 5.0}
    windows = stage.GetPrimAtPath("/World/model_0/Window")
    assert properties(windows) == {"symbol": "Window", "line": 4}
    assert len(windows.GetChildren()) == 4
    assert all(prim.IsInstance() for prim in windows.GetChildren())
    assert len({prim.GetPrototype() for prim in stage.Traverse() if prim.IsInstance()}) <= 6
    tiles = stage.GetPrimAtPath("/World/model_0/Tiles")
    material, _ = shade.MaterialBindingAPI(tiles).ComputeBoundMaterial()
    assert material.GetPath().name == "brick"
    texture = shade.Shader(stage.GetPrimAtPath(f"{material.GetPath()}/Texture")).GetInput("file").Get()
    assert Path(texture.resolvedPath).read_bytes() == (tmp_path / "assets" / "brick.png").read_bytes()
    assert path.read_bytes() == save(houses, path, options=SaveOptions(assets=tmp_path / "assets")).read_bytes()


def test_a_package_is_the_stage_with_its_images(tmp_path):
    usd, sdf = pytest.importorskip("pxr.Usd"), pytest.importorskip("pxr.Sdf")
    (tmp_path / "assets").mkdir()
    Image.new("RGB", (8, 8), (200, 100, 50)).save(tmp_path / "assets" / "brick.png")
    rules = RULES + 'Roof --> setupProjection(0, scope.xy, 2, 2) texture("brick.png") projectUV(0) Tiles\n'
    houses, options = scene(rules, assets=tmp_path / "assets"), SaveOptions(assets=tmp_path / "assets")
    plain, package = (save(houses, tmp_path / f"two houses.{kind}", options=options) for kind in ("usd", "usdz"))
    package.rename(tmp_path / "alone.usdz")
    stages = [usd.Stage.Open(str(path)) for path in (plain, tmp_path / "alone.usdz")]
    one, other = (stage.GetRootLayer().ExportToString() for stage in stages)
    assert one == other
    with ZipFile(tmp_path / "alone.usdz") as archive:
        assert [Path(name).suffix for name in archive.namelist()] == [".usdc", ".png"]
        assert {each.date_time for each in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
        assert archive.read(archive.namelist()[1]) == (tmp_path / "assets" / "brick.png").read_bytes()
    reader = sdf.ZipFile.Open(str(tmp_path / "alone.usdz"))
    entries = [reader.GetFileInfo(name) for name in reader.GetFileNames()]
    assert [(each.dataOffset % 64, each.compressionMethod, each.encrypted) for each in entries] == [(0, 0, False)] * 2


def test_names_that_are_one_to_usd_keep_their_values(tmp_path):
    usd = pytest.importorskip("pxr.Usd")
    rules = 'attr größe = 2 attr grüße = 3 Lot --> report("a.b", 5) report("a_b", 6) report("a_b_2", 7) extrude(3) Box'
    stage = usd.Stage.Open(str(save(scene(rules), tmp_path / "names.usd")))
    model = stage.GetPrimAtPath("/World/model_0")
    values = {
        model.GetAttribute(f"userProperties:{name}").GetDisplayName(): it for name, it in properties(model).items()
    }
    assert values == {"größe": 2.0, "grüße": 3.0, "a.b": 5.0, "a_b": 6.0, "a_b_2": 7.0}
