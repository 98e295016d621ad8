"""Rejection agrees with what can be computed."""

import numpy as np
import pytest
from scipy.stats import chisquare

from grammarlab.density.samples.sampled import learn
from grammarlab.density.targets.rejection import reject
from grammarlab.density.targets.target import Target
from grammarlab.derivation.derive import derive
from grammarlab.errors import GrammarlabError, UsageError
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.language.grammar import Grammar
from tests.density.samples.test_sampled import STYLE, STYLES, score

KINDS = [parse(text) for text in ("OldWall", "NewWall", "OldDoor", "NewDoor", "OldRoof", "NewRoof", "Trees", "Roses")]
LOOSE = score((90, "{OldWall} + {OldDoor} + {OldRoof} >= 2"), (30, "{NewWall}"), (6, "{Trees}"))


def kinds(forest):
    """A number for each kind of model."""
    return np.minimum(count(forest, KINDS), 2).astype(np.int64) @ 3 ** np.arange(len(KINDS))


def agree(one, other):
    """Whether two samples may come from one density: chi-square of their kinds, p > 0.001."""
    values, places = np.unique(np.concatenate([kinds(one), kinds(other)]), return_inverse=True)
    left = np.bincount(places[: one.num_models], minlength=len(values))
    right = np.bincount(places[one.num_models :], minlength=len(values))
    common = left + right >= 10
    left, right = left[common], right[common]
    share = (left + right) / (left + right).sum()
    found = np.concatenate([left, right])
    return chisquare(found, np.concatenate([share * left.sum(), share * right.sum()]), ddof=len(left)).pvalue > 0.001


@pytest.mark.parametrize("base", ["grammar", "uniform"])
def test_rejection_and_compile_agree(base):
    target = Target.of_score(STYLES, LOOSE, base)
    sampler = reject(target)
    compiled = Target.of_score(STYLES, LOOSE, base).compiled()
    assert agree(sampler.sample(20_000, 4), compiled.sample(20_000, 5))
    forest = derive(STYLES, 500, 6)
    assert sampler.ratio(forest) == pytest.approx(compiled.ratio(forest), rel=0.05, abs=1e-12)
    liked = compiled.ratio(forest) > 0
    assert sampler.log_density(forest)[liked] == pytest.approx(compiled.log_density(forest)[liked], abs=0.05)
    assert (sampler.log_density(forest)[~liked] == -np.inf).all()


def test_a_learned_grammar_can_propose():
    target = Target.of_score(STYLES, STYLE)
    plain = reject(target)
    quick = reject(target, proposal=learn(target, "parameters", num_samples=2_000, seed=1))
    assert quick.pilot.rate > 3 * plain.pilot.rate
    assert agree(quick.sample(5_000, 2), plain.sample(5_000, 3))


def test_no_model_without_a_score_is_made():
    target = Target.of_score(STYLES, STYLE)
    forest, acceptance = reject(target).draw(300, 8)
    assert forest.num_models == 300
    assert (target.of_models(forest) > 0).all()
    assert acceptance.has_bound
    assert acceptance.rate == pytest.approx((40 + 20) / 40 / 64, abs=0.01)


def test_models_do_not_depend_on_how_many_are_asked_for():
    sampler = reject(Target.of_score(STYLES, LOOSE))
    some, more = sampler.sample(100, 8), sampler.sample(1_000, 8)
    assert (kinds(more)[:100] == kinds(some)).all()
    assert (kinds(sampler.sample(1_000, 9)) != kinds(more)).any()


def test_a_preference_without_a_known_bound():
    target = Target(STYLES, (parse("Bed"), parse("OldWall")), lambda v: 1.0 + v[:, 0] + 3 * v[:, 1])
    sampler = reject(target)
    assert not sampler.pilot.has_bound
    assert sampler.pilot.bound == 6.0
    assert "the largest one met" in str(sampler.draw(10, 1)[1])


def test_what_never_occurs_is_told():
    grammar = Grammar.parse("Lot --> 50% : A else : B")
    with pytest.raises(GrammarlabError, match="too rare for rejection"):
        reject(Target.of_score(grammar, score((100, "{C}"))), most_proposals=3_000)
    with pytest.raises(UsageError, match="at least one model"):
        reject(Target.of_score(grammar, score((100, "{A}")))).sample(0, 1)
