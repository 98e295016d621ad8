"""Rings of the stems of one level: where their cross-sections are along them, at full detail, and how wide they are.

A stem begins on the axis of its parent, no wider than its parent there, and is widened where it leaves its surface: it
grows out of its parent without a gap.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Floats, Ints, index_in_row, offsets_from_counts, row_of_value, take_rows
from grammarlab.trees.draws import values
from grammarlab.trees.skeleton import Skeleton
from grammarlab.trees.stem_axes import Axes
from grammarlab.trees.taper import radii

_SMOOTH_TURN = np.radians(14.0)
"""Largest turn between two rings, in radians, that looks smooth at full detail."""
_MOST_PARTS = (4, 3, 2, 1)
"""Largest number of parts of a segment, by level."""
_FLARE = np.array([0.006, 0.016, 0.032, 0.056, 0.09])
"""Shares of a trunk at which rings show its flare, which ends at 1/8."""
_CLOSEST = 1e-4
"""Smallest share of a length between two rings of a stem."""
_ROUND_END = np.array([1.0, 0.72, 0.45, 0.22, 0.07])
"""Distances from a rounded end, in radii, at which rings show it."""
_COLLAR = np.array([0.0, 0.35, 1.0])
"""Shares of a collar at which rings show it."""
_RINGS_PER_BEAD = 6
_MOST_BEADS = (40, 12, 4, 2)
"""Largest number of beads of one stem that rings show, by level: a budget."""
WIDENING = 0.3
"""Widening of a stem where it leaves its parent, by its radius."""
_COLLAR_LENGTH = 2.5
"""Length of a collar in radii of its stem."""
_THINNEST_COLLAR = 1e-3
"""Radius of the thinnest stems with a collar, in heights of the tree: 12 mm at 12 m."""
_ROOM = 0.85
"""Largest radius of a stem on the axis of its parent, by that of the parent."""
_CLONE_ROOM = 0.92
"""Radius of a clone where it begins inside its source, by that of the source."""


@dataclass(frozen=True, slots=True, eq=False)
class Collars:
    """Widened parts of the stems of one level."""

    start: Floats
    """[S] share of its length at which a stem leaves its parent."""
    reach: Floats
    """[S] share of its length over which it is widened; 0 for stems without a collar."""
    room: Floats
    """[S] metres: radius of the parent where the stem begins; infinite for trunks and clones."""


@dataclass(frozen=True, slots=True, eq=False)
class Stations:
    """Shares of the length of S stems at which they are drawn; the last is their tip."""

    offsets: Ints
    """[S + 1] into `along`; at least two per stem."""
    along: Floats
    """[R] ascending within a stem, at most 1."""

    @property
    def counts(self) -> Ints:
        """[S] stations of each stem."""
        return np.diff(self.offsets)

    def stem(self) -> Ints:
        """[R] stem of each station."""
        return row_of_value(self.counts)

    def thinned(self, counts: Ints) -> Stations:
        """Evenly chosen stations, `counts` [S] of each stem, at least two: the first, the last and some between."""
        index, row = index_in_row(counts), row_of_value(counts)
        step = (self.counts - 1)[row] / (counts - 1)[row]
        return Stations(offsets_from_counts(counts), self.along[self.offsets[row] + np.rint(index * step).astype(int)])

    def take(self, stems: Ints) -> Stations:
        """The stations of selected stems."""
        rows, offsets = take_rows(self.offsets, stems)
        return Stations(offsets, self.along[rows])


def full_stations(skeleton: Skeleton, level: int, axes: Axes, collars: Collars) -> Stations:
    """Stations of the stems of a level at full detail.

    They are at nodes, in bends, in the flare of trunks, in collars, and at rounded ends and beads.
    """
    parts = np.clip(np.ceil(axes.turns() / _SMOOTH_TURN), 1, _MOST_PARTS[level]).astype(np.int64)
    parts[axes.offsets[1:] - 1] = 1
    node, part = row_of_value(parts), index_in_row(parts)
    following = np.minimum(node + 1, len(axes.along) - 1)
    along = axes.along[node] + (axes.along[following] - axes.along[node]) * part / parts[node]
    counts = np.add.reduceat(parts, axes.offsets[:-1]) if len(parts) else np.zeros(0, np.int64)
    extra_stem, extra = _extra_stations(skeleton, level, collars)
    if len(extra) == 0:
        return Stations(offsets_from_counts(counts), along)
    inside = (extra > along[offsets_from_counts(counts)[extra_stem]]) & (extra < 1.0)
    extra_stem, extra = extra_stem[inside], extra[inside]
    stem = np.concatenate([row_of_value(counts), extra_stem])
    along = np.concatenate([along, extra])
    order = np.argsort(stem + 0.5 * along, kind="stable")
    return _spaced(stem[order], along[order], len(counts))


def _spaced(stem: Ints, along: Floats, num_stems: int) -> Stations:
    """Stations without those that almost touch the one before, or the end of their stem."""
    is_close = (stem[1:] == stem[:-1]) & (np.diff(along) < _CLOSEST)
    is_end = np.append(stem[1:] != stem[:-1], True)
    spare = np.zeros(len(stem), dtype=bool)
    spare[1:] = is_close & ~is_end[1:]
    spare[:-1] |= is_close & is_end[1:]
    return Stations(offsets_from_counts(np.bincount(stem[~spare], minlength=num_stems)), along[~spare])


def _extra_stations(skeleton: Skeleton, level: int, collars: Collars) -> tuple[Ints, Floats]:
    """Stems and shares of stations that a profile of radii needs between the nodes."""
    stems = skeleton.levels[level]
    taper = values(skeleton.rows, stems.tree, f"taper_{level}")
    slenderness = stems.radius / np.maximum(stems.length, 1e-9)
    collared = np.flatnonzero(collars.reach > 0.0)
    rows: list[Ints] = [collared.repeat(len(_COLLAR))]
    shares: list[Floats] = [(collars.start[collared, None] + collars.reach[collared, None] * _COLLAR).ravel()]
    if level == 0:
        flared = np.flatnonzero((values(skeleton.rows, stems.tree, "flare") > 0.0) & ~stems.is_clone)
        rows.append(flared.repeat(len(_FLARE)))
        shares.append(np.tile(_FLARE, len(flared)))
    rounded = np.flatnonzero((taper > 1.0) & (taper <= 2.0))
    rows.append(rounded.repeat(len(_ROUND_END)))
    ends = np.clip(1.0 - np.minimum(slenderness[rounded], 0.5)[:, None] * _ROUND_END, 0.0, 1.0)
    shares.append(ends.ravel())
    beaded = np.flatnonzero(taper > 2.0)
    beads = np.clip(np.ceil(0.5 / np.maximum(slenderness[beaded], 1e-6)), 1, _MOST_BEADS[level]).astype(np.int64)
    counts = beads * _RINGS_PER_BEAD - 1
    rows.append(beaded.repeat(counts))
    shares.append((index_in_row(counts) + 1.0) / (counts + 1.0).repeat(counts))
    return np.concatenate(rows), np.concatenate(shares)


def collars(skeleton: Skeleton, level: int) -> Collars:
    """Collars of the stems of a level."""
    stems = skeleton.levels[level]
    start, reach, room = np.zeros(len(stems)), np.zeros(len(stems)), np.full(len(stems), np.inf)
    child = np.flatnonzero((stems.parent >= 0) & ~stems.is_clone)
    if level == 0 or len(child) == 0:
        return Collars(start, reach, room)
    parents, parent = skeleton.levels[level - 1], stems.parent[child]
    along = np.clip(stems.offset[child] / np.maximum(parents.length[parent], 1e-9), 0.0, 1.0)
    room[child] = radii(skeleton, level - 1, parent, along)
    thick = stems.radius[child] >= _THINNEST_COLLAR * skeleton.scale[stems.tree[child]]
    child, parent, along = child[thick], parent[thick], along[thick]
    node = parents.node_offsets[parent] + _segment(skeleton, level - 1, parent, along)
    cosine = np.einsum("ni,ni->n", parents.frames[node, :, 2], stems.frames[stems.node_offsets[child], :, 2])
    # A stem along its parent never leaves it: its collar lies within its first third.
    way_out = room[child] / np.sqrt(np.maximum(1.0 - cosine**2, 0.01)) / np.maximum(stems.length[child], 1e-9)
    start[child] = np.minimum(way_out, 0.3)
    reach[child] = np.minimum(_COLLAR_LENGTH * stems.radius[child] / np.maximum(stems.length[child], 1e-9), 0.3)
    return Collars(start, reach, room)


def joined_radii(skeleton: Skeleton, level: int, stem: Ints, along: Floats, parts: Collars, is_first: Ints) -> Floats:
    """[R] radii at cross-sections of stems, in metres.

    Args:
        skeleton: the trees.
        level: level of the stems.
        stem: [R] rows of the stems.
        along: [R] shares of their length.
        parts: collars of the level.
        is_first: [K] indices of the first cross-section of each stem.
    """
    radius = radii(skeleton, level, stem, np.clip(along, 0.0, 1.0))
    collared = np.flatnonzero(parts.reach[stem] > 0.0)
    owner = stem[collared]
    distance = np.clip((along[collared] - parts.start[owner]) / parts.reach[owner], 0.0, 1.0)
    wide = radius[collared] * (1.0 + WIDENING * (1.0 - distance) ** 2)
    radius[collared] = np.maximum(radius[collared], np.minimum(wide, _ROOM * parts.room[owner]))
    stems = skeleton.levels[level]
    owner = stem[is_first]
    factor = np.where(
        stems.is_clone[owner] & (along[is_first] < stems.along[stems.node_offsets[owner]]), _CLONE_ROOM, 1.0
    )
    radius[is_first] = np.minimum(radius[is_first] * factor, _ROOM * parts.room[owner])
    return radius


def _segment(skeleton: Skeleton, level: int, stem: Ints, along: Floats) -> Ints:
    """[K] number of the segment of each stem that holds a share of its length, of segments of equal length."""
    stems = skeleton.levels[level]
    start = stems.along[stems.node_offsets[stem]]
    segments = stems.num_nodes[stem] - 1
    share = (along - start) / np.maximum(1.0 - start, 1e-9)
    return np.clip(np.floor(share * segments), 0, segments - 1).astype(np.int64)
