"""Joints: how wide a stem is inside its parent and where it leaves it, so that it grows out of it without a gap.

A stem begins on the axis of its parent, no wider than its parent there, and is widened where it leaves its surface.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.trees.skeleton import Skeleton
from grammarlab.trees.taper import radii

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
