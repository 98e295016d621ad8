"""The engine against the per-shape interpreter, and its costs one by one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.grammars import FACADES, chain
from grammarlab.assets.mesh_files import AssetFolder
from grammarlab.derivation import compile_grammar, derive
from grammarlab.derivation.selection import select_models
from grammarlab.language.grammar import Grammar
from grammarlab.language.importing import load
from grammarlab.scene import realize
from grammarlab.scene.triangles import triangles
from tests.oracle.interpreter import interpret
from tests.oracle.shape import Mesh

GRAMMARS = Path(__file__).parent.parent / "grammars"


@pytest.fixture(scope="module")
def building():
    return compile_grammar(load(GRAMMARS / "building.cga")), AssetFolder(GRAMMARS / "assets")


def test_derive_1000_buildings(benchmark, building):
    program, assets = building
    forest = benchmark(derive, program, 1000, 1, assets=assets)
    benchmark.extra_info["leaves per model"] = len(forest.leaves) / 1000


def test_derive_5_buildings_shape_by_shape(benchmark):
    grammar, assets = load(GRAMMARS / "building.cga"), AssetFolder(GRAMMARS / "assets")

    def derive_five():
        return [
            interpret(grammar, 1, k, assets=lambda name: Mesh.from_columns(assets.load(name).meshes)) for k in range(5)
        ]

    benchmark.pedantic(derive_five, rounds=3)


def test_derive_1000_buildings_with_log_probability(benchmark, building):
    program, assets = building
    benchmark(lambda: derive(program, 1000, 1, assets=assets).log_probability())


@pytest.fixture(scope="module")
def buildings_of_340_leaves(building):
    """The 1,000 buildings nearest to 340 leaves among 4,000; the mean of all is about 520."""
    program, assets = building
    forest = derive(program, 4000, 1, assets=assets)
    leaves = np.bincount(forest.nodes.model[forest.leaves.node], minlength=4000)
    return select_models(forest, np.sort(np.argsort(np.abs(leaves - 340), kind="stable")[:1000]))


def test_merge_1000_buildings_of_340_leaves(benchmark, buildings_of_340_leaves):
    """From the forest to merged vertices, normals and triangles: at most 150 ms."""
    batch = benchmark(lambda: triangles(realize(buildings_of_340_leaves)))
    assert np.isfinite(batch.vertices).all()
    benchmark.extra_info |= {
        "leaves per model": len(buildings_of_340_leaves.leaves) / 1000,
        "vertices per model": len(batch.vertices) / 1000,
    }


def test_write_as_many_bytes_as_1000_merged_buildings(benchmark, buildings_of_340_leaves):
    """What the memory alone costs: the merged arrays once more."""
    batch = triangles(realize(buildings_of_340_leaves))
    benchmark(lambda: (batch.vertices.copy(), batch.normals.copy(), batch.triangles.copy()))


def test_derive_one_model_of_3000_leaves(benchmark):
    program = compile_grammar(Grammar.parse(FACADES))
    forest = benchmark(derive, program, 1, 1, footprint=(30.0, 30.0))
    benchmark.extra_info["leaves"] = len(forest.leaves)


def test_derive_one_model_that_touches_400_rules(benchmark):
    program = compile_grammar(Grammar.parse(chain(400)))
    forest = benchmark(derive, program, 1, 1, footprint=(400.0, 10.0))
    assert len(np.unique(forest.nodes.rule)) >= 400
