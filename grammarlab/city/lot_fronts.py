"""Fronts of lots: which edge comes first, how far buildings stay from each edge, corner and inner lots."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints, offsets_from_counts
from grammarlab.city.lot_edges import LotEdges, merged_edges
from grammarlab.geometry.lot_sides import BACK, FRONT, LEFT, Sides, edge_sides

COLLINEAR = 10.0
"""Degrees; edges that turn by less are one edge."""
_LEAST_TURN = 45.0
"""Degrees between the lines of two streets at a corner lot, and between a side and the direction of the front."""
LOT, INNER_LOT, CORNER_LOT = "Lot", "LotInner", "LotCorner"
"""Start rules of CGA for lots along streets in one direction, without a street, and in several directions."""


def first_edges(edges: LotEdges, widths: Floats, towards: Floats | None = None) -> Ints:
    """[S] corner that the first edge of each lot leaves: along its widest street, and of those the longest.

    Collinear edges on streets count as one, and so do those without a street; the longest of them is the first edge.

    Args:
        edges: P edges of S lots.
        widths: [P] widths of the streets along them in metres, 0 for none.
        towards: [S, 2] directions in which the first edge looks if there is no street; left out for any.
    """
    is_facing = np.ones(len(widths), np.bool_)
    if towards is not None:
        is_facing = (edges.normal * towards[edges.outline]).sum(axis=1) > np.cos(np.radians(_LEAST_TURN))
    chain = merged_edges(edges, (widths > 0.0).astype(np.int64), COLLINEAR)
    chain_length = np.bincount(chain, edges.length)
    chain_width = np.zeros(len(chain_length))
    np.maximum.at(chain_width, chain, widths)
    # Equal edges are ordered as their corners are, which starts in the west.
    length = np.round(chain_length, 6)[chain]
    keys = (-edges.length, -length, ~is_facing, -chain_width[chain], edges.is_hole, edges.outline)
    rank = np.lexsort(keys)
    return rank[np.searchsorted(edges.outline[rank], np.arange(len(edges)))]


def sides_of_edges(edges: LotEdges, widths: Floats) -> Sides:
    """[P] side of each edge (`grammarlab.geometry.lot_sides`); the outer ring of a lot must begin with its first edge.

    Edges of holes are at the left, whatever their direction.
    """
    outer = np.flatnonzero(~edges.is_hole)
    offsets = offsets_from_counts(np.bincount(edges.outline[outer], minlength=len(edges)))
    sides = np.full(len(edges.points), LEFT, np.int8)
    sides[outer] = edge_sides(edges.points[outer] * (1.0, -1.0), offsets, widths[outer])
    return sides


def edge_setbacks(edges: LotEdges, sides: Sides, distances: Floats) -> Floats:
    """[P] distance in metres that a building keeps from each edge: the largest of its kind in collinear edges.

    Args:
        edges: P edges of S lots.
        sides: [P] sides of the edges.
        distances: [S, 3] setbacks at the front, the sides and the back.
    """
    kind = np.where(sides == FRONT, 0, np.where(sides == BACK, 2, 1))
    setback = distances[edges.outline, kind]
    chain = merged_edges(edges, np.zeros(len(setback), np.int64), COLLINEAR)
    largest = np.zeros(len(setback))
    np.maximum.at(largest, chain, setback)
    return largest[chain]


def lot_kinds(edges: LotEdges, widths: Floats) -> NDArray[np.object_]:
    """[S] start rule of CGA that fits each lot: `LOT`, `INNER_LOT` or `CORNER_LOT`.

    Args:
        edges: P edges of S lots, whose outer rings begin with the first edges.
        widths: [P] widths of the streets along them in metres, 0 for none.
    """
    is_front = widths > 0.0
    first = edges.ring_offsets[edges.outline_offsets[:-1]]
    cosine = (edges.normal * edges.normal[first][edges.outline]).sum(axis=1)
    is_across = is_front & (np.abs(cosine) < np.cos(np.radians(_LEAST_TURN)))
    has_front, is_corner = (
        np.bincount(edges.outline, flag, minlength=len(edges)) > 0 for flag in (is_front, is_across)
    )
    return np.where(is_corner, CORNER_LOT, np.where(has_front, LOT, INNER_LOT)).astype(object)
