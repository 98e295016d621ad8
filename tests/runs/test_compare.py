"""Comparing grammars: exact where only percentages differ, and otherwise never more than can be shown."""

import math

import pytest

from grammarlab.errors import UsageError
from grammarlab.runs.compare import compare_grammars

HOUSE = """version "2023.0"
Lot --> {low}% : Low else : High
Low --> NIL
High --> 50% : Wall. else : Glass.
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
    result = compare_grammars(one, one)
    assert (result.js, result.at_least, result.differences) == (0.0, 0.0, ())


def test_percentages_decide_the_divergence(file):
    result = compare_grammars(file("one", HOUSE.format(low=20)), file("two", HOUSE.format(low=70)), num_models=20_000)
    assert result.js == pytest.approx(nats(0.2, 0.7), abs=0.005)
    assert result.at_least == pytest.approx(nats(0.2, 0.7), abs=0.01)
    assert {found.symbol for found in result.differences} >= {"Low", "High"}


def test_the_order_of_the_grammars_does_not_matter(file):
    one, two = file("one", HOUSE.format(low=20)), file("two", HOUSE.format(low=70))
    assert compare_grammars(one, two).js == pytest.approx(compare_grammars(two, one).js)


def test_grammars_with_other_rules_are_compared_by_what_they_share(file):
    other = HOUSE.format(low=40).replace("Glass", "Timber").replace("Low --> NIL", "Low --> Cellar.")
    result = compare_grammars(file("one", HOUSE.format(low=40)), file("two", other))
    assert result.js is None
    assert result.at_least < 0.003
    assert set(result.only_first) == {"Glass."}
    assert set(result.only_second) == {"Timber.", "Cellar."}


def test_a_missing_grammar_is_told(file):
    with pytest.raises(UsageError, match="no rule file"):
        compare_grammars(file("one", HOUSE.format(low=40)), "nowhere.cga")
