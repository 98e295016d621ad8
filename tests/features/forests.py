"""Random derivation trees with few symbols, and what a pattern means, told by recursion over one tree."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from math import prod
from typing import Any

import numpy as np
from hypothesis import strategies as st

from grammarlab.derivation.forest import Draws, Forest, Leaves, Nodes, Reports, RuleName, Site
from grammarlab.derivation.lots import Lots
from grammarlab.derivation.materials import CHANNELS, Materials
from grammarlab.features.patterns.pattern import Below, Pattern
from grammarlab.geometry.meshes.mesh import Meshes

SYMBOLS = ("A", "B", "Leaf.")
RULES = (
    RuleName("A", 0, (0,), 1),
    RuleName("A", 0, (1, 0), 2),
    RuleName("A", 0, (1, 1), 3),
    RuleName("A", 1, (), 4),
    RuleName("B", 0, (0,), 5),
    RuleName("B", 0, (1,), 6),
)
SITES = (Site("h", "uniform", "h", 1, 0), Site("A", "choice", "A", 2, 3), Site("h", "uniform", "h", 1, 0))


def forest_of(
    nodes: Sequence[tuple[int, ...]],
    draws: list[tuple[int, int, float]] | None = None,
    num_models: int | None = None,
) -> Forest:
    """A forest of nodes (model, parent, symbol, rule, child, repeat) and draws (node, site, value)."""
    table = np.array(nodes, dtype=np.int64).reshape(-1, 6)
    drawn = np.array(draws or [], dtype=np.float64).reshape(-1, 3)
    types = (np.int32, np.int32, np.int16, np.int16, np.int16, np.int32)
    columns: list[Any] = [table[:, i].astype(kind) for i, kind in enumerate(types)]
    empty = np.zeros(0, np.int32)
    num_models = int(table[:, 0].max(initial=-1)) + 1 if num_models is None else num_models
    return Forest(
        lots=Lots.of(num_models, seed=0),
        symbols=SYMBOLS,
        rules=RULES,
        sites=SITES,
        nodes=Nodes(*columns),
        leaves=Leaves(empty, np.zeros((0, 3)), np.zeros((0, 3)), empty, empty, empty, empty),
        draws=Draws(
            drawn[:, 0].astype(np.int32), drawn[:, 1].astype(np.int16), drawn[:, 2].copy(), np.zeros(len(drawn))
        ),
        reports=Reports(empty, empty, np.zeros(0), ()),
        frames=np.eye(3)[None],
        meshes=Meshes.from_polygons(np.zeros((0, 3)), np.zeros(0, np.int64)),
        materials=Materials(np.zeros((0, len(CHANNELS))), ()),
        texture_maps=np.zeros((0, 2, 4)),
    )


def random_forest(rng: np.random.Generator, num_models: int, nodes_per_model: int, depth: float = 0.5) -> Forest:
    """Trees whose siblings are numbered as the engine numbers them, rows of the models mixed.

    Args:
        rng: decides all.
        num_models: at least 1.
        nodes_per_model: at most; at least 1.
        depth: 0 for flat trees, 1 for deep ones.
    """
    rows: list[tuple[int, int, int, int, int, int]] = []
    members: list[list[int]] = [[] for _ in range(num_models)]
    made: dict[tuple[int, int], int] = {}
    own = {symbol: [i for i, rule in enumerate(RULES) if rule.symbol == symbol] for symbol in SYMBOLS}
    for _ in range(num_models * nodes_per_model):
        model = int(rng.integers(num_models))
        parents = [row for row in members[model] if rows[row][3] >= 0]
        if members[model] and not parents:
            continue
        parent = parents[int(len(parents) * rng.random() ** max(0.001, 1.0 - depth))] if parents else -1
        child = int(rng.integers(3)) if parents else 0
        repeat = made.get((parent, child), 0) if parents else 0
        made[parent, child] = repeat + 1
        symbol = int(rng.integers(len(SYMBOLS)))
        choices = own[SYMBOLS[symbol]]
        rule = int(rng.choice(choices)) if choices and (not parents or rng.random() < 0.8) else -1
        members[model].append(len(rows))
        rows.append((model, parent, symbol, rule, child, repeat))
    draws = [
        (int(rng.integers(len(rows))), int(rng.integers(3)), float(rng.integers(3))) for _ in range(2 * num_models)
    ]
    return forest_of(rows, draws, num_models)


def brute_force(forest: Forest, pattern: Pattern) -> list[int]:
    """The count in every model, as the definition says: node by node, by recursion."""
    nodes = forest.nodes
    children = children_of(forest)

    @cache
    def ways(pattern: Pattern, row: int) -> int:
        total = int(fits(forest, pattern, row))
        for below in pattern.below:
            total *= total and anywhere(below, row)
        return total

    def anywhere(below: Below, row: int) -> int:
        found = direct(below, row)
        if below.deep:
            found += sum(anywhere(below, child) for child in children[row])
        return found

    def direct(below: Below, row: int) -> int:
        siblings, total = children[row], 0
        for start, first in enumerate(siblings[: len(siblings) - len(below.run) + 1]):
            if below.child is None or nodes.child[first] == below.child:
                total += prod(ways(part, siblings[start + offset]) for offset, part in enumerate(below.run))
        return total

    counts = [0] * forest.num_models
    for row in range(len(nodes)):
        counts[nodes.model[row]] += ways(pattern, row)
    return counts


def children_of(forest: Forest) -> list[list[int]]:
    """The rows below each row, siblings in their order."""
    nodes = forest.nodes
    children: list[list[int]] = [[] for _ in range(len(nodes))]
    for row in np.lexsort((nodes.repeat, nodes.child)):
        if nodes.parent[row] >= 0:
            children[nodes.parent[row]].append(int(row))
    return children


def fits(forest: Forest, pattern: Pattern, row: int) -> bool:
    """Whether the label of a node fits."""
    rule = forest.rules[forest.nodes.rule[row]] if forest.nodes.rule[row] >= 0 else None
    if pattern.symbol not in {None, forest.symbols[forest.nodes.symbol[row]]}:
        return False
    if rule is None:
        return pattern.parameters is None and pattern.branch is None
    wanted = pattern.branch or ()
    return pattern.parameters in {None, rule.parameters} and rule.branch[: len(wanted)] == wanted


def patterns(max_leaves: int = 6) -> st.SearchStrategy[Pattern]:
    """Patterns over the symbols above, and some that are not there."""
    symbol = st.sampled_from([None, "A", "B", "Leaf.", "A", "Nothing"])
    parameters = st.sampled_from([None, None, None, 0, 1])
    branch = st.sampled_from([None, None, (), (0,), (1,), (1, 0), (1, 1), (7,)])
    leaf = st.builds(Pattern, symbol, parameters, branch)

    def grow(inner: st.SearchStrategy[Pattern]) -> st.SearchStrategy[Pattern]:
        runs = st.lists(inner, min_size=1, max_size=3).map(tuple)
        below = st.builds(Below, runs, st.sampled_from([None, None, 0, 1, 2]), st.booleans())
        return st.builds(Pattern, symbol, parameters, branch, st.lists(below, max_size=2).map(tuple))

    return st.recursive(leaf, grow, max_leaves=max_leaves)
