"""Words: those for known preferences name what they are about, and little else."""

import re
from dataclasses import replace
from itertools import combinations, product
from pathlib import Path

import numpy as np
import pytest

import grammarlab as gl
from grammarlab.arrays import Floats
from grammarlab.evaluation.preparation import true_scores
from grammarlab.features.columns.column_names import FeatureNames
from grammarlab.features.columns.formula_names import MOST_NAMED, formula_words
from grammarlab.features.expression import Expression
from grammarlab.features.patterns.operations import evaluate
from grammarlab.features.patterns.pattern import Draw, Formula, Pattern
from grammarlab.language.display_names import DisplayNames
from grammarlab.learning.designs.design_tables import Columns, DesignTable
from grammarlab.learning.designs.pool import Pool
from grammarlab.learning.round import Study, init
from grammarlab.learning.targets.explanation import MAX_PARTS, Words, _ColumnWords, _Range, words_of
from grammarlab.learning.targets.statements import shown
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
        ("tastes/tuning/additive_skyscraper", {"Ground", "Podium", "Cladding", "Mast", "Tower"}),
        ("tastes/tuning/conjunction_building", {"WallColor", "WallColorPlain", "Building", "MassL", "Big"}),
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
    assert words == Words(("Wall = Brick, Roof ≠ Flat (80; others 0)",), ())


def test_counts_and_draws_are_told_with_their_ranges():
    randomness = np.random.default_rng(1)
    rows = np.column_stack([randomness.integers(0, 9, 600), randomness.random(600) * 10.0, coins(600, 1)]).astype(
        np.float64
    )
    table = table_of(rows, ["number of Window", "height", "number of Door"])
    counted = words_of(table, np.where((rows[:, 0] >= 3) & (rows[:, 0] < 7), 100.0, 0.0), np.ones(600))
    assert counted == Words(("number of Window: 3 to 6 (100; others 0)",), ())
    drawn = words_of(table, np.where(rows[:, 1] < 4.0, 70.0, 0.0), np.ones(600))
    assert re.fullmatch(r"height at most (4|4\.0\d?|3\.9\d?) \(70; others 0\)", drawn.likes[0])
    assert words_of(table, 60.0 * rows[:, 2], np.ones(600)).lines == ("Likes: Door (60; others 0).",)
    assert words_of(table, 60.0 * (1.0 - rows[:, 2]), np.ones(600)).lines == ("Does not like: Door (0; others 60).",)


@pytest.mark.parametrize("name", ["number of Door", "Door"])
def test_numbers_of_parts_are_told_as_parts_that_are_there_or_not(name):
    rows = np.random.default_rng(1).integers(0, 4, (600, 1)).astype(np.float64)
    table = replace(table_of(rows, [name]), features=(Pattern("Door"),))

    def words(is_liked):
        return words_of(table, np.where(is_liked, 100.0, 0.0), np.ones(600))

    assert words(rows[:, 0] >= 1) == Words(("Door (100; others 0)",), ())
    assert words(rows[:, 0] == 0) == Words((), ("Door (0; others 100)",))
    assert words(rows[:, 0] >= 2) == Words(("number of Door: 2 or more (100; others 0)",), ())


def test_comparisons_of_draws_are_told_as_such():
    draws = np.random.default_rng(1).random((600, 2)) * 10.0
    difference = draws[:, 0] - draws[:, 1]
    table = table_of(np.column_stack([draws, difference]), ["a", "b", "a − b"])
    table = replace(table, features=(*table.features[:2], Formula.of("-", Draw("a"), Draw("b"))))

    def words(bound):
        return words_of(table, np.where(difference >= bound, 100.0, 0.0), np.ones(600))

    assert words(0.0013) == Words(("a at least b (100; others 0)",), ())
    assert words(3.0).likes[0].startswith("a − b: at least ")


def denial_of(name, feature=None):
    """What words say of designs without a property."""
    rows = coins(400, 2)
    table = table_of(rows, [name, "number of Bay"])
    if feature is not None:
        table = replace(table, features=(feature, table.features[1]))
    told = (f"{name} (80; others 0)", f"{name}: 1 (80; others 0)")
    assert set(words_of(table, 80.0 * rows[:, 0], np.ones(400)).likes) <= set(told)
    (kind,) = words_of(table, 80.0 * (1.0 - rows[:, 0]) * rows[:, 1], np.ones(400)).likes
    assert kind.startswith("Bay, ")
    assert kind.endswith(" (80; others 0)")
    return kind.removeprefix("Bay, ").removesuffix(" (80; others 0)")


def test_statements_are_denied_as_such():
    assert denial_of("both towers alike") == "not both towers alike"
    assert denial_of("Wall = Brick beside Wall = Glass") == "Wall = Brick not beside Wall = Glass"


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
    assert denial_of(name, Formula.of("not", Draw("a"))) == denied


def test_what_is_too_long_to_be_read_holds_or_does_not():
    assert denial_of("a combination of a and b") == "a combination of a and b: none"
    rows = coins(400, 2)
    words = words_of(table_of(rows, ["a relation of Roof and Wall", "b"]), 80.0 * rows[:, 0], np.ones(400))
    assert words == Words(("a relation of Roof and Wall holds (80; others 0)",), ())


def test_sums_of_things_are_told_as_numbers_of_these():
    rows = coins(600, 3)
    table = table_of(
        np.column_stack([rows, rows.sum(axis=1)]), ["a", "b", "c", "number of Door + not number of Bay + A → B"]
    )
    words = words_of(table, np.where(rows.sum(axis=1) >= 2, 100.0, 0.0), np.ones(600))
    assert words == Words(("2 or more of these: Door, no Bay, A = B (100; others 0)",), ())


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

    assert words(rows[:, 0] >= 1) == Words(("Range = Deck (100; others 0)",), ())
    assert words(rows[:, 0] == 0) == Words((), ("Range = Deck (0; others 100)",))
    assert words((rows[:, 0] >= 2) & (rows[:, 0] < 4)).likes == ("Range = Deck 2 to 3 times (100; others 0)",)
    assert words(rows[:, 0] == 1).likes == ("Range = Deck once (100; others 0)",)
    assert words(rows[:, 0] < 3).likes == ("Range = Deck at most 2 times (100; others 0)",)
    assert words(table.rows[:, 1] > 0).likes == ("Quoins = Left and Right (100; others 0)",)


def test_quantities_have_their_units():
    """A height, an area of thousands of square metres and an angle, as a person says them."""
    rows = np.random.default_rng(1).random((600, 3)) * [30.0, 4000.0, 60.0]
    table = replace(table_of(rows, ["height", "width · depth", "pitch"]), units=("m", "m²", "°"))

    def liked(is_liked):
        return words_of(table, np.where(is_liked, 100.0, 0.0), np.ones(600)).likes[0]

    assert re.fullmatch(r"height at most 1[12](\.\d)? m \(100; others 0\)", liked(rows[:, 0] < 12.0))
    assert re.fullmatch(
        r"height 9\.?\d* to 1[12](\.\d)? m \(100; others 0\)", liked((rows[:, 0] < 12.0) & (rows[:, 0] > 9.0))
    )
    assert re.fullmatch(r"width · depth: at least 2,\d{3} m² \(100; others 0\)", liked(rows[:, 1] > 2500.0))
    assert re.fullmatch(r"pitch at least (30|29\.\d|30\.\d)° \(100; others 0\)", liked(rows[:, 2] > 30.0))


def test_tables_of_pairs_are_denied_as_a_whole():
    one, both = "A = x with B = y / z", "one of these: A = x with B = y, or A ≠ x with B = z"
    assert denial_of(one) == f"not {one}"
    assert denial_of(both) == f"none{both.removeprefix('one')}"


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
    assert words in (Words((f"{likes} (100; others 0)",), ()), Words((), (f"{dislikes} (0; others 100)",)))


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
    assert words.likes == ("1 of A, C is B (100; others 0)",)


def test_where_all_the_denied_choices_are_wanted_none_is_the_value():
    rows = coins(600, 3)
    table = table_of(np.column_stack([rows, rows.sum(axis=1)]), ["ab", "bb", "cb", "not A → B + not C → B + not D → B"])
    words = words_of(table, np.where(rows.sum(axis=1) <= 2, 100.0, 0.0), np.ones(600))
    assert words == Words(("1 or more of A, C, D are B (100; others 0)",), ())


@pytest.mark.parametrize("scores", [np.zeros(50), np.full(50, 100.0)])
def test_where_all_are_alike_there_is_nothing_to_tell(scores):
    assert words_of(table_of(coins(50, 3), ["a", "b", "c"]), scores, np.ones(50)).lines == ()


def test_nothing_that_cannot_be_made_is_told():
    rows = coins(100, 3)
    weights = 1.0 - rows[:, 0]
    assert words_of(table_of(rows, ["a", "b", "c"]), 100.0 * rows[:, 0], weights).lines == ()
    words = words_of(table_of(rows, ["a", "b", "c"]), 100.0 * np.maximum(rows[:, 0], rows[:, 1]), weights)
    assert words.lines == ("Likes: b (100; others 0).",)


def designs_of(kind, rows):
    """Which designs a kind is about, read from its words."""
    is_in = np.ones(len(rows), dtype=bool)
    for condition in kind.split(", "):
        has = rows[:, "abcd".index(condition.removeprefix("no "))] > 0.0
        is_in &= ~has if condition.startswith("no ") else has
    return is_in


def differing(kind, other):
    """Conditions on four properties that two kinds do not share, as properties."""
    return {condition[-1] for condition in set(kind.split(", ")) ^ set(other.split(", "))}


@pytest.mark.parametrize("levels", [[0.0, 0.0, 100.0], [0.0, 1.0, 40.0, 42.0, 100.0]])
@pytest.mark.parametrize("seed", range(40))
def test_kinds_are_true_and_none_follows_from_the_others(seed, levels):
    """Scores of random tables of four properties: every mean is that of the designs, and nothing is said twice."""
    randomness = np.random.default_rng(seed)
    rows = coins(300, 4, seed)
    values: Floats = randomness.choice(levels, 16).astype(float)
    scores = values[(rows @ [8, 4, 2, 1]).astype(int)]
    words = words_of(table_of(rows, list("abcd")), scores, np.ones(300))
    sides = [
        [re.fullmatch(r"(.*) \((\d+)(?:; others (\d+))?\)", kind) for kind in side]
        for side in (words.likes, words.dislikes)
    ]
    described = np.zeros((2, 300), dtype=int)
    for number, side in enumerate(sides):
        for match in side:
            assert match
            is_in = designs_of(match[1], rows)
            described[number] += is_in
            assert scores[is_in].mean() == pytest.approx(float(match[2]), abs=0.51)
            if match[3]:
                assert scores[~is_in].mean() == pytest.approx(float(match[3]), abs=0.51)
                assert len(words.likes) + len(words.dislikes) == 1
        for one, other in combinations(filter(None, side), 2):
            is_one_apart = one[1].count(",") == other[1].count(",") and len(differing(one[1], other[1])) == 1
            assert not is_one_apart or abs(float(one[2]) - float(other[2])) >= 3.0
    assert described.sum(axis=0).max(initial=0) <= 1
    is_all = (described.sum(axis=0) == 1).all()
    assert not is_all or min(len(words.likes), len(words.dislikes)) != 1


@pytest.mark.parametrize(
    ("operation", "holds", "told"),
    [
        ("!=", lambda a, b: a != b, "A = x or B = y but not both"),
        ("==", lambda a, b: a == b, "both or neither of A = x and B = y"),
        ("or", lambda a, b: (a + b) > 0, "A = x or B = y"),
        ("*", lambda a, b: (a * b) > 0, "A = x and B = y"),
        ("+", lambda a, b: (a + b) > 0, "A = x or B = y"),
    ],
)
def test_formulas_of_choices_are_told_by_the_choices(operation, holds, told):
    rows = coins(600, 2) if operation != "+" else np.eye(3)[np.random.default_rng(1).integers(0, 3, 600)][:, :2]
    column = holds(rows[:, 0], rows[:, 1]).astype(float)
    features = Pattern("A", branch=(0,)), Pattern("B", branch=(0,))
    names = ["A → x", "B → y", "a formula"]
    table = replace(
        table_of(np.column_stack([rows, column]), names), features=(*features, Formula.of(operation, *features))
    )
    assert words_of(table, 100.0 * column, np.ones(600)) == Words((f"{told} (100; others 0)",), ())


def test_a_number_that_counts_beside_a_property_is_told_with_it():
    rows = np.column_stack([coins(600, 1), np.random.default_rng(1).integers(1, 6, (600, 1))]).astype(np.float64)
    product = rows[:, 0] * rows[:, 1]
    features = Pattern("Mast"), Pattern("Block")
    names = ["number of Mast", "number of Block", "a formula"]
    table = replace(table_of(np.column_stack([rows, product]), names), features=(*features, Formula.of("*", *features)))
    words = words_of(table, np.where(product >= 3, 100.0, 0.0), np.ones(600))
    assert words == Words(("Mast, number of Block: 3 or more (100; others 0)",), ())


@pytest.mark.parametrize("properties", [1, 2])
def test_a_number_beside_properties_is_told_with_them_where_it_is_no_column_of_its_own(properties):
    rows = np.column_stack([coins(900, properties), np.random.default_rng(1).integers(0, 5, 900)])
    value = rows.prod(axis=1)
    features = tuple(Draw(name, 1) for name in ("tone", "finish")[:properties])
    formula = Pattern("Floor")
    for feature in features:
        formula = Formula.of("*", feature, formula)
    names = [f"{feature.site} = 1" for feature in features]
    table = table_of(np.column_stack([rows[:, :-1], value]), [*names, "a product"])
    table = replace(table, features=(*features, formula))
    words = words_of(table, np.where(value >= 3, 100.0, 0.0), np.ones(900))
    assert words.likes == (f"{', '.join(reversed(names))}, number of Floor: 3 or more (100; others 0)",)


@pytest.mark.parametrize("operation", ["*", "/"])
def test_products_and_quotients_of_things_that_are_there_or_not_say_that_all_are(operation):
    rows = coins(600, 2)
    features = (Pattern("Wall", branch=(0,)), Draw("tone", 1))
    table = table_of(np.column_stack([rows, rows.prod(axis=1)]), ["Wall → Brick", "tone = 1", "both"])
    table = replace(table, features=(*features, Formula.of(operation, *features)))
    words = words_of(table, 100.0 * rows.prod(axis=1), np.ones(600))
    assert words.likes in (("Wall = Brick and tone = 1 (100; others 0)",), ("Wall = Brick, tone = 1 (100; others 0)",))


@pytest.mark.parametrize(
    ("least", "low", "high", "told"),
    [
        (1, -np.inf, 2.5, "Ground = alternative 1 / alternative 2"),
        (1, 2.5, np.inf, "Ground = alternative 3"),
        (0, 1.5, np.inf, "Ground = alternative 2 / alternative 3"),
        (0, -np.inf, 1.5, "Ground ≠ alternative 2 and Ground ≠ alternative 3"),
    ],
)
def test_numbers_of_alternatives_are_told_as_the_alternatives(least, low, high, told):
    branches, rows = alternatives_of_one_place(np.eye(4)[np.random.default_rng(1).integers(least, 4, 900)][:, 1:])
    condition = condition_of_first(first_of(branches, rows, branches), low, high)
    assert shown(condition, DisplayNames({}, {}, {})) == told


def alternatives_of_one_place(rows):
    return [Pattern("Ground", branch=(branch,)) for branch in range(rows.shape[1])], rows


def first_of(features, rows, operands, groups=None):
    """A table of alternatives, and of the number of the first one of some operands that a design has."""
    formula = Formula.of("which", *operands)
    values = {feature: rows[:, column] for column, feature in enumerate(features)}
    number = evaluate(formula.steps, values, len(rows))
    groups = [*(groups or [0] * len(features)), 99]
    names = [FeatureNames()[feature] for feature in features]
    table = table_of(np.column_stack([rows, number]), [*names, "Ground"], groups)
    return replace(table, features=(*features, formula))


def condition_of_first(table, low, high):
    column = len(table.names) - 1
    return _ColumnWords(table, table.values(len(table.rows)), DisplayNames({}, {}, {})).condition(
        _Range(column, low, high)
    )


@pytest.mark.parametrize(("low", "high"), [(-np.inf, 1.5), (1.5, np.inf), (0.5, 2.5)])
def test_positions_of_several_things_at_once_are_no_alternatives(low, high):
    """The first of several floors that are offices says nothing about the floors after it."""
    floors, rows = [Pattern(f"F{number}", branch=(0,)) for number in (1, 2, 3)], coins(600, 3)
    assert "alternative" not in condition_of_first(first_of(floors, rows, floors, [0, 1, 2]), low, high).text
    exclusive = np.eye(4)[np.random.default_rng(1).integers(0, 4, 600)][:, 1:]
    assert "alternative" not in condition_of_first(first_of(floors, exclusive, floors, [0, 1, 2]), low, high).text
    branches, rows = alternatives_of_one_place(rows)
    assert "alternative" not in condition_of_first(first_of(branches, rows, branches), low, high).text


def test_alternatives_are_told_only_if_all_are_known_and_once():
    branches, rows = alternatives_of_one_place(np.eye(4)[np.random.default_rng(1).integers(0, 4, 600)][:, 1:])
    first, second, third = branches
    unknown = first_of(branches, rows, [first, Formula.of("not", second), third])
    assert "alternative" not in condition_of_first(unknown, 0.5, 2.5).text
    some = first_of(branches, rows, [first, 0.0, third])
    assert condition_of_first(some, 0.5, np.inf).text.count("Ground = ") == 2
    twice = first_of(branches, rows, [first, first, second])
    assert condition_of_first(twice, 0.5, 2.5).text == "Ground = alternative 1"


def test_a_full_sum_of_things_that_are_there_or_not_says_that_all_are():
    rows = coins(600, 2)
    features = (Pattern("Wall", branch=(0,)), Draw("tone", 1))
    value = rows[:, 0] + (1.0 - rows[:, 1])
    formula = Formula.of("+", features[0], Formula.of("not", features[1]))
    table = table_of(np.column_stack([rows, value]), ["Wall → Brick", "tone = 1", "Wall → Brick + (not tone = 1)"])
    table = replace(table, features=(*features, formula))
    condition = _ColumnWords(table, table.values(600), DisplayNames({}, {}, {})).condition
    assert condition(_Range(2, 1.5, np.inf)).text == "Wall = Brick and tone ≠ 1"
    assert condition(_Range(2, -np.inf, 1.5)).text == "Wall ≠ Brick or tone = 1"
    assert condition(_Range(2, 0.5, np.inf)).text != "Wall = Brick and tone ≠ 1"


@pytest.mark.parametrize("most", [1, 3])
def test_what_a_function_draws_several_times_is_no_property(most):
    """Three draws of 0 and one floor are three, and so are two draws and a mast: neither says what is there."""
    randomness = np.random.default_rng(1)
    draws, floors, masts = randomness.integers(0, [most + 1, 5, 2], (900, 3)).astype(np.float64).T
    draw, floor, mast = Draw("f#1", 0), Pattern("Floor"), Pattern("Mast")
    product, total, alone = Formula.of("*", draw, floor), Formula.of("+", mast, draw), Formula.of("not", draw)
    rows = np.column_stack([draws, floors, masts, draws * floors, masts + draws, draws == 0.0])
    names = ["f#1 = 0", "number of Floor", "number of Mast", "a product", "number of Mast + f#1 = 0", "no draw"]
    table = replace(table_of(rows, names), features=(draw, floor, mast, product, total, alone))
    condition = _ColumnWords(table, rows, DisplayNames({}, {}, {})).condition
    is_property = most == 1
    assert condition(_Range(3, 2.5, np.inf)).text.startswith("f#1 = 0, ") == is_property
    assert (condition(_Range(4, 1.5, np.inf)).text == "Mast and f#1 = 0") == is_property
    assert condition(_Range(5, 0.5, np.inf)).text == ("f#1 ≠ 0" if is_property else "f#1 = 0 never")


def test_two_sets_of_parts_are_told_as_their_column_is_called():
    parts = [Pattern("A"), Pattern("B", branch=(0,)), Pattern("C")]
    formula = Expression.parse("({A} + {B:0}) and {C}").formula
    rows, names = coins(600, 3), [FeatureNames()[part] for part in parts]
    value = (rows[:, 0] + rows[:, 1]) * rows[:, 2] > 0.0
    name = formula_words(formula, FeatureNames())
    table = replace(table_of(np.column_stack([rows, value]), [*names, name]), features=(*parts, formula))
    condition = _ColumnWords(table, table.values(600), DisplayNames({}, {}, {})).condition
    assert condition(_Range(3, 0.5, np.inf)).text == name == "(A or B = alternative 1) and C"


def test_what_is_there_or_not_is_named_rather_than_a_number_that_says_the_same():
    rows = coins(600, 2)
    table = table_of(np.column_stack([2.0 * rows[:, 0], rows]), ["number of Bay", "number of Balconies", "number of X"])
    table = replace(table, features=(Pattern("Bay"), Pattern("Balconies"), Pattern("X")))
    assert words_of(table, 100.0 * rows[:, 0], np.ones(600)).likes == ("Balconies (100; others 0)",)


def test_the_least_number_that_occurs_is_told_as_it_is():
    rows = np.random.default_rng(1).integers(1, 4, (600, 1)).astype(np.float64)
    words = words_of(table_of(rows, ["number of kinds of Block"]), np.where(rows[:, 0] < 2, 100.0, 0.0), np.ones(600))
    assert words == Words(("number of kinds of Block: 1 (100; others 0)",), ())


def test_one_of_two_alternatives_is_named_rather_than_denied():
    """A and B have two alternatives each; where neither matters, only a part that is there or not can be missing."""
    rows = np.array([[a, 1 - a, b, 1 - b, c] for a, b, c in product((0, 1), repeat=3)] * 50, dtype=float)
    table = table_of(rows, ["A → x", "A → y", "B → x", "B → y", "c"], [0, 0, 1, 1, 2])
    for column, value in product(range(2), repeat=2):
        scores = 80.0 * (rows[:, 0] == value) * (rows[:, 2] == column) * rows[:, 4]
        kinds = words_of(table, scores, np.ones(400)).likes
        assert kinds == (f"A = {'yx'[value]}, B = {'yx'[column]}, c (80; others 0)",) or {
            *kinds[0].removesuffix(" (80; others 0)").split(", ")
        } == {f"A = {'yx'[value]}", f"B = {'yx'[column]}", "c"}


def things_of_formulas():
    """Names of a part and of the alternatives of three choices."""
    places = [(place, number, value) for place in "ABC" for number, value in enumerate("VW")]
    alternatives = {f"{place} → {value}": Pattern(place, branch=(number,)) for place, number, value in places}
    return {"number of Big": Pattern("Big"), **alternatives}


def wild_words(identifiers, randomness):
    """Words for identifiers that hold what connects the parts of sentences, no two with the same beginning or end."""
    parts = [" or ", " and ", ", ", " = ", " ≠ ", " / ", " (+3)", "; others 2)", " with ", " of these: ", " brick"]
    return {
        identifier: f"{index}“{''.join(randomness.choice(parts, 3))}”{index}"
        for index, identifier in enumerate(identifiers)
    }


def allowed(condition, places):
    """A place and the values there with which a condition holds."""
    place, sign, values = condition.split(" ", 2)
    assert sign in ("=", "≠")
    return place, {value for value in places[place] if (value in values.split(" / ")) == (sign == "=")}


@pytest.mark.parametrize("seed", range(60))
def test_what_is_said_of_choices_is_true_whatever_they_are_called(seed):
    """Random tables of choices, and random words with what connects the parts of sentences."""
    randomness = np.random.default_rng(seed)
    places = {place: [f"{place}{number}" for number in range(randomness.integers(2, 6))] for place in ("A", "B", "C")}
    names = [f"{place} → {value}" for place, values in places.items() for value in values]
    designs = [dict(zip(places, values, strict=True)) for values in product(*places.values())] * 4
    rows = np.array([[float(design[name[0]] == name[4:]) for name in names] for design in designs])
    levels = randomness.choice([0.0, 0.0, 1.0, 40.0, 80.0, 81.0], (2, *map(len, places.values())))
    scores = np.tile(levels.max(axis=0).ravel() if seed % 2 else levels[0].ravel(), 4)
    table = table_of(rows, names, [list(places).index(name[0]) for name in names])
    words = words_of(table, scores, np.ones(len(rows)))
    for kind in (*words.likes, *words.dislikes):
        if match := re.fullmatch(r"(.*) \((\d+)(?:; others (\d+))?\)", kind):
            conditions = [allowed(condition, places) for condition in match[1].split(", ")]
            is_in = np.array([all(design[place] in values for place, values in conditions) for design in designs])
            assert scores[is_in].mean() == pytest.approx(float(match[2]), abs=0.51)
            assert match[3] is None or scores[~is_in].mean() == pytest.approx(float(match[3]), abs=0.51)
    wild = wild_words([*places, *(value for values in places.values() for value in values)], randomness)
    called = words_of(table, scores, np.ones(len(rows)), display=DisplayNames(wild, {}, {}))
    for side, expected in ((called.likes, words.likes), (called.dislikes, words.dislikes)):
        assert side == tuple(re.sub(r"\b[ABC]\d?\b", lambda name: wild[name[0]], kind) for kind in expected)


@pytest.mark.parametrize("seed", range(100))
def test_what_is_said_of_random_formulas_is_the_same_whatever_their_things_are_called(seed):
    randomness = np.random.default_rng(seed)
    things = things_of_formulas()
    rows = coins(400, len(things), seed)

    def text(depth):
        if depth == 0 or randomness.random() < 0.2:
            return f"{{{randomness.choice(list(map(str, things.values())))}}} > 0"
        negation, sign = randomness.choice(["", "", "not "]), randomness.choice(["and", "or", "or", "==", "!="])
        return f"{negation}(({text(depth - 1)}) {sign} ({text(depth - 1)}))"

    formula = Expression.parse(text(3)).formula
    order = [list(map(str, things.values())).index(str(feature)) for feature in formula.features]
    holds = (Expression.of(formula).evaluate(rows[:, order]) > 0.0).astype(float)
    table = table_of(np.column_stack([rows, holds]), [*things, str(formula)])
    table = replace(table, features=(*things.values(), formula))
    words = words_of(table, 100.0 * holds, np.ones(400))
    wild = wild_words(["Big", "A", "B", "C", "V", "W"], randomness)
    called = words_of(table, 100.0 * holds, np.ones(400), display=DisplayNames(wild, {}, {}))
    for side, expected in ((called.likes, words.likes), (called.dislikes, words.dislikes)):
        assert side == tuple(re.sub(r"\b(Big|[ABCVW])\b", lambda name: wild[name[0]], kind) for kind in expected)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{Big} > 0 or {A:0} > 0 or {B:1} > 0", "Big or Old roof = V or New roof = W"),
        ("{A:0} > 0 or {A:1} > 0", "Old roof = V / W"),
        ("{A:0} > 0 or {B:0} > 0 or {C:0} > 0", "Old, New or Low roof = V"),
        ("({A:0} > 0 and {B:1} > 0) or {C:1} > 0", "(Old roof = V and New roof = W) or Low roof = W"),
    ],
)
def test_alternatives_name_what_they_share_once(text, words):
    things = things_of_formulas()
    rows = coins(400, len(things))
    formula = Expression.parse(text).formula
    order = [list(map(str, things.values())).index(str(feature)) for feature in formula.features]
    holds = Expression.of(formula).evaluate(rows[:, order])
    table = table_of(np.column_stack([rows, holds]), [*things, text])
    table = replace(table, features=(*things.values(), formula))
    display = DisplayNames({"A": "Old roof", "B": "New roof", "C": "Low roof"}, {}, {})
    assert words_of(table, 100.0 * holds, np.ones(400), display=display).likes == (f"{words} (100; others 0)",)


@pytest.mark.parametrize(
    ("name", "likes", "dislikes"),
    [
        ("number of kinds of W", "W (100; others 0)", "W (0; others 100)"),
        ("number of these: A and B", "one of these: A and B (100; others 0)", "one of these: A and B (0; others 100)"),
    ],
)
def test_a_number_that_is_at_most_one_is_what_is_there(name, likes, dislikes):
    rows = coins(400, 1)
    assert words_of(table_of(rows, [name]), 100.0 * rows[:, 0], np.ones(400)) == Words((likes,), ())
    assert words_of(table_of(rows, [name]), 100.0 - 100.0 * rows[:, 0], np.ones(400)) == Words((), (dislikes,))
