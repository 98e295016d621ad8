"""Where children leave their parents: their number, places, angles and lengths (Weber and Penn, section 4.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Floats, Ints, index_in_row, row_of_value
from grammarlab.randomness import Keys
from grammarlab.trees.draws import Site, counts, values, varied_by
from grammarlab.trees.orientation import axes_from_frames, turned_about_x, turned_about_z
from grammarlab.trees.parameters import SPREAD
from grammarlab.trees.skeleton import Stems

_EPSILON = 1e-9
"""Tolerance of the rounding of counts, so that it does not depend on the order of operations."""
_TURN = np.int64(1) << np.int64(52)
"""Units of a full turn: sums of whole numbers do not depend on the batch, sums of floats do."""


@dataclass(frozen=True, slots=True, eq=False)
class Spots:
    """C places on stems where children begin, in the order of the stems."""

    stem: Ints
    """[C] row of the parent in its level."""
    index: Ints
    """[C] number of the child on its parent, from 0."""
    along: Floats
    """[C] share of the length of the parent."""
    node: Ints
    """[C] node of the parent at which the segment begins that bears it."""
    share: Floats
    """[C] share of this segment, 0 to 1."""

    def positions(self, stems: Stems) -> Floats:
        """[C, 3] metres."""
        start = stems.points[self.node]
        return start + self.share[:, None] * (stems.points[self.node + 1] - start)

    def axes(self, stems: Stems) -> Floats:
        """[3, 3, C] axes of the segments."""
        return axes_from_frames(stems.frames[self.node])


def bare_share(rows: Floats, stems: Stems, height: Floats, level: int) -> Floats:
    """[S] share of each stem's length without children: 0 but for trunks.

    Args:
        rows: [n, P] parameters of the trees.
        stems: stems of a level.
        height: [n] metres, of each tree.
        level: the level.
    """
    if level > 0:
        return np.zeros(len(stems))
    return np.minimum(1.0, values(rows, stems.tree, "base_size") * height[stems.tree] / stems.length)


def num_segments(rows: Floats, tree: Ints, level: int) -> Ints:
    """[S] segments of whole stems."""
    return counts(rows, tree, f"curve_res_{level}")


def bearing_start(stems: Stems, bare: Floats, segments: Ints) -> Floats:
    """[S] share of the length from which a stem bears children: a clone bears none before it splits off."""
    return np.maximum(bare, stems.first / segments)


def rounded(numbers: Floats) -> Ints:
    """[S] nearest whole numbers; halves are rounded up."""
    return np.floor(numbers + (0.5 + _EPSILON)).astype(np.int64)


def spots(stems: Stems, start: Floats, segments: Ints, num: Ints) -> Spots:
    """Places of children, evenly in each segment; what rounding loses in one is carried on to the next.

    Args:
        stems: parents.
        start: [S] share of the length from which they bear children.
        segments: [S] segments of the whole stem.
        num: [S] children of each.
    """
    ends = np.arange(int(segments.max(initial=0)) + 1)
    edges = np.minimum(ends / segments[:, None], 1.0)
    bearing = np.maximum(edges, start[:, None])
    shares = (bearing - start[:, None]) / np.where(start < 1.0, 1.0 - start, 1.0)[:, None]
    totals = rounded(num[:, None] * shares)
    in_segment = np.diff(totals, axis=1)
    cell = row_of_value(in_segment.ravel())
    number = index_in_row(in_segment.ravel())
    stem, segment = np.divmod(cell, max(1, len(ends) - 1))
    low, high = bearing[stem, segment], edges[stem, segment + 1]
    along = low + (high - low) * ((number + 0.5) / in_segment.ravel()[cell])
    return Spots(
        stem=stem,
        index=totals[stem, segment] + number,
        along=along,
        node=stems.node_offsets[stem] + segment - stems.first[stem],
        share=np.clip(along * segments[stem] - segment, 0.0, 1.0),
    )


def child_axes(rows: Floats, level: int, place: Spots, stems: Stems, bare: Floats, keys: Keys) -> Floats:
    """[3, 3, C] axes with which children begin.

    Args:
        rows: [n, P] parameters of the trees.
        level: level whose angles are used.
        place: where they begin.
        stems: their parents.
        bare: [S] `bare_share` of the parents.
        keys: [C] keys of the children.
    """
    axes = turned_about_z(place.axes(stems), azimuths(rows, level, place, stems, keys))
    down = down_angles(rows, level, stems.tree[place.stem], place.along, bare[place.stem], keys)
    return turned_about_x(axes, down)


def down_angles(rows: Floats, level: int, tree: Ints, along: Floats, bare: Floats, keys: Keys) -> Floats:
    """[C] radians between the directions of children and of their parents.

    Args:
        rows: [n, P] parameters of the trees.
        level: level whose angles are used.
        tree: [C] tree of each child.
        along: [C] share of its parent's length at which it begins.
        bare: [C] `bare_share` of its parent.
        keys: [C] keys of the children.
    """
    angle, spread = values(rows, tree, f"down_angle_{level}"), values(rows, tree, f"down_angle_{level}{SPREAD}")
    # S(0, height below the top) = .2 + .8 of it: with a negative spread, high children point up and low ones down.
    by_height = spread * (1.0 - 2.0 * (0.2 + 0.8 * below_top(along, bare)))
    drawn = varied_by(np.maximum(spread, 0.0), keys, Site.DOWN)
    return np.radians(angle + np.where(spread < 0.0, by_height, drawn))


def below_top(along: Floats, bare: Floats) -> Floats:
    """[C] share of the bearing part of a stem that is above a place: 0 at the tip, 1 where the first children are."""
    return (1.0 - along) / np.where(bare < 1.0, 1.0 - bare, 1.0)


def azimuths(rows: Floats, level: int, place: Spots, stems: Stems, keys: Keys) -> Floats:
    """[C] radians by which children are turned about the direction of their parent."""
    tree = stems.tree[place.stem]
    rotate = values(rows, tree, f"rotate_{level}")
    spread = varied_by(values(rows, tree, f"rotate_{level}{SPREAD}"), keys, Site.ROTATE)
    units = np.rint((rotate + spread) * (float(_TURN) / 360.0)).astype(np.int64)
    sums = np.cumsum(units)  # it may wrap around: only its part below a full turn is used
    first = np.flatnonzero(np.diff(place.stem, prepend=-1))
    sums -= np.repeat(sums[first] - units[first], np.diff(first, append=len(units)))
    helix = (sums & (_TURN - 1)) * (2.0 * np.pi / float(_TURN))
    side = np.where(place.index % 2 == 0, 1.0, -1.0)
    return np.where(rotate < 0.0, side * np.radians(180.0 - rotate + spread), helix)


def num_children(rows: Floats, level: int, stems: Stems, parents: Stems | None, unit: Floats) -> Floats:
    """[S] children of a level if their parent bears them along its whole length, before rounding.

    Args:
        rows: [n, P] parameters of the trees.
        level: level of the children.
        stems: stems of the level before, which bear them.
        parents: parents of these; None for trunks.
        unit: [n] metres: the length of each tree's trunk before its stretch.
    """
    branches = values(rows, stems.tree, f"branches_{level}")
    if parents is None:
        return branches
    if level == 2:
        longest = values(rows, stems.tree, "length_1") + values(rows, stems.tree, f"length_1{SPREAD}")
        return branches * (0.2 + 0.8 * np.minimum(1.0, stems.length / (unit[stems.tree] * longest)))
    return branches * (1.0 - 0.5 * stems.offset / parents.length[stems.parent])
