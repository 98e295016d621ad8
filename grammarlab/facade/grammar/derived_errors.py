"""Differences between the leaves of a facade and the leaves that its grammar or its family derives."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.spatial import KDTree

from grammarlab.arrays import Floats, Ints
from grammarlab.derivation import derive
from grammarlab.facade.grammar.bands import SAME_PLACE
from grammarlab.facade.grammar.leaf_looks import OutlinedLeaf, store_shapes
from grammarlab.facade.grammar.rule_text import AROUND
from grammarlab.facade.grammar.walks import KindPattern, KindSequence
from grammarlab.facade.looks import look_of
from grammarlab.facade.tree import Facade
from grammarlab.language.grammar import Grammar

_OUTWARDS = np.array([1.0, 1.0, -1.0, -1.0])
"""Signs of left, bottom, right and top; with them, the outermost of several is the least."""
_Pieces = tuple[Ints, Ints, Floats]
"""[P, 2] column and row, [P] label and [P, 2] place in them."""


def member_error(
    facade: Facade,
    pattern: KindPattern,
    grammar: Grammar,
    labels: Mapping[str, str],
    outlined: Collection[OutlinedLeaf] = (),
) -> float:
    """Largest difference of the sides of leaves that are not walls, metres; columns and rows may cut them.

    A derived leaf is a piece of a leaf of its label in the same column and row. Of several, those with the nearest
    places are paired.

    Args:
        facade: the expected leaves.
        pattern: the pattern of the facade.
        grammar: the grammar of its own columns and rows, of which the first model is measured.
        labels: labels of the symbols of derived leaves.
        outlined: leaves whose meshes the grammar refers to.

    Returns:
        Infinity if elements are missing or surplus; 0 if there are none.
    """
    boxes, derived_names = _derived_leaves(grammar, labels, outlined)
    pieces = np.array([not look_of(label).is_flexible for label in derived_names], dtype=bool)
    derived = _box_sides(boxes[pieces])
    names = [facade.name_of(leaf) for leaf in facade.leaves.tolist()]
    things = np.array([not look_of(name).is_flexible for name in names], dtype=bool)
    expected = _box_sides(_leaf_boxes(facade)[things])
    number = {label: index for index, label in enumerate(dict.fromkeys((*names, *derived_names)))}
    found_label, label = (
        np.array(
            [number[name] for name, is_thing in zip(all_names, is_thing_by_name, strict=True) if is_thing],
            dtype=np.int64,
        )
        for all_names, is_thing_by_name in ((derived_names, pieces), (names, things))
    )
    edges = [np.array(lines.edges) for lines in (pattern.columns, pattern.rows)]
    thing, band = _cut(expected, edges, SAME_PLACE * facade.size[0])
    own_edges = [_own_edges(lines) for lines in (pattern.columns, pattern.rows)]
    own_band = _bands(derived, own_edges)
    piece, cut = _pairs(
        (own_band, found_label, _middle(derived) - _starts(own_edges, own_band)),
        (band, label[thing], _middle(_clipped(expected[thing], edges, band)) - _starts(edges, band)),
    )
    if len(piece) < max(len(derived), len(thing)) or len(np.unique(thing)) < len(expected):
        return np.inf
    reach = np.full((len(expected), 4), np.inf)
    np.minimum.at(reach, thing[cut], derived[piece] * _OUTWARDS)
    return float(np.abs(reach * _OUTWARDS - expected).max(initial=0.0))


def leaf_error(
    facade: Facade, grammar: Grammar, labels: Mapping[str, str], outlined: Collection[OutlinedLeaf] = ()
) -> float:
    """Largest difference of the sides of leaves, metres, in the first model of a grammar.

    Args:
        facade: the expected leaves.
        grammar: a grammar of boxes whose front is in the x-y plane.
        labels: labels of the symbols of derived leaves.
        outlined: leaves whose meshes the grammar refers to.

    Returns:
        Infinity if leaves are missing, surplus, or of other labels.
    """
    boxes, names = _derived_leaves(grammar, labels, outlined)
    if len(boxes) != len(facade.leaves):
        return np.inf
    expected = _leaf_boxes(facade)
    nearest = np.asarray(KDTree(boxes).query(expected)[1])
    if len(np.unique(nearest)) != len(nearest):
        return np.inf
    if any(names[near] != facade.name_of(leaf) for near, leaf in zip(nearest, facade.leaves.tolist(), strict=True)):
        return np.inf
    return float(np.abs(_box_sides(boxes)[nearest] - _box_sides(expected)).max())


def _derived_leaves(
    grammar: Grammar, labels: Mapping[str, str], outlined: Collection[OutlinedLeaf] = ()
) -> tuple[Floats, list[str]]:
    """[D, 4] left, bottom, width and height of the leaves of the first model, and their labels; none of `AROUND`."""
    if outlined:
        with TemporaryDirectory() as folder:
            store_shapes(outlined, Path(folder))
            forest = derive(grammar, 1, seed=0, assets=Path(folder))
    else:
        forest = derive(grammar, 1, seed=0)
    leaves = forest.leaves
    # The name of a symbol without a rule ends with a full stop.
    symbols = [forest.symbols[symbol].rstrip(".") for symbol in forest.nodes.symbol[leaves.node].tolist()]
    is_leaf = np.array([symbol != AROUND for symbol in symbols], dtype=bool)
    box = np.concatenate([leaves.position[:, :2], leaves.size[:, :2]], axis=1)
    return box[is_leaf], [labels.get(symbol, "") for symbol in symbols if symbol != AROUND]


def _box_sides(boxes: Floats) -> Floats:
    """[K, 4] left, bottom, right and top of boxes."""
    return np.concatenate([boxes[:, :2], boxes[:, :2] + boxes[:, 2:]], axis=1)


def _leaf_boxes(facade: Facade) -> Floats:
    """[L, 4] left, bottom, width and height of the leaves of a facade."""
    return np.concatenate([facade.position - facade.position[0], facade.size], axis=1)[facade.leaves]


def _cut(box: Floats, edges: list[Floats], least: Floats) -> tuple[Ints, Ints]:
    """Pieces of boxes [T, 4] in columns and rows: of each piece [P] its box, and [P, 2] its column and row."""
    inside = [
        np.minimum(box[:, None, 2 + axis], edges[axis][1:]) - np.maximum(box[:, None, axis], edges[axis][:-1])
        > least[axis]
        for axis in range(2)
    ]
    rows = np.argwhere(inside[0][:, :, None] & inside[1][:, None, :])
    return rows[:, 0], rows[:, 1:]


def _own_edges(lines: KindSequence) -> Floats:
    """[B + 1] metres at which the columns or rows of the facade's own member begin and end."""
    return np.cumsum([0.0, *(lines.size[kind] for kind in lines.kind)])


def _bands(box: Floats, edges: list[Floats]) -> Ints:
    """[P, 2] the column and row in which the middles of boxes [P, 4] are."""
    middle = _middle(box)
    bands = [np.searchsorted(edges[axis], middle[:, axis]).clip(1, len(edges[axis]) - 1) - 1 for axis in range(2)]
    return np.stack(bands, axis=1)


def _middle(box: Floats) -> Floats:
    return (box[:, :2] + box[:, 2:]) / 2.0


def _pairs(first_pieces: _Pieces, second_pieces: _Pieces) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Pairs of pieces of one label in one column and row, as indices into both."""
    keys = np.concatenate([np.column_stack(pieces[:2]) for pieces in (first_pieces, second_pieces)])
    group = np.unique(keys, axis=0, return_inverse=True)[1].ravel()
    groups = []
    for numbers in (group[: len(first_pieces[0])], group[len(first_pieces[0]) :]):
        order = np.argsort(numbers, kind="stable")
        groups.append(np.split(order, np.searchsorted(numbers[order], np.arange(1, group.max(initial=0) + 1))))
    first, second = [np.zeros(0, dtype=np.intp)], [np.zeros(0, dtype=np.intp)]
    for first_rows, second_rows in zip(*groups, strict=True):
        cost = np.abs(first_pieces[2][first_rows][:, None] - second_pieces[2][second_rows][None]).sum(axis=2)
        rows, columns = linear_sum_assignment(cost)
        first.append(first_rows[rows])
        second.append(second_rows[columns])
    return np.concatenate(first), np.concatenate(second)


def _starts(edges: list[Floats], band: Ints) -> Floats:
    """[P, 2] left and bottom of columns and rows."""
    return np.stack([edges[axis][band[:, axis]] for axis in range(2)], axis=1)


def _clipped(box: Floats, edges: list[Floats], band: Ints) -> Floats:
    low, high = _starts(edges, band), _starts(edges, band + 1)
    return np.hstack([np.maximum(box[:, :2], low), np.minimum(box[:, 2:], high)])
