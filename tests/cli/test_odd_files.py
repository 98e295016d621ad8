"""Files that are not what their names promise: pipes, names that are not text, numbers of thousands of digits."""

from __future__ import annotations

import json
import os

import pytest

from tests.facade.test_file import VALID

CSV = "label,left,bottom,right,top\nwindow,1,1,2,3\nwindow,4,1,5,3\n"
DESIGN = 'canvas = { width = WIDTH, height = 16.0 }\nsymbols = { A = 1.0 }\n[[layers]]\nx = "A^k"\ny = "A^m"\n'


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes")
@pytest.mark.parametrize(
    ("command", "name"),
    [
        (["check"], "pipe.cga"),
        (["facade", "show", "-o", "a.svg"], "pipe.json"),
        (["facade", "read"], "pipe.csv"),
        (["facade", "layers", "-o", "out"], "pipe.toml"),
        (["facade", "match", "-o", "out"], "pipe.json"),
        (["facade", "match", "-o", "out"], "pipe.ply"),
    ],
)
def test_a_pipe_is_refused_without_waiting_for_it(run_any, tmp_path, monkeypatch, command, name):
    monkeypatch.chdir(tmp_path)
    os.mkfifo(tmp_path / name)
    result = run_any(*command, name)
    assert result.exit_code in (1, 2)
    assert name in result.stderr
    assert [path.name for path in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize("width", ["1e-320", "1e308", "9" * 5_000, "0x" + "f" * 5_000, "-0.0", "nan", "1e-7"])
def test_canvases_that_are_no_size_are_refused_with_their_place(run, tmp_path, width):
    (tmp_path / "a.toml").write_text(DESIGN.replace("WIDTH", width))
    result = run("facade", "layers", tmp_path / "a.toml", "-n", "1", "-o", tmp_path / "out", code=1)
    assert "a.toml:1:" in result.stderr
    assert "expected" in result.stderr
    assert len(result.stderr) < 1_000


def test_names_that_are_not_text_are_read_shown_and_written(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    name = os.fsdecode(b"b\xff")
    try:
        (tmp_path / f"{name}.csv").write_text(CSV)
    except OSError:
        pytest.skip("a file system of Unicode names")
    assert "b\\udcff.facade.json" in run("facade", "read", f"{name}.csv", "--width", "8").stdout
    written = json.loads(run("facade", "grammar", f"{name}.facade.json", "--json").stdout)["file"]
    assert written == f"{name}.cga"
    assert "b\\udcff.cga: nothing" in run("check", written).stdout
    assert run("show", written, "--graph", f"{name}.svg").exit_code == 0
    (tmp_path / "a.cga").write_text("Lot --> extrude(3) Wall")
    run("sample", "a.cga", "-n", "1", "--no-image", "--format", "obj", "-o", name)
    assert json.loads((tmp_path / name / "manifest.json").read_text(encoding="utf-8"))["complete"] is True


@pytest.mark.parametrize("label", ["\ud800", "\x1b[31m", "\u202e"])
def test_labels_that_a_terminal_obeys_are_refused_or_shown_as_escapes(run_any, tmp_path, label):
    path = tmp_path / "a.json"
    path.write_bytes(VALID.replace(b'"wall"', json.dumps(label).encode()))
    result = run_any("facade", "grammar", path, "-o", tmp_path / "a.cga")
    assert not set(result.stdout + result.stderr) & {"\x1b", "\u202e", "\ud800"}
