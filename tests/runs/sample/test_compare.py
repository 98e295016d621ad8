"""Comparing grammars: exact where both make trees of one grammar, and otherwise never more than can be shown."""

import math

import pytest

from grammarlab.errors import UsageError
from grammarlab.learning.targets.divergence import jensen_shannon
from grammarlab.runs.learn.from_scenario import learn_from_scenario
from grammarlab.runs.sample.comparison import compare_files

HOUSE = """version "2023.0"
Lot --> {low}% : Low else : High
Low --> NIL
High --> 50% : Wall. else : Glass.
"""


STYLES = """version "2023.0"
Lot --> Wall Door Colour
Wall --> 40% : OldWall else : NewWall
Door --> 40% : OldDoor else : NewDoor
Colour --> 50% : Red else : Green
"""


@pytest.fixture
def file(tmp_path):
    def write(name, text):
        path = tmp_path / f"{name}.cga"
        path.write_text(text)
        return str(path)

    return write


def nats(p, q):
    """Divergence of a choice of two, once with probability p and once with q."""
    total = 0.0
    for a, b in ((p, q), (1 - p, 1 - q)):
        middle = (a + b) / 2
        total += sum(x * math.log(x / middle) / 2 for x in (a, b) if x > 0)
    return total


def test_a_grammar_is_not_apart_from_itself(file):
    one = file("one", HOUSE.format(low=40))
    result = compare_files(one, one)
    assert (result.js, result.at_least, result.differences) == (0.0, 0.0, ())


def test_percentages_decide_the_divergence(file):
    result = compare_files(file("one", HOUSE.format(low=20)), file("two", HOUSE.format(low=70)), num_models=20_000)
    assert result.js == pytest.approx(nats(0.2, 0.7), abs=0.005)
    assert result.at_least == pytest.approx(nats(0.2, 0.7), abs=0.01)
    assert {found.symbol for found in result.differences} >= {"Low", "High"}


def test_the_choices_that_differ_are_told(file):
    result = compare_files(file("one", HOUSE.format(low=20)), file("two", HOUSE.format(low=70)), num_models=5_000)
    assert result.origin == "one"
    (choice,) = result.choices
    assert (choice.symbol, choice.line) == ("Lot", 2)
    assert [branch.makes for branch in choice.branches] == ["Low", "High"]
    assert [branch.second for branch in choice.branches] == pytest.approx([0.7, 0.3], abs=0.03)


def test_two_learned_grammars_are_compared_as_trees_of_the_one_they_came_from(file, tmp_path):
    common = file("house", STYLES)
    for name, liked in (("old", "{OldWall} == {OldDoor}"), ("new", "{Red}")):
        (tmp_path / f"{name}.toml").write_text(
            f'name = "{name}"\ntitle = "T"\ngrammar = "house.cga"\nnum_models = 100\n'
            f'[[preference]]\nscore = 9\nwhen = "{liked}"\n'
        )
        learn_from_scenario(common, tmp_path / f"{name}.toml", "compile", tmp_path / f"{name}.cga")
    old, new = (str(tmp_path / f"{name}.cga") for name in ("old", "new"))
    result = compare_files(old, new, num_models=20_000)
    assert result.origin == "house"
    # By hand: wall, door and colour of all kinds of houses.
    q = {"OOr": 0.16, "ONr": 0.24, "NOr": 0.24, "NNr": 0.36}
    p = {"OOr": 0.08 / 0.52, "OOg": 0.08 / 0.52, "NNr": 0.18 / 0.52, "NNg": 0.18 / 0.52}
    keys = sorted(p | q)
    wanted = jensen_shannon([p.get(key, 0.0) for key in keys], [q.get(key, 0.0) for key in keys])
    assert result.js == pytest.approx(wanted, abs=0.006)
    (tmp_path / "house.cga").write_text(STYLES + "// changed")
    assert compare_files(old, new, num_models=200).js is None


def test_numbers_that_differ_are_told(file):
    rules = "attr height = rand({}, 9)\nLot --> extrude(height) Wall"
    one, two = file("one", rules.format(1)), file("two", rules.format(5))
    result = compare_files(one, two, num_models=4_000)
    assert result.js == pytest.approx(nats(0.0, 0.5), abs=0.01)
    (number,) = result.numbers
    assert (number.attribute, round(number.first), round(number.second)) == ("height", 5, 7)


def test_the_order_of_the_grammars_does_not_matter(file):
    one, two = file("one", HOUSE.format(low=20)), file("two", HOUSE.format(low=70))
    assert compare_files(one, two).js == pytest.approx(compare_files(two, one).js)


def test_grammars_with_other_rules_are_compared_by_what_they_share(file):
    other = HOUSE.format(low=40).replace("Glass", "Timber").replace("Low --> NIL", "Low --> Cellar.")
    result = compare_files(file("one", HOUSE.format(low=40)), file("two", other))
    assert result.js is None
    assert result.at_least < 0.003
    assert set(result.only_first) == {"Glass."}
    assert set(result.only_second) == {"Timber.", "Cellar."}


def test_a_missing_grammar_is_told(file):
    with pytest.raises(UsageError, match="no rule file"):
        compare_files(file("one", HOUSE.format(low=40)), "nowhere.cga")
