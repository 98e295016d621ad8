"""Learning from samples: what is written down is what was fitted, and it comes near what is wanted."""

from itertools import product

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given
from hypothesis import strategies as st

from grammarlab.density.grammar_skeleton import Alternative, Cases, Chance, TreeGrammar
from grammarlab.density.samples.choices import Choices
from grammarlab.density.samples.mixture import Cells, Mixture
from grammarlab.density.samples.sampled import METHODS, learn, written
from grammarlab.density.targets.target import Target
from grammarlab.derivation.derive import derive
from grammarlab.errors import GrammarlabError, UsageError
from grammarlab.features.expression import Expression
from grammarlab.features.model_score import Score, ScoreCase
from grammarlab.features.patterns import counts as counting
from grammarlab.features.patterns import pattern_text
from grammarlab.features.patterns.pattern import Threshold
from grammarlab.language.grammar import Grammar
from grammarlab.learning.targets.divergence import jensen_shannon
from tests.cases import bulk
from tests.density.samples.test_choices import cells_taken, contexts_of
from tests.density.trees import Tree, all_trees, grammars, patterns, text_of

few = bulk(25, suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much])

STYLES = Grammar.parse(
    """
version "2023.0"
// A house of three parts
Lot --> Wall Door Roof Garden
Wall --> 25% : OldWall 25% : NewWall else : PlainWall
Door --> 25% : OldDoor 25% : NewDoor else : PlainDoor
Roof --> 25% : OldRoof 25% : NewRoof else : PlainRoof
// How it is planted does not matter.
Garden --> 50% : Trees else : 50% : Bed Bed else : Bed
Bed --> 10% : Roses else : Tulips
"""
)
OLD = "{OldWall} and {OldDoor} and {OldRoof}"
NEW = "{NewWall} and {NewDoor} and {NewRoof}"


def score(*cases):
    return Score.of_cases([ScoreCase(value, Expression.parse(when)) for value, when in cases])


STYLE = score((40, OLD), (20, NEW))


def divergence(learned, target, seed=77, number=4_000):
    forest = derive(target.grammar, number, seed)
    return jensen_shannon(target.of_models(forest), learned.ratio(forest))


def mixture_trees(learned):
    """Every tree of a learned grammar as a tree of the original, with its probability, from the text alone."""
    skeleton = TreeGrammar.of(learned.grammar)

    def ends(body, p, component):
        if isinstance(body, Alternative):
            yield p, body
        elif isinstance(body, Cases):
            yield from ends(body.branches[component], p, component)
        else:
            for probability, inner in zip(body.probabilities, body.branches, strict=True):
                yield from ends(inner, p * probability, component)

    def trees(key, component):
        origin = learned.origins.get(key)
        name = origin.key[0] if origin else key[0]
        if key not in skeleton.bodies:
            return [(1.0, Tree(name, None))]
        found = []
        for p, end in ends(skeleton.bodies[key], 1.0, component):
            branch = origin.branches[end.branch or ()] if origin else end.branch
            for parts in product(*(trees(successor.key, component) for successor in end.successors)):
                children = tuple((i, tree) for i, (_, tree) in enumerate(parts))
                found.append((p * float(np.prod([q for q, _ in parts])), Tree(name, branch, children)))
        return found

    total = {}
    for number, component in enumerate(learned.components):
        for p, tree in trees(skeleton.start, number):
            total[tree] = total.get(tree, 0.0) + component.probability * p
    return total


@st.composite
def mixtures(draw):
    """A small grammar, and a random mixture of grammars of its split symbols; many probabilities are 0 or 1."""
    rules = draw(grammars())
    features = draw(st.lists(patterns(), max_size=2))
    grammar = Grammar.parse(text_of(rules))
    choices = Choices.of(
        contexts_of(TreeGrammar.of(grammar), features, draw(st.sampled_from(["none", "edges", "open"])))
    )
    random = np.random.default_rng(draw(st.integers(0, 2**32)))
    number = draw(st.integers(1, 3))
    raw = random.integers(0, 3, size=(number, len(choices.original))) * random.random((number, 1))
    raw[:, choices.original == 0.0] = 0.0
    probabilities = Cells(choices.original, choices.choice).normalised(raw.astype(float))
    return rules, grammar, choices, Mixture(random.dirichlet(np.ones(number)), probabilities)


@few
@given(mixtures(), st.integers(0, 100))
def test_the_text_of_a_mixture_has_its_density(case, seed):
    rules, grammar, choices, mixture = case
    trees = all_trees(rules, "S")
    assume(len(trees) <= 500)
    learned = written(Target(grammar, (), lambda v: v), choices, mixture, "tied", 1.0, (), ("A header",))
    counts = np.array([cells_taken(choices, tree) for _, tree in trees])
    expected = np.zeros(len(trees))
    for alpha, probabilities in zip(mixture.weights, mixture.probabilities, strict=True):
        expected += alpha * np.prod(np.where(counts > 0, probabilities, 1.0) ** counts, axis=1)
    found = mixture_trees(learned)
    assert [found.get(tree, 0.0) for _, tree in trees] == pytest.approx(expected, rel=1e-11, abs=1e-14)
    assert sum(found.values()) == pytest.approx(1.0, abs=1e-12)

    forest = derive(grammar, 40, seed)
    cells = Cells(choices.original, choices.choice)
    ratio = np.exp(mixture.log_ratio(cells, choices.count(grammar, forest)))
    assert learned.ratio(forest) == pytest.approx(ratio, rel=1e-11, abs=1e-13)
    again = Grammar.parse(learned.text)
    assert again.tree == learned.grammar.tree


@pytest.mark.parametrize(("method", "most"), [("parameters", 0.4), ("structure", 0.003), ("tied", 0.001)])
def test_learned_grammars_come_near_what_is_wanted(method, most):
    target = Target.of_score(STYLES, STYLE)
    learned = learn(target, method, num_samples=3_000, seed=3)
    assert divergence(learned, target) < most
    assert learned.method == method
    assert learned.findings[0] == "3,000 models drawn by the exact grammar"


def test_two_styles_need_two_components_and_nothing_else():
    learned = learn(Target.of_score(STYLES, STYLE), "tied", num_samples=3_000, seed=3)
    assert len(learned.components) == 2
    assert sorted(c.probability for c in learned.components) == pytest.approx([1 / 3, 2 / 3], abs=0.03)
    assert "// How it is planted does not matter.\nGarden --> 50% : Trees" in learned.text
    sampled = learned.sample(500, 1)
    assert (STYLE.evaluate(counting.count(sampled, STYLE.features)) > 0).all()


def test_parameters_are_the_relative_frequencies_of_liked_models():
    target = Target.of_score(STYLES, score((100, "{OldWall} or {OldDoor}")))
    learned = learn(target, "parameters", num_samples=4_000, seed=3)
    wall = TreeGrammar.of(learned.grammar).body(("Wall", 0))
    assert isinstance(wall, Chance)
    assert wall.probabilities is not None
    # P(old wall | old wall or old door) = 1/4 / (1 - 9/16)
    assert wall.probabilities[0] == pytest.approx(4 / 7, abs=0.03)


def test_one_component_without_splits_is_parameter_learning():
    target = Target.of_score(STYLES, STYLE)
    one = learn(target, "parameters", num_samples=500, seed=3)
    other = learn(target, "structure", num_samples=500, seed=3, num_components=1)
    forest = derive(STYLES, 300, 5)
    np.testing.assert_allclose(one.ratio(forest), other.ratio(forest), rtol=1e-12)


def test_splits_learn_what_depends_on_the_place():
    towers = Grammar.parse("Tower --> 50% : Block Block else : Block Block Block\nBlock --> 40% : Box else : Round")
    target = Target.of_score(towers, score((100, "{Tower > Block@0:0}")))
    assert divergence(learn(target, "parameters", num_samples=2_000), target) > 0.02
    assert divergence(learn(target, "structure", num_samples=2_000), target) < 0.002
    tied = learn(target, "tied", num_samples=2_000)
    assert divergence(tied, target) == pytest.approx(0.0, abs=1e-12)
    assert len(tied.components) == 1


def test_descendants_at_any_depth_can_be_liked():
    grammar = Grammar.parse(
        "Lot --> 50% : Tower A else : A Tower\nTower --> 30% : A else : Red A\n"
        "A --> 50% : B else : Red\nB --> 50% : Red else : Blue"
    )
    target = Target.of_score(grammar, score((100, "{Tower >> Blue}")))
    assert divergence(learn(target, "tied", num_samples=4_000), target) < 0.002


def test_drawn_attributes_get_new_ranges():
    grammar = Grammar.parse("attr height = rand(0, 10)\nLot --> 50% : extrude(height) A else : extrude(height) B")
    liked = score((90, "$height < 2 and {A}"), (10, "$height >= 2 and {B}"))
    target = Target.of_score(grammar, liked)
    learned = learn(target, "tied", num_samples=4_000)
    assert divergence(learned, target) < 0.001
    assert "rand(0, 2)" in learned.text


def test_an_even_base_makes_all_trees_equal():
    grammar = Grammar.parse(
        "Lot --> A B\nA --> 90% : Old else : 50% : New else : Plain\nB --> 70% : Old else : 50% : New else : Plain"
    )
    forest = derive(grammar, 4_000, 9)
    every = Target.of_score(grammar, score((100, "{Lot}")), "uniform")
    target = Target.of_score(grammar, score((100, "{Old} == 1")), "uniform")
    for method in METHODS:
        learned = learn(every, method, num_samples=2_000)
        density = learned.ratio(forest) * np.exp(forest.log_probability())
        assert density == pytest.approx(np.full(4_000, 1 / 9), rel=0.2)
        assert learned.base == "uniform"
    learned = learn(target, "tied", num_samples=4_000)
    density = learned.ratio(forest) * np.exp(forest.log_probability())
    liked = counting.count(forest, [pattern_text.parse("Old")])[:, 0] == 1
    assert density[liked] == pytest.approx(np.full(liked.sum(), 1 / 4), rel=0.1)
    assert density[~liked] == pytest.approx(0.0, abs=1e-12)


def test_what_is_liked_equally_changes_nothing():
    target = Target.of_score(STYLES, score((50, "{Lot}")))
    learned = learn(target, "tied", num_samples=100)
    assert learned.text == STYLES.text
    assert learned.rules_after == learned.rules_before


def test_liking_nothing_is_told():
    target = Target.of_score(STYLES, score((100, "{Nowhere}")))
    for method in METHODS:
        with pytest.raises(GrammarlabError, match=r"0 for every model that the grammar makes.*Nowhere never occurs"):
            learn(target, method, num_samples=10)


def test_where_no_exact_grammar_draws_models_are_rejected():
    towers = Grammar.parse("Lot --> extrude(rand(1, 9)) split(y) { 2 : Block }*\nBlock --> 30% : Box else : Round")
    rare = Target.of_score(towers, score((100, "{Box} >= 4")))
    learned = learn(rare, "tied", num_samples=200, seed=1)
    assert learned.findings[0].startswith("accepted ")
    with pytest.raises(GrammarlabError, match="none of 300 models was accepted"):
        learn(Target.of_score(towers, score((100, "{Box} >= 9"))), "tied", num_samples=10, most_proposals=300)


def test_progress_is_told():
    told = []
    learn(Target.of_score(STYLES, STYLE), "tied", num_samples=600, on_progress=lambda *now: told.append(now))
    assert told[-1] == ("models drawn", 600, 600)
    assert [done for _, done, _ in told] == sorted(done for _, done, _ in told)


def test_a_single_model_can_be_learned_from():
    target = Target.of_score(STYLES, STYLE)
    for method in METHODS:
        learned = learn(target, method, num_samples=1)
        sampled = learned.sample(20, 1)
        assert (target.of_models(sampled) > 0).all()


def test_the_same_seed_gives_the_same_grammar():
    target = Target.of_score(STYLES, STYLE)
    texts = {learn(target, "structure", num_samples=200, seed=seed).text for seed in (1, 1, 2)}
    assert len(texts) == 2


def test_impossible_numbers_are_refused():
    target = Target.of_score(STYLES, STYLE)
    with pytest.raises(UsageError, match="at least one sample"):
        learn(target, "tied", num_samples=0)
    with pytest.raises(UsageError, match="one component"):
        learn(target, "tied", num_components=0)


def test_what_cannot_be_split_is_told():
    grammar = Grammar.parse("attr h = case width > 1 : rand(0, 3) else : 2\nattr width = 3\nLot --> 50% : A else : B")
    target = Target(grammar, (Threshold("h", 1.0), pattern_text.parse("A")), lambda v: 1.0 + v[:, 0] + v[:, 1])
    learned = learn(target, "tied", num_samples=300)
    assert any("$h keeps its density" in finding for finding in learned.findings)
