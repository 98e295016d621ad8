"""The formatter against the parser: what one writes, the other reads."""

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.language.formatting import WIDTH, format_grammar
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax.syntax_tree import (
    Case,
    Invoke,
    Name,
    Number,
    Rule,
    RuleFile,
    Sequence,
    Stochastic,
    alternatives,
)
from grammarlab.language.syntax.tokens import tokenize
from tests.cases import bulk
from tests.language.trees import PHASES, expressions, rule_files

GRAMMARS = sorted((Path(__file__).parents[2] / "grammars").glob("*.cga"))

COMMENTED = """
# head

version "2023.0"  // the version

/* two
   lines */
@Range(1, 2) // first
// between
@Order(3)
attr h = 1 + 2 * 3 // trailing

// own line
Lot --> // after the arrow
    extrude(h) # grow
    // before comp
    comp(f) { top : Roof // roof
            | /* sides */ side : split(y) { ~1 : Floor }* // floors
            // the rest
            | all : NIL }
    [ t(0, 1, 0) Lamp /* a lamp */ ]
Roof --> case h > 3 : // high
           A
         // low
         else : B
Annexe -->
    union { // of two
        A // the first
        // no bar yet
      | [ B /* inner */ ] // the second
        // still inside
    }
    split(x) { { 1 : A // one
                 // repeated
               }* | 2 : [ [ t(1, 0, 0) A ]
                          // scoped
                        ]
      // all parts
    }
    splitAndSetbackPerimeter(0, 0, 0) { ~3 : 2 : A
        // lots
      }* { remainder : B
        // court
      }
    scatter(surface, 3, uniform) { A /* scattered */ }
    union { A // alone
    } inline { B } [ // nothing
    ] [ ] [ case h > 3 : // in a scope
            A
            else : B ]
// the end
"""


def reread(tree):
    return Grammar.parse(format_grammar(tree)).tree


@bulk(100, phases=PHASES)
@given(rule_files)
def test_any_tree_is_read_as_it_was_written(tree):
    assert reread(tree) == tree


@bulk(80, phases=PHASES)
@given(rule_files)
def test_formatting_twice_changes_nothing(tree):
    text = format_grammar(tree)
    assert format_grammar(Grammar.parse(text)) == text


@bulk(100, phases=PHASES)
@given(expressions)
def test_parentheses_stand_only_where_they_are_needed(expression):
    text = format_grammar(RuleFile("", (Rule("Lot", (), Sequence((Invoke("s", (expression,)),))),)))
    pairs = _pairs_of_parentheses(text)
    tree = Grammar.parse(text).tree
    for opening, closing in pairs:
        # A percentage that is no plain word or number, and a block in an expression, are always told apart by them.
        if text[closing + 1] == "%" or text.startswith("comp(", opening + 1):
            continue
        bare = text[:opening] + " " + text[opening + 1 : closing] + " " + text[closing + 1 :]
        assert _tree_or_none(bare) != tree


def _pairs_of_parentheses(text):
    open_, pairs = [], []
    for token in tokenize(text).tokens:
        if token.type == "_LPAR":
            open_.append(token.start)
        elif token.type == "RPAR":
            pairs.append((open_.pop(), token.start))
    return pairs


def _tree_or_none(text):
    try:
        return Grammar.parse(text).tree
    except Exception:
        return None


@pytest.mark.parametrize("path", GRAMMARS, ids=lambda path: path.stem)
def test_shipped_grammars_keep_their_meaning_and_their_comments(path):
    text = path.read_text(encoding="utf-8")
    grammar = Grammar.parse(text)
    formatted = format_grammar(grammar)
    again = Grammar.parse(formatted)
    assert again.tree == grammar.tree
    assert format_grammar(again) == formatted
    assert _comments(formatted) == _comments(text)


def _comments(text):
    return [comment.text.rstrip() for comment in tokenize(text).comments]


def test_comments_stay_by_what_they_are_about():
    formatted = format_grammar(Grammar.parse(COMMENTED))
    assert _comments(formatted) == _comments(COMMENTED)
    lines = formatted.splitlines()
    assert "    extrude(h)  # grow" in lines
    assert "        top : Roof  // roof" in lines
    assert lines[lines.index("    // before comp") + 1] == "    comp(f) {"
    assert lines[lines.index("        // the rest") + 1] == "      | all : NIL"
    assert lines[lines.index("// own line") + 1] == "Lot -->  // after the arrow"
    assert "attr h = 1 + 2 * 3  // trailing" in lines
    assert lines[:3] == ["# head", "", 'version "2023.0"  // the version']
    assert lines[-1] == "// the end"
    assert lines[lines.index("        // no bar yet") + 1] == "    |"
    assert lines[lines.index("        // still inside") + 1].startswith("    }")
    assert lines[lines.index("            // repeated") + 1] == "        }*"


@bulk(60, phases=PHASES)
@given(
    st.lists(
        st.tuples(st.integers(0, 400), st.sampled_from(["// c\n", "# c\n", "/* c */", "/* c\n c */", "\n\n"])),
        max_size=6,
    )
)
def test_comments_anywhere_are_kept_and_formatting_settles_at_once(insertions):
    text = COMMENTED
    for position, comment in insertions:
        text = _insert_between_tokens(text, position, comment)
    _assert_settled(text, format_grammar(Grammar.parse(text)))
    _assert_in_their_groups(text, format_grammar(Grammar.parse(text)))


ONE_COMMENT = ["// c\n", "/* c */", "\n// c\n"]


@pytest.mark.parametrize(
    "text",
    [
        "Lot --> union { A } B inline { [ A ] } inline(append) C union { comp(f) { all : A } }",
        "Lot --> A [ ] [ [ ] B ] [ [ A ] [ ] ] scatter(surface, 3, uniform) { }",
        "Lot --> [ case b : [ C ] else : [ D ] ] E [ 50% : [ case b : A ] else : [ [ ] ] ]",
        "Lot --> split(x) { { 1 : [ A ] | { 2 : B }* }* | { 1 : }* }",
    ],
)
@pytest.mark.parametrize("comment", ONE_COMMENT)
def test_a_comment_at_any_place_stays_in_its_group(text, comment):
    for position in range(len(tokenize(text).tokens)):
        commented = _insert_between_tokens(text, position, comment)
        formatted = format_grammar(Grammar.parse(commented))
        _assert_settled(commented, formatted)
        _assert_in_their_groups(commented, formatted)


@pytest.mark.parametrize(
    "text",
    [
        "f(x) = case x > 1 : comp(f) { top : 1 | side : 2 } else : 3",
        "Lot --> A extrude(case b : [1, 2][0] else : 2) t(0, comp(f) { all : 2 }, 0) B",
        "Lot --> case (case a : b else : c) : A else : B",
    ],
)
@pytest.mark.parametrize("comment", ONE_COMMENT)
def test_a_comment_at_any_place_of_an_expression_is_kept(text, comment):
    for position in range(len(tokenize(text).tokens)):
        commented = _insert_between_tokens(text, position, comment)
        _assert_settled(commented, format_grammar(Grammar.parse(commented)))


def _assert_settled(text, formatted):
    again = Grammar.parse(formatted)
    assert again.tree == Grammar.parse(text).tree
    assert _comments(formatted) == _comments(text)
    assert format_grammar(again) == formatted


def _assert_in_their_groups(text, formatted):
    """Comments leave no group or scope, but a comment just before one may be moved into it."""
    opened, ended = _groups_before_comments(_SINGLE.sub(r"\1 \2", text))
    opened_again, ended_again = _groups_before_comments(formatted)
    assert ended_again == ended
    assert all(again >= once for once, again in zip(opened, opened_again, strict=True))


_SINGLE = re.compile(r"\b((?:union|inline)\s+)\{\s+(\w+)\s+\}")
"""One operation without a comment, in braces that formatting removes."""


def _groups_before_comments(text):
    """The number of groups and scopes that begin, and that end, before each comment."""
    words = tokenize(text)
    starts = [(token.location.line, token.location.column) for token in words.tokens if token.value in ("{", "[")]
    ends = [(token.location.line, token.location.column) for token in words.tokens if token.value in ("}", "]")]
    places = [(comment.location.line, comment.location.column) for comment in words.comments]
    return [[sum(bracket < place for bracket in each) for place in places] for each in (starts, ends)]


def _insert_between_tokens(text, position, comment):
    starts = [token.start for token in tokenize(text).tokens]
    start = starts[position % len(starts)]
    return f"{text[:start]} {comment} {text[start:]}"


def test_a_short_definition_stands_on_one_line():
    assert format_grammar(Grammar.parse("Lot-->extrude( 10 )split(x){1:A|~1:B}*")) == (
        "Lot --> extrude(10) split(x) { 1 : A | ~1 : B }*\n"
    )


def test_long_sequences_fill_lines_up_to_the_width():
    items = " ".join(f"t(0, {i}, 0) Part{i}" for i in range(60))
    lines = format_grammar(Grammar.parse(f"Lot --> {items}")).splitlines()
    assert all(WIDTH - 20 < len(line) <= WIDTH for line in lines[1:-1])


@pytest.mark.parametrize(
    ("written", "canonical"),
    [
        ("a = (1+(2*3))", "a = 1 + 2 * 3"),
        ("a = (1+2)*3", "a = (1 + 2) * 3"),
        ("a = 1-(2-3)", "a = 1 - (2 - 3)"),
        ("a = -(-x)", "a = --x"),
        ("a = !(b&&c)||(d)", "a = !(b && c) || d"),
        ("a = 1.50 + .5 + 1e3 + 2.", "a = 1.5 + 0.5 + 1000 + 2"),
        ("a = 270+(case b:1 else:2)", "a = 270 + (case b : 1 else : 2)"),
        ("a = [1,2;3,4][0,1]", "a = [1, 2; 3, 4][0, 1]"),
        ("a = [ 1:2:9 ]", "a = [1 : 2 : 9]"),
        ("A --> s('1,'(b+1),'.5)", "A --> s('1, '(b + 1), '0.5)"),
        ("A --> split(x){~(a+b)*2:B}", "A --> split(x) { ~(a + b) * 2 : B }"),
        ("A --> primitiveCube()", "A --> primitiveCube()"),
        ("@Range( min = 1,max=2 )@Hidden attr a=1", "@Range(min=1, max=2) @Hidden\nattr a = 1"),
        ('import l(s):"f.cga"(h=3,w,R(x)-->A B)', 'import l(s) : "f.cga" (h = 3, w, R(x) --> A B)'),
        ('import l:"f.cga"()', 'import l : "f.cga" ()'),
        ("A --> inline(append) B inline { C D }", "A --> inline(append) B inline { C D }"),
        ("A --> l(h=3).B(1)", "A --> l(h = 3).B(1)"),
        ("start A(x) with (y:=x) --> B", "start A(x) with (y := x) --> B"),
    ],
)
def test_one_text_has_one_form(written, canonical):
    assert format_grammar(Grammar.parse(written)) == canonical + "\n"


def test_a_random_choice_that_would_swallow_the_next_branch_ends_in_else():
    inner = Stochastic((Number(40.0), Number(60.0)), (Sequence((Invoke("A"),)), Sequence((Invoke("B"),))))
    outer = Stochastic((Number(50.0), Number(50.0)), (inner, Sequence((Invoke("C"),))))
    tree = reread(RuleFile("", (Rule("Lot", (), outer),)))
    (rule,) = tree.definitions
    assert isinstance(rule, Rule)
    assert isinstance(rule.body, Stochastic)
    assert len(rule.body.branches) == 2
    assert isinstance(rule.body.branches[0], Stochastic)
    assert rule.body.branches[0].percentages == (Number(40.0), None)
    assert list(alternatives(rule.body)) == list(alternatives(outer))


def test_cases_that_would_swallow_the_next_branch_stand_in_brackets():
    inner = Case((Name("a"),), (Sequence((Invoke("A"),)),))
    outer = Case((Name("b"), None), (inner, Sequence((Invoke("C"),))))
    text = format_grammar(RuleFile("", (Rule("Lot", (), outer),)))
    (rule,) = Grammar.parse(text).tree.definitions
    assert isinstance(rule, Rule)
    assert isinstance(rule.body, Case)
    assert rule.body.branches[1] == Sequence((Invoke("C"),))


def test_a_number_without_a_form_is_refused():
    tree = RuleFile("", (Rule("Lot", (), Sequence((Invoke("extrude", (Number(float("nan")),)),))),))
    with pytest.raises(ValueError, match="finite"):
        format_grammar(tree)
