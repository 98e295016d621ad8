"""Least energy of sizes along one axis, of a whole facade and of the parts beside repeated bands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from grammarlab.facade.grid import Grid
from grammarlab.facade.retargeting.repeats import Repeats
from grammarlab.facade.sizes.axes import LineOrigin, Weights, build_axis, leaf_weights
from grammarlab.facade.sizes.lines import Sums
from grammarlab.facade.sizes.model import build_model
from grammarlab.facade.sizes.wishes import Size
from grammarlab.facade.tree import Facade, Ints, X
from grammarlab.facade.variations.copies import take
from grammarlab.facade.variations.single import Variation

_ROUNDING = 1e-9
"""Relative error of the energy of a solution."""


def origin_of(facade: Facade, variation: Variation) -> LineOrigin:
    """Target sizes and source positions of the nodes of a variation."""
    return LineOrigin(facade.position[variation.source], variation.wanted, facade.size[0])


def least_energy(
    facade: Facade, origin: LineOrigin, wishes: Sequence[Size], weights: Weights, held: Sequence[int]
) -> float:
    """Energy of the best sizes along one axis under these kinds of rows; infinite if there are none."""
    # One unit for all variations of a facade, so that rounding errors choose the same anchors in all of them.
    leaf, scale, along = facade.leaves, float(origin.whole.max()), wishes[0].axis
    weight = leaf_weights(origin.size[leaf], origin.whole, weights)[:, along]
    axis = build_axis(facade, along, origin, weight, scale)
    model = build_model([axis], wishes, scale)
    kept = np.isin(model.kind, held)
    sums, still = model.program.rows, model.program.still[kept]
    program = replace(model.program, rows=Sums(sums.line[kept], sums.factor[kept]), still=still)
    place = program.solve(model.value[kept])
    if place is None:
        return np.inf
    size = axis.lines.laid(model.lines(place)[0])[1]
    return float(np.square(weight * (size[leaf] - origin.size[leaf, along])).sum())


def energy_beside(repeats: Repeats, facade: Facade, wish: Size, weights: Weights, held: Sequence[int]) -> float:
    """Lower bound of the energy of the parts beside the bands, for any columns; without strips.

    Of the rows for these parts, only those that do not depend on columns are kept: equal sizes, and alignment in
    columns (for heights, rows) of a grid without elements in a band.

    Args:
        repeats: bands that can be repeated.
        facade: facade of the original sizes.
        wish: target of the whole facade.
        weights: weights of deviations.
        held: kinds of rows.
    """
    before, other = repeats.before, {*(band.node for band in repeats.bands), *repeats.strips}
    whole = before.facade
    beside = [part for part in whole.children[0].tolist() if part not in other] if 0 not in other else []
    if not beside:
        return 0.0
    source = np.concatenate([np.arange(part, int(whole.end[part])) for part in beside])
    if len(beside) > 1:
        source = np.append(0, source)
    place = np.full(len(whole), -1, dtype=np.int64)
    place[source] = np.arange(len(source))
    parent = place[whole.parent[source]]
    parent[0] = -1
    wanted = before.wanted[source]
    alone = take(whole, parent, whole.axis[source], source, wanted)
    grids = [_grid_beside(grid, place, wish.axis) for grid in whole.grids]
    alone = replace(alone, grids=tuple(grid for grid in grids if len(grid.node)))
    origin = LineOrigin(facade.position[before.source[source]], wanted, facade.size[0])
    return least_energy(alone, origin, [wish], weights, held) * (1.0 - _ROUNDING)


def _grid_beside(grid: Grid, place: Ints, along: int) -> Grid:
    """The elements of a grid beside bands; in a line of their own if other elements of the line are in a band."""
    left = place[grid.node] >= 0
    line = grid.column if along == X else grid.row
    mixed = np.isin(line, line[~left])
    line = np.where(mixed, line.max(initial=-1) + 1 + np.arange(len(line)), line)[left]
    row, column = (grid.row[left], line) if along == X else (line, grid.column[left])
    return Grid(grid.name, place[grid.node[left]], row, column)
