"""Axes of the stems of one level as they are drawn: smooth curves through the nodes of a skeleton.

A clone begins a little before it leaves its source, in its direction, so that no gap shows between them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints, offsets_from_counts, row_of_value, take_rows
from grammarlab.trees.skeleton import Stems

_KEY_STEP = 0.5
"""Factor of shares of a length in sorting keys: the keys of two stems stay apart."""
CLONE_START = 0.7
"""Distance by which a clone begins before it leaves its source, in radii."""


@dataclass(frozen=True, slots=True, eq=False)
class Axes:
    """Cubic Hermite curves of S stems, with frames that do not twist."""

    offsets: Ints
    """[S + 1] into the nodes; at least two per stem."""
    along: Floats
    """[N] share of the whole stem's length, ascending within a stem; slightly negative where a clone begins."""
    points: Floats
    """[N, 3] metres."""
    tangents: Floats
    """[N, 3] unit vectors."""
    sides: Floats
    """[N, 3] unit vectors at right angles to the tangents."""

    def take(self, stems: Ints) -> Axes:
        """Selected stems."""
        rows, offsets = take_rows(self.offsets, stems)
        return Axes(offsets, self.along[rows], self.points[rows], self.tangents[rows], self.sides[rows])

    def begun(self, stems: Flags, starts: Floats) -> Axes:
        """The same curves, of which some begin at other points.

        Args:
            stems: [S] which ones.
            starts: [K, 3] metres.
        """
        points = self.points.copy()
        points[self.offsets[:-1][stems]] = starts
        return replace(self, points=points)

    def turns(self) -> Floats:
        """[N] radians between the tangents at a node and at the next one; 0 at the ends of stems."""
        cosine = np.ones(len(self.along))
        cosine[:-1] = np.einsum("ni,ni->n", self.tangents[1:], self.tangents[:-1])
        cosine[self.offsets[1:] - 1] = 1.0
        return np.arccos(np.clip(cosine, -1.0, 1.0))

    def positions(self, stem: Ints, along: Floats) -> tuple[Floats, Floats, Floats]:
        """Points, unit tangents and unit sides [R, 3] of stems [R] at shares [R] of their length."""
        node, share = _segments(self.offsets, self.along, stem, along)
        start, end = self.points.take(node, axis=0), self.points.take(node + 1, axis=0)
        chord = end - start
        reach = np.sqrt(np.einsum("ni,ni->n", chord, chord))[:, None]
        t = share[:, None]
        out, into = self.tangents.take(node, axis=0) * reach, self.tangents.take(node + 1, axis=0) * reach
        points = start + t * t * (3.0 - 2.0 * t) * chord + t * (1.0 - t) * ((1.0 - t) * out - t * into)
        slope = 6.0 * t * (1.0 - t) * chord + (1.0 - t) * (1.0 - 3.0 * t) * out + t * (3.0 * t - 2.0) * into
        tangents = _unit(slope)
        return points, tangents, _across(self.sides.take(node, axis=0), tangents)


def axes_of_level(stems: Stems, clone_radius: Floats) -> Axes:
    """Curves of the stems of one level.

    Args:
        stems: S stems.
        clone_radius: [S] radius of clones where they begin, in metres; not used for the others.
    """
    direction = stems.frames[:, :, 2]
    source_node = stems.node_offsets[stems.source] + stems.first - stems.first[stems.source]
    begins_inside = stems.is_clone & (source_node > stems.node_offsets[stems.source])
    counts = stems.num_nodes + begins_inside
    offsets = offsets_from_counts(counts)
    stem = row_of_value(counts)
    node = np.arange(len(stem)) - (offsets[:-1] + begins_inside - stems.node_offsets[:-1])[stem]
    start, clone = offsets[:-1][begins_inside], np.flatnonzero(begins_inside)
    node[start] += 1
    points, directions, along = stems.points[node], direction[node], stems.along[node]
    before = direction[source_node[clone] - 1]
    reach = CLONE_START * clone_radius[clone]
    points[start] -= before * reach[:, None]
    directions[start] = before
    along[start] -= np.minimum(reach / np.maximum(stems.length[clone], 1e-9), 0.5)
    tangents = _node_tangents(directions, offsets[:-1])
    return Axes(offsets, along, points, tangents, _transported(stems.frames[node, :, 0], tangents, offsets))


def interpolated(offsets: Ints, along: Floats, points: Floats, stem: Ints, share: Floats) -> Floats:
    """[K, 3] points at shares [K] of stems [K] on polylines with points [N, 3] at shares [N], ragged by `offsets`."""
    node, part = _segments(offsets, along, stem, share)
    start = points.take(node, axis=0)
    return start + part[:, None] * (points.take(node + 1, axis=0) - start)


def _segments(offsets: Ints, along: Floats, stem: Ints, share: Floats) -> tuple[Ints, Floats]:
    """The nodes [K] at which segments begin that hold shares [K] of stems [K], and the share [K] of each segment."""
    keys = row_of_value(np.diff(offsets)) + _KEY_STEP * along
    node = np.searchsorted(keys, stem + _KEY_STEP * share, side="right") - 1
    node = np.clip(node, offsets[stem], offsets[stem + 1] - 2)
    extent = np.maximum(along[node + 1] - along[node], 1e-12)
    return node, np.clip((share - along[node]) / extent, 0.0, 1.0)


def _node_tangents(directions: Floats, firsts: Ints) -> Floats:
    """[N, 3] means of the directions of the segments before and after each node."""
    tangents = directions.copy()
    tangents[1:] += directions[:-1]
    tangents[firsts] = directions[firsts]
    return _unit(tangents)


def _transported(first_sides: Floats, tangents: Floats, offsets: Ints) -> Floats:
    """[N, 3] the side [N, 3] of the first node of each stem, turned from node to node by the smallest rotation."""
    sides, counts = np.empty_like(tangents), np.diff(offsets)
    active = np.arange(len(counts))
    node = offsets[:-1]
    side = _across(first_sides[node], tangents[node])
    sides[node] = side
    step = 1
    while True:
        more = counts[active] > step
        active, side, node = active[more], side[more], node[more] + 1
        if len(active) == 0:
            return sides
        before, after = tangents[node - 1], tangents[node]
        turn = 1.0 + np.einsum("ni,ni->n", before, after)
        amount = np.einsum("ni,ni->n", after, side) / np.maximum(turn, 1e-6)
        side = _across(side - amount[:, None] * (before + after), after)
        sides[node] = side
        step += 1


def _across(sides: Floats, tangents: Floats) -> Floats:
    """[N, 3] unit vectors nearest to sides [N, 3] at right angles to unit tangents [N, 3]."""
    flat = sides - np.einsum("ni,ni->n", sides, tangents)[:, None] * tangents
    squares = np.einsum("ni,ni->n", flat, flat)
    parallel = squares < 1e-12
    if parallel.any():
        # Any other axis will do where a curve turns into its own side.
        axis = np.eye(3)[np.abs(tangents[parallel]).argmin(axis=1)]
        flat[parallel] = axis - np.einsum("ni,ni->n", axis, tangents[parallel])[:, None] * tangents[parallel]
        squares = np.einsum("ni,ni->n", flat, flat)
    return flat / np.sqrt(squares)[:, None]


def _unit(vectors: Floats) -> Floats:
    """Vectors [N, 3] at length one; straight up if there is no direction."""
    length = np.sqrt(np.einsum("ni,ni->n", vectors, vectors))[:, None]
    return np.where(length > 1e-12, vectors / np.maximum(length, 1e-12), (0.0, 1.0, 0.0))
