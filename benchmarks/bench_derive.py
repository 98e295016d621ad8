"""The engine against the per-shape interpreter, and its costs one by one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.grammars import FACADES, chain
from grammarlab.derivation import compile_grammar, derive
from grammarlab.geometry.assets import AssetFolder
from grammarlab.language.grammar import Grammar
from grammarlab.language.importing import load
from grammarlab.scene import realize
from grammarlab.scene.triangles import triangles

GRAMMARS = Path(__file__).parent.parent / "grammars"


@pytest.fixture(scope="module")
def building():
    return compile_grammar(load(GRAMMARS / "building.cga")), AssetFolder(GRAMMARS / "assets")


def test_derive_1000_buildings(benchmark, building):
    program, assets = building
    forest = benchmark(derive, program, 1000, 1, assets=assets)
    benchmark.extra_info["leaves per model"] = len(forest.leaves) / 1000


def test_derive_1000_buildings_with_log_probability(benchmark, building):
    program, assets = building
    benchmark(lambda: derive(program, 1000, 1, assets=assets).log_probability())


def test_merge_1000_buildings_into_triangles(benchmark, building):
    program, assets = building
    scene = realize(derive(program, 1000, 1, assets=assets))
    batch = benchmark(triangles, scene)
    assert np.isfinite(batch.vertices).all()


def test_derive_one_model_of_3000_leaves(benchmark):
    program = compile_grammar(Grammar.parse(FACADES))
    forest = benchmark(derive, program, 1, 1, footprint=(30.0, 30.0))
    benchmark.extra_info["leaves"] = len(forest.leaves)


def test_derive_one_model_that_touches_400_rules(benchmark):
    program = compile_grammar(Grammar.parse(chain(400)))
    forest = benchmark(derive, program, 1, 1, footprint=(400.0, 10.0))
    assert len(np.unique(forest.nodes.rule)) >= 400
