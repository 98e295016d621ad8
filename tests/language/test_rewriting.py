"""Text surgery on rule files."""

import re

import pytest

from grammarlab.language.checking.percentages import probabilities
from grammarlab.language.grammar import Grammar
from grammarlab.language.rewriting import (
    Chances,
    Conditions,
    RuleCopy,
    Same,
    Text,
    choice_text,
    likely_last,
    rewrite,
)
from grammarlab.language.syntax.syntax_tree import Case, Invoke, Sequence, Stochastic, walk
from grammarlab.runs.sample.shipped import shipped_examples

HOUSE = """version "2023.0"
// The file.

attr height = 3 // metres

// Begin here.
@StartRule
Lot -->
\t30% : extrude(height) House
\telse : case height > 2 : [ Tree ] Tree
\t       case height > 1 : Bush

// A house.
House(a, b) -->
\tsplit(x) { ~1 : Wall /* left */ | { 2 : Window(a) }* | ~1 : Wall } // done

Tree --> 50% : Oak else : Elm
"""


def choice_of(text, name):
    """The percentages of a rule, None for ``else``, and its branches."""
    choice = Grammar.parse(text).rules[name, 0].body
    assert isinstance(choice, Stochastic)
    return [getattr(percentage, "value", None) for percentage in choice.percentages], choice.branches


def places(text, name):
    """Where a successor is named, in the order of the text."""
    return [node.location for node in walk(Grammar.parse(text).tree) if isinstance(node, Invoke) and node.name == name]


def test_nothing_to_do_changes_nothing():
    assert rewrite(Grammar.parse(HOUSE), {}) == HOUSE


ODD_LAYOUT = """Lot -->
  case scope.sx > 9 :  // wide ones

\t\t60%  :Wide /* w */
\t\telse : Narrow // n
  else :
      case scope.sy > 2 : 50% : Tall else : Low
      // the others
      else: 30%: [ Flat ]
            else: NIL

Wide --> 20% : A 30% : B
\telse : C
"""


def as_it_is(choice, path=()):
    """The body of a rule with its own percentages; None without constant ones, or with one choice just in another."""
    if not isinstance(choice, Case | Stochastic):
        return Text(path, {})
    bodies = [as_it_is(branch, (*path, i)) for i, branch in enumerate(choice.branches)]
    if None in bodies:
        return None
    if isinstance(choice, Case):
        return Same(path, tuple(bodies))
    shares = probabilities(choice)
    if shares is None or min(shares) < 1e-3 or any(isinstance(body, Chances) for body in bodies):
        return None
    return Chances(tuple(zip(shares, bodies, strict=True)))


@pytest.mark.parametrize("text", [ODD_LAYOUT, *(source.text() for source in shipped_examples())])
def test_rules_with_their_own_percentages_keep_their_layout(text):
    """New percentages are the only difference for a reader of a pull request: lines, indents and comments stay."""
    grammar = Grammar.parse(text)
    bodies = {key: as_it_is(rule.body) for key, rule in grammar.rules.items() if "." not in key[0]}
    copies = {key: [RuleCopy(key[0], body)] for key, body in bodies.items() if isinstance(body, Chances | Same)}
    assert copies or text != ODD_LAYOUT
    heads = re.compile(r"(?:\d+(?:\.\d+)?\s*%|\belse)\s*:")
    assert heads.sub("#:", rewrite(grammar, copies)) == heads.sub("#:", text)


def test_a_branch_never_becomes_a_part_of_the_comment_before_it():
    text = "Lot --> 60% : A // often\n  20% : B 20% : C"
    body = Chances(((0.5, Text((0,), {})), (0.5, Text((2,), {}))))
    written = rewrite(Grammar.parse(text), {("Lot", 0): [RuleCopy("Lot", body)]})
    assert choice_of(written, "Lot")[0] == [50.0, None]
    assert "// often" in written


NESTED = """Roof --> # why
  // outer
  50% : // wide
    // a
    50% : /* in */ Flat // f
    // b
    else : Hip
  else : // none
"""


def test_comments_follow_their_branches():
    """Where choices are merged, reordered or repeated, or only one branch stays."""
    flat, hip, none = Text((0, 0), {}), Text((0, 1), {}), Text((1,), {})

    def written(body):
        return rewrite(Grammar.parse(NESTED), {("Roof", 0): [RuleCopy("Roof", body)]})

    first = "Roof -->\n  # why\n  // outer\n  // wide\n"
    rest = "  // b\n  30% : Hip\n  else : [ ] // none\n"
    merged = Chances(((0.3, flat), (0.3, hip), (0.4, none)))
    assert written(merged) == f"{first}  // a\n  30% : /* in */ Flat // f\n{rest}"
    assert written(hip) == f"{first}  // b\n  Hip\n"
    repeated = Chances(((0.3, hip), (0.3, hip), (0.4, none)))
    assert written(repeated) == f"{first}  // b\n  30% : Hip\n  30% : Hip\n  else : [ ] // none\n"


def test_new_rules_are_an_empty_line_apart_and_below_the_comment_of_the_author():
    text = "Lot --> Roof\n// about roof\nRoof --> 50% : Flat else : Hip // h\nFlat --> 50%: A else: B\nA --> X.\n"
    copies = {
        (name, 0): [RuleCopy(f"{name}_{i}", Text((i,), {}), f"{name} {i}") for i in range(2)]
        for name in ("Roof", "Flat")
    }
    assert rewrite(Grammar.parse(text), copies) == (
        "Lot --> Roof\n// about roof\n// Roof 0\nRoof_0 --> Flat\n\n// Roof 1\nRoof_1 --> Hip // h\n\n"
        "// Flat 0\nFlat_0 --> A\n\n// Flat 1\nFlat_1 --> B\n\nA --> X.\n"
    )


def test_a_hash_in_a_string_is_not_a_comment():
    text = 'Roof --> 20% : color("#ff0000") Flat 30% : Dome else : print("// no") Hip // h'
    body = Chances(((0.2, Text((0,), {})), (0.8, Text((2,), {}))))
    assert rewrite(Grammar.parse(text), {("Roof", 0): [RuleCopy("Roof", body)]}) == text.replace(" 30% : Dome", "")


@pytest.mark.parametrize("source", shipped_examples(), ids=lambda source: source.name)
def test_rules_written_as_they_are_say_the_same(source):
    grammar = Grammar.parse(source.text())
    copies = {key: [RuleCopy(key[0])] for key in grammar.rules}
    assert rewrite(grammar, copies) == source.text()


def test_successors_are_renamed_in_place():
    wall, _ = places(HOUSE, "Wall")
    (window,) = places(HOUSE, "Window")
    body = Text((), {wall: "Brick", window: "Door"})
    text = rewrite(Grammar.parse(HOUSE), {("House", 2): [RuleCopy("House", body)]})
    assert text == HOUSE.replace("~1 : Wall /*", "~1 : Brick /*").replace("Window(a)", "Door(a)")


def test_copies_have_their_comments_and_no_annotations():
    copies = [RuleCopy("Lot"), RuleCopy("Lot_green", Text((1, 0), {}), "Lot with trees")]
    text = rewrite(Grammar.parse(HOUSE), {("Lot", 0): copies})
    assert HOUSE.split("// A house.", maxsplit=1)[0] in text
    assert "\n// Lot with trees\nLot_green --> [ Tree ] Tree\n\n// A house." in text


def test_a_removed_rule_takes_its_comment_with_it():
    text = rewrite(Grammar.parse(HOUSE), {("House", 2): []})
    before, after = HOUSE.split("// A house.")
    assert text == before.rstrip("\n") + "\n\nTree" + after.split("Tree")[1]


def test_chances_are_written_to_the_last_digit_and_conditions_stay():
    kept = Same((1,), (Text((1, 0), {}), Text((1, 1), {})), closed=True)
    body = Chances(((1 / 3, kept), (2 / 3, Text((0,), {}))))
    text = rewrite(Grammar.parse(HOUSE), {("Lot", 0): [RuleCopy("Lot", body)]})
    percentages, (first, second) = choice_of(text, "Lot")
    assert percentages == [pytest.approx(100 / 3, rel=4e-16), None]
    assert isinstance(first, Case)
    assert len(first.branches) == 3  # the last one is for when neither condition holds
    assert isinstance(second, Sequence)
    assert [item.name for item in second.items if isinstance(item, Invoke)] == ["extrude", "House"]


def test_new_conditions_and_attributes():
    body = Conditions((("kind == 1", Text((0,), {})), ("", Text((1, 1), {}))))
    text = rewrite(
        Grammar.parse(HOUSE),
        {("Lot", 0): [RuleCopy("Lot", body)]},
        {"height": " rand(2, 3)"},
        [f"attr kind ={choice_text([(0.25, '1'), (0.75, '2')], '    ')}"],
        ["Line one", ""],
    )
    assert text.startswith(
        '// Line one\n//\n\nversion "2023.0"\n// The file.\n\nattr kind =\n    25% : 1\n    else : 2\n'
    )
    assert "attr height = rand(2, 3) // metres" in text
    assert "Lot -->\n\tcase kind == 1 : extrude(height) House\n\telse : Bush" in text
    assert Grammar.parse(text).attributes.keys() == {"kind", "height"}


def test_an_empty_branch_is_not_mistaken_for_the_next():
    grammar = Grammar.parse("Lot --> 50% : else : House")
    body = Chances(((0.2, Text((0,), {})), (0.3, Text((1,), {})), (0.5, Text((1,), {}))))
    assert choice_of(rewrite(grammar, {("Lot", 0): [RuleCopy("Lot", body)]}), "Lot")[0] == [20, 30, None]


def test_an_unlikely_branch_is_not_written_as_else():
    choice = [(0.6, "a"), (0.4 - 1e-9, "b"), (1e-9, "c")]
    assert [text for _, text in likely_last(choice)] == ["b", "c", "a"]
    assert likely_last(choice[:2]) == tuple(choice[:2])


def test_percentages_of_any_sum_do_not_take_the_branches_behind_them():
    grammar = Grammar.parse("attr p = 30\nLot --> 50% : A else : p% : A (2*p)% : B // b\n")
    inner = Same((1,), (Text((1, 0), {}), Text((1, 1), {})))
    text = rewrite(grammar, {("Lot", 0): [RuleCopy("Lot", Chances(((0.1, inner), (0.9, Text((0,), {})))))]})
    closed = "10% : case true : p% : A (2*p)% : B // b\n    case true : NIL else : NIL\n    else : A\n"
    assert text == f"attr p = 30\nLot -->\n    {closed}"
    assert choice_of(text, "Lot")[0] == [10, None]
    last = rewrite(grammar, {("Lot", 0): [RuleCopy("Lot", Chances(((0.9, Text((0,), {})), (0.1, inner))))]})
    assert "case" not in last


def test_a_rule_on_the_line_of_another_is_removed_alone():
    grammar = Grammar.parse("// about B\nA --> B B --> C C --> D // end\nD --> E")
    assert rewrite(grammar, {("B", 0): []}) == "// about B\nA --> B C --> D // end\nD --> E"


def test_comments_beside_other_definitions_stay_when_a_rule_goes():
    text = 'A --> B /* beside\nA */\n// alone\n/* above\nB */\nB --> C\nversion "2023.0" // of the version\nC --> D\n'
    grammar = Grammar.parse(text)
    assert rewrite(grammar, {("B", 0): []}) == text.replace("\n// alone\n/* above\nB */\nB --> C", "")
    assert rewrite(grammar, {("C", 0): []}) == text.replace("\nC --> D", "")


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_rules_are_rewritten_with_unix_line_ends(end):
    text = "A --> B\n\n// about B\nB --> C\n\nC --> D\n".replace("\n", end)
    assert rewrite(Grammar.parse(text), {("B", 0): []}) == "A --> B\n\nC --> D\n"


def test_a_removed_rule_takes_the_comment_that_ends_on_its_line():
    text = "attr a = 1\n/* doc\n of Roof */ Roof --> A\nFlat --> B\n"
    assert rewrite(Grammar.parse(text), {("Roof", 0): []}) == "attr a = 1\nFlat --> B\n"


def test_start_rules_can_be_moved():
    grammar = Grammar.parse("@StartRule\nLot --> 50% : Lot else : NIL")
    copies = [RuleCopy("Lot"), RuleCopy("Lot_big", Text((0,), {}), start=True)]
    text = rewrite(grammar, {("Lot", 0): copies})
    assert [rule.name for rule in Grammar.parse(text).start_rules] == ["Lot_big"]
