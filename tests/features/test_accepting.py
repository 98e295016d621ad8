"""Models that an acceptance rule keeps, and the annotation that says the rule."""

import numpy as np
import pytest

from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.derive import derive
from grammarlab.derivation.lots import Lots
from grammarlab.derivation.selection import select_models
from grammarlab.errors import GrammarlabError, UsageError
from grammarlab.features.acceptance import Acceptance, SplitSymbol, derive_accepted
from grammarlab.features.expression import Expression
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.language.grammar import Grammar

RULES = """
@StartRule
Lot --> 50% : Block Block else : Block Block Block
Block --> 30% : extrude(3) Low else : extrude(rand(4, 9)) High
"""
GRAMMAR, LOW = Grammar.parse(RULES), parse("Low")
PROGRAM = compile_grammar(GRAMMAR)


def rule(text, split=None):
    return Acceptance(Expression.parse(text), split or {})


def with_annotation(annotation):
    return Acceptance.of(Grammar.parse(f"{annotation}\nconst rate = 1\n{RULES}").tree)


def equal(one, other):
    columns = [*zip(vars_of(one.nodes), vars_of(other.nodes), strict=True)]
    columns += [*zip(vars_of(one.draws), vars_of(other.draws), strict=True)]
    return all(np.array_equal(a, b) for a, b in columns)


def vars_of(table):
    return [getattr(table, name) for name in table.__slots__]


def test_a_model_is_the_same_alone_and_in_any_batch():
    accepting = rule("choose({Low} >= 2, 0.9, 0.02)")
    whole = derive_accepted(PROGRAM, accepting, Lots.of(40, 5))
    for some in ([3], [39], [0, 7, 20]):
        alone = derive_accepted(PROGRAM, accepting, Lots.at(5, some))
        assert equal(alone.forest, select_models(whole.forest, np.array(some)))
        assert alone.tries.tolist() == whole.tries[some].tolist()
        assert alone.forest.lots.model.tolist() == some
    assert set(whole.forest.lots.seed.tolist()) == {5}
    assert whole.tries.max() > 3


def test_models_come_in_proportion_to_how_often_they_are_kept():
    accepting = rule("choose({Low} == 0, 0.1, {Low} == 1, 0.4, 1)")
    plain, kept = derive(PROGRAM, 20_000, 1), derive_accepted(PROGRAM, accepting, Lots.of(20_000, 2))
    weights = accepting.probabilities(plain)
    for number in range(4):
        wanted = weights[count(plain, [LOW])[:, 0] == number].sum() / weights.sum()
        found = (count(kept.forest, [LOW])[:, 0] == number).mean()
        assert found == pytest.approx(wanted, abs=0.02)
    assert 1.0 / kept.tries.mean() == pytest.approx(weights.mean(), rel=0.05)
    assert kept.is_accepted.all()


def test_a_rule_that_keeps_all_changes_nothing():
    for always in (rule("1"), rule("7"), None):
        found = derive_accepted(PROGRAM, always, Lots.of(30, 3))
        assert equal(found.forest, derive(PROGRAM, 30, 3))
        assert (found.tries == 1).all()


def test_no_models_are_no_error():
    assert derive_accepted(PROGRAM, rule("0"), Lots.of(0, 0)).forest.num_models == 0


def test_after_the_last_try_the_nearest_candidate_stands_there():
    accepting = rule("choose({Low} == 3, 1e-9, {Low} == 0, 1e-12, 0)")
    found = derive_accepted(PROGRAM, accepting, Lots.of(4, 1), enough_tries=50)
    assert not found.is_accepted.any()
    assert (found.tries == 50).all()
    assert set(count(found.forest, [LOW])[:, 0]) <= {0.0, 3.0}
    again = derive_accepted(PROGRAM, accepting, Lots.at(1, [2]), enough_tries=50)
    assert equal(again.forest, select_models(found.forest, np.array([2])))


def test_a_rule_that_keeps_nothing_is_an_error_in_words():
    for num, tries in ((1, 400), (2, 200), (30, 20)):
        with pytest.raises(GrammarlabError, match=rf"keeps none of {tries} candidates of model 0 of seed 1"):
            derive_accepted(PROGRAM, rule("{Low} < 0"), Lots.of(num, 1), enough_tries=20)


def test_models_without_a_possible_candidate_are_tried_further():
    accepting = rule("{Low} >= 2")
    found = derive_accepted(PROGRAM, accepting, Lots.of(300, 1), enough_tries=20)
    assert found.is_accepted.all()
    assert (count(found.forest, [LOW])[:, 0] >= 2).all()
    late = np.flatnonzero(found.tries > 20)
    assert 0 < len(late) < 300
    again = derive_accepted(PROGRAM, accepting, Lots.of(int(late[0]) + 1, 1), enough_tries=20)
    assert np.array_equal(again.tries, found.tries[: late[0] + 1])
    assert np.array_equal(again.forest.log_probability(), found.forest.log_probability()[: late[0] + 1])


def test_symbols_that_were_split_are_counted_under_their_old_names():
    split = Grammar.parse(
        """
@StartRule
Lot --> 50% : Block_low Block else : Block_low Block_low Block
Block --> 30% : extrude(3) Low else : extrude(rand(4, 9)) High
Block_low --> extrude(3) Low
"""
    )
    accepting = rule("{Block:0} + 10 * {Block}", {("Block_low", 0): SplitSymbol("Block", {(): (0,)})})
    forest = derive(split, 200, 1)
    unsplit = accepting._unsplit(forest)
    assert np.array_equal(count(unsplit, [parse("Block:0")]), count(forest, [LOW]))
    assert np.array_equal(count(unsplit, [parse("Block")])[:, 0] + 1.0, forest.shapes_per_model() // 2 + 1.0)


def test_the_annotation_says_the_rule():
    split = {("Block_low", 0): SplitSymbol("Block", {(): (0,), (1, 0): None})}
    accepting = rule("choose({Lot > Block@0:1} >= 1, 1, 0.05)", split)
    read = with_annotation(accepting.annotation())
    assert read == accepting
    assert Acceptance.of(GRAMMAR.tree) is None


@pytest.mark.parametrize(
    ("annotation", "message"),
    [
        ("@Acceptance(3)", "expected texts"),
        ('@Acceptance("{Low} >")', "expected"),
        ('@Acceptance("1", "Low")', "expected a split symbol such as"),
        ('@Acceptance("1", "Low/0 Block a:b")', "expected a branch such as"),
        ('@Acceptance("1") @Acceptance("1")', "found 2 annotations"),
        (f'@Acceptance("{"(" * 9_000}1{")" * 9_000}{" " * 9_000}")', "characters"),
        (f'@Acceptance("{" + ".join(f"exp({i} * {{Low}})" for i in range(1_300))}")', "characters|steps"),
    ],
)
def test_what_is_no_rule_is_refused_in_words(annotation, message):
    with pytest.raises(UsageError, match=message):
        with_annotation(annotation)


def test_deep_nesting_is_read_without_recursion():
    assert with_annotation(f'@Acceptance("{"(" * 9_000}1{")" * 9_000}")') is not None


def test_split_symbols_of_imported_rules_have_dots_in_their_names():
    text = '@Acceptance("{other.Box_low/0:*} >= 1", "other.Box_low/0 other.Box *:0 1:1")\n@StartRule\nLot --> X.'
    acceptance = Acceptance.of(Grammar.parse(text).tree)
    assert acceptance is not None
    ((key, split),) = acceptance.split.items()
    assert key == ("other.Box_low", 0)
    assert split.symbol == "other.Box"
