"""Words: those for known preferences name what they are about, and little else."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import grammarlab as gl
from grammarlab.density.exact.name_words import MOST_NAMED
from grammarlab.evaluation.preparation import true_scores
from grammarlab.features.patterns.pattern import Draw, Formula
from grammarlab.learning.designs.design_tables import Columns, DesignTable
from grammarlab.learning.designs.pool import Pool
from grammarlab.learning.round import Study, init
from grammarlab.learning.targets.explanation import MAX_PARTS, Words, words_of
from grammarlab.runs.sample.sources import load_source
from tests.cases import takes_turns

SCENARIOS = Path(__file__).parents[3] / "scenarios"


def table_of(rows, names, groups=None):
    groups = np.arange(len(names)) if groups is None else np.array(groups)
    group_names = tuple(f"group {number}" for number in range(int(groups.max()) + 1))
    none = np.zeros((0, len(names)))
    features = tuple(map(Draw, names))
    return DesignTable(Columns(1), rows, none, features, tuple(names), groups, group_names, np.ones(len(names)))


def coins(number, width, seed=0):
    return np.random.default_rng(seed).integers(0, 2, (number, width)).astype(float)


def test_counts_are_no_continuous_columns_however_they_were_scaled():
    scales, counts = np.random.default_rng(0).uniform(1.0, 1e6, 99), np.arange(2e7, 2e7 + 500)[:, None]
    rows = np.column_stack([counts / scales, counts[:, 0] + 0.4])
    table = replace(table_of(rows, [f"n{number}" for number in range(100)]), scales=np.append(scales, 1.0))
    assert not table.continuous[:99].any()
    assert table.continuous[99]


def truth_of(name):
    source = load_source(SCENARIOS / f"{name}.toml")
    study = Study(source.space, Pool(0, 2000))
    made = study.tables().pool_designs
    scores = np.concatenate([true_scores(source, forest) for forest in made.batches])
    return words_of(study.table(init(study)), 100.0 * np.prod(scores / 100.0, axis=1), made.weights)


@takes_turns
@pytest.mark.parametrize(
    ("name", "named"),
    [
        ("F2", {"Finish", "Plan", "UnderRound"}),
        ("L1", {"height"}),
        ("tastes/tuning/xor_furniture", {"Plan", "UnderRound", "Finish"}),
        ("tastes/tuning/additive_skyscraper", {"Ground", "Podium", "Cladding", "Crown", "Tower"}),
        ("tastes/tuning/conjunction_building", {"WallColor", "WallColorPlain", "Building", "MassL"}),
    ],
)
def test_known_preferences_are_told_by_their_own_choices(name, named):
    words = truth_of(name)
    told = set(re.findall(r"[A-Za-z]+", " ".join(words.likes)))
    assert named <= told
    assert 1 <= len(words.likes) <= MAX_PARTS
    assert len(words.dislikes) <= MOST_NAMED
    assert all(text.count(",") < 8 for text in (*words.likes, *words.dislikes))


def test_parts_that_add_up_are_told_with_their_points():
    rows = coins(400, 8)
    words = words_of(
        table_of(rows, [f"Roof → {n}" for n in "abcdefgh"]), 50 + rows @ [30, -20, 0, 15, 0, 0, 0, 0], np.ones(400)
    )
    assert words == Words(("Roof = a (+30)", "Roof = d (+15)"), ("Roof = b (-20)",))


def test_what_is_liked_together_is_told_together():
    rows = coins(400, 6)
    scores = 80.0 * rows[:, 1] * (1.0 - rows[:, 4])
    words = words_of(table_of(rows, ["a", "Wall → Brick", "c", "d", "Roof → Flat", "e"]), scores, np.ones(400))
    assert words.likes == ("Wall = Brick, Roof ≠ Flat (80)",)
    assert set(words.dislikes) == {"Wall ≠ Brick (0)", "Wall = Brick, Roof = Flat (0)"} or set(words.dislikes) == {
        "Roof = Flat (0)",
        "Roof ≠ Flat, Wall ≠ Brick (0)",
    }


def test_counts_and_draws_are_told_with_their_ranges():
    randomness = np.random.default_rng(1)
    rows = np.column_stack([randomness.integers(0, 9, 600), randomness.random(600) * 10.0, coins(600, 1)]).astype(
        np.float64
    )
    table = table_of(rows, ["number of Window", "height", "number of Door"])
    counted = words_of(table, np.where((rows[:, 0] >= 3) & (rows[:, 0] < 7), 100.0, 0.0), np.ones(600))
    assert counted.likes == ("number of Window: 3 to 6 (100)",)
    assert set(counted.dislikes) == {"number of Window: at most 2 (0)", "number of Window: 7 or more (0)"}
    drawn = words_of(table, np.where(rows[:, 1] < 4.0, 70.0, 0.0), np.ones(600))
    assert re.fullmatch(r"height at most (4|4\.0\d?|3\.9\d?) \(70\)", drawn.likes[0])
    assert drawn.lines[1].startswith("Does not like: height at least ")
    assert words_of(table, 60.0 * rows[:, 2], np.ones(600)).lines == (
        "Likes: Door (60).",
        "Does not like: no Door (0).",
    )


def test_comparisons_of_draws_are_told_as_such():
    draws = np.random.default_rng(1).random((600, 2)) * 10.0
    difference = draws[:, 0] - draws[:, 1]
    table = table_of(np.column_stack([draws, difference]), ["a", "b", "a − b"])
    table = replace(table, features=(*table.features[:2], Formula.of("-", Draw("a"), Draw("b"))))

    def words(bound):
        return words_of(table, np.where(difference >= bound, 100.0, 0.0), np.ones(600))

    assert words(0.0013) == Words(("a at least b (100)",), ("a below b (0)",))
    assert words(3.0).likes[0].startswith("a − b: at least ")


def test_statements_are_denied_as_such():
    rows = coins(400, 2)
    table = table_of(rows, ["both towers alike", "number of Bay"])
    assert words_of(table, 80.0 * rows[:, 0], np.ones(400)).dislikes == ("not both towers alike (0)",)
    assert words_of(table, 80.0 * rows[:, 1], np.ones(400)).dislikes == ("no Bay (0)",)


@pytest.mark.parametrize(
    ("name", "denied"),
    [
        ("A → x equal to B → x", "not (A → x equal to B → x)"),
        ("not (A → x and number of B)", "not (not (A → x and number of B))"),
        ("no adjacent A with the same choice", "not no adjacent A with the same choice"),
        ("not a equal to b", "not not a equal to b"),
        ("a and b alike (2)", "not a and b alike (2)"),
        ("a above 0", "not (a above 0)"),
        ("A ≠ x with B = y", "not (A ≠ x with B = y)"),
        ("all adjacent A with the same choice (3)", "not all adjacent A with the same choice (3)"),
    ],
)
def test_formulas_are_denied_as_a_whole(name, denied):
    rows = coins(400, 2)
    table = table_of(rows, [name, "number of Bay"])
    table = replace(table, features=(Formula.of("not", Draw("a")), table.features[1]))
    assert words_of(table, 80.0 * rows[:, 0], np.ones(400)) == Words((f"{name} (80)",), (f"{denied} (0)",))


def test_what_is_too_long_to_be_read_holds_or_does_not():
    rows = coins(400, 2)
    table = table_of(rows, ["a relation of Roof and Wall", "a combination of a and b"])
    assert words_of(table, 80.0 * rows[:, 0], np.ones(400)) == Words(
        ("a relation of Roof and Wall holds (80)",), ("a relation of Roof and Wall does not hold (0)",)
    )
    assert words_of(table, 80.0 * rows[:, 1], np.ones(400)).dislikes == ("a combination of a and b: none (0)",)


def test_sums_of_things_are_told_as_numbers_of_these():
    rows = coins(600, 3)
    table = table_of(
        np.column_stack([rows, rows.sum(axis=1)]), ["a", "b", "c", "number of Door + not number of Bay + A → B"]
    )
    words = words_of(table, np.where(rows.sum(axis=1) >= 2, 100.0, 0.0), np.ones(600))
    assert words == Words(
        ("2 or more of these: Door, no Bay, A = B (100)",), ("at most 1 of these: Door, no Bay, A = B (0)",)
    )


def test_designs_that_cannot_differ_teach_nothing_and_this_is_said():
    grammar = gl.Grammar.parse("attr h = 3\nLot --> extrude(h) A")
    result = gl.learn(grammar, lambda forest: np.full(forest.num_models, 50.0), budget=4, progress=None)
    assert result.predicted.words.likes == ()
    assert result.predicted.words.knowledge[0].startswith("All models are alike: ")


def test_choices_that_models_make_several_times_are_counted_in_words():
    rows = np.random.default_rng(1).integers(0, 5, (600, 1)).astype(np.float64)
    table = table_of(np.column_stack([rows, coins(600, 1)]), ["Range → Deck", "any Quoins → Left and Right"])

    def words(is_liked):
        return words_of(table, np.where(is_liked, 100.0, 0.0), np.ones(600))

    assert words(rows[:, 0] >= 1) == Words(("Range = Deck 1 or more times (100)",), ("Range = Deck never (0)",))
    assert words((rows[:, 0] >= 2) & (rows[:, 0] < 4)).likes == ("Range = Deck 2 to 3 times (100)",)
    assert words(rows[:, 0] == 1).likes == ("Range = Deck once (100)",)
    assert words(rows[:, 0] < 3).likes == ("Range = Deck at most 2 times (100)",)
    assert words(table.rows[:, 1] > 0).likes == ("Quoins = Left and Right (100)",)


def test_quantities_have_their_units():
    """A height, an area of thousands of square metres and an angle, as a person says them."""
    rows = np.random.default_rng(1).random((600, 3)) * [30.0, 4000.0, 60.0]
    table = replace(table_of(rows, ["height", "width · depth", "pitch"]), units=("m", "m²", "°"))

    def liked(is_liked):
        return words_of(table, np.where(is_liked, 100.0, 0.0), np.ones(600)).likes[0]

    assert re.fullmatch(r"height at most 1[12](\.\d)? m \(100\)", liked(rows[:, 0] < 12.0))
    assert re.fullmatch(r"height 9\.?\d* to 1[12](\.\d)? m \(100\)", liked((rows[:, 0] < 12.0) & (rows[:, 0] > 9.0)))
    assert re.fullmatch(r"width · depth: at least 2,\d{3} m² \(100\)", liked(rows[:, 1] > 2500.0))
    assert re.fullmatch(r"pitch at least (30|29\.\d|30\.\d)° \(100\)", liked(rows[:, 2] > 30.0))


def test_tables_of_pairs_are_denied_as_a_whole():
    rows = coins(400, 3)
    one, both = "A = x with B = y / z", "one of these: A = x with B = y, or A ≠ x with B = z"
    table = table_of(rows, [one, both, "number of Door"])
    assert words_of(table, 80.0 * rows[:, 0], np.ones(400)) == Words((f"{one} (80)",), (f"not {one} (0)",))
    denied = "none of these: A = x with B = y, or A ≠ x with B = z (0)"
    assert words_of(table, 80.0 * rows[:, 1], np.ones(400)) == Words((f"{both} (80)",), (denied,))


@pytest.mark.parametrize(
    ("name", "likes", "dislikes"),
    [
        ("A → B + C → B + D → B", "2 or more of A, C, D are B", "at most 1 of A, C, D is B"),
        ("not A → B + not C → B + not D → B", "at most 1 of A, C, D is B", "2 or more of A, C, D are B"),
        (
            "not A → B + C → B + not D",
            "2 or more of these: A ≠ B, C = B, not D",
            "at most 1 of these: A ≠ B, C = B, not D",
        ),
    ],
)
def test_numbers_of_equal_choices_are_told_without_denials(name, likes, dislikes):
    rows = coins(600, 3)
    table = table_of(np.column_stack([rows, rows.sum(axis=1)]), ["a", "b", "c", name])
    words = words_of(table, np.where(rows.sum(axis=1) >= 2, 100.0, 0.0), np.ones(600))
    assert words == Words((f"{likes} (100)",), (f"{dislikes} (0)",))


@pytest.mark.parametrize(
    "name", ["A → B + C → B", "A → B → D + C → B → D", "any A → B + any C → B", "A then C → B + D → B"]
)
def test_numbers_of_what_is_no_choice_are_numbers_of_these(name):
    rows = coins(600, 2)
    sums = rows.sum(axis=1) * (4 if name == "A → B + C → B" else 1)
    likes, *_ = words_of(table_of(sums[:, None], [name]), np.where(sums > 0, 100.0, 0.0), np.ones(600)).likes
    assert " or more of these: " in likes


def test_one_of_equal_choices_is_the_value():
    rows = coins(600, 2)
    table = table_of(np.column_stack([rows, rows.sum(axis=1)]), ["ab", "bb", "A → B + C → B"])
    words = words_of(table, np.where(rows.sum(axis=1) == 1, 100.0, 0.0), np.ones(600))
    assert words.likes == ("1 of A, C is B (100)",)


def test_where_all_the_denied_choices_are_wanted_none_is_the_value():
    rows = coins(600, 3)
    table = table_of(np.column_stack([rows, rows.sum(axis=1)]), ["ab", "bb", "cb", "not A → B + not C → B + not D → B"])
    words = words_of(table, np.where(rows.sum(axis=1) <= 2, 100.0, 0.0), np.ones(600))
    assert words.likes == ("1 or more of A, C, D are B (100)",)
    assert words.dislikes == ("none of A, C, D are B (0)",)


@pytest.mark.parametrize("scores", [np.zeros(50), np.full(50, 100.0)])
def test_where_all_are_alike_there_is_nothing_to_tell(scores):
    assert words_of(table_of(coins(50, 3), ["a", "b", "c"]), scores, np.ones(50)).lines == ()


def test_nothing_that_cannot_be_made_is_told():
    rows = coins(100, 3)
    weights = 1.0 - rows[:, 0]
    assert words_of(table_of(rows, ["a", "b", "c"]), 100.0 * rows[:, 0], weights).lines == ()
    words = words_of(table_of(rows, ["a", "b", "c"]), 100.0 * np.maximum(rows[:, 0], rows[:, 1]), weights)
    assert words.lines == ("Likes: b (100).", "Does not like: no b (0).")
