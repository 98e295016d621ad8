"""Forests of the engine against derivations of the oracle, shape by shape."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field, fields

import numpy as np

from grammarlab.derivation.forest import Forest
from grammarlab.derivation.materials import CHANNELS
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax.syntax_tree import Call, Node, Stochastic
from tests.oracle.interpreter import Model
from tests.oracle.numbers import nodes_of, number_sites

Path = tuple[tuple[int, int], ...]
"""The way from the root: (child, repeat) at each step."""
Faces = list[np.ndarray]
TOLERANCE = 1e-9


@dataclass
class Tree:
    """One derivation, in a form that does not depend on the order in which it came about."""

    rules: dict[Path, tuple] = field(default_factory=dict)
    """Symbol, and name, arity and branch of the rule, of every node."""
    leaves: dict[Path, list[tuple[tuple, Faces]]] = field(default_factory=lambda: defaultdict(list))
    """Material and faces in the world of the visible shapes of every node."""
    draws: dict[tuple[Path, int], list[tuple[float, float]]] = field(default_factory=lambda: defaultdict(list))
    """Values and log-densities by node and number of the random expression."""
    reports: dict[tuple[Path, str], list[float]] = field(default_factory=lambda: defaultdict(list))


def assert_same_trees(engine: Tree, oracle: Tree, exact_draws: bool = True) -> None:
    """The two derivations are equal: trees and draws exactly, geometry to 1e-9 m, log-densities to 1e-12.

    Args:
        engine: of the columnar engine.
        oracle: of the oracle.
        exact_draws: False where a range of ``rand`` is computed from geometry, whose last bits may differ.
    """
    assert engine.rules == oracle.rules
    assert sorted(engine.draws) == sorted(oracle.draws)
    for place, drawn in engine.draws.items():
        expected = sorted(oracle.draws[place])
        found = sorted(drawn)
        assert len(found) == len(expected), place
        for (value, density), (true_value, true_density) in zip(found, expected, strict=True):
            slack = 0.0 if exact_draws else TOLERANCE * max(1.0, abs(true_value))
            assert abs(value - true_value) <= slack, (place, value, true_value)
            assert abs(density - true_density) <= max(slack, 1e-12 * max(1.0, abs(true_density))), place
    assert sorted(engine.leaves) == sorted(oracle.leaves)
    for path, shapes in engine.leaves.items():
        assert_same_shapes(shapes, oracle.leaves[path], f"node {path} {engine.rules[path]}")
    assert sorted(engine.reports) == sorted(oracle.reports)
    for place, values in engine.reports.items():
        np.testing.assert_allclose(sorted(values), sorted(oracle.reports[place]), rtol=1e-9, atol=1e-9)


def assert_same_records(one: Forest, other: Forest) -> None:
    """Two forests have the same nodes, draws and reports, to the last bit."""
    for first, second in ((one.nodes, other.nodes), (one.draws, other.draws), (one.reports, other.reports)):
        for column in fields(first):
            np.testing.assert_array_equal(getattr(first, column.name), getattr(second, column.name), column.name)


def assert_same_shapes(found: list[tuple[tuple, Faces]], expected: list[tuple[tuple, Faces]], where: str) -> None:
    """The same visible shapes, in any order."""
    assert len(found) == len(expected), f"{where}: {len(found)} shapes, not {len(expected)}"
    left = list(expected)
    for shape in found:
        match = next((place for place, other in enumerate(left) if is_same_shape(shape, other)), None)
        assert match is not None, f"{where}: the engine made {shape}, the oracle {left}"
        del left[match]


def is_same_shape(one: tuple[tuple, Faces], other: tuple[tuple, Faces]) -> bool:
    """Equal material, and the same faces in the same order, each beginning at the same corner; boxes in any order."""
    one, other = (one[0], _in_one_order(one[1])), (other[0], _in_one_order(other[1]))
    if len(one[1]) != len(other[1]) or any(a.shape != b.shape for a, b in zip(one[1], other[1], strict=True)):
        return False
    numbers = np.allclose(one[0][:-1], other[0][:-1], rtol=0.0, atol=TOLERANCE) and one[0][-1] == other[0][-1]
    return numbers and all(np.allclose(a, b, rtol=1e-12, atol=TOLERANCE) for a, b in zip(one[1], other[1], strict=True))


def _in_one_order(faces: Faces) -> Faces:
    """The faces; those of boxes, which the engine shows as one mesh, sorted and from their lowest corners on."""
    if len(faces) != 6 or any(len(face) != 4 for face in faces):
        return faces
    rounded = [np.round(face, 6) + 0.0 for face in faces]
    first = [min(range(4), key=lambda i, face=face: tuple(face[i])) for face in rounded]
    order = sorted(range(6), key=lambda i: np.roll(rounded[i], -first[i], axis=0).ravel().tolist())
    return [np.roll(faces[i], -first[i], axis=0) for i in order]


def tree_of_model(model: Model, grammar: Grammar) -> Tree:
    """What the oracle derived."""
    sites = {place: site for site, place in enumerate(random_places(grammar))}
    tree = Tree()
    paths: list[Path] = []
    for node in model.nodes:
        paths.append((*paths[node.parent], (node.child, node.repeat)) if node.parent >= 0 else ())
        tree.rules[paths[-1]] = (node.symbol, node.rule)
    assert len(tree.rules) == len(model.nodes)
    for leaf in model.leaves:
        material = (*(leaf.material[name] for name in CHANNELS), leaf.material["texture"])
        tree.leaves[paths[leaf.node]].append((material, leaf.polygons))
    for draw in model.draws:
        tree.draws[paths[draw.node], sites[draw.place]].append((draw.value, draw.log_density))
    for node, key, value in model.reports:
        tree.reports[paths[node], key].append(float("nan") if isinstance(value, str) else float(value))
    return tree


def trees_of_forest(forest: Forest) -> list[Tree]:
    """What the engine derived, model by model."""
    trees = [Tree() for _ in range(forest.num_models)]
    nodes = forest.nodes
    paths: list[Path] = []
    for row in range(len(nodes)):
        parent = nodes.parent[row]
        paths.append((*paths[parent], (int(nodes.child[row]), int(nodes.repeat[row]))) if parent >= 0 else ())
        rule = None if nodes.rule[row] < 0 else forest.rules[nodes.rule[row]]
        branch = None if rule is None else (rule.symbol, rule.parameters, rule.branch)
        tree = trees[nodes.model[row]]
        assert paths[row] not in tree.rules, "two nodes of one model have the same path"
        tree.rules[paths[row]] = (forest.symbols[nodes.symbol[row]], branch)
    for row, (material, polygons) in enumerate(_leaf_shapes(forest)):
        node = forest.leaves.node[row]
        trees[nodes.model[node]].leaves[paths[node]].append((material, polygons))
    for row, node in enumerate(forest.draws.node):
        place = paths[node], int(forest.draws.site[row])
        drawn = float(forest.draws.value[row]), float(forest.draws.log_density[row])
        trees[nodes.model[node]].draws[place].append(drawn)
    for row, node in enumerate(forest.reports.node):
        key = forest.reports.keys[forest.reports.key[row]]
        trees[nodes.model[node]].reports[paths[node], key].append(float(forest.reports.value[row]))
    return trees


def _leaf_shapes(forest: Forest) -> Iterator[tuple[tuple, Faces]]:
    leaves = forest.leaves
    for row in range(len(leaves)):
        polygons = [
            leaves.position[row] + (leaves.size[row] * polygon) @ forest.frames[leaves.frame[row]].T
            for polygon in polygons_of(forest.meshes, int(leaves.mesh[row]))
        ]
        material = leaves.material[row]
        channels = forest.materials.channels[material].tolist()
        yield (*channels, forest.materials.textures[material]), polygons


def polygons_of(meshes: Meshes, mesh: int) -> Faces:
    """The faces of one mesh of a batch as lists of points."""
    points = meshes.points[meshes.mesh_points[mesh] : meshes.mesh_points[mesh + 1]]
    faces = range(int(meshes.mesh_faces[mesh]), int(meshes.mesh_faces[mesh + 1]))
    return [points[meshes.corners[meshes.face_offsets[f] : meshes.face_offsets[f + 1]]] for f in faces]


def random_places(grammar: Grammar) -> list[int]:
    """The numbers of the random expressions of a grammar, in the order of the text."""
    numbers = number_sites(grammar.tree)
    return [numbers[id(node)] for node in nodes_of(grammar.tree) if _is_random(node)]


def _is_random(node: Node) -> bool:
    return isinstance(node, Stochastic) or (isinstance(node, Call) and node.function in {"rand", "p", "fileRandom"})
