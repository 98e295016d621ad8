"""Exact compile against brute force: all trees of small grammars, random patterns, random preferences."""

from collections import defaultdict
from itertools import product

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given
from hypothesis import strategies as st

from grammarlab.density.exact.compile import compile_density
from grammarlab.density.grammar_skeleton import Alternative, Chance, TreeGrammar
from grammarlab.derivation.derive import derive
from grammarlab.errors import GrammarlabError, InexactError
from grammarlab.features.patterns import counts as counting
from grammarlab.features.patterns import pattern_text
from grammarlab.language.grammar import Grammar
from tests.cases import bulk
from tests.density.trees import Tree, all_trees, count, grammars, patterns, text_of

MOST_TREES = 3000
few = bulk(40, suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much])


class Preference:
    """A value for every tuple of counts; many are zero, and equal and proportional ones are frequent."""

    def __init__(self, seed, zeros=0.3, cap=2**20):
        self.seed, self.zeros, self.cap = seed, zeros, cap

    def __call__(self, values):
        hashed = np.full(len(values), self.seed * 2654435761 % 2**32, dtype=np.uint64)
        for column in np.minimum(values, self.cap).T.astype(np.uint64):
            hashed = (hashed ^ (column + np.uint64(977))) * np.uint64(2246822519) % np.uint64(2**32)
            hashed ^= hashed >> np.uint64(15)
        uniform, level = hashed / 2.0**32, (hashed >> np.uint64(7)) % np.uint64(4)
        return np.where(
            uniform < self.zeros, 0.0, np.select([level == 0, level == 1, level == 2], [1.0, 2.0, 0.5], uniform)
        )


def learned_trees(learned):
    """Every tree of a learned grammar as a tree of the original, with its probability."""
    skeleton = TreeGrammar.of(learned.grammar)

    def ends(body, p, path=()):
        if isinstance(body, Alternative):
            yield p, body
        else:
            assert isinstance(body, Chance)
            assert body.probabilities is not None
            for i, inner in enumerate(body.branches):
                yield from ends(inner, p * body.probabilities[i], (*path, i))

    def trees(key):
        origin = learned.origins.get(key)
        name = origin.key[0] if origin else key[0]
        if key not in skeleton.bodies:
            return [(1.0, Tree(name, None))]
        found = []
        for p, end in ends(skeleton.bodies[key], 1.0):
            branch = origin.branches[end.branch or ()] if origin else end.branch
            for parts in product(*(trees(successor.key) for successor in end.successors)):
                children = tuple((i, tree) for i, (_, tree) in enumerate(parts))
                found.append((p * float(np.prod([q for q, _ in parts])), Tree(name, branch, children)))
        return found

    return trees(skeleton.start)


@few
@given(grammars(), st.lists(patterns(), min_size=1, max_size=3), st.integers(0, 1000))
def test_every_tree_has_the_probability_that_brute_force_gives_it(rules, features, seed):
    trees = all_trees(rules, "S")
    assume(len(trees) <= MOST_TREES)
    preference = Preference(seed)
    values = preference(np.array([[count(pattern, tree) for pattern in features] for _, tree in trees]))
    weights = np.array([p for p, _ in trees]) * values
    assume(weights.sum() > 0)
    learned = compile_density(Grammar.parse(text_of(rules)), features, preference)
    found = defaultdict(float)
    for p, tree in learned_trees(learned):
        found[tree] += p
    wanted = weights / weights.sum()
    assert learned.mean_preference == pytest.approx(weights.sum(), rel=1e-12)
    assert [found[tree] for _, tree in trees] == pytest.approx(wanted, rel=1e-12, abs=1e-15)
    assert set(found) <= {tree for _, tree in trees}


@few
@given(grammars(), st.lists(patterns(), min_size=1, max_size=3), st.integers(0, 1000))
def test_an_even_base_counts_every_tree_once(rules, features, seed):
    trees = all_trees(rules, "S")
    assume(len(trees) <= MOST_TREES)
    preference = Preference(seed)
    values = preference(np.array([[count(pattern, tree) for pattern in features] for _, tree in trees]))
    assume(values.sum() > 0)
    learned = compile_density(Grammar.parse(text_of(rules)), features, preference, base="uniform")
    found = defaultdict(float)
    for p, tree in learned_trees(learned):
        found[tree] += p
    assert [found[tree] for _, tree in trees] == pytest.approx(values / values.sum(), rel=1e-11, abs=1e-15)


@few
@given(grammars(), st.lists(patterns(), min_size=1, max_size=3), st.integers(0, 1000))
def test_the_ratio_of_densities_is_the_preference_by_its_mean(rules, features, seed):
    grammar = Grammar.parse(text_of(rules))
    forest = derive(grammar, 50, seed)
    preference = Preference(seed)
    values = preference(counting.count(forest, features))
    assume(values.any())
    learned = compile_density(grammar, features, preference)
    assert learned.ratio(forest) == pytest.approx(values / learned.mean_preference, rel=1e-10, abs=1e-14)
    again = Grammar.parse(learned.grammar.text)
    assert again.tree == learned.grammar.tree


@few
@given(grammars(), st.lists(patterns(), min_size=1, max_size=3), st.integers(0, 1000))
def test_what_is_not_liked_is_not_sampled(rules, features, seed):
    preference = Preference(seed, zeros=0.6)
    try:
        learned = compile_density(Grammar.parse(text_of(rules)), features, preference)
    except GrammarlabError:
        return
    forest = learned.sample(200, seed)
    assert (preference(counting.count(forest, features)) > 0).all()


@bulk(30, suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much])
@given(grammars(recursive=True), st.lists(patterns(1), min_size=1, max_size=2), st.integers(0, 1000))
def test_recursive_grammars_follow_capped_counts(rules, features, seed):
    grammar = Grammar.parse(text_of(rules))
    preference = Preference(seed, cap=2)
    forest = derive(grammar, 200, seed)
    values = preference(counting.count(forest, features))
    assume(values.any())
    learned = compile_density(grammar, features, preference, cap=3)
    assert learned.ratio(forest) == pytest.approx(values / learned.mean_preference, rel=1e-10, abs=1e-14)
    sampled = learned.sample(200, seed)
    assert (preference(counting.count(sampled, features)) > 0).all()


def test_a_preference_for_nothing_is_told():
    grammar = Grammar.parse("Lot --> 50%: Low else: High")
    with pytest.raises(GrammarlabError, match=r"nothing to sample; Tower never occurs"):
        compile_density(grammar, [pattern_text.parse("Tower")], lambda v: v[:, 0])


def test_a_symbol_that_never_occurs_changes_nothing():
    grammar = Grammar.parse("Lot --> 50%: Low else: High")
    learned = compile_density(grammar, [pattern_text.parse("Tower")], lambda v: 3.0 + v[:, 0])
    assert learned.text == grammar.text
    assert learned.mean_preference == 3.0


def test_a_grammar_that_never_ends_is_told():
    grammar = Grammar.parse("Lot --> 50%: Low Lot else: Lot High")
    with pytest.raises(GrammarlabError, match="no derivation of Lot ends"):
        compile_density(grammar, [pattern_text.parse("Low")], lambda v: 1.0 + v[:, 0])


def test_an_unbounded_preference_over_a_recursive_grammar_is_refused():
    grammar = Grammar.parse("Lot --> 50%: Low Lot else: High")
    with pytest.raises(GrammarlabError, match="score with comparisons"):
        compile_density(grammar, [pattern_text.parse("Low")], lambda v: 1.0 + v[:, 0])


@pytest.mark.parametrize("text", ["Lot --> 50% : A else : A Lot", "Lot --> 90% : A else : Lot Lot"])
def test_an_even_base_needs_finitely_many_trees(text):
    grammar = Grammar.parse(text)
    with pytest.raises(InexactError, match=r"Lot calls itself so often .* finitely many trees"):
        compile_density(grammar, [pattern_text.parse("A")], lambda v: (v[:, 0] >= 3).astype(np.float64), base="uniform")


@pytest.mark.parametrize("parts", ["extrude(3) split(y) { ~1 : D }*", "D D D"])
def test_an_even_base_counts_the_trees_of_each_copy(parts):
    """Three copies with two trees each have eight trees together, against one tree without them."""
    grammar = Grammar.parse(f"Lot --> 50%: Q. X else: W.\nX --> 50%: {parts} else: NIL\nD --> 10%: S. else: T.")
    learned = compile_density(
        grammar,
        [pattern_text.parse("Q.")],
        lambda v: v[:, 0].astype(np.float64),
        base="uniform",
        forest=derive(grammar, 200, 1),
    )
    X, D = (learned.text.partition(f"\n{name} -->")[2].split("%")[0] for name in "XD")
    assert (float(X), float(D)) == (pytest.approx(800.0 / 9.0), pytest.approx(50.0))


@pytest.mark.parametrize("values", [np.nan, -1.0, np.inf])
def test_a_preference_must_be_a_density(values):
    grammar = Grammar.parse("Lot --> 50%: Low else: High")
    with pytest.raises(GrammarlabError, match="finite and at least 0"):
        compile_density(grammar, [pattern_text.parse("Low")], lambda v: np.full(len(v), values))


def test_what_sizes_decide_is_refused_where_it_matters():
    text = "Lot --> s(rand(2, 9), 1, 1) split(x) { 1 : Bay }*\nBay --> 50%: Window. else: Door."
    with pytest.raises(GrammarlabError, match="how often Lot has Bay"):
        compile_density(Grammar.parse(text), [pattern_text.parse("Window.")], lambda v: np.sign(v[:, 0]))


def test_a_case_whose_branches_are_liked_differently_is_refused():
    text = "attr tall = rand(0, 1)\nLot --> case tall > 0.5 : Tower else : House\nTower --> A.\nHouse --> B."
    with pytest.raises(GrammarlabError, match="Lot chooses by a condition"):
        compile_density(Grammar.parse(text), [pattern_text.parse("Tower")], lambda v: 1.0 + v[:, 0])
