"""Every method of learning makes a density that comes nearer to what is liked."""

from pathlib import Path

import pytest

from grammarlab.density.targets.rejection import RejectionSampler
from grammarlab.derivation.derive import derive
from grammarlab.errors import UsageError
from grammarlab.language.grammar import Grammar
from grammarlab.learning.targets.grammar_target import METHODS
from grammarlab.runs.learn.from_scenario import learn_from_scenario

RULES = """
// A house of three parts
Lot --> Wall Door Roof
Wall --> 40% : OldWall else : NewWall
Door --> 40% : OldDoor else : NewDoor
Roof --> 40% : OldRoof else : NewRoof
"""
SCENARIO = """
name = "old"
title = "Old houses"
grammar = "house.cga"
num_models = 2000
[[preference]]
score = 50
when = "{OldWall} and {OldDoor} and {OldRoof}"
[[preference]]
score = 10
when = "{NewWall} and {NewDoor} and {NewRoof}"
"""


def learn(folder: Path, method: str, **options):
    (folder / "house.cga").write_text(RULES)
    (folder / "old.toml").write_text(SCENARIO)
    return learn_from_scenario(str(folder / "house.cga"), folder / "old.toml", method, folder / "out.cga", **options)


@pytest.mark.parametrize(
    ("method", "most"),
    [("compile", 1e-9), ("parameters", 0.383), ("structure", 0.003), ("tied", 0.003), ("rejection", 0.0)],
)
def test_every_method_comes_nearer(tmp_path, method, most):
    result = learn(tmp_path, method, num_samples=1_000)
    assert result.learned.method == method
    assert result.js <= most < result.js_before
    if method == "rejection":
        assert isinstance(result.learned, RejectionSampler)
        assert result.file is None
        assert not (tmp_path / "out.cga").exists()
        assert "accepted" in result.learned.findings[0]
    else:
        text = (tmp_path / "out.cga").read_text()
        assert f"// Method {method}" in text
        assert derive(Grammar.parse(text), 10, 1).num_models == 10


def test_all_methods_are_tested_above():
    assert METHODS == ("compile", "parameters", "structure", "tied", "rejection")


def test_no_samples_are_refused(tmp_path):
    for method in ("tied", "rejection"):
        with pytest.raises(UsageError, match="at least one"):
            learn(tmp_path, method, num_samples=0)
