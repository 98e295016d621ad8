"""Kinds of the surfaces of buildings, by the names of the symbols that made them.

A window is everything below the topmost symbol whose name says so, ``OldWindow``, ``Glass``; a name such as
``WindowRow`` says that windows are in it, and ends one. Leaves called after walls or roofs are such; of all others the
direction of the faces decides (`grammarlab.export.surface_labels`).
"""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Ints
from grammarlab.derivation.forest import Forest
from grammarlab.export.surface_labels import DOOR, ROOF, UNLABELLED, WALL, WINDOW, SurfaceLabels
from grammarlab.scene.instances import leaf_order

_KIND_OF_WORD = {
    **dict.fromkeys(("window", "glass", "glazing", "pane", "sash", "skylight", "vitrine"), WINDOW),
    **dict.fromkeys(("door", "doorway", "gate", "portal"), DOOR),
    **dict.fromkeys(("roof", "rooftop", "roofing"), ROOF),
    **dict.fromkeys(("wall", "facade"), WALL),
}
_CONTAINERS = frozenset(
    (
        *("area", "axis", "band", "bay", "block", "building", "column", "facade", "field", "floor", "front", "grid"),
        *("house", "level", "mass", "module", "part", "range", "roof", "row", "section", "side", "storey", "story"),
        *("strip", "tile", "wall"),
    )
)
"""Last words of names of things that have windows or doors in them."""
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
_NONE = -1


def surface_labels(forest: Forest) -> SurfaceLabels:
    """Labels of the instances of ``realize(forest)``.

    >>> import grammarlab as gl
    >>> rules = "Lot --> split(x) { ~1 : Wall. | 1 : OldWindow } OldWindow --> split(z) { 1 : Sill. | ~1 : Pane. }"
    >>> labels = surface_labels(gl.derive(gl.Grammar.parse(rules), 1, seed=1))
    >>> labels.kind.tolist(), len(set(labels.opening[labels.kind == WINDOW].tolist()))
    ([2, 4, 4], 1)
    """
    names = [_words(symbol) for symbol in forest.symbols]
    kind_of_symbol = np.array([_kind(words) for words in names], dtype=np.int8)
    opening = _openings(forest, names, kind_of_symbol)
    leaf = forest.leaves.node[leaf_order(forest)]
    own = kind_of_symbol[forest.nodes.symbol[leaf]]
    above = opening[leaf]
    kind = np.where(above == _NONE, UNLABELLED, kind_of_symbol[forest.nodes.symbol[above]])
    kind = np.where((own == WALL) | (own == ROOF), own, kind).astype(np.int8)
    return SurfaceLabels(kind, above.astype(np.int32))


def _openings(forest: Forest, names: list[list[str]], kind_of_symbol: NDArray[np.int8]) -> Ints:
    """[N] the node of the window or door that each node is part of; `_NONE` for the others."""
    nodes = forest.nodes
    ends = np.array([bool(words) and words[-1] in _CONTAINERS for words in names])[nodes.symbol]
    kind = kind_of_symbol[nodes.symbol]
    starts = ((kind == WINDOW) | (kind == DOOR)) & ~ends
    opening = np.full(len(nodes), _NONE, dtype=np.int64)
    for rows in _levels(nodes.parent):
        parent = nodes.parent[rows]
        inherited = np.where((parent < 0) | ends[rows], _NONE, opening[parent])
        opening[rows] = np.where((inherited == _NONE) & starts[rows], rows, inherited)
    return opening


def _levels(parent: NDArray[np.int32]) -> Iterator[Ints]:
    """Rows of the nodes of each depth, from the roots on."""
    depth = np.zeros(len(parent), dtype=np.int64)
    above = parent.astype(np.int64)
    while (has_parent := above >= 0).any():
        depth += has_parent
        above = np.where(has_parent, parent[above], _NONE)
    order = np.argsort(depth, kind="stable")
    yield from np.split(order, np.flatnonzero(np.diff(depth[order])) + 1)


def _words(symbol: str) -> list[str]:
    """Words of a name in lower case, in the singular.

    >>> _words("OldGround_Windows2"), _words("Glass")
    (['old', 'ground', 'window'], ['glass'])
    """
    words = [word.lower() for word in _WORD.findall(symbol)]
    return [word if word.endswith("ss") else word.removesuffix("s") for word in words]


def _kind(words: list[str]) -> int:
    """Kind that the last word with one has; ``RoofWindow`` is a window."""
    return next((_KIND_OF_WORD[word] for word in reversed(words) if word in _KIND_OF_WORD), UNLABELLED)
