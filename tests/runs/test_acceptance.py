"""Runs of files with an acceptance rule: the same models whoever makes them, and what is said about candidates."""

import json
from typing import Any

import numpy as np
import pytest

from grammarlab.errors import LanguageError
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.runs.sample import models
from grammarlab.runs.sample.checks import grammar_to_run
from grammarlab.runs.sample.derivations import load_forest
from grammarlab.runs.sample.request import SampleRequest
from grammarlab.runs.sample.run import sample_run
from grammarlab.runs.sample.trace import as_values, trace_model
from grammarlab.runs.work.executors import SERIAL, Processes
from tests.command_line import invoke
from tests.runs.sample.test_sample import contents

RULES = """
@Acceptance("choose({Low} >= 2, 0.8, 0.1)")
const acceptance_rate = 0.25

@StartRule
Lot --> 50% : Block Block else : Block Block Block
Block --> 30% : extrude(3) Low else : extrude(rand(4, 9)) High
"""
LOW = parse("Low")


def request(tmp_path, **options: Any):
    values: dict[str, Any] = {"num_models": 30, "image": False, **options}
    return SampleRequest(name="lots", text=RULES, assets=tmp_path, seed=5, **values)


def test_models_do_not_depend_on_who_makes_them_or_how_many(tmp_path, monkeypatch):
    one = sample_run(request(tmp_path), tmp_path / "one")
    monkeypatch.setattr(models, "BATCH_MODELS", 7)
    sample_run(request(tmp_path), tmp_path / "cut", executor=SERIAL)
    sample_run(request(tmp_path), tmp_path / "two", executor=Processes(2))
    assert contents(tmp_path / "cut") == contents(tmp_path / "two")
    few = sample_run(request(tmp_path, num_models=4), tmp_path / "few")
    for model, other in zip(few.models, one.models, strict=False):
        assert (few.folder / model.file).read_bytes() == (one.folder / other.file).read_bytes()
        assert model.tries == other.tries
    assert one.accept_rate == 30 / sum(model.tries for model in one.models)
    assert max(model.tries for model in one.models) > 1
    assert not one.not_accepted


def test_all_ways_to_derive_a_model_give_the_one_that_is_kept(tmp_path):
    run = sample_run(request(tmp_path), tmp_path / "out")
    wanted = count(load_forest(run.derivations / "00000"), [LOW])[:, 0]
    space = GrammarSpace(grammar_to_run(RULES, "lots.cga"))
    by_address = space.make([Address(False, 5, model) for model in range(30)])
    in_chunks = next(iter(space.sample(False, 30, 5)))
    assert np.array_equal(count(by_address, [LOW])[:, 0], wanted)
    assert np.array_equal(count(in_chunks, [LOW])[:, 0], wanted)
    (tmp_path / "lots.cga").write_text(RULES)
    nodes = as_values(trace_model(str(tmp_path / "lots.cga"), 7, 5))["nodes"]
    assert sum(node["symbol"] == "Low" for node in nodes) == wanted[7]


def test_the_proposal_is_weighed_as_what_is_kept(tmp_path):
    space = GrammarSpace(grammar_to_run(RULES, "lots.cga"))
    own, flat = (next(iter(space.sample(kind, 1_000, 3))) for kind in (False, True))
    weights = np.exp(space.log_ratio(flat))
    assert weights.mean() == pytest.approx(1.0, abs=0.1)
    for number in range(4):
        share = (count(own, [LOW])[:, 0] == number).mean()
        assert weights[count(flat, [LOW])[:, 0] == number].sum() / 1_000 == pytest.approx(share, abs=0.06)


def test_the_command_says_how_many_candidates_were_kept(tmp_path):
    (tmp_path / "lots.cga").write_text(RULES)
    command = ["sample", str(tmp_path / "lots.cga"), "-n", "9", "--no-image", "-o", str(tmp_path / "out")]
    found = json.loads(invoke(*command, "--json").stdout)
    assert found["accept_rate"] == pytest.approx(9 / sum(model["tries"] for model in found["models"]))
    assert (found["most_tries"], found["not_accepted"]) == (20_000, [])
    manifest = json.loads((tmp_path / "out" / "manifest.json").read_text())
    assert [model["tries"] for model in manifest["models"]] == [model["tries"] for model in found["models"]]
    assert "the acceptance rule kept" in invoke(*command).output


def test_a_rule_that_keeps_hardly_any_is_warned_of(tmp_path):
    (tmp_path / "lots.cga").write_text(RULES.replace("0.8, 0.1", "1e-9, 0"))
    command = ["sample", str(tmp_path / "lots.cga"), "-n", "2", "--no-image", "-o", str(tmp_path / "out")]
    assert "warning: none of 1,000 candidates was accepted for 2 models" in " ".join(invoke(*command).output.split())


def test_a_wrong_rule_is_an_error_of_the_file(tmp_path):
    (tmp_path / "lots.cga").write_text(RULES.replace("0.1)", "0.1"))
    with pytest.raises(LanguageError, match="bad-acceptance"):
        grammar_to_run((tmp_path / "lots.cga").read_text(), "lots.cga")
    found = invoke("check", tmp_path / "lots.cga")
    assert found.exit_code == 1
    assert "bad-acceptance" in found.output
