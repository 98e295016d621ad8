"""Khronos' own validator finds nothing wrong with written files."""

from __future__ import annotations

import json
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from grammarlab.export import SaveOptions, save
from grammarlab.export.tiles.tile_file import write_tile
from grammarlab.scene import Scene
from tests.export.tiles.quarter import tile_of
from tests.scene.buildings import STONE, TILE, house, scene_of, street
from tests.waiting import PATIENCE

PACKAGE = "gltf-validator@2.0.0-dev.3.10"
VALIDATE = """
const validator = require("gltf-validator"), fs = require("fs");
(async () => {
  const reports = [];
  for (const file of process.argv.slice(1)) reports.push(
    await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), { maxIssues: 20 }));
  console.log(JSON.stringify(reports));
})();
"""


@pytest.fixture(scope="module")
def validator(tmp_path_factory) -> Path:
    """A folder in which node finds the validator."""
    node, npm = shutil.which("node"), shutil.which("npm")
    if node is None or npm is None:
        pytest.skip("node and npm are not installed")
    folder = tmp_path_factory.mktemp("validator")
    (folder / "package.json").write_text('{"private": true}')
    options = ["--no-audit", "--no-fund", "--ignore-scripts", "--fetch-retries=0", "--fetch-timeout=15000"]
    try:
        subprocess.run([npm, "install", PACKAGE, *options], cwd=folder, check=True, capture_output=True, timeout=40)
    except (subprocess.SubprocessError, OSError) as error:
        pytest.skip(f"npm cannot install {PACKAGE}: {error}")
    return folder


def files(folder: Path) -> list[Path]:
    """Plain and textured streets, a single house and nothing at all, written in every way."""
    assets = folder / "assets"
    assets.mkdir()
    Image.new("RGB", (8, 8), (200, 100, 50)).save(assets / "wall.png")
    Image.new("RGB", (4, 16), (90, 90, 160)).save(assets / "roof.jpg")
    names = [""] * 6
    names[STONE], names[TILE] = "wall.png", "roof.jpg"
    plain = street()
    scenes: dict[str, Scene] = {
        "plain": plain,
        "textured": replace(plain, materials=replace(plain.materials, textures=tuple(names))),
        "house": scene_of([house()]),
        "nothing": scene_of([[]]),
    }
    tiles = [folder / f"tile_{level}.glb" for level in ("full", "plain")]
    write_tile(tiles[0], tile_of(list(range(9))), "full", np.eye(4), assets)
    write_tile(tiles[1], tile_of(list(range(9))), "plain", np.eye(4), assets)
    return tiles + [
        save(scene, folder / f"{name}_{reuse}.glb", options=SaveOptions(reuse=reuse, assets=assets))
        for name, scene in scenes.items()
        for reuse in ("merged", "nodes", "instancing")
    ]


def test_the_validator_finds_no_error_and_no_warning(validator, tmp_path):
    paths = files(tmp_path)
    command = ["node", "-e", VALIDATE, *(str(path) for path in paths)]
    done = subprocess.run(command, cwd=validator, check=True, capture_output=True, text=True, timeout=PATIENCE)
    reports = json.loads(done.stdout)
    assert len(reports) == len(paths)
    for path, report in zip(paths, reports, strict=True):
        issues = report["issues"]
        assert issues["numErrors"] == issues["numWarnings"] == 0, f"{path.name}: {issues['messages']}"
        if "merged" in path.name and not path.name.startswith("nothing"):
            assert report["info"]["totalTriangleCount"] > 0
            # Nothing is written that nothing refers to.
            assert "UNUSED_OBJECT" not in {message["code"] for message in issues["messages"]}


def test_the_validator_does_find_faults(validator, tmp_path):
    path = save(scene_of([house()]), tmp_path / "model.glb")
    path.write_bytes(path.read_bytes().replace(b'"metallicFactor":0.0', b'"metallicFactor":7.0'))
    command = ["node", "-e", VALIDATE, str(path)]
    done = subprocess.run(command, cwd=validator, check=True, capture_output=True, text=True, timeout=PATIENCE)
    assert json.loads(done.stdout)[0]["issues"]["numErrors"] > 0
