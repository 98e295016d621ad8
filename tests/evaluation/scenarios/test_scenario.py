"""Scenario files."""

import os
import re
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import UsageError
from grammarlab.evaluation.scenario import FeatureOptions, PaperFigures, ScenarioGoal, load, parse
from grammarlab.evaluation.scenario_values import MAX_BYTES
from grammarlab.features.patterns.pattern import Threshold
from grammarlab.language.grammar import Grammar
from grammarlab.language.presets import NO_CHOICES, RuleChoices
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.runs.sample.sources import load_source

ROOT = Path(__file__).parents[3]
PATHS = sorted((ROOT / "scenarios").glob("*.toml"))

SMALL = """\
name = "small"
title = "Low towers"
grammar = "toy"

[definitions]
low = "$h1 < 2"
orange = "{MESH2:0}"

[[preference]]
score = 70
when = "low and orange == 2"
means = "low and all orange"

[[preference]]
score = 30
when = "low"
"""


@pytest.mark.parametrize("path", PATHS, ids=lambda path: path.stem)
def test_every_shipped_scenario_fits_its_grammar_and_says_what_it_means(path):
    scenario = load(path)
    scenario.check(load_source(path).space)
    assert scenario.name == path.stem
    assert path.read_text().startswith("# ")
    assert 10 < len(scenario.title) < 100
    for factor in scenario.factors:
        # A graded preference is an expression without cases.
        assert factor.score.cases or " * " in factor.score.expression.text
        assert all(case.means for case in factor.score.cases)


def test_scenarios_differ_in_their_hashes():
    scenarios = [load(path) for path in PATHS]
    assert len({scenario.hash for scenario in scenarios}) == len(scenarios) >= 19
    assert [load(path).hash for path in PATHS] == [scenario.hash for scenario in scenarios]


def test_a_file_becomes_a_value():
    scenario = parse(SMALL)
    assert (scenario.name, scenario.title, scenario.grammar) == ("small", "Low towers", "toy")
    assert (scenario.num_models, scenario.seed, scenario.base, scenario.draws) == (5000, 0, "grammar", "grammar")
    assert (scenario.features, scenario.methods) == (FeatureOptions(), ("default",))
    assert (scenario.paper, scenario.target) == (PaperFigures(), ScenarioGoal())
    (factor,) = scenario.factors
    assert [case.means for case in factor.score.cases] == ["low and all orange", ""]
    assert factor.score.features[0] == Threshold("h1", 2.0)
    assert scenario.score.evaluate(np.array([[1.0, 2], [1, 1], [0, 2]])).tolist() == [70, 30, 0]
    assert parse(SMALL) == scenario
    assert parse(SMALL.replace("\n", "\n# Remark\n")) == scenario


def test_all_that_can_be_set_is_read():
    head = SMALL.replace(
        '"toy"\n',
        '"toy"\nnum_models = 10\nseed = 18446744073709551615\nbase = "uniform"\ndraws = "flattened"\n'
        'methods = ["a", "b"]\n',
    )
    scenario = parse(
        head
        + """
[features]
path_length = 4
families = ["paths", "siblings"]
[paper]
original = 0.3
p_learning = 0.2
s_learning = 0
labels = 245
kde_labels = 438
figure = "4.11b"
[target]
js = 1e-3
labels = 64
aim = 48
since = "first liked"
ask = 512
"""
    )
    assert (scenario.num_models, scenario.seed) == (10, 2**64 - 1)
    assert (scenario.base, scenario.draws, scenario.methods) == ("uniform", "flattened", ("a", "b"))
    assert scenario.features == FeatureOptions(4, ("paths", "siblings"))
    assert scenario.paper == PaperFigures(0.3, 0.2, 0.0, 245, 438, "4.11b")
    assert scenario.target == ScenarioGoal(1e-3, 64, 48, "first liked", 512)
    assert scenario.hash != parse(SMALL).hash


def test_choices_for_the_rule_file_belong_to_the_scenario(tmp_path):
    choices = 'start = "Lot"\nstyle = "Tall"\nlibrary = "lib"\nattributes = {h = 3, tall = true, tone = "red"}\n'
    text = SMALL.replace('"toy"\n', f'"toy"\n{choices}')
    scenario = parse(text, Path("some/where/a.toml"))
    attributes = {"h": 3, "tall": True, "tone": "red"}
    assert scenario.choices == RuleChoices(Path("some/where/lib"), "Tall", "Lot", attributes)
    changes = [('"Lot"', '"Hut"'), ('"Tall"', '""'), ('"lib"', '"other"'), ("h = 3", "h = 4"), (choices, "")]
    assert len({parse(text.replace(*change)).hash for change in [*changes, ("", "")]}) == 6
    assert parse(SMALL).hash == parse(text.replace(choices, "attributes = {}\n")).hash
    same = text.replace('{h = 3, tall = true, tone = "red"}', '{tone = "red", tall = true, h = 3.0}')
    assert parse(same, Path("elsewhere/a.toml")).hash == scenario.hash
    assert len({scenario, parse(text, Path("some/where/a.toml"))}) == 1

    (tmp_path / "small.toml").write_text(SMALL)
    both = 'name = "both"\ntitle = "Both"\ngrammar = "toy"\nfactors = ["small"]\n'
    assert parse(both, tmp_path / "test.toml").choices == NO_CHOICES
    with pytest.raises(UsageError, match="small has another start rule"):
        parse(both + 'start = "Lot"', tmp_path / "test.toml")


def test_a_choice_that_does_not_fit_is_refused_with_the_scenario(tmp_path):
    path = tmp_path / "small.toml"
    for choice, says in [('start = "Strat"', "did you mean 'Start'"), ("attributes = {h1 = true}", "a finite number")]:
        path.write_text(SMALL.replace('"toy"\n', f'"toy"\n{choice}\n'))
        with pytest.raises(UsageError, match=f"small.toml: .*{says}"):
            load_source(path)


def test_a_preference_may_be_an_expression():
    head, _, _ = SMALL.partition("[[preference]]")
    text = head.replace("[definitions]", 'preference = "100 * low / (1 + orange)"\n[definitions]')
    scenario = parse(text)
    assert scenario.score.evaluate(np.array([[1.0, 0], [1, 1], [0, 0]])).tolist() == [100, 50, 0]
    assert scenario.score.cases == ()


def test_factors_are_scenarios_of_the_same_folder(tmp_path):
    (tmp_path / "small.toml").write_text(SMALL)
    (tmp_path / "tall.toml").write_text(SMALL.replace("small", "tall").replace("$h1 < 2", "$h1 > 2"))
    both = 'name = "both"\ntitle = "Both"\ngrammar = "toy"\nfactors = ["small", "tall"]'
    (tmp_path / "both.toml").write_text(both)
    scenario = load(tmp_path / "both.toml")
    assert [factor.name for factor in scenario.factors] == ["small", "tall"]
    assert scenario.factors[0] == load(tmp_path / "small.toml").factors[0]

    (tmp_path / "loop.toml").write_text(both.replace("both", "loop").replace("tall", "loop"))
    for text, says in [
        (both.replace("tall", "tal"), "no scenario file"),
        (both.replace("tall", "small"), "different names"),
        (both.replace("tall", "../tall"), "beside this one"),
        (both.replace('["small", "tall"]', "[]"), "1 to 8 different names"),
        (both.replace('"toy"', '"building"'), "small is about the grammar 'toy', this about another"),
        (both.replace("tall", "loop"), "loop has factors itself"),
        (both + '\npreference = "1"', "expected either factors or preference"),
        (both + "\n[definitions]", "expected either factors or definitions"),
    ]:
        with pytest.raises(UsageError, match=re.escape(says)):
            parse(text, tmp_path / "test.toml")


def test_a_rule_file_is_looked_for_beside_the_scenario():
    text = SMALL.replace('"toy"', '"rules/mine.cga"')
    assert Path(parse(text, Path("some/where/a.toml")).grammar) == Path("some/where/rules/mine.cga")


@pytest.mark.parametrize(
    ("change", "line", "says"),
    [
        (("name = ", "nam = "), 1, "unknown key 'nam'; did you mean name?"),
        (('"small"', '"../small"'), 1, "expected a name of letters, digits, _ and -"),
        (('"Low towers"', '"  "'), 2, "expected title = a text"),
        (('title = "Low towers"\n', ""), None, "expected title = a text"),
        (('"toy"', '"toy"\nnum_models = 0'), 4, "expected num_models = a whole number from 1 to 1000000, found 0"),
        (('"toy"', '"toy"\nnum_models = true'), 4, "found True"),
        (('"toy"', '"toy"\nseed = -1'), 4, "expected seed = a whole number from 0"),
        (('"toy"', '"toy"\nseed = 1.5'), 4, "expected seed"),
        (('"toy"', '"toy"\nbase = "uniforn"'), 4, "expected base = 'grammar' or 'uniform', found 'uniforn'"),
        (('"toy"', '"toy"\nmethods = "paper"'), 4, "expected methods = a list of texts"),
        (('"toy"', '"toy"\nstart = 3'), 4, "expected start = a text"),
        (('"toy"', '"toy"\nattributes = 3'), 4, "expected a table [attributes]"),
        (('"low"', '"low"\n[attributes]\nh = [3]'), 18, "attribute 'h': expected a number, true, false or a text"),
        (("$h1 < 2", "$h1 <"), 6, "definition low: expected a value: a number"),
        (("$h1 < 2", "orange < 2"), 6, "a definition may use those above it; orange is not"),
        (("low = ", "min = "), 6, "'min' cannot be the name of a definition"),
        (("low = ", '"a b" = '), 6, "'a b' cannot be the name of a definition"),
        (('"$h1 < 2"', "2"), 6, "definition 'low': expected an expression in quotes"),
        (("{MESH2:0}", "{MESH2 > > }"), 7, "definition orange: in the pattern {MESH2 > > }: expected a symbol"),
        (("score = 70", "score = 101"), 9, "expected score = a number from 0 to 100, found 101"),
        (("score = 70", 'score = "70"'), 9, "expected score"),
        (("score = 30", "score = nan"), 14, "expected score = a number from 0 to 100, found nan"),
        (("score = 30\n", ""), 14, "expected score = a number, when = an expression"),
        (("and orange", "and oragne"), 9, "case 1: unknown name 'oragne'; did you mean orange?"),
        (('when = "low"', "when = 3"), 14, "when = an expression in quotes"),
        (('when = "low"', 'wen = "low"'), 14, "unknown key 'wen' in [preference]; did you mean when?"),
        (("[[preference]]\nscore = 30", "[preferences]\nscore = 30"), 14, "did you mean preference?"),
        (('"low"', '"low"\n[features]\npath_length = 5'), 18, "expected path_length = a whole number from 1 to 4"),
        (('"low"', '"low"\n[features]\nfamilies = ["path"]'), 18, "family of features 'path'; did you mean paths?"),
        (('"low"', '"low"\n[paper]\noriginal = 3'), 18, "expected original = a number from 0 to 0.7"),
        (('"low"', '"low"\n[target]\nlabel = 3'), 18, "unknown key 'label' in [target]; did you mean labels?"),
        (('"low"', '"low"\n[target]\nsince = "liked"'), 18, "expected since = 'start' or 'first liked', found 'liked'"),
        (
            ('"low"', '"low"\n[target]\nlabels = 9\nask = 8'),
            19,
            "expected to ask for at least the 9 labels",
        ),
        (('"toy"', '"toy"\ntarget = 3'), 4, "expected a table [target]"),
        (('"toy"', '"toy"\ndefinitions = 3'), 6, "this is not TOML"),
        (('"toy"', '"toy'), 3, "this is not TOML: Illegal character"),
    ],
)
def test_a_mistake_is_explained_with_its_line(change, line, says):
    before, after = change
    text = SMALL.replace(before, after, 1)
    assert text != SMALL
    with pytest.raises(UsageError) as caught:
        parse(text, Path("a.toml"))
    assert says in str(caught.value)
    assert str(caught.value).startswith(f"a.toml:{line}: " if line else "a.toml: ")


def test_a_scenario_without_preference_says_what_to_write():
    head, _, _ = SMALL.partition("[[preference]]")
    for text in (head, head.replace("[definitions]", "preference = 3\n[definitions]")):
        with pytest.raises(UsageError, match=r"expected a preference: one or more tables \[\[preference\]\]"):
            parse(text)
    with pytest.raises(UsageError, match="expected 1 to 100 cases, found 0"):
        parse(head.replace("[definitions]", "preference = []\n[definitions]"))


def test_what_the_grammar_lacks_is_named_with_the_scenario():
    space = GrammarSpace(Grammar.parse("attr h = rand(3)\nLot --> A"))
    with pytest.raises(UsageError) as caught:
        parse(SMALL).check(space)
    assert str(caught.value).startswith("scenario small does not fit toy:\n")
    assert "has no random expression 'h1'" in str(caught.value)
    assert "no symbol 'MESH2'" in str(caught.value)


def test_files_that_cannot_be_read_are_refused(tmp_path):
    (tmp_path / "small.toml").write_text(SMALL)
    (tmp_path / "large.toml").write_bytes(b"#" * (MAX_BYTES + 1))
    (tmp_path / "latin.toml").write_bytes("# Bâtiment\n".encode("latin-1") + SMALL.encode())
    (tmp_path / "binary.toml").write_bytes(bytes(range(256)))
    with pytest.raises(UsageError, match=r"no scenario file .*smal\.toml'; did you mean small\.toml"):
        load(tmp_path / "smal.toml")
    with pytest.raises(UsageError, match="no scenario file"):
        load(tmp_path)
    with pytest.raises(UsageError, match="at most 262,144 bytes"):
        load(tmp_path / "large.toml")
    with pytest.raises(UsageError, match="expected text in UTF-8; byte 3 is not"):
        load(tmp_path / "latin.toml")
    with pytest.raises(UsageError):
        load(tmp_path / "binary.toml")
    (tmp_path / "dos.toml").write_bytes(SMALL.replace("\n", "\r\n").encode())
    assert load(tmp_path / "dos.toml") == load(tmp_path / "small.toml")
    (tmp_path / "marked.toml").write_text(SMALL, encoding="utf-8-sig")
    assert load(tmp_path / "marked.toml") == load(tmp_path / "small.toml")
    (tmp_path / "wide.toml").write_text(SMALL, encoding="utf-16")
    with pytest.raises(UsageError, match="found UTF-16"):
        load(tmp_path / "wide.toml")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes")
def test_a_pipe_is_refused_without_waiting_for_it(tmp_path):
    os.mkfifo(tmp_path / "pipe.toml")
    with pytest.raises(UsageError, match="a regular file, found a pipe"):
        load(tmp_path / "pipe.toml")


@pytest.mark.parametrize(
    "text",
    [
        "a = " + "[" * 5_000,
        "a = " + "[" * 5_000 + "]" * 5_000,
        "a = " + "{a=" * 5_000,
        "a." * 5_000 + "a = 1",
        "[" + "a." * 5_000 + "a]",
        "a = " + "9" * 9_000,
        'name = "' + "x" * 9_000 + '"',
        "seed = 1e999",
        "name = 2020-01-01",
    ],
    ids=lambda text: text[:8],
)
def test_hostile_texts_are_refused(text):
    with pytest.raises(UsageError) as caught:
        parse(text)
    assert len(str(caught.value)) < 500


@given(st.data())
def test_a_damaged_file_is_read_or_explained(data):
    start = data.draw(st.integers(0, len(SMALL)))
    end = min(len(SMALL), start + data.draw(st.integers(0, 5)))
    inserted = data.draw(st.text(alphabet="[]{}=\"'\n .,#0a\\\x00é", max_size=5))
    with suppress(UsageError):
        parse(SMALL[:start] + inserted + SMALL[end:])
