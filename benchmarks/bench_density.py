"""How fast a known preference becomes a grammar, and how fast that grammar samples beside the original.

Ratios within one run: sampling has to be at least 0.8 times as fast as before, whatever the machine.
"""

from __future__ import annotations

from functools import cache
from time import process_time

import numpy as np
import pytest

from grammarlab.assets.mesh_files import AssetFolder
from grammarlab.density.exact.contexts import Contexts, NoContext
from grammarlab.density.exact.learned import LearnedGrammar
from grammarlab.density.grammar_skeleton import MAX_EXAMINED_MODELS, TreeGrammar
from grammarlab.density.samples.choices import Choices
from grammarlab.density.samples.mixture import Cells, fit_mixture
from grammarlab.density.targets.rejection import reject, thin
from grammarlab.density.targets.target import Target
from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.derive import derive
from grammarlab.derivation.selection import select_models
from grammarlab.evaluation.scenario import load
from grammarlab.features.patterns.counts import count
from grammarlab.language.grammar import Grammar
from grammarlab.learning.designs.flattening import flattened
from grammarlab.runs.evaluate.request import shipped_scenarios
from grammarlab.runs.sample.shipped import examples_folder

NAMES = ("F1", "F2", "F3", "F4", "B1", "B2", "B3", "B4", "S1", "S2", "A1", "L3", "L4", "L5")
ASSETS = AssetFolder(examples_folder() / "assets")


@cache
def source(name: str):
    scenario = load(shipped_scenarios()[name])
    text = (examples_folder() / f"{scenario.grammar}.cga").read_text(encoding="utf-8")
    return scenario, Grammar.parse(text)


@cache
def sample_of(grammar: Grammar):
    return derive(flattened(grammar).program, MAX_EXAMINED_MODELS, 0, assets=ASSETS)


@cache
def learned_from(name: str) -> LearnedGrammar:
    scenario, grammar = source(name)
    return Target.of_score(grammar, scenario.score).compiled(sample_of(grammar))


@pytest.mark.parametrize("name", NAMES)
def test_compile(benchmark, name):
    scenario, grammar = source(name)
    forest = sample_of(grammar)
    learned = benchmark(lambda: Target.of_score(grammar, scenario.score).compiled(forest))
    benchmark.extra_info |= {"rules_before": learned.rules_before, "rules_after": learned.rules_after}


@pytest.mark.parametrize(("name", "num_models"), [("F1", 4000), ("B1", 300), ("S1", 1000), ("A1", 2000)])
def test_sampling_beside_the_original(benchmark, name, num_models):
    _, grammar = source(name)
    programs = compile_grammar(grammar), compile_grammar(learned_from(name).grammar)
    seconds = [[], []]

    def both():
        for program, found in zip(programs, seconds, strict=True):
            begun = process_time()
            derive(program, num_models, 1, assets=ASSETS)
            found.append(process_time() - begun)

    benchmark.pedantic(both, rounds=5)
    ratio = min(seconds[0]) / min(seconds[1])
    benchmark.extra_info["times as fast"] = ratio
    assert ratio >= 0.8


@pytest.mark.parametrize(("name", "num_models"), [("F1", 2000), ("B1", 200)])
def test_sampling_beside_rejection_with_a_known_score(benchmark, name, num_models):
    """Rejection at its best: proposals of the grammar, a score that is an expression, and a bound that is known.

    A compiled grammar gains what rejection throws away, and the counting of features: 1 / (share accepted), times what
    counting adds to deriving.
    """
    scenario, grammar = source(name)
    target = Target.of_score(grammar, scenario.score, assets=examples_folder() / "assets")
    sampler = reject(target, num_pilot=300)
    program = compile_grammar(learned_from(name).grammar)
    samples = (lambda: derive(program, num_models, 1, assets=ASSETS)), (lambda: sampler.sample(num_models, 1))
    seconds = [[], []]

    def both():
        for sample, found in zip(samples, seconds, strict=True):
            begun = process_time()
            sample()
            found.append(process_time() - begun)

    benchmark.pedantic(both, rounds=3)
    benchmark.extra_info |= {"times as fast": min(seconds[1]) / min(seconds[0]), "accepted": sampler.pilot.rate}


@pytest.mark.parametrize(("name", "num_models", "num_proposals"), [("F1", 4000, 20_000), ("B1", 300, 2_000)])
def test_sampling_beside_rejection_as_in_the_paper(benchmark, name, num_models, num_proposals):
    """Section 4.6: models in proportion to the score u alone, so a model is accepted with u / (C p) and C is found by
    sampling.

    The bound C is set by the least probable model met that is liked, and grows with every such model: of the few
    models accepted here, fewer would be with more proposals, so the factor is a lower bound.
    """
    scenario, grammar = source(name)
    features = scenario.score.features
    even = Target.of_score(grammar, scenario.score, "uniform").compiled(sample_of(grammar))
    programs = compile_grammar(even.grammar), compile_grammar(grammar)
    seconds = [0.0, 0.0]
    accepted = []

    def compiled():
        derive(programs[0], num_models, 1, assets=ASSETS)

    def propose(first, number):
        return derive(programs[1], number, 1, first_model=first, assets=ASSETS)

    middle = float(np.median(propose(0, 300).log_probability()))

    def weigh(forest):
        return scenario.score.evaluate(count(forest, features)) * np.exp(middle - forest.log_probability())

    def rejected():
        found = thin(propose, weigh, select_models, num_models, 1, most_proposals=num_proposals, chunk=num_models)
        accepted.append(found.acceptance.accepted)

    def both():
        for i, sample in enumerate((compiled, rejected)):
            begun = process_time()
            sample()
            seconds[i] += process_time() - begun

    benchmark.pedantic(both, rounds=1)
    factor = (num_models / seconds[0]) / (accepted[0] / seconds[1])
    benchmark.extra_info |= {"times as fast": factor, "accepted": accepted[0] / num_proposals}
    assert factor >= 50.0


def test_em_of_5000_models_and_80_components(benchmark):
    """Every step is a matrix product of counts and log-probabilities, and another one back."""
    _, grammar = source("B1")
    tree = TreeGrammar.of(grammar)
    choices = Choices.of(Contexts.of(tree, NoContext()))
    cells = Cells(choices.original, choices.choice)
    forest = derive(flattened(grammar).program, 5_000, 0, assets=ASSETS)
    counts = choices.count(grammar, forest)
    first = np.random.default_rng(0).integers(0, 80, 5_000)
    fit = benchmark.pedantic(fit_mixture, args=(cells, counts, np.ones(5_000), first), rounds=1)
    benchmark.extra_info |= {"steps": len(fit.log_likelihoods), "components": len(fit.mixture.weights)}
    assert len(fit.mixture.weights) > 40


@pytest.mark.parametrize("name", ["F1", "B1", "A1"])
def test_density_of_trees(benchmark, name):
    scenario, grammar = source(name)
    learned = learned_from(name)
    forest = sample_of(grammar)
    ratio = benchmark(learned.ratio, forest)
    values = scenario.score.evaluate(count(forest, scenario.score.features))
    np.testing.assert_allclose(ratio, values / learned.mean_preference, rtol=1e-10)
