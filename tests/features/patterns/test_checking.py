"""Features that a grammar lacks."""

import pytest

from grammarlab.derivation import compile_grammar
from grammarlab.errors import UsageError
from grammarlab.features.patterns.pattern import Draw, Formula, Present, Threshold
from grammarlab.features.patterns.pattern_checks import MAX_REMARKS, check
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.language.grammar import Grammar

PROGRAM = compile_grammar(
    Grammar.parse("""
attr height = rand(1, 5)
attr style = 50% : "old" else : "new"
@StartRule
Tower --> 30% : Block Crown 40% : Block Block else : case height > 2 : Block(2) else : NIL
Block --> 50% : BoxBlock. else : case height > 3 : Roof. else : BoxBlock.
Block(n) --> Roof.
Crown --> Roof.
""")
)


def remarks(*features):
    check(features, PROGRAM.symbols, PROGRAM.rule_names, PROGRAM.sites)


@pytest.mark.parametrize(
    "text",
    [
        *("Tower", "*", "*:*", "*:1", "Tower:0 > Block@0", "Tower:2.1", "Block:1.0", "Block/0:1", "Block/1", "Crown:*"),
        *("Roof.", "Tower[Block:0 + Block:1 >> BoxBlock.]", "*/1"),
    ],
)
def test_what_a_grammar_has_passes(text):
    remarks(parse(text), Present(parse(text)))


def test_draws_that_a_grammar_makes_pass():
    remarks(
        Threshold("height", 2.0),
        Draw("height"),
        Draw("style", 1),
        Draw("Tower"),
        Formula.of("+", Formula.of("-", parse("Tower:1"), parse("Crown")), Draw("style", 1)),
    )


@pytest.mark.parametrize(
    ("feature", "says"),
    [
        (parse("Towr"), "the grammar has no symbol 'Towr'; did you mean 'Tower'?"),
        (Formula.of("+", parse("Tower"), parse("Towr")), "did you mean 'Tower'?"),
        (Formula.of("+", parse("Tower"), Draw("style", 7)), "$style has no branch :7"),
        (parse("Roof"), "the grammar has no symbol 'Roof'; did you mean 'Roof.'?"),
        (parse("Tower > Blok"), "the grammar has no symbol 'Blok'; did you mean 'Block'"),
        (parse("Tower:3"), "the symbol 'Tower' has no branch :3; it has 3, :0 to :2"),
        (parse("Tower:2.5"), "the symbol 'Tower' has no branch :2.5; it has 2, :2.0 to :2.1"),
        (parse("Tower:1.0"), "branch :1 of the symbol 'Tower' has no branches of its own; leave .0 out"),
        (parse("Crown:0"), "the symbol 'Crown' has no branches; leave :0 out"),
        (parse("Roof.:0"), "the symbol 'Roof.' has no rule, so it is always a leaf; leave the branch out"),
        (parse("Roof.:*"), "the symbol 'Roof.' has no rule"),
        (parse("Block/2"), "the symbol 'Block' has no rule with 2 parameters; it has /0, /1"),
        (parse("Block/1:0"), "the symbol 'Block' with 1 parameters has no branches; leave :0 out"),
        (parse("*:9"), "the grammar has no branch :9; it has 3, :0 to :2"),
        (Present(parse("Towr")), "no symbol 'Towr'"),
        (Threshold("heigth", 1.0), "the grammar has no random expression 'heigth'; did you mean 'height'?"),
        (Draw("style", 2), "$style has no branch :2; it is a choice of 2, :0 to :1"),
        (Draw("height", 0), "$height has no branch :0; it is not a choice"),
        (Formula.of("+", Draw("height"), Draw("width")), "the grammar has no random expression 'width'"),
    ],
)
def test_what_a_grammar_lacks_is_named(feature, says):
    with pytest.raises(UsageError) as caught:
        remarks(feature)
    assert says in str(caught.value)


def test_all_that_is_missing_is_named_once_and_not_without_end():
    with pytest.raises(UsageError) as caught:
        remarks(parse("Towr"), parse("Towr"), parse("Tower:3[Blok]"))
    assert len(str(caught.value).splitlines()) == 3
    with pytest.raises(UsageError) as caught:
        remarks(*(parse(f"Q{i}") for i in range(99)))
    assert len(str(caught.value).splitlines()) == MAX_REMARKS
