"""``grammarlab facade infer``."""

import json
from pathlib import Path

from grammarlab.facade.file import load_facade
from grammarlab.layers.infer import compare
from tests.layers.samples import DESIGNS


def test_a_facade_becomes_a_design_that_is_laid_out_again(run, tmp_path: Path) -> None:
    source, design = DESIGNS / "townhouse.json", tmp_path / "new" / "town.toml"
    told = json.loads(run("facade", "infer", source, "-o", design, "--json").stdout)
    assert told["design"] == str(design)
    assert told["score"] > 0.999 < told["iou"]
    assert told["patterns"]["bays"] == "aSaHa(Sa)^k"
    assert told["counters"] == {"k": 2, "n": 3}
    layouts = json.loads(run("facade", "layers", design, "-n", 1, "-o", tmp_path / "out", "--json").stdout)["layouts"]
    score = compare(load_facade(source), load_facade(Path(layouts[0]["files"]["facade"])))
    assert score.area > 0.999
    assert "Inferred: 100.00% of the area" in design.read_text(encoding="utf-8")


def test_what_is_read_is_not_written(run, tmp_path: Path) -> None:
    file = tmp_path / "a.toml"
    file.write_bytes((DESIGNS / "townhouse.json").read_bytes())
    assert "write to another one" in run("facade", "infer", file, "-o", file, code=2).stderr
