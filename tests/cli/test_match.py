"""``grammarlab facade match`` from the file of a scene to what is found."""

import json

from grammarlab.facade.file import load_facade
from grammarlab.language.grammar import Grammar
from tests.cases import takes_turns


@takes_turns
def test_a_scene_is_matched(run, tmp_path):
    scene = tmp_path / "scene.json"
    run("facade", "scene", "-n", 12, "--kinds", 4, "--noise", 0.002, "--occluded", 0, "-o", scene)
    document = json.loads(scene.read_text())
    document["elements"][3]["points"] = [[1, 1]]
    scene.write_text(json.dumps(document))
    arguments = ("facade", "match", scene, "--templates", "rectangle", "--json", "-o", tmp_path / "out")
    found = json.loads(run(*arguments).stdout)
    assert found["elements"][3]["kind"] == "unknown"
    assert "1 points" in found["elements"][3]["uncertain"]
    assert found["truth"]["mislabelled"] == 1
    first = found["elements"][0]
    truth = document["kinds"][document["elements"][0]["kind"]]["parameters"]
    for name, value in truth.items():
        assert abs(first["parameters"][name] - value) < 4 * first["standard_deviations"][name] + 0.005
    assert found["templates"] == ["rectangle"]
    assert sorted(each for group in found["groups"] for each in group["elements"]) == [0, 1, 2, *range(4, 12)]
    again = json.loads(run(*arguments).stdout)
    assert [each["parameters"] for each in again["elements"]] == [each["parameters"] for each in found["elements"]]
    assert len(load_facade(tmp_path / "out/completed.facade.json").leaves) > 7
    assert Grammar.parse((tmp_path / "out/kinds.cga").read_text()).rules


def test_mistakes_of_use_end_with_2(run, tmp_path):
    scene = tmp_path / "scene.npz"
    run("facade", "scene", "-n", 2, "--kinds", 1, "-o", scene)
    run("facade", "match", scene, "--templates", "no-such", "-o", tmp_path / "out", code=2)
    run("facade", "match", scene, "--method", "magic", "-o", tmp_path / "out", code=2)
    for option, value in (("--unit", "mm"), ("--up", "y"), ("--unit", "inch"), ("--up", "x")):
        run("facade", "match", scene, option, value, "-o", tmp_path / "out", code=2)
    broken = tmp_path / "broken.json"
    broken.write_text('{"elements": [{"points": [[NaN, 1]]}]}')
    run("facade", "match", broken, "-o", tmp_path / "out", code=1)


def test_the_scan_is_not_replaced_by_what_is_found_in_it(run, tmp_path):
    scene = tmp_path / "match.json"
    run("facade", "scene", "-n", 2, "--kinds", 1, "-o", scene)
    before = scene.read_bytes()
    assert "is the input file" in run("facade", "match", scene, "-o", tmp_path, code=2).stderr
    assert scene.read_bytes() == before
