"""Sizes, numbers and indices of parts, for splits along axes and along texture coordinates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.calls.calls import BoundCall, Head
from grammarlab.derivation.state.shapes import Floats, Shapes
from grammarlab.derivation.state.workspace import Workspace
from grammarlab.derivation.values.splitting import Element, SplitPieces, SplitRepeat, SplitSize

_INDICES = frozenset({"split.index", "split.total"})


def asked_indices(workspace: Workspace) -> frozenset[str]:
    """Those of ``split.index`` and ``split.total`` that the grammar reads."""
    return workspace.state_names & _INDICES


def elements_of(call: BoundCall, heads: Sequence[Head], length: Floats) -> list[Element]:
    """Sizes of a split of lengths [N], grouped by repeated group."""
    elements: list[Element] = []
    group = -1
    for head in heads:
        argument = head.argument
        number = call.number(argument)
        size = SplitSize(number * length if argument.relative else number, argument.floating)
        if head.group < 0:
            elements.append(size)
        elif head.group == group and isinstance(elements[-1], SplitRepeat):
            elements[-1] = SplitRepeat((*elements[-1].sizes, size))
        else:
            elements.append(SplitRepeat((size,)))
        group = head.group
    return elements


def numbered(pieces: Sequence[SplitPieces], shapes: Shapes, is_wanted: bool) -> list[NDArray[np.int64]]:
    """Index of each piece along its shape, from 0; only if it is read or a part draws."""
    counts = [len(piece.row) for piece in pieces]
    if shapes.key is None and not is_wanted:
        return [np.zeros(count, np.int64) for count in counts]
    if all(piece.is_one_each for piece in pieces):
        return [np.full(count, place) for place, count in enumerate(counts)]
    row = np.concatenate([piece.row for piece in pieces])
    order = np.lexsort((np.concatenate([piece.start for piece in pieces]), row))
    per_row = np.bincount(row, minlength=shapes.num)
    number = np.empty(len(row), np.int64)
    number[order] = np.arange(len(row)) - np.repeat(np.cumsum(per_row) - per_row, per_row)
    return np.split(number, np.cumsum(counts)[:-1])


def indexed(
    made: Sequence[Shapes],
    pieces: Sequence[SplitPieces],
    numbers: Sequence[NDArray[np.int64]],
    num_shapes: int,
    asked: frozenset[str],
) -> list[Shapes]:
    """Parts with their index and total, if the grammar reads them."""
    totals = np.bincount(np.concatenate([piece.row for piece in pieces]), minlength=num_shapes)
    result = []
    for part, piece, number in zip(made, pieces, numbers, strict=True):
        known = {"split.index": number.astype(np.float64), "split.total": totals[piece.row].astype(np.float64)}
        result.append(part._replace(state={**part.state, **{name: known[name] for name in asked}}))
    return result
