"""Addresses of the draws of a tree, and its parameters as columns over stems.

A tree's trunk has the key ``fold(tree key, STEMS)``. A stem's children, clones and leaves have keys below its own, so a
draw depends on the seed, the tree, the path of indices to its stem and the draw's name, on nothing else.
"""

from __future__ import annotations

from enum import IntEnum, unique

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.randomness import Keys, fold, uniforms
from grammarlab.trees.parameters import COLUMN, SPREAD

STEMS = 2
"""Lane below the key of a tree for its trunk; lane 1 has its parameters (`grammarlab.trees.species`)."""


@unique
class Site(IntEnum):
    """Draws below the key of a stem or leaf, and the lanes of the keys below it."""

    SCALE = 0
    Z_SCALE = 1
    RADIUS = 2
    LENGTH = 3
    DOWN = 4
    ROTATE = 5
    BLOSSOM = 6
    CHILDREN = 16
    CLONES = 17
    LEAVES = 18
    SEGMENTS = 19


@unique
class Turn(IntEnum):
    """Draws of a segment: segment j of a stem has the key ``fold(fold(stem key, SEGMENTS), j)``."""

    CURVE = 0
    SPLIT = 1
    SPREAD = 2
    SIDE = 3


def values(rows: Floats, tree: Ints, name: str) -> Floats:
    """[S] values of a column for each stem.

    Args:
        rows: [n, P] parameters of the trees.
        tree: [S] tree of each stem.
        name: name of the column.
    """
    return rows[tree, COLUMN[name]]


def counts(rows: Floats, tree: Ints, name: str) -> Ints:
    """[S] values of a column of whole numbers for each stem."""
    return np.rint(values(rows, tree, name)).astype(np.int64)


def varied(rows: Floats, tree: Ints, name: str, keys: Keys, site: int) -> Floats:
    """[S] value ± spread, drawn uniformly, in the unit of the column."""
    return values(rows, tree, name) + varied_by(values(rows, tree, f"{name}{SPREAD}"), keys, site)


def varied_by(spread: Floats, keys: Keys, site: int) -> Floats:
    """[S] uniform draws between -spread and spread."""
    if not spread.any():
        return np.zeros(len(spread))
    return spread * (2.0 * uniforms(keys, site) - 1.0)


def segment_keys(keys: Keys, segment: int) -> Keys:
    """[S] keys of the draws of one segment of each stem."""
    return fold(fold(keys, Site.SEGMENTS), segment)
