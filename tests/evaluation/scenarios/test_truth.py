"""The preferences in scenarios/ against hand-labelled trees and against truth functions in plain Python."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from grammarlab.derivation import Forest, derive, derive_chunks
from grammarlab.evaluation.scenario import load
from grammarlab.features.patterns.counts import count
from grammarlab.language.grammar import Grammar
from grammarlab.learning.designs.flattening import flattened
from grammarlab.learning.targets.divergence import jensen_shannon
from grammarlab.runs.sample.shipped import find_rules
from tests.cases import some, takes_turns
from tests.evaluation.scenarios.forests import forest_of
from tests.evaluation.scenarios.truth import TRUTH, Model, models

ROOT = Path(__file__).parents[3]
SCENARIOS = {path.stem: load(path) for path in sorted((ROOT / "scenarios").glob("*.toml"))}
SCENARIOS = {name: scenario for name, scenario in SCENARIOS.items() if find_rules(scenario.grammar).suffix == ".cga"}


@cache
def grammar(name: str) -> Grammar:
    return Grammar.parse((ROOT / "grammars" / f"{name}.cga").read_text())


def scores(forest: Forest, name: str) -> list[float]:
    score = SCENARIOS[name].score
    return score.evaluate(count(forest, score.features)).tolist()


# Trees labelled by hand ----------------------------------------------------------------------------------------------


def table(legs: int, base: int | None, plan: int = 0, finish: int = 0, parts: str = "", style: int = 0) -> str:
    """A table with a branch of each of its rules, ``style`` that of the rule that shapes its legs."""
    under = "Support:0" if base is None else f"Support:1(BaseFinish:0(Base:{base}))"
    shape = f"{('OneLeg', 'TwoLegs', 'FourLegs')[legs]}:{style}"
    legs_and_base = f"Under:0({under} LegFinish:0(LegCount:{legs}({shape})))"
    return f"Table(Finish:{finish}(Plan:{plan}({legs_and_base} TopFinish:0(Top:0) {parts})))"


def building(mass: str, floors: str, *parts: str) -> str:
    return f"Lot(Building:{['MassRectangle', 'MassL', 'MassU'].index(mass)}({mass}({floors}(" + " ".join(parts) + "))))"


def tower(*blocks: tuple[int, int]) -> str:
    names = ("BoxBlock", "CylinderBlock", "VBlock")
    inner = " ".join(f"Block:{shape}({names[shape]}(Glass:{glass} Frame))" for shape, glass in blocks)
    return f"Lot(Tower:{len(blocks) - 1}({inner} Crown:0))"


def styled(style: str, **other: str) -> tuple[str, ...]:
    return tuple(part + other.get(part, style) for part in ("WallColor", "GroundFloor", "UpperFloors", "Roof"))


def plane(*styles: str) -> str:
    engine = styles[3] + ("Engine" if styles[3] in {"Biplane", "Fokker"} else "Engines")
    return f"Airplane({styles[0]}Body {styles[1]}Wings {styles[2]}Tail {engine} {styles[4]}Gear)"


HAND_LABELLED = {
    "F1": [
        (table(0, 1, style=0), 70),  # a round column on a plate
        (table(0, 1, style=3), 70),  # turned
        (table(0, 1, style=1), 0),  # square
        (table(0, 1, style=2), 0),  # tapered
        (table(0, 2, style=1), 70),  # a square column on a cross
        (table(0, 2, style=2), 70),
        (table(0, 2, style=0), 0),
        (table(0, 2, style=3), 0),
        (table(0, 4, style=0), 70),  # a plinth suits every column
        (table(0, 4, style=1), 70),
        (table(0, None), 0),  # on the floor: tips over
        (table(0, 0), 0),  # on pads at the corners
        (table(0, 3), 0),
        (table(1, 3), 20),  # two legs on runners
        (table(1, 3, style=1), 20),
        (table(1, 4), 20),  # on a plinth
        (table(1, None), 0),
        (table(1, 1), 0),
        (table(2, None), 10),  # four legs on the floor
        (table(2, None, style=4), 10),
        (table(2, 0), 10),
        (table(2, 3), 10),
        (table(2, 1), 0),  # four legs around a plate in the middle
        (table(2, 2), 0),
    ],
    "F2": [
        (table(0, 1, plan=0, finish=0), 60),  # round, light
        (table(0, 0, plan=0, finish=0), 60),  # whether it stands or not
        (table(0, 1, plan=1, finish=1), 40),  # rectangular, dark
        (table(0, 1, plan=1, finish=0), 0),
        (table(0, 1, plan=0, finish=1), 0),
        (table(0, 1, plan=2, finish=0), 0),  # oval
        (table(0, 1, plan=0, finish=0, parts="Edge:0 ShelfFinish:1"), 60),
        (table(0, 1, plan=0, finish=0, parts="Edge:4"), 60),  # a brass edge changes nothing
        (table(0, 1, plan=0, finish=0, parts="ShelfFinish:2"), 60),
        (table(0, 1, plan=1, finish=1, parts="ShelfFinish:2"), 40),
    ],
    "F3": [
        (table(0, 1, finish=2), 70),  # steel
        (table(0, None, finish=2), 0),  # steel, but falls
        (table(0, 2, finish=2), 0),  # steel, but a round column on a cross
        (table(0, 1, finish=0), 30),
        (table(0, 1, finish=1), 30),
        (table(0, 1, finish=0, parts="Edge:2"), 30),
        (table(0, 1, finish=2, parts="Edge:2"), 70),  # a wooden edge changes nothing
        (table(0, 1, finish=3), 0),  # paint
    ],
    "F4": [
        (table(2, None, 0), 70),
        (table(2, None, 1), 30),
        (table(2, None, 2), 0),
        (table(2, 1, 0), 0),
        (table(0, 1, 0, style=1), 0),
    ],
    "F2_parts": [
        (table(0, 1, plan=0, finish=0), 60),  # round, light
        (table(0, 0, plan=0, finish=0), 60),  # whether it stands or not
        (table(0, 1, plan=1, finish=1), 40),  # rectangular, dark
        (table(0, 1, plan=1, finish=0), 0),
        (table(0, 1, plan=0, finish=1), 0),
        (table(0, 1, plan=2, finish=0), 0),  # oval
        (table(0, 1, plan=0, finish=0, parts="Edge:0 ShelfFinish:1"), 60),  # a light shelf on a light table
        (table(0, 1, plan=0, finish=0, parts="Edge:4"), 0),  # a brass edge
        (table(0, 1, plan=0, finish=0, parts="ShelfFinish:2"), 0),
        (table(0, 1, plan=1, finish=1, parts="ShelfFinish:2"), 40),
    ],
    "F3_parts": [
        (table(0, 1, finish=2), 70),  # steel
        (table(0, None, finish=2), 0),  # steel, but falls
        (table(0, 2, finish=2), 0),  # steel, but a round column on a cross
        (table(0, 1, finish=0), 30),
        (table(0, 1, finish=1), 30),
        (table(0, 1, finish=0, parts="Edge:2"), 30),  # two woods are wood
        (table(0, 1, finish=2, parts="Edge:2"), 0),  # steel and wood are neither
        (table(0, 1, finish=3), 0),  # paint
    ],
    "F3xF4": [
        (table(0, 1, plan=0, finish=2), 49),
        (table(0, 1, plan=0, finish=0), 21),
        (table(0, 1, plan=1, finish=2), 21),
        (table(0, 1, plan=1, finish=1), 9),
        (table(0, 0, plan=0, finish=2), 0),
        (table(0, 1, plan=3, finish=2), 0),
    ],
    "B1": [
        (building("MassL", "Big", *styled("Office")), 40),
        (building("MassU", "Small", *styled("Paris")), 20),
        (building("MassL", "Big", *styled("Plain")), 20),
        (building("MassL", "Big", *styled("Old")), 20),
        (building("MassL", "Big", *styled("Office", GroundFloor="Paris")), 0),
        (building("MassL", "Big", *styled("Old", Roof="Plain")), 0),
    ],
    "B2": [
        (building("MassL", "Big"), 50),
        (building("MassRectangle", "Small"), 50),
        (building("MassRectangle", "Big"), 0),
        (building("MassL", "Small"), 0),
        (building("MassL", "Medium"), 0),
        (building("MassU", "Big"), 0),
    ],
    "B3": [(building("MassL", "Big"), 60), (building("MassRectangle", "Big"), 40), (building("MassU", "Big"), 0)],
    "B4": [(building("MassL", "Big"), 80), (building("MassU", "Small"), 20), (building("MassL", "Medium"), 0)],
    "S1": [
        (tower((0, 5)), 60),
        (tower((0, 5), (0, 1), (0, 0)), 60),
        (tower((2, 5), (2, 1)), 20),
        (tower((1, 5), (1, 5), (1, 5), (1, 5)), 20),
        (tower((0, 5), (1, 5)), 0),
        (tower((2, 5), (0, 5), (2, 5)), 0),
    ],
    "S2": [
        (tower((0, 5)), 100),
        (tower((0, 5), (2, 1)), 100),
        (tower((1, 5), (0, 1)), 50),
        (tower((2, 5), (0, 1), (0, 1)), 0),
    ],
    "A1": [
        (plane("Biplane", "Biplane", "Biplane", "Biplane", "Biplane"), 100),
        (plane("Biplane", "Fokker", "Biplane", "Fokker", "Biplane"), 100),  # both are old
        (plane("Airliner", "Jet", "Transport", "Airliner", "Jet"), 50),
        (plane("Airliner", "Jet", "Transport", "Fokker", "Jet"), 0),
        (plane("Biplane", "Biplane", "Biplane", "Biplane", "Jet"), 0),
    ],
    "L1": [("$width=9 $depth=9 $height=4.99 Lot(Box)", 100), ("$width=1 $depth=1 $height=5 Lot(Box)", 0)],
    "L2": [("$width=5 $depth=5 $height=4.99 Lot(Box)", 100), ("$width=5 $depth=5 $height=5 Lot(Box)", 0)],
    # 1 + 43 / 11 = 4.909, 1 + 44 / 11 = 5
    "L1_discrete": [("$width=99 $depth=99 $height=43 Lot(Box)", 100), ("$width=0 $depth=0 $height=44 Lot(Box)", 0)],
    "L2_discrete": [("$width=44 $depth=44 $height=43 Lot(Box)", 100), ("$width=44 $depth=44 $height=44 Lot(Box)", 0)],
    "L3": [
        (tower((0, 5), (0, 5), (1, 0)), 50),
        (tower((2, 5), (0, 5), (0, 2)), 30),
        (tower((0, 0), (0, 0), (0, 1)), 20),
        (tower((0, 0), (0, 0), (0, 4)), 0),
        (tower((0, 0), (0, 0)), 0),
        (tower((0, 0), (0, 0), (0, 0), (0, 0)), 0),
    ],
    "L4": [
        (tower((0, 2), (1, 0)), 100),  # black cylinder on a green box
        (tower((2, 5), (0, 2), (1, 0), (2, 5)), 100),
        (tower((0, 2), (1, 0), (0, 1), (1, 0)), 0),  # and another one on a blue box
        (tower((0, 2), (1, 0), (0, 1), (1, 3)), 100),  # that one is bronze
        (tower((0, 2), (1, 3)), 0),
        (tower((1, 2), (1, 0)), 0),
        (tower((0, 2), (2, 5), (1, 0)), 0),  # not directly above
        (tower((1, 0), (0, 2)), 0),  # below
        (tower((0, 0), (1, 2)), 0),
        (tower((0, 1), (1, 0)), 0),
    ],
    "L4_relation": [
        (tower((0, 5), (1, 5)), 100),
        (tower((2, 5), (0, 1), (1, 0)), 100),
        (tower((1, 5), (0, 5)), 0),
        (tower((0, 5), (2, 5), (1, 5)), 0),
    ],
    "L5": [
        ("Lot(GildedSteps GildedColumns GildedBeams GildedRoof GildedFinial)", 100),
        ("Lot(GildedSteps GildedColumns PlainBeams GildedRoof GildedFinial)", 0),
        ("Lot(PlainSteps PlainColumns PlainBeams PlainRoof PlainFinial)", 0),
    ],
}


def test_every_scenario_has_hand_labelled_trees_and_a_truth_function():
    assert set(SCENARIOS) == set(HAND_LABELLED) == set(TRUTH)
    for name, scenario in SCENARIOS.items():
        assert name == scenario.name
        labels = {label for _, label in HAND_LABELLED[name]}
        if len(scenario.factors) == 1:
            assert labels == set(scenario.score.levels)


@pytest.mark.parametrize("name", SCENARIOS)
def test_hand_labelled_trees_get_their_labels(name):
    trees, labels = zip(*HAND_LABELLED[name], strict=True)
    assert dict(zip(trees, scores(forest_of(*trees), name), strict=True)) == dict(zip(trees, labels, strict=True))


# Against plain Python ------------------------------------------------------------------------------------------------


@cache
def sample(name: str) -> tuple[tuple[Forest, Forest], list[Model]]:
    """500 models, half of them with equally likely alternatives so that rare ones are among them."""
    assets = ROOT / "grammars" / "assets"
    forest = derive(grammar(name), 250, 7, assets=assets)
    rare = derive(flattened(grammar(name)).program, 250, 8, assets=assets)
    return (forest, rare), [*models(forest), *models(rare)]


@pytest.mark.parametrize("name", some(list(SCENARIOS)))
@takes_turns
def test_500_models_get_the_score_that_plain_python_gives_them(name):
    forests, trees = sample(SCENARIOS[name].grammar)
    expected = [TRUTH[name](tree) for tree in trees]
    assert set(expected) >= set(SCENARIOS[name].score.levels)
    assert np.allclose([score for forest in forests for score in scores(forest, name)], expected, rtol=0, atol=1e-9)


# As hard as the paper's ----------------------------------------------------------------------------------------------


@cache
def labelled(name: str) -> dict[str, np.ndarray]:
    """The true scores of the labelled set of every scenario about a grammar."""
    wanted = [s for s in SCENARIOS.values() if s.grammar == name and s.draws == "grammar"]
    assert {(s.num_models, s.seed) for s in wanted} == {(5000, 0)}
    chunks = derive_chunks(grammar(name), 5000, 0, assets=ROOT / "grammars" / "assets")
    parts = [[scores(forest, s.name) for s in wanted] for forest in chunks]
    return {s.name: np.concatenate([part[i] for part in parts]) for i, s in enumerate(wanted)}


@pytest.mark.parametrize("name", [name for name, s in SCENARIOS.items() if s.paper.original])
def test_the_grammar_is_as_far_from_the_preference_as_the_papers(name):
    original = jensen_shannon(labelled(SCENARIOS[name].grammar)[name], np.ones(5000))
    assert original == pytest.approx(SCENARIOS[name].paper.original, rel=0.1)


def test_all_eleven_preferences_of_the_papers_table_are_there():
    assert sum(s.paper.original is not None for s in SCENARIOS.values()) == 11


def test_the_rare_style_has_probability_one_in_100000():
    flat = flattened(grammar("limits_rare"))
    forest = derive(flat.program, 2000, 3)
    wanted = np.array(scores(forest, "L5")) > 0
    log_ratio = flat.log_ratio(forest)
    # The flattened grammar makes it with probability 1 / 32, and every such model stands for 32e-5 of them.
    np.testing.assert_allclose(log_ratio[wanted], np.log(32e-5))
    assert 30 < wanted.sum() < 100
    assert np.exp(log_ratio).mean() == pytest.approx(1, abs=0.2)
