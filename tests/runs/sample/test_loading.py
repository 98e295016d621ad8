"""Grammars by name or path, with their assets."""

from pathlib import Path

import pytest

import grammarlab as gl
from grammarlab.errors import DerivationError, UsageError
from grammarlab.runs.sample.shipped import shipped_examples

QUAD = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"
RULES = 'Lot --> extrude(3) i("part.obj") Part\n'


@pytest.mark.parametrize("name", [source.name for source in shipped_examples()])
def test_every_shipped_grammar_is_derived_from_python(name):
    forest = gl.derive(gl.load(name), 2, seed=1)
    assert len(forest.leaves)
    assert not forest.missing_assets


@pytest.mark.parametrize("folder", ["assets", "."])
def test_a_loaded_file_finds_the_assets_that_the_command_line_finds(tmp_path, folder):
    (tmp_path / folder).mkdir(exist_ok=True)
    (tmp_path / folder / "part.obj").write_text(QUAD)
    (tmp_path / "lot.cga").write_text(RULES)
    grammar = gl.load(tmp_path / "lot.cga")
    given = gl.derive(gl.Grammar.parse(RULES), 1, seed=1, assets=tmp_path / folder)
    for forest in (gl.derive(grammar, 1, seed=1), gl.sample(grammar, 1, seed=1), given):
        assert not forest.missing_assets
        assert len(gl.realize(forest)) == 1


def test_a_given_folder_comes_before_that_of_the_grammar(tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "part.obj").write_text(QUAD)
    (tmp_path / "lot.cga").write_text(RULES)
    forest = gl.derive(gl.load(tmp_path / "lot.cga"), 1, seed=1, assets=str(tmp_path / "empty"))
    assert [asset.path for asset in forest.missing_assets] == ["part.obj"]


def test_a_grammar_without_a_folder_names_the_argument():
    with pytest.raises(DerivationError, match="in Python assets='DIR'"):
        gl.derive(gl.Grammar.parse(RULES), 1, seed=1)


def test_a_folder_that_is_none_is_refused():
    with pytest.raises(UsageError, match=r"assets: expected a folder .* found 'nowhere'"):
        gl.derive(gl.Grammar.parse(RULES), 1, seed=1, assets=Path("nowhere"))


TOY = gl.Grammar.parse("attr height = 3\nLot --> extrude(height) Tower")
FOREST = gl.derive(TOY, 1, seed=1)
MISTAKES = [
    (lambda any_: gl.derive(any_, 1, seed=1), "toy", "grammar: expected Grammar such as gl.load"),
    (lambda any_: gl.sample(any_, 1), "toy", "grammar: expected Grammar"),
    (lambda any_: gl.learn(any_, lambda _: [0.0], 1), "toy", "grammar: expected Grammar"),
    (lambda any_: gl.learn(TOY, any_, 1), "height", "score: expected a function"),
    (lambda any_: gl.derive(TOY, any_, seed=1), "3", "expected 0 models or more, found '3'"),
    (lambda any_: gl.derive(TOY, 1, seed=1, attributes=any_), "height=3", "attributes: expected values by name"),
    (lambda any_: gl.derive(TOY, 1, seed=1, attributes=any_), {"hight": 3}, "unknown attribute hight; .* height"),
    (lambda any_: gl.derive(TOY, 1, seed=1, start_rule=any_), "Lott", "unknown start rule Lott; .* Lot"),
    (lambda any_: gl.derive(TOY, 1, seed=1, footprint=any_), "20x12", "footprint: .* gl.read_footprints"),
    (gl.realize, TOY, "forest: expected Forest such as gl.derive"),
    (gl.render, FOREST, "scene: expected Scene such as gl.realize"),
    (lambda any_: gl.save(any_, "a.glb"), FOREST, "scene: expected Scene such as gl.realize"),
    (gl.extract, TOY, "forests: expected Iterable"),
    (lambda any_: gl.extract([any_]), TOY, r"forests\[0\]: expected Forest"),
    (lambda any_: gl.fit([[1.0]], [3.0], kinds=[any_]), "starz", "kinds: expected score, stars, .* found 'starz'"),
    (
        lambda any_: gl.learn_from_labels("toy", any_, "a.cga", labels_from="a"),
        "a.csv",
        "labels: expected Labels such as gl.read_labels",
    ),
]


@pytest.mark.parametrize(("call", "value", "message"), MISTAKES)
def test_a_wrong_argument_of_a_public_function_is_named_with_a_right_one(call, value, message):
    with pytest.raises(UsageError, match=message):
        call(value)
