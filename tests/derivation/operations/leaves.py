"""What the leaves of a forest are, measured in the world."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation import Forest, derive
from grammarlab.geometry.meshes import measure
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.language.grammar import Grammar

L_SHAPE = np.array([[0, 0, 0], [0, 0, 12], [8, 0, 12], [8, 0, 22], [26, 0, 22], [26, 0, 0.0]])
"""Corners of a lot of 492 square metres with one reflex corner."""

TRIANGLE = np.array([[0, 0, 0], [0, 0, 9], [12, 0, 0.0]])
"""Corners of a lot of 54 square metres."""


def sampled(
    text: str, footprint: tuple[float, float] | NDArray[np.float64] = (30.0, 20.0), num_models: int = 1
) -> Forest:
    """Models of a rule file given as text."""
    return derive(Grammar.parse(text), num_models, seed=3, footprint=footprint)


def world_meshes(forest: Forest) -> Meshes:
    """The geometry of all leaves, in the world."""
    leaves = forest.leaves
    meshes = forest.meshes.take(leaves.mesh)
    owner = meshes.mesh_of_point()
    local = meshes.points * leaves.size[owner]
    turned = np.einsum("pij,pj->pi", forest.frames[leaves.frame[owner]], local)
    return meshes.with_points(turned + leaves.position[owner])


def areas_by_symbol(forest: Forest) -> dict[str, float]:
    """Square metres of all leaves of each symbol."""
    return _summed(forest, measure.areas(world_meshes(forest)))


def volumes_by_symbol(forest: Forest) -> dict[str, float]:
    """Cubic metres of all leaves of each symbol."""
    return _summed(forest, measure.volumes(world_meshes(forest)))


def symbols(forest: Forest) -> list[str]:
    """The symbol of each leaf."""
    return [forest.symbols[symbol] for symbol in forest.nodes.symbol[forest.leaves.node]]


def _summed(forest: Forest, values: NDArray[np.float64]) -> dict[str, float]:
    sums: dict[str, float] = {}
    for symbol, value in zip(symbols(forest), values.tolist(), strict=True):
        sums[symbol] = sums.get(symbol, 0.0) + value
    return sums


def forest_frames(forest):
    return forest.frames[forest.leaves.frame]
