"""Every command on facades says which kind of file it takes, when it is given another kind of ours."""

from pathlib import Path

import pytest

from grammarlab.runs.sample.shipped import examples_folder
from tests.command_line import invoke

HOUSES = examples_folder() / "facades"
OBJ = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n"
ELEMENTS = '{"format": "grammarlab elements", "version": 1, "elements": []}'
COCO = '{"images": [], "annotations": []}'
OPTIONS = {
    "edit": ["--width", "5", "-o", "out"],
    "grammar": [],
    "infer": [],
    "show": ["-o", "out.svg"],
    "layers": ["-o", "out"],
    "synthesize": ["--rows", "4", "--columns", "4", "-o", "out"],
    "match": ["-o", "out"],
    "read": ["-o", "out.json"],
    "open": ["--no-browser"],
}
FACADE, DESIGN, MESH, SCAN, BOXES = "file of a facade", "design of layers", "a mesh", "a scan", "labelled boxes"
TAKES = {
    **{command: {FACADE} for command in ("edit", "grammar", "infer", "show")},
    "open": {FACADE, DESIGN, MESH, SCAN},
    "layers": {DESIGN},
    "synthesize": {MESH},
    "match": {MESH, SCAN},
    "read": {BOXES, "a rule file"},
}


@pytest.fixture
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Path]:
    """One of each kind, by what it is called."""
    monkeypatch.chdir(tmp_path)
    texts = {"wall.obj": OBJ, "scene.json": ELEMENTS, "boxes.json": COCO, "rules.cga": "Lot --> NIL"}
    for name, text in texts.items():
        Path(name).write_text(text, encoding="utf-8")
    return {
        FACADE: HOUSES / "arcade.json",
        DESIGN: HOUSES / "library.toml",
        MESH: Path("wall.obj"),
        SCAN: Path("scene.json"),
        BOXES: Path("boxes.json"),
        "a rule file": Path("rules.cga"),
    }


@pytest.mark.parametrize("command", OPTIONS)
def test_another_kind_of_file_is_named_with_what_is_expected(files: dict[str, Path], command: str) -> None:
    for kind in files.keys() - TAKES[command]:
        found = invoke("facade", command, files[kind], *OPTIONS[command])
        assert found.exit_code in {1, 2}
        named, _, expected = found.stderr.partition("; expected")
        assert f"{files[kind].name} is " in named
        assert kind in named
        assert all(taken in expected for taken in TAKES[command])
    assert not Path("out").exists()
