"""Rules of families as a reader finds them: in place if they are used once, from the whole to its parts, with names."""

import re

from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.facade.grammar.family import write_family
from grammarlab.facade.grammar.rule_text import nested, renamed, split_body, top_down
from grammarlab.language.formatting import WIDTH, format_grammar
from grammarlab.language.grammar import Grammar
from tests.facade.grammar.houses import house, of_columns
from tests.facade.grammar.test_exact import pictured


@st.composite
def rule_sets(draw: st.DrawFn) -> dict[str, str]:
    """Rules each of which uses earlier ones, with long and short numbers."""
    rules = {"Wall": 'color("#ffffff") primitiveCube()'}
    for index in range(draw(st.integers(1, 12))):
        uses = draw(st.lists(st.sampled_from(sorted(rules)), min_size=1, max_size=4))
        sizes = draw(st.lists(st.sampled_from(["1", "~1.234567"]), min_size=len(uses), max_size=len(uses)))
        body = split_body(draw(st.sampled_from("xy")), list(zip(sizes, uses, strict=True)))
        body = uses[0] if len(uses) == 1 and draw(st.booleans()) else body
        setup = draw(
            st.sampled_from(["", "", "setupProjection(0, scope.xy, 20.075018, 25.631944, -0.025032, -22.00246) "])
        )
        rules[f"Cell{index}"] = setup + body
    return rules


def whole(rules: dict[str, str], body: str) -> str:
    """A body with all that is in it, down to walls."""
    inner = {
        name: whole(rules, text) for name, text in rules.items() if name != "Wall" and re.search(rf"\b{name}\b", body)
    }
    return renamed(body, inner)


@settings(max_examples=15)
@given(rule_sets())
def test_nesting_changes_no_rule_and_adds_no_line(rules: dict[str, str]) -> None:
    last = list(rules)[-1]
    short = nested(rules, set(rules) - {"Wall", last})
    assert last in short
    assert all(whole(short, body) == whole(rules, rules[name]) for name, body in short.items())
    before, after = (
        format_grammar(Grammar.parse("\n".join(f"{name} --> {body}" for name, body in each.items())))
        for each in (rules, short)
    )
    num_before, num_after = (sum(map(bool, text.splitlines())) for text in (before, after))
    assert num_after <= num_before
    if max(map(len, after.splitlines())) > WIDTH:
        assert max(map(len, after.splitlines())) <= max(map(len, before.splitlines()))


@settings(max_examples=15)
@given(rule_sets())
def test_rules_come_after_those_that_use_them_first(rules: dict[str, str]) -> None:
    last = list(rules)[-1]
    order = list(top_down(rules, [last]))
    assert order[0] == last
    for index, name in enumerate(order[1:], start=1):
        assert any(re.search(rf"\b{name}\b", rules[user]) for user in order[:index])


def test_areas_are_called_by_their_column_and_floor() -> None:
    text = write_family(pictured(house(columns=5, rows=4)), (5.0, 20.0), (6.0, 16.0)).text
    names = [line.split(" -->")[0] for line in text.splitlines() if " -->" in line]
    assert {"WindowColumnFloor2", "DoorColumnFloor2", "PierFloor2"} <= set(names)
    assert names.index("DoorColumn") < names.index("DoorColumnFloor2") < names.index("Wall")


def test_numbers_of_names_have_no_gaps() -> None:
    facade = pictured(of_columns(["WBWDWBW", "WBWWWBW"]))
    text = write_family(facade, (5.0, 20.0), (3.0, 9.0)).text
    names = {line.split(" -->")[0] for line in text.splitlines() if " -->" in line}
    for name in names:
        if numbered := re.fullmatch(r"(\w*Cell)(\d+)", name):
            before = int(numbered[2]) - 1
            assert numbered[1] + (str(before) if before > 1 else "") in names
