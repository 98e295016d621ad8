"""The files and the picture of a model are a function of the model: of neither its batch nor its place in the world."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest

from grammarlab.assets.mesh_files import AssetFolder
from grammarlab.derivation import compile_grammar, derive
from grammarlab.derivation.forest import Forest
from grammarlab.export import REUSES, SaveOptions, save_each
from grammarlab.export.save import Format
from grammarlab.geometry.footprints.footprint_text import read_footprints
from grammarlab.language.importing import load
from grammarlab.rendering.camera import View, frame
from grammarlab.rendering.raycast import RaycastRenderer
from grammarlab.rendering.renderer import RenderOptions
from grammarlab.runs.sample.contact_sheet import seen_points
from grammarlab.runs.sample.request import SampleRequest
from grammarlab.runs.sample.run import sample_run
from grammarlab.runs.work.executor_choice import executor_of
from grammarlab.scene import realize, triangles
from tests.cases import takes_turns
from tests.export.gltf import MESH_FORMATS, read_glb
from tests.whole_grammars import WHOLE

GRAMMARS = WHOLE
ASSETS = GRAMMARS[0].parent / "assets"
WAYS: list[tuple[Any, Any]] = [(suffix, "merged") for suffix in MESH_FORMATS] + [("glb", reuse) for reuse in REUSES[1:]]
BATCHES = [(5, 1), (4, 2), (0, 7), (5, 7)]
"""First model and number of models of batches that have model 5."""
LOTS = {
    "rectangle": [[0, 0, 12.5], [18.27, 0, 12.5], [18.27, 0, 0], [0, 0, 0]],
    "turned": [[3.1, 0, 14.9], [17.6, 0, 11.25], [21.03, 0, 2.5], [8.8, 0, 0], [0, 0, 5.25]],
}
PLACES = {"zurich": (2683000.13, 0.0, -1247000.37), "far": (1e7, 0.0, -1e7), "beyond": (-1e7 / 3, 0.0, 0.0)}


@pytest.fixture(scope="module", params=GRAMMARS, ids=lambda path: path.stem)
def program(request):
    return compile_grammar(load(request.param))


def files_of(forest: Forest, model: int, folder: Path) -> dict[str, bytes]:
    """All files of one model of a forest in all formats, by format, way of reuse and name."""
    scene, found = realize(forest), {}
    for suffix, reuse in WAYS:
        target = folder / suffix / reuse
        first = int(forest.lots.model[0])
        save_each(scene, target, suffix, SaveOptions(reuse=reuse, assets=ASSETS), first_model=first)
        for path in target.glob(f"model_{model:05d}*"):
            found[f"{reuse} {path.name}"] = path.read_bytes()
    return found


def picture_of(forest: Forest, index: int) -> np.ndarray:
    batch = triangles(realize(forest)).model(index)
    return RaycastRenderer().render(batch, frame(seen_points(batch), 1.0, View()), RenderOptions(48, 48, 1))


def test_the_files_of_a_model_do_not_depend_on_its_batch(program, tmp_path):
    files, pictures = [], []
    for first, count in BATCHES:
        forest = derive(program, count, 3, first_model=first, assets=AssetFolder(ASSETS))
        files.append(files_of(forest, 5, tmp_path / f"{first}-{count}"))
        pictures.append(picture_of(forest, 5 - first).tobytes())
    assert len(files[0]) >= len(WAYS)
    for other in files[1:]:
        assert other == files[0]
    assert len(set(pictures)) == 1


@takes_turns
def test_the_files_of_a_run_do_not_depend_on_its_size_or_jobs(tmp_path):
    """66 models are two batches, and so two tasks of the processes."""
    for suffix in get_args(Format):
        contents = []
        for number, jobs in ((66, 2), (66, 1), (2, 1)):
            folder = tmp_path / f"{suffix}-{number}-{jobs}"
            request = SampleRequest.of("toy", num_models=number, seed=3, file_format=suffix, image=False)
            sample_run(request, folder, executor=executor_of(jobs))
            contents.append({path.name: path.read_bytes() for path in folder.glob("toy-*")})
        assert contents[0] == contents[1]
        assert contents[2] == {name: contents[0][name] for name in contents[2]}
        assert len(contents[2]) >= 2


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("lot", LOTS)
def test_a_model_is_the_same_wherever_it_stands(program, tmp_path, lot, place):
    """Far away, everything is equal to the last bit, but for the origin that the files name."""
    corners, shift = np.array(LOTS[lot], dtype=float), np.array(PLACES[place])
    near = derive(program, 2, 3, footprint=corners, assets=AssetFolder(ASSETS))
    far = derive(program, 2, 3, footprint=corners + shift, assets=AssetFolder(ASSETS))
    assert not near.origins.any()
    assert np.abs(far.origins - shift).max() < 2e-9
    for table in ("nodes", "draws", "leaves", "reports"):
        for name in getattr(near, table).__slots__:
            np.testing.assert_array_equal(getattr(getattr(far, table), name), getattr(getattr(near, table), name))
    np.testing.assert_array_equal(picture_of(far, 1), picture_of(near, 1))
    if place == "zurich":
        here = files_of(near, 1, tmp_path / "near")
        there = files_of(far, 1, tmp_path / "far")
        assert here.keys() == there.keys()
        for name in here:
            origin, rest = without_origin(name, there[name], tmp_path)
            assert np.abs(origin - shift).max() < 2e-9 or name.endswith((".mtl", ".png", ".jpg"))
            assert rest == without_origin(name, here[name], tmp_path)[1]


def without_origin(name: str, content: bytes, folder: Path) -> tuple[np.ndarray, object]:
    """The origin of a file, and everything else that it says."""
    if name.endswith(".glb"):
        (folder / "one.glb").write_bytes(content)
        glb = read_glb(folder / "one.glb")
        document, origin = glb.document, [0.0, 0.0, 0.0]
        if document["nodes"][-1]["name"] == "origin" if "name" in document["nodes"][-1] else False:
            node = document["nodes"].pop()
            origin, document["scenes"][0]["nodes"] = node["translation"], node["children"]
        return np.array(origin), (document, glb.buffer)
    head, end, tail = content.partition(b"end_header" if name.endswith(".ply") else b"mtllib")
    lines = head.decode(errors="replace").splitlines()
    found = [line for line in lines if " origin " in line]
    kept = [line for line in lines if " origin " not in line]
    return np.array(found[0].split("origin ")[1].split()[:3] if found else [0, 0, 0], dtype=float), (kept, end, tail)


def test_the_parcel_of_the_issue_keeps_its_millimetres(tmp_path):
    """Absolute coordinates of 32 bits would have steps of 0.25 m."""
    corners = "2683000.13 1247000.37, 2683018.4 1247000.37, 2683018.4 1247016.9, 2683000.13 1247016.9"
    text = f"POLYGON(({corners}, 2683000.13 1247000.37))"
    (footprint,) = read_footprints(text)
    request = SampleRequest.of("building", footprint=text, num_models=1, image=False)
    result = sample_run(request, tmp_path)
    glb = read_glb(tmp_path / result.models[0].file)
    (node,) = [node for node in glb.document["nodes"] if node["name"] == "origin"]
    low = footprint.polygon.min(axis=0).tolist()
    assert node["translation"] == low == [2683000.13, 0.0, -1247016.9]
    assert json.loads(result.manifest.read_text())["models"][0]["origin"] == low
    primitives = [primitive for mesh in glb.document["meshes"] for primitive in mesh["primitives"]]
    local = np.concatenate([glb.values(primitive["attributes"]["POSITION"]) for primitive in primitives])
    assert np.abs(local).max() < 100.0
    assert len(np.unique(local[:, 0])) > 50
