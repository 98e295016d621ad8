"""Random facades with grids, and the paper's own formulation of their sizes, as a slow reference.

The unknowns here are the sizes of leaves, alpha and beta are vectors over them, and the hierarchy has its own rows.
"""

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from hypothesis import strategies as st

from grammarlab.arrays import Floats
from grammarlab.facade.grid import Grid
from grammarlab.facade.tree import LEAF, Facade, X, Y, laid_out, plain
from tests.facade.strategies import trees


@st.composite
def sized(draw: st.DrawFn, max_nodes: int = 40, grids: int = 2) -> Facade:
    """A random guillotine tree with grids of random leaves in bins, so that columns and rows are roughly aligned."""
    facade = draw(trees(max_nodes))
    randomness = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    found = []
    for name in range(draw(st.integers(0, grids))):
        leaf = facade.leaves[randomness.random(len(facade.leaves)) < 0.5]
        middle = (facade.position[leaf] + 0.5 * facade.size[leaf]) / facade.size[0]
        bins = np.floor(middle * randomness.integers(1, 5)).astype(int)
        bins[:, Y] = bins[:, Y].max(initial=0) - bins[:, Y]
        _, first = np.unique(bins, axis=0, return_index=True)
        first = np.sort(first)
        if first.size:
            column, row = (np.unique(bins[first, axis], return_inverse=True)[1] for axis in (X, Y))
            found.append(Grid(str(name), leaf[first], row, column))
    return replace(facade, grids=tuple(found))


def storeys(columns: int, rows: int, widths: tuple[float, ...] = (0.8, 1.2, 1.6)) -> Facade:
    """Storeys of wall, window, wall, window, ..., wall; columns of windows differ in width, and are one grid."""
    parent, axis, wanted, names, places = [-1], [Y], [(1.0, 1.0)], [""], []

    def add(above: int, along: int, size: tuple[float, float], name: str) -> int:
        parent.append(above)
        axis.append(along)
        wanted.append(size)
        names.append(name)
        return len(parent) - 1

    for row in range(rows):
        storey = add(0, X, (1.0, 1.0), "")
        for column in range(columns):
            add(storey, LEAF, ((1.0, 0.7)[column % 2], 3.0), "wall")
            width = widths[column % len(widths)]
            bay = add(storey, Y, (1.0, 1.0), "")
            for name, height in (("wall", 0.8), ("window", 1.4), ("wall", 0.8)):
                leaf = add(bay, LEAF, (width, height), name)
                if name == "window":
                    places.append((leaf, rows - 1 - row, column))
        add(storey, LEAF, ((1.0, 0.7)[columns % 2], 3.0), "wall")
    node, at_row, at_column = np.array(places).T
    tree = np.array(parent), np.array(axis, dtype=np.int8)
    facade = plain(*tree, *laid_out(*tree, np.array(wanted)), names)
    return replace(facade, grids=(Grid("windows", node, at_row, at_column),))


@dataclass(frozen=True)
class Paper:
    """Equation 1 for one axis, dense: minimise |weight (x - start)|^2 so that rows @ x = value, x >= least."""

    start: Floats
    weight: Floats
    rows: Floats
    value: Floats
    least: Floats

    def energy(self, x: Floats) -> float:
        return float(np.square(self.weight * (x - self.start)).sum())


def paper(facade: Facade, along: int, weight: Floats, target: float | None) -> Paper:
    alpha, beta, rows = _vectors(facade, along)
    value: list[Any] = [0.0] * len(rows)
    low, size, leaf = facade.position[:, along], facade.size[:, along], facade.leaves
    for grid in facade.grids:
        lines, others = (grid.column, grid.row) if along == X else (grid.row, grid.column)
        for line in range(lines.max() + 1):
            column = grid.node[lines == line][np.argsort(others[lines == line])]
            shares = (0.0, 0.5, 1.0)
            share = min(shares, key=lambda eps: round(float(np.var(low[column] + eps * size[column])), 12))
            for one, other in pairwise(column):
                rows.append(beta[one] + share * alpha[one] - beta[other] - share * alpha[other])
                value.append(low[one] + share * size[one] - low[other] - share * size[other])
        for label in np.unique(facade.label[grid.node]):
            alike = sorted(grid.node[facade.label[grid.node] == label], key=lambda node: float(size[node]))
            near = [(one, other) for one, other in pairwise(alike) if size[other] <= 1.1 * size[one]]
            rows += [alpha[other] - alpha[one] * size[other] / size[one] for one, other in near]
            value += [0.0] * len(near)
    if target is not None:
        rows.append(alpha[0])
        value.append(target)
    start = size[leaf]
    matrix = np.array(rows).reshape(-1, len(leaf))
    return Paper(start, weight, matrix, np.array(value), 1e-3 * start)


def _vectors(facade: Facade, along: int) -> tuple[Floats, Floats, list[Floats]]:
    """[N, L] alpha and beta, and the rows of the hierarchy."""
    leaf = facade.leaves
    alpha, beta = np.zeros((len(facade), len(leaf))), np.zeros((len(facade), len(leaf)))
    alpha[leaf, np.arange(len(leaf))] = 1.0
    rows = []
    for node in range(len(facade) - 1, -1, -1):
        parts = facade.children[node].tolist()
        if facade.axis[node] == along:
            alpha[node] = alpha[parts].sum(axis=0)
        elif parts:
            alpha[node] = alpha[parts[0]]
            rows += [alpha[one] - alpha[other] for one, other in pairwise(parts)]
    for node in range(len(facade)):
        left = beta[node].copy()
        for part in facade.children[node].tolist():
            beta[part] = left
            left = left + alpha[part] if facade.axis[node] == along else left
    return alpha, beta, rows
