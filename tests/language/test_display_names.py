"""Words for what grammars name."""

import numpy as np
import pytest

import grammarlab as gl
from grammarlab.language.display_names import DisplayNames, color_word

NAMES = DisplayNames.of(
    gl.Grammar.parse("""
@DisplayName("Pitch of the roof") attr roofPitch = rand(20, 50)
attr GFA_total = 3
attr tone = 50% : "#8E4B38" else : "#C0C4C8"
attr lightRed = .8
attr lightGreen = .7
attr steel = .5
Lot --> 30% : Low(2) 30% : Low(3) else : case GFA_total > 2 : GroundFloor else : NIL
Low(n) --> WallColor
GroundFloor -->
    50% : GroundFloorShop
    else : GroundFloorOfficeHall
GroundFloorShop --> case true : NIL else : X.
WallColor -->
    30% : color("#ff0000") Wall
    30% : color("#0000ff") Wall
    else : i("asset/oldWall.obj") Wall
Finish -->
    18% : color(lightRed, lightGreen, 0) Wall
    82% : color(steel, steel, 0) Wall
groundfloor --> Wall
""").tree
)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("roofPitch below 30", "Pitch of the roof below 30"),
        ("2 · roofPitch − GFA_total", "2 · Pitch of the roof − GFA total"),
        ("number of GroundFloorShop", "number of Ground floor shop"),
        ("GroundFloor = GroundFloorShop, Wall ≠ Lot", "Ground floor = Shop, Wall ≠ Lot"),
        ("GroundFloor 2 → GroundFloorOfficeHall", "Ground floor 2 → Office hall"),
        ("GroundFloor = GroundFloorShop and WallColor", "Ground floor = Ground floor shop and Wall color"),
        ("WallColor = 30%, line 15", "Wall color = red"),
        ("Lot › WallColor → line 16 (60)", "Lot › Wall color → blue (60)"),
        ("WallColor (40%) › Wall", "Wall color (old wall) › Wall"),
        ("WallColor → 30%", "Wall color → 30%"),
        ("Finish → 18%, Finish = 82%", "Finish → light, Finish = steel"),
        ("tone = 0, tone ≠ 1 (−5)", "tone = brown, tone ≠ light grey (−5)"),
        ("unknownName 7%", "unknownName 7%"),
        (
            "GroundFloor = GroundFloorShop / GroundFloorOfficeHall with tone ≠ 0 / 1",
            "Ground floor = Shop / Office hall with tone ≠ brown / light grey",
        ),
        ("WallColor = line 16 / 30%, Finish ≠ 18% / 82%", "Wall color = blue / 30%, Finish ≠ light / steel"),
        ("#8E4B38, x.WallColor", "#8E4B38, x.WallColor"),
        ("GroundFloor#2 above 3, Wall = tex#1.png", "Ground floor (draw 2) above 3, Wall = tex#1.png"),
    ],
)
def test_identifiers_become_words(name, words):
    assert NAMES.text(name) == words


def test_branches_that_differ_in_numbers_of_a_colour_are_called_after_it():
    text = """attr tone = rand(0.9, 1.1)
Glass -->
    30% : color(0.05 * tone, 0.05 * tone, 0.06) Pane
    30% : color(0.1, 0.2 * tone, 0.6) Pane
    else : color(tone * 0.1, 0.4, 0.1) Pane
Frame --> 50% : color(0.1, 0.2 * (1 - tone), 0.3) Bar else : color(2, 0.9, 0.9) Bar"""
    branches = DisplayNames.of(gl.Grammar.parse(text).tree).branches
    assert [branches["Glass", f"line {line}"] for line in (3, 4, 5)] == ["black", "blue", "green"]
    assert [word for (symbol, _), word in branches.items() if symbol == "Frame"] == ["tone"]


def test_two_identifiers_never_get_the_same_words():
    names = DisplayNames.of(gl.Grammar.parse("attr roofPitch = 1\nattr roof_pitch = 2\nLot --> RoofPitch").tree)
    assert names.text("roofPitch, roof_pitch, RoofPitch") == "roofPitch, roof_pitch, Roof pitch"


@pytest.mark.parametrize("given", ["", "  ", r"a\tb"])
def test_an_empty_or_unprintable_name_is_no_name(given):
    names = DisplayNames.of(gl.Grammar.parse(f'@DisplayName("{given}") attr roofPitch = 1\nLot --> NIL').tree)
    assert names.text("roofPitch") == "roof pitch"


def test_a_long_name_is_cut():
    names = DisplayNames.of(gl.Grammar.parse(f'@DisplayName("{"x" * 9999}") attr h = 1\nLot --> NIL').tree)
    assert names.text("h") == "x" * 60


@pytest.mark.parametrize("name", ["building", "furniture", "quarter", "toy"])
def test_the_columns_of_shipped_grammars_stay_distinguishable(name):
    grammar = gl.load(name)
    table = gl.extract(gl.derive(grammar, 60, seed=1))
    names = DisplayNames.of(grammar.tree)
    words = [names.text(each) for each in table.names]
    assert len(set(words)) == len(words)


@pytest.mark.parametrize(
    ("color", "word"),
    [("#000000", "black"), ("#ffffff", "white"), ("#ff0000", "red"), ("#ff00aa", "pink"), ("#808080", "grey")],
)
def test_colors_have_words(color, word):
    assert color_word(color) == word


@pytest.mark.parametrize("seed", range(20))
def test_branches_have_the_same_words_on_one_line_as_on_several(seed):
    randomness = np.random.default_rng(seed)
    colors = randomness.permutation(["#ff0000", "#0000ff", "#00ff00", "#ffffff", "#000000"])
    shares = randomness.choice([10, 20], 3)
    branches = [f'{share}% : color("{color}") X.' for share, color in zip(shares, colors, strict=False)]
    branches.append(f'else : {{}} color("{colors[3]}") X.')

    def words(separator):
        choice = separator.join(branches).format(f"case h > 5 : X. Y.{separator}else :")
        grammar = gl.Grammar.parse(f"attr h = rand(1, 9)\nLot --> Wall\nWall -->{separator}{choice}")
        table = gl.extract(gl.derive(grammar, 200, seed=1))
        names = list(map(DisplayNames.of(grammar.tree).text, table.names))
        assert len(set(names)) == len(names)
        return [name for name in names if " → " in name]

    assert words(" ") == words("\n    ")
    assert len([name for name in words(" ") if name.endswith(tuple(map(color_word, colors)))]) >= 3


@pytest.mark.parametrize("identifier", ["groundFloor2", "GFA_total", "OldHTMLWall", "X", "wallX", "a2b", "ABc12D"])
def test_words_are_those_of_any_alphabet(identifier):
    """Small and capital letters that are put for others, one for one, change no word but in its letters."""
    ours = "abcdefghijklmnopqrstuvwxyz"
    greek, accented = "αβγδεζηθικλμνξοπρστυφχψω", "äöüéèêàâáçñåøõôóòíìîúùûýþ"

    def words(name):
        return DisplayNames.of(gl.Grammar.parse(f"attr {name} = 1\nLot --> NIL").tree).text(name)

    for other in (greek + "ыю", accented + "ů"):
        table = str.maketrans(ours + ours.upper(), other + other.upper())
        assert words(identifier.translate(table)) == words(identifier).translate(table)


def test_words_are_not_replaced_again():
    text = """Lot --> 50% : print("Roof or Wall = Hip#2, 50%") X. else : print("Hip") X.
@DisplayName("Wall") Roof --> 50% : Hip else : Flat
@DisplayName("Roof") Wall --> X."""
    names = DisplayNames.of(gl.Grammar.parse(text).tree)
    assert names.text("Lot = line 1 branch 1, Roof ≠ Hip, Wall") == "Lot = Roof or Wall = Hip#2, 50%, Wall ≠ Hip, Roof"


def test_branches_of_overloads_that_one_name_means_have_no_words():
    text = """Lot --> Wall(1) Wall(1, 2)
Wall(a) --> 30% : color("#ff0000") X. else : color("#00ff00") X.
Wall(a, b) --> 30% : color("#0000ff") X. 20% : color("#ffffff") X. else : color("#000000") X."""
    names = DisplayNames.of(gl.Grammar.parse(text).tree)
    assert names.text("Wall = 30%, Wall = 70%, Wall = 20%") == "Wall = 30%, Wall = green, Wall = white"


BRANCHES = """
attr shape = "auto"
attr gap = 20% : 0 else : rand(3, 6)
const plain = false
attr lit = 50% : true else : plain
finish = 50% : -1.5 else : rand(2)
Lot --> extrude(gap) Plan Side Höfe
Plan -->
    case shape == "left" : Wing("l")
    else :
        case geometry.area > 9 : 50% : Wing("l") else : Wing("r")
        else : 50% : Wing("l") 30% : Wing("r") else : split(x) { ~1 : lib.Court }
Side -->
    30% : Faces
    30% : split(x) { '0.5 : Faces }
    else : s('1, '0.5, '1) Faces
Höfe -->
    40% : shapeL(2, 3) { shape : Körper }
    else : shapeU(2, 3, 2) { shape : Körper }
Wing(o) --> X.
Faces --> X.
"""


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("Plan = line 11 branch 2", "Plan = Wing l (line 11)"),
        ("Plan = line 12 branch 4", "Plan = Wing l (line 12)"),
        ("Plan = line 12 branch 6", "Plan = Court"),
        ("Side = line 14, Side = line 15, Side ≠ line 16", "Side = Faces (alone), Side = split, Side ≠ size"),
        ("Höfe → 40%, Höfe → 60%", "Höfe → shape L, Höfe → shape U"),
        ("gap#1 = 0 and gap#1 ≠ 1", "gap = 0 and gap ≠ 3 to 6"),
        ("gap#2 at least 4", "gap (draw 2) at least 4"),
        ("gap#1 = 0 / 1", "gap = 0 / 3 to 6"),
        ("gap#2 ≠ 0 / 1", "gap (draw 2) ≠ alternative 1 / alternative 2"),
        ("lit = 0, lit = 1", "lit = true, lit = plain"),
        ("finish#1 = 0 (90), finish#1 = 1", "finish = -1.5 (90), finish = 0 to 2"),
    ],
)
def test_branches_that_only_their_siblings_distinguish_have_words(name, words):
    assert DisplayNames.of(gl.Grammar.parse(BRANCHES).tree).text(name) == words


def test_a_leaf_that_is_called_after_a_rule_has_its_words():
    names = DisplayNames.of(gl.Grammar.parse("Lot --> 50% : GreenSpace else : X.\nGreenSpace --> GreenSpace.").tree)
    assert names.text("Lot ≠ GreenSpace") == "Lot ≠ Green space"


def words_in(rules, name):
    return DisplayNames.of(gl.Grammar.parse(rules).tree).text(name)


def test_values_are_those_of_the_draw_that_a_number_means():
    """Draws are numbered over all overloads of a function, also those below conditions."""
    rules = """f(a) = case a > 1 : 50% : 1 else : 2 else : 3
f(a, b) = 50% : 7 else : 8
Lot --> extrude(f(2) + f(1, 2)) X."""
    assert words_in(rules, "f#1 = 0, f#2 ≠ 1") == "f (draw 1) = alternative 1, f (draw 2) ≠ alternative 2"


@pytest.mark.parametrize(
    ("first", "second", "words"),
    [
        ("0.25", "1.75", "0.25, 1.75"),
        ("12.125", "12.5", "12.125, 12.5"),
        ("100000", "123456", "100,000, 123,456"),
        ("1234567", "1234568", "1,234,567, 1,234,568"),
        ("0.00001", "1/3", "0.00001, 0.333333"),
        ("rand(1.5, 12.75)", "rand(6, 3)", "1.5 to 12.75, 3 to 6"),
        ("rand(-2)", "rand(2)", "-2 to 0, 0 to 2"),
        ('"v1.25"', '"v1.5"', "v1.25, v1.5"),
        ('"1/2"', '"A / B"', "1/2, A / B"),
        ('"oldWall.obj"', '"maps/newWall"', "old wall, new wall"),
        (f'"{"x" * 60}a"', f'"{"x" * 60}b"', "alternative 1, alternative 2"),
        ("3 + Lot.h", "4", "3 + area, 4"),
        ("(other - 1) * other + 0.5", "rint(rand(2, 5))", "(other - 1) · other + 0.5, 2 to 5"),
        ("other / 2", "4", "alternative 1, alternative 2"),
        ("sqrt(Lot.h)", "4", "alternative 1, alternative 2"),
        (" + ".join(["other"] * 9), "4", "alternative 1, alternative 2"),
    ],
)
def test_values_are_told_as_they_are_written(first, second, words):
    rules = f"attr h = 50% : {first} else : {second}\nattr other = 3\nLot --> extrude(h) X."
    rules = rules.replace("Lot.h", "geometry.area")
    assert words_in(rules, "h = 0") == f"h = {words.split(', ')[0]}"
    assert words_in(rules, "h = 1") == f"h = {words.split(', ')[1]}"


def test_values_of_the_only_choice_below_conditions_have_words():
    rules = 'use = case geometry.area > 30 : "Any" else : 80% : "Home" else : "Shop"\nLot --> print(use) X.'
    assert words_in(rules, "use = 0, use ≠ 1") == "use = Home, use ≠ Shop"
    two = rules.replace('"Any"', '50% : "Any" else : "None"')
    assert words_in(two, "use#1 = 0, use#2 = 0") == "use (draw 1) = alternative 1, use (draw 2) = alternative 1"


def test_numbers_of_successors_keep_their_digits():
    rules = "Lot --> 40% : Low(2.25) 30% : Low(2.5) else : Low(1000000)\nLow(a) --> X."
    names = (f"Lot = line 1 branch {number}" for number in (1, 2, 3))
    assert [words_in(rules, name) for name in names] == ["Lot = Low 2.25", "Lot = Low 2.5", "Lot = Low 1,000,000"]


@pytest.mark.parametrize(
    "body",
    [
        "case geometry.area > 9 : 50% : A else : B else : 50% : A else : B",
        "case geometry.area > 9 :\n 50% : A else : B\n else : 50% : A\n else : B",
        "case geometry.area > 9 : A else : 50% : A else : B",
        "40% : A 30% : only_A else : A B",
        "40% : A 30% : only_A A else : A A",
    ],
)
def test_words_of_the_branches_of_a_rule_are_unique(body):
    names = DisplayNames.of(gl.Grammar.parse(f"Lot --> {body}\nA --> X.\nB --> X.\nonly_A --> Y.").tree)
    words = [word for (_, key), word in names.branches.items() if key.startswith("line")]
    assert len(words) >= 2
    assert len(set(words)) == len(words)


def test_the_only_random_one_of_branches_of_one_word_has_no_line():
    rules = """Lot -->
    case geometry.area > 9 :
        case geometry.area > 20 : A
        else : B
    else : 50% : A else : B
A --> X.
B --> X."""
    assert words_in(rules, "Lot = line 5 branch 3, Lot = line 3") == "Lot = A, Lot = A (line 3)"


def test_only_is_said_as_no_identifier_reads():
    rules = "Lot --> 50% : A else : A A\nA --> 50% : only_A(1) else : only_A(1) B\nonly_A(a) --> Y."
    assert words_in(rules, "Lot = line 1 branch 1, A = line 2 branch 1") == "Lot = A (alone), A = only A (alone)"


def test_a_leaf_that_is_called_after_its_own_rule_is_named_whole():
    rules = "Lot --> 50% : GreenSpace else : X.\nGreenSpace --> 50% : GreenSpace. else : Other."
    assert (
        words_in(rules, "GreenSpace = GreenSpace., GreenSpace ≠ Other.")
        == "Green space = Green space, Green space ≠ Other"
    )
