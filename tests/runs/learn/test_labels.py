"""From labels to a learned grammar: the density is that of the scores, whatever the labels are like."""

import numpy as np
import pytest

from grammarlab.density.exact.learned import LearnedGrammar
from grammarlab.density.sampler import GrammarSampler
from grammarlab.density.targets.target import Target
from grammarlab.derivation.derive import derive
from grammarlab.errors import InexactError, LanguageError, UsageError
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.language.grammar import Grammar
from grammarlab.learning.designs.addresses import hashes_of
from grammarlab.learning.designs.flattening import flattened
from grammarlab.learning.designs.pool import Pool
from grammarlab.learning.settings import FeatureOptions, Settings
from grammarlab.learning.targets.writers import NUM_SAMPLES, Making
from grammarlab.preference.labels import Label, Labels
from grammarlab.runs.learn.density_pages import page_of_labels
from grammarlab.runs.learn.from_labels import learn_from_labels
from grammarlab.runs.learn.report import report_text
from grammarlab.runs.sample.shipped import find_rules
from tests.cases import takes_turns
from tests.preference.labelling import label_models

RULES = """version "2023.0"
attr height = rand(3, 9)
@StartRule
Lot --> extrude(height) split(y) { ~1 : Part | ~1 : Part }
Part --> 50% : color("#ff0000") Wall else : color("#0000ff") Wall
Wall --> 20% : Glass. 30% : Brick. else : Stone.
"""
BOTTOM_RED, GLASS = parse("Lot > Part@0:0"), parse("Wall:0")


@pytest.fixture
def grammar(tmp_path):
    (tmp_path / "house.cga").write_text(RULES)
    return Grammar.parse(RULES)


def scored(grammar, score, number=80, seed=7, factor="overall"):
    """Labels of the first models of a seed."""
    forest = derive(grammar, number, seed)
    return label_models(grammar.hash, seed, range(number), score(forest).tolist(), factor)


def learn(tmp_path, labels, **options):
    options.setdefault("pool", Pool(0, 500))
    chosen = options.pop("method", ""), options.pop("base", "grammar"), options.pop("num_samples", NUM_SAMPLES)
    making = Making(*chosen, options.pop("max_rules", None))
    files = str(tmp_path / "house.cga"), labels, tmp_path / "new.cga"
    return learn_from_labels(*files, making, labels_from="labels.csv", **options)


def written(result):
    """The text of the new rule file."""
    return result.file.read_text()


UNEVEN = 1e-4
"""Divergence in nats of an even density from one that improbable explanations of the scores make a little uneven."""


def red_below(forest):
    return 60.0 * count(forest, [BOTTOM_RED])[:, 0]


def glassy(forest):
    return 100.0 * (count(forest, [GLASS])[:, 0] > 0)


@pytest.fixture(scope="module")
def red(tmp_path_factory):
    """What is learned from 80 scores of models that are red below; tests read it only."""
    return learned_from(red_below, tmp_path_factory.mktemp("red"))


@pytest.fixture(scope="module")
def glass(tmp_path_factory):
    """What is learned from 80 scores of models with glass; tests read it only."""
    return learned_from(glassy, tmp_path_factory.mktemp("glass"))


def learned_from(score, folder):
    (folder / "house.cga").write_text(RULES)
    return learn(folder, scored(Grammar.parse(RULES), score))


def is_learned(result, grammar, score):
    """Whether the density is that of the grammar times a score, up to rounding."""
    forest = derive(grammar, 1000, 99)
    wanted = score(forest)
    ratio = result.learned.ratio(forest)
    liked = wanted > 0
    assert (ratio[~liked] == 0).all()
    np.testing.assert_allclose(ratio[liked] / wanted[liked], (ratio[liked] / wanted[liked]).mean(), rtol=1e-9)


def test_labels_become_the_grammar_that_samples_in_proportion_to_them(grammar, red):
    result = red
    is_learned(result, grammar, red_below)
    assert [str(feature) for feature in result.density.features] in (
        ["Lot:* > Part@0:0"],
        ["Lot > Part@0:0"],
    )
    assert result.learned.method == "compile"
    assert result.density.measured.after.js < UNEVEN
    assert result.density.measured.before.js > 0.1
    assert sum(step.js for step in result.density.steps) < UNEVEN
    text = written(result)
    assert "Labels labels.csv: 80 scores" in text
    assert "rand(3, 9)" in text


def test_the_result_depends_on_nothing_but_its_arguments(grammar, red, tmp_path):
    assert written(learn(tmp_path, scored(grammar, red_below))) == written(red)


def test_factors_multiply(grammar, tmp_path):
    labels = scored(grammar, red_below, factor="colour") + scored(grammar, glassy, seed=8, factor="material")
    result = learn(tmp_path, labels)
    is_learned(result, grammar, lambda forest: red_below(forest) * glassy(forest))
    assert [factor.name for factor in result.factors] == ["colour", "material"]


def test_models_of_the_flattened_grammar_may_be_labelled(grammar, tmp_path):
    forest = derive(flattened(grammar).program, 80, 5)
    labels = label_models(hashes_of(grammar.hash)[1], 5, range(80), red_below(forest).tolist())
    is_learned(learn(tmp_path, labels), grammar, red_below)


def test_scattered_models_are_found_by_their_addresses(grammar, tmp_path):
    models = [3 + 100 * i for i in range(52)]
    scores = [float(red_below(derive(grammar, 1, 5, first_model=model))[0]) for model in models]
    is_learned(learn(tmp_path, label_models(grammar.hash, 5, models, scores)), grammar, red_below)


def test_what_no_exact_grammar_can_follow_is_left_to_an_acceptance_rule(grammar, tmp_path, monkeypatch):
    def refuse(*_arguments, **_options):
        raise InexactError("too many kinds of Lot")

    monkeypatch.setattr(Target, "compiled", refuse)
    result = learn(tmp_path, scored(grammar, red_below))
    assert result.learned.method == "acceptance"
    assert result.learned.rules_after == result.learned.rules_before
    assert result.learned.accept_rate == pytest.approx(0.5, abs=0.05)
    is_learned(result, grammar, red_below)
    assert "@Acceptance" in written(result)
    assert (red_below(GrammarSampler(Grammar.parse(written(result))).sample(50, 1)) > 0).all()


def test_no_more_rules_are_made_than_allowed_and_what_was_given_up_is_said(grammar, red, tmp_path):
    free = red
    assert free.learned.rules_after > free.learned.rules_before
    bound = learn(tmp_path, scored(grammar, red_below), max_rules=free.learned.rules_before)
    assert bound.learned.rules_after <= free.learned.rules_before
    assert "a grammar alone would have " in bound.learned.findings[0]
    assert f" and {free.learned.rules_before} are allowed" in bound.learned.findings[0]
    is_learned(bound, grammar, red_below)


def test_what_the_scores_do_not_depend_on_is_left_alone(grammar, glass):
    forest = derive(grammar, 500, 3)
    ratio = glass.learned.ratio(forest)
    is_red, is_glassy = red_below(forest) > 0, glassy(forest) > 0
    assert ratio[is_glassy].min() > 1.0
    assert ratio[~is_glassy].max() == 0.0
    assert ratio[is_red & is_glassy].mean() == pytest.approx(ratio[~is_red & is_glassy].mean())


def test_models_all_liked_alike_leave_the_grammar_as_it_is(grammar, tmp_path):
    result = learn(tmp_path, scored(grammar, lambda forest: np.full(forest.num_models, 40.0)))
    forest = derive(grammar, 200, 1)
    np.testing.assert_allclose(result.learned.ratio(forest), 1.0)
    assert result.density.features == ()


def test_an_even_base_makes_all_liked_trees_equally_likely(grammar, tmp_path):
    result = learn(tmp_path, scored(grammar, red_below), base="uniform")
    assert isinstance(result.learned, LearnedGrammar)
    assert result.learned.base == "uniform"
    forest = derive(grammar, 1000, 99)
    assert isinstance(result.learned, LearnedGrammar)
    density = np.exp(result.learned.log_density(forest))
    liked = red_below(forest) > 0
    # By hand: the bottom is red, its wall one of 3, the top 2 colours with 3 walls, and the height even over 6 m.
    np.testing.assert_allclose(density[liked], 1.0 / (3 * 2 * 3) / 6.0, rtol=1e-6)
    assert (density[~liked] == 0.0).all()
    assert result.density.measured.after.js < UNEVEN
    assert result.density.measured.before.js > 0.1
    sampled = result.learned.sample(900, 3)
    glass = count(sampled, [parse("Wall:0"), parse("Wall:1")]).mean(axis=0)
    assert glass == pytest.approx([2 / 3, 2 / 3], abs=0.08)


@takes_turns
def test_an_even_base_works_for_a_shipped_grammar(tmp_path):
    source = find_rules("airplane")
    shipped, assets = Grammar.parse(source.text()), source.assets
    forest = derive(shipped, 40, 7, assets=assets)
    scores = 80.0 * (count(forest, [parse("Wings:0")])[:, 0] > 0) + 10.0
    labels = label_models(shipped.hash, 7, range(40), scores.tolist(), "overall")
    settings, pool = Settings(FeatureOptions(1, ("paths",))), Pool(0, 500)
    result = learn_from_labels(
        "airplane",
        labels,
        tmp_path / "new.cga",
        Making(base="uniform"),
        labels_from="labels.csv",
        settings=settings,
        pool=pool,
    )
    assert result.learned.method == "compile"
    assert result.density.measured.after.js < 0.02
    assert result.density.measured.before.js > 0.1
    assert "base uniform" in (tmp_path / "new.cga").read_text()
    assert isinstance(result.learned, LearnedGrammar)
    some = result.learned.sample(20, 1)
    assert np.isfinite(result.learned.log_density(some)).all()


@takes_turns
@pytest.mark.parametrize(
    ("method", "most"), [("parameters", 0.15), ("structure", 0.01), ("tied", 0.01), ("rejection", UNEVEN)]
)
def test_other_methods_make_the_grammar_from_samples(grammar, tmp_path, method, most):
    result = learn(tmp_path, scored(grammar, red_below), method=method, num_samples=400)
    assert result.learned.method == method
    assert result.density.measured.after.js < most < result.density.measured.before.js
    assert (result.file is None) == (method == "rejection")


def test_an_unknown_method_is_refused(grammar, tmp_path):
    with pytest.raises(UsageError, match="unknown method 'magic'"):
        learn(tmp_path, scored(grammar, red_below), method="magic")


def test_contradicting_scores_are_averaged(grammar, tmp_path):
    twice = scored(grammar, red_below) + scored(grammar, lambda forest: red_below(forest) / 3)
    result = learn(tmp_path, twice)
    forest = derive(grammar, 1000, 99)
    liked = red_below(forest) > 0
    ratio = result.learned.ratio(forest)
    assert ratio[liked].min() > 5 * ratio[~liked].max()


def test_one_label_is_enough_for_an_answer(grammar, tmp_path):
    labels = Labels((Label(1, 0, "overall", 50.0, grammar.hash),))
    assert learn(tmp_path, labels).learned.ratio(derive(grammar, 50, 1)).min() > 0.0


@takes_turns
def test_thousands_of_labels_are_learned_from(grammar, tmp_path):
    is_learned(learn(tmp_path, scored(grammar, red_below, number=2_000)), grammar, red_below)


@takes_turns
def test_thousands_of_features_are_looked_at(tmp_path):
    rules = [f"S{i} --> " + " ".join(f"5% : L{i}x{j}" for j in range(19)) + f" else : L{i}x19" for i in range(52)]
    text = "Lot --> " + " ".join(f"S{i}" for i in range(52)) + "\n" + "\n".join(rules)
    (tmp_path / "house.cga").write_text(text)
    many = Grammar.parse(text)
    # The 2 liked ones among the first 80 are no evidence in a thousand columns.
    result = learn(tmp_path, scored(many, lambda forest: 70.0 * count(forest, [parse("L3x7")])[:, 0], number=200))
    assert len(result.density.predicted.shares) > 1_000
    is_learned(result, many, lambda forest: 70.0 * count(forest, [parse("L3x7")])[:, 0])


def test_a_grammar_that_never_ends_is_told(tmp_path):
    (tmp_path / "house.cga").write_text("Lot --> A Lot")
    labels = Labels((Label(1, 0, "overall", 50.0, Grammar.parse("Lot --> A Lot").hash),))
    with pytest.raises(LanguageError, match="the rule Lot never ends"):
        learn(tmp_path, labels)


def test_an_even_base_of_infinitely_many_trees_leaves_them_as_likely_as_they_were(tmp_path):
    text = "Lot --> 60% : Leaf else : Lot Lot"
    (tmp_path / "house.cga").write_text(text)
    grammar = Grammar.parse(text)
    labels = scored(grammar, lambda forest: 50.0 * (count(forest, [parse("Leaf")])[:, 0] > 1))
    result = learn(tmp_path, labels, base="uniform")
    assert result.learned.method == "acceptance"
    assert result.density.measured.after.js < 0.01


def test_labels_of_another_grammar_are_refused_with_a_way_on(grammar, tmp_path):
    labels = scored(Grammar.parse(RULES.replace("20%", "25%")), red_below)
    with pytest.raises(UsageError, match=r"80 of 80 labels are about another grammar.*score models of this one anew"):
        learn(tmp_path, labels)
    assert not (tmp_path / "new.cga").exists()


def ties(grammar, number=12):
    """Ties between models of one seed."""
    others = [f'{{"seed":7,"model":{model + number}}}' for model in range(number)]
    own = (Label(7, m, "overall", 50.0, grammar.hash, kind="tie", other=others[m]) for m in range(number))
    return Labels(tuple(own))


def test_ties_alone_like_nothing(grammar, tmp_path):
    with pytest.raises(UsageError, match="all 12 comparisons are ties, so nothing is liked"):
        learn(tmp_path, ties(grammar))


@takes_turns
def test_scores_of_nothing_are_no_scale(grammar, tmp_path):
    for least in (5e-324, 1e-300, 1e-160):
        labels = scored(grammar, lambda forest, least=least: least * red_below(forest), number=16)
        result = learn(tmp_path, labels)
        assert np.isfinite(result.learned.ratio(derive(grammar, 200, 1))).all()


def test_nothing_liked_is_told(grammar, tmp_path):
    with pytest.raises(UsageError, match="all 80 scores of 'overall' are 0"):
        learn(tmp_path, scored(grammar, lambda forest: np.zeros(forest.num_models)))
    zeros = scored(grammar, lambda forest: np.zeros(forest.num_models), 8)
    with pytest.raises(UsageError, match="all 8 scores of 'overall' are 0"):
        learn(tmp_path, Labels((*zeros, *ties(grammar))))


def test_no_labels_are_told(grammar, tmp_path):
    with pytest.raises(UsageError, match="there are no labels"):
        learn(tmp_path, Labels())


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"start_rule": "Nothing"}, "unknown start rule Nothing"),
        ({"attributes": '{"depth":3}'}, "depth, which is not an attribute"),
        ({"footprint": "/etc/hosts"}, "is a file"),
        ({"footprint": "lots.geojson"}, "is a file"),
        ({"footprint": "round"}, "expected WIDTHxDEPTH"),
    ],
)
def test_addresses_that_cannot_be_followed_are_refused(grammar, tmp_path, change, message):
    labels = Labels((Label(1, 0, "overall", 50.0, grammar.hash, **change),))
    with pytest.raises(UsageError, match=message):
        learn(tmp_path, labels)


def test_too_many_models_are_refused_before_any_is_derived(grammar, tmp_path, monkeypatch):
    monkeypatch.setattr("grammarlab.learning.answers.MAX_DESIGNS", 10)
    with pytest.raises(UsageError, match="about 80 models; 10 can be learned from"):
        learn(tmp_path, scored(grammar, red_below))


def test_the_report_says_what_happened(red):
    text = report_text(page_of_labels(red))
    assert "| branches of rules | 6 | 7 |" in text
    assert "| models that rejection would accept | " in text
    assert "- Lot › Part 1" in text


def test_the_report_shows_a_choice_as_two_models_that_differ_in_it_alone(glass):
    page = page_of_labels(glass)
    choices = page.choices()
    assert {choice.text for choice in choices} == {"Wall = Glass"}
    assert (round(choices[0].without), round(choices[0].having), choices[0].scene.num_models) == (0, 100, 2)
    assert "![Wall = Glass](choice-1.png)" in report_text(page, choices)
