"""How fast a known preference becomes a grammar, and how fast that grammar samples beside the original.

Ratios within one run: sampling has to be at least 0.8 times as fast as before, whatever the machine.
"""

from __future__ import annotations

from functools import cache
from time import process_time

import numpy as np
import pytest

from grammarlab.density.compile import compile_score
from grammarlab.density.learned import LearnedGrammar
from grammarlab.density.skeleton import ENOUGH_MODELS
from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.derive import derive
from grammarlab.evaluation.flattening import flattened
from grammarlab.evaluation.scenario import load
from grammarlab.features.counting import count
from grammarlab.geometry.assets import AssetFolder
from grammarlab.language.grammar import Grammar
from grammarlab.runs.evaluate.find import shipped_scenarios
from grammarlab.runs.examples import examples_folder

NAMES = ("F1", "F2", "F3", "F4", "B1", "B2", "B3", "B4", "S1", "S2", "A1", "L3", "L4", "L5")
ASSETS = AssetFolder(examples_folder() / "assets")


@cache
def source(name: str):
    scenario = load(shipped_scenarios()[name])
    text = (examples_folder() / f"{scenario.grammar}.cga").read_text(encoding="utf-8")
    return scenario, Grammar.parse(text)


@cache
def sample_of(grammar: Grammar):
    return derive(flattened(grammar).program, ENOUGH_MODELS, 0, assets=ASSETS)


@cache
def learned_from(name: str) -> LearnedGrammar:
    scenario, grammar = source(name)
    return compile_score(grammar, scenario.score, forest=sample_of(grammar))


@pytest.mark.parametrize("name", NAMES)
def test_compile(benchmark, name):
    scenario, grammar = source(name)
    forest = sample_of(grammar)
    learned = benchmark(compile_score, grammar, scenario.score, forest=forest)
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


@pytest.mark.parametrize("name", ["F1", "B1", "A1"])
def test_density_of_trees(benchmark, name):
    scenario, grammar = source(name)
    learned = learned_from(name)
    forest = sample_of(grammar)
    ratio = benchmark(learned.ratio, forest)
    values = scenario.score.evaluate(count(forest, scenario.score.features))
    np.testing.assert_allclose(ratio, values / learned.mean_preference, rtol=1e-10)
