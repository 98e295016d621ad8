"""Tables of path counts against a Counter filled tree by tree, over the same forests."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from statistics import median
from time import process_time

import pytest

from grammarlab.assets.mesh_files import AssetFolder
from grammarlab.derivation import derive
from grammarlab.features.columns.paths import count_paths, count_sequences
from grammarlab.features.columns.vocabulary import Options, Vocabulary
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.node_labels import KeyIndex, NodeLabels
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.features.patterns.tree_index import Trees
from grammarlab.language.importing import load

GRAMMARS = Path(__file__).parent.parent / "grammars"
NUM_MODELS = 5_000
"""As many as the labelled sets of the scenarios have."""
LARGE = {"building": 1_000, "skyscraper": 2_000}
"""Fewer of those that have hundreds of nodes each."""
LENGTHS = [2, 4]
NAMES = sorted(path.stem for path in GRAMMARS.glob("*.cga"))


@pytest.fixture(scope="module", params=NAMES)
def forest(request):
    name = request.param
    num_models = LARGE.get(name, NUM_MODELS)
    return derive(load(GRAMMARS / f"{name}.cga"), num_models, 1, assets=AssetFolder(GRAMMARS / "assets"))


def tree_by_tree(forest, length):
    """A Counter of paths for every model; paths are tuples of (rule, child), a rule alone at the end has child -1."""
    nodes = forest.nodes
    models, parents, rules, children = (c.tolist() for c in (nodes.model, nodes.parent, nodes.rule, nodes.child))
    counters = [Counter() for _ in range(forest.num_models)]
    for row in range(len(models)):
        counter, rule, above, edges = counters[models[row]], rules[row], row, ()
        for edge in range(length + 1):
            if edges:
                counter[edges] += 1
            if rule >= 0 and edge < length:
                counter[(*edges, (rule, -1))] += 1
            parent = parents[above]
            if parent < 0:
                break
            edges = ((rules[parent], children[above]), *edges)
            above = parent
    return counters


@pytest.mark.parametrize("length", LENGTHS)
def test_paths_tree_by_tree(benchmark, forest, length):
    benchmark.pedantic(tree_by_tree, (forest, length), rounds=1)
    _tell(benchmark, forest)


@pytest.mark.parametrize("length", LENGTHS)
def test_paths_by_columns(benchmark, forest, length):
    labels = NodeLabels.of([forest])

    def by_columns():
        index = KeyIndex()
        return count_paths(count_sequences(Trees(forest), labels, length, index, grow=True), len(index)).counts

    counts = benchmark(by_columns)
    _tell(benchmark, forest)
    benchmark.extra_info["columns"] = counts.shape[1]
    ratio = _seconds(lambda: tree_by_tree(forest, length), 3) / _seconds(by_columns, 15)
    benchmark.extra_info["times as fast as tree by tree"] = ratio


@pytest.mark.parametrize("length", LENGTHS)
def test_find_a_vocabulary(benchmark, forest, length):
    vocabulary = benchmark.pedantic(Vocabulary.find, (forest, Options(length)), rounds=3)
    _tell(benchmark, forest)
    benchmark.extra_info["columns kept"] = len(vocabulary.features)


@pytest.mark.parametrize("length", LENGTHS)
def test_apply_a_vocabulary(benchmark, forest, length):
    benchmark.pedantic(Vocabulary.find(forest, Options(length)).apply, (forest,), rounds=3)
    _tell(benchmark, forest)


@pytest.mark.parametrize("text", ["Block:1", "Tower[Block:0 >> Glass:2 + Block:1 >> Glass:0]", "* >> *"])
def test_count_a_pattern(benchmark, forest, text):
    benchmark(count, forest, [parse(text)])
    _tell(benchmark, forest)


def _seconds(run, rounds):
    """Processor time, the median of some rounds."""
    times = []
    for _ in range(rounds):
        start = process_time()
        run()
        times.append(process_time() - start)
    return median(times)


def _tell(benchmark, forest):
    benchmark.extra_info["nodes per model"] = len(forest.nodes) / forest.num_models
