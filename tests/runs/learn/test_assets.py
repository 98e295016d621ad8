"""A learned rule file finds the assets of the one that it was made from, wherever it is put."""

from pathlib import Path

import pytest

from grammarlab.language.grammar import Grammar
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.runs.learn.from_scenario import put_assets_beside
from grammarlab.runs.sample.checks import hash_assets
from grammarlab.runs.sample.request import SampleRequest

RULES = (
    'attr tree = "assets/trees/o?k.obj"\nLot --> texture("wall.png") i(fileRandom(tree)) i("/city/assets/door.obj") A'
)


@pytest.fixture
def house(tmp_path: Path) -> Path:
    """A rule file of a project."""
    for name in ("assets/trees/oak.obj", "assets/wall.png", "assets/door.obj", "assets/unused.obj"):
        (tmp_path / "city" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "city" / name).write_text(name)
    (tmp_path / "city" / "rules").mkdir()
    rules = tmp_path / "city" / "rules" / "house.cga"
    rules.write_text(RULES)
    return rules


@pytest.mark.parametrize("place", ["elsewhere/a.cga", "city/rules/a.cga", "city/rules/sub/a.cga", "city/a.cga"])
def test_a_rule_file_written_elsewhere_finds_the_same_assets(house, tmp_path, place):
    before = SampleRequest.of(house)
    assert len(hash_assets(before)) == 3
    file = tmp_path / place
    file.parent.mkdir(exist_ok=True)
    file.write_text(RULES)
    put_assets_beside(file, GrammarSpace(Grammar.parse(RULES)), before.assets)
    assert hash_assets(SampleRequest.of(file)) == hash_assets(before) == hash_assets(SampleRequest.of(house))
    assert not (tmp_path / "elsewhere" / "assets" / "unused.obj").exists()


def test_files_of_a_person_stay_and_nothing_from_outside_comes_along(house, tmp_path):
    mine, secret = tmp_path / "elsewhere" / "assets" / "wall.png", tmp_path / "secret"
    mine.parent.mkdir(parents=True)
    mine.write_text("mine")
    secret.write_text("secret")
    (tmp_path / "city" / "assets" / "trees" / "elm.obj").symlink_to(secret)
    put_assets_beside(mine.parent.parent / "a.cga", GrammarSpace(Grammar.parse(RULES)), SampleRequest.of(house).assets)
    assert mine.read_text() == "mine"
    assert (mine.parent / "trees" / "oak.obj").is_file()
    assert (mine.parent / "trees" / "elm.obj").is_symlink()


@pytest.mark.parametrize(
    ("rules", "files"),
    [
        ('Lot --> i("trees/" + kind + ".obj") A  attr kind = "oak"', ["trees/oak.obj"]),
        ('Lot --> i(folder + ("o" + n) + "k" + ".obj") A  const folder = "assets/trees/"  n = 1', ["trees/oak.obj"]),
        (
            'Lot --> i("/city/assets/" + (case p(0.5) : "door" else : "gate")) A',
            ["door.obj", "trees/oak.obj", "unused.obj", "wall.png"],
        ),
        ('Lot --> texture(names[0] + ".png") A  const names = ["wall"]', ["wall.png"]),
        ('Lot --> texture(["wall.png", "trees/oak.obj"][split.index]) A', ["trees/oak.obj", "wall.png"]),
        ('Lot --> report("height in " + unit, 1 + 2) print("a" + 1) A  const unit = "m"', []),
    ],
)
def test_files_whose_names_rules_build_are_part_of_a_run(house, rules, files):
    house.write_text(rules)
    before = hash_assets(SampleRequest.of(house))
    assert list(before) == files
    for name in files:
        (house.parents[1] / "assets" / name).write_text("changed")
    assert all(before[name] != digest for name, digest in hash_assets(SampleRequest.of(house)).items())
