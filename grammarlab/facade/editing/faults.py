"""Faults that a person sees in an edited facade, measured on the facade and on the sources of its parts.

Nothing is taken from the solver, so results of every kind of edit are compared by one measure. Openings are windows and
doors, or all elements if there are none.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.facade.editing.grids import is_background, single_shops
from grammarlab.facade.editing.pieces import WHOLE
from grammarlab.facade.editing.variations import Variation
from grammarlab.facade.looks import is_door, is_opening
from grammarlab.facade.tree import TOLERANCE, Facade, X, Y

_LEAST_OVERLAP = 0.2
"""Least common share of the shorter of two openings of which one is above or beside the other."""
_MOST_SHIFT = 0.02
"""Largest difference of the sides of two openings in line, as a share of the shorter one."""
_MOST_STRETCH = 1.43
"""Largest change of the ratio of width to height of an opening."""
_MOST_UNEQUAL = 1.1
"""Largest ratio of openings of one size after the edit."""
_MOST_SHARE = 0.05
"""Largest share of openings with a fault that nobody sees."""
_MOST_BORDER = 0.5
"""Largest part of a side of the facade that its border may take up inside."""
_LEAST_OPEN = 0.7
"""Least share of the area of openings of the facade, as a share of that before."""
_LEAST_SIZE = 0.5
"""Least size of an element, as a share of its own."""


@dataclass(frozen=True, slots=True)
class Faults:
    """How much of an edited facade has each kind of fault."""

    out_of_line: float
    """Share of pairs of openings that stood exactly above (beside) each other and do no more."""
    stretched: float
    """Share of openings with clearly other proportions."""
    unequal: float
    """Largest ratio of the sizes of openings that were equal."""
    border_inside: float
    """Length of parts of the edge of the facade that are inside now, as a share of that edge."""
    doors: int
    """Number of doors more or fewer."""
    cut: float
    """Share of openings and outlines of which only a part is left, and of shop windows of which less than half is."""
    shrunk: float
    """Share of elements of less than half of their own size."""
    open: float
    """Share of the facade's area that openings have, as a share of that before; 1 if there are none."""

    @property
    def words(self) -> tuple[str, ...]:
        """The faults that a person sees, in words."""
        visible = {
            "openings out of line": self.out_of_line > _MOST_SHARE,
            "stretched openings": self.stretched > _MOST_SHARE,
            "unequal openings": self.unequal > _MOST_UNEQUAL,
            "parts of the edge inside": self.border_inside > _MOST_BORDER,
            "another number of doors": self.doors != 0,
            "cut openings": self.cut > 0.0,
            "elements of less than half of their size": self.shrunk > 0.0,
            "blank walls": self.open < _LEAST_OPEN,
        }
        return tuple(name for name, is_visible in visible.items() if is_visible)


def find_faults(original: Facade, variation: Variation, facade: Facade) -> Faults:
    """The faults of an edited facade.

    Args:
        original: the facade before the edit.
        variation: sources of the nodes of the edited facade.
        facade: the edited facade, with its sizes.
    """
    source = variation.source
    leaf = facade.leaves[source[facade.leaves] >= 0]
    whole = np.isclose(variation.visible[leaf], WHOLE, atol=1e-6).all(axis=1)
    element = ~is_background(facade)[leaf]
    names = np.array([*(is_opening(name) for name in facade.labels), False])
    opening = names[facade.label[leaf]] if names[original.label[original.leaves]].any() else element
    has_outline = np.diff(facade.outline_offsets)[leaf] > 0
    shops = single_shops(original)[source[leaf]]
    is_rest = (facade.size[leaf] < _LEAST_SIZE * original.size[source[leaf]]).any(axis=1)
    cut = ~whole & (opening | (element & has_outline) | (shops & is_rest))
    seen = leaf[opening & whole]
    ratio = facade.size[leaf] / variation.target[leaf]
    proportion = facade.size[seen] / original.size[source[seen]]
    stretch = np.exp(np.abs(np.log(proportion[:, X] / proportion[:, Y])))
    doors = [
        int(np.array([*(is_door(name) for name in one.labels), False])[one.label[one.leaves]].sum())
        for one in (original, facade)
    ]
    return Faults(
        out_of_line=_out_of_line(original, source[seen], facade, seen),
        stretched=_share(stretch > _MOST_STRETCH),
        unequal=_unequal(original, source[seen], facade, seen),
        border_inside=_border_inside(original, source[leaf[whole]], facade, leaf[whole]),
        doors=doors[1] - doors[0],
        cut=_share(cut),
        shrunk=_share(ratio[element].min(axis=1, initial=np.inf) < _LEAST_SIZE),
        open=_open_share(facade, names) / before if (before := _open_share(original, names)) else 1.0,
    )


def _open_share(facade: Facade, opening: Flags) -> float:
    """Share of the area of a facade that leaves with these labels have."""
    leaf = facade.leaves
    return float(facade.size[leaf[opening[facade.label[leaf]]]].prod(axis=1).sum() / facade.size[0].prod())


def _share(flags: Flags) -> float:
    return float(flags.mean()) if len(flags) else 0.0


def _out_of_line(original: Facade, source: Ints, facade: Facade, node: Ints) -> float:
    num_pairs = num_shifted = 0
    for along in (X, Y):
        sides = np.stack([original.position[source, along], original.size[source, along]], axis=1)
        low = facade.position[node, along]
        high, across = low + facade.size[node, along], facade.position[node, 1 - along]
        for group in _equal(sides, TOLERANCE * float(original.size[0, along])):
            order = group[np.argsort(across[group], kind="stable")]
            pairs, shifted = _pairs(
                low[order], high[order], across[order], TOLERANCE * float(facade.size[0, 1 - along])
            )
            num_pairs, num_shifted = num_pairs + pairs, num_shifted + shifted
    return num_shifted / num_pairs if num_pairs else 0.0


def _pairs(low: Floats, high: Floats, across: Floats, slack: float) -> tuple[int, int]:
    """Number of intervals, in the order of their place across, with another above them; and of those out of line."""
    shorter = np.minimum(high - low, (high - low)[:, None])
    overlap = np.minimum(high, high[:, None]) - np.maximum(low, low[:, None])
    above = (across > across[:, None] + slack) & (overlap > _LEAST_OVERLAP * shorter)
    first, has_above = above.argmax(axis=1), above.any(axis=1)
    here = np.arange(len(low))
    shift = np.maximum(np.abs(low[first] - low), np.abs(high[first] - high))
    return int(has_above.sum()), int((has_above & (shift > _MOST_SHIFT * shorter[here, first])).sum())


def _unequal(original: Facade, source: Ints, facade: Facade, node: Ints) -> float:
    worst = 1.0
    for along in (X, Y):
        size = facade.size[node, along]
        for group in _equal(original.size[source, along][:, None], TOLERANCE * float(original.size[0, along])):
            worst = max(worst, float(size[group].max() / size[group].min()))
    return worst


def _equal(values: Floats, tolerance: float) -> list[Ints]:
    """Indices of equal rows [K, V] for each group of at least two."""
    if not len(values):
        return []
    number = np.rint(values / (4.0 * tolerance)).astype(np.int64)
    _, group = np.unique(number, axis=0, return_inverse=True)
    order = np.argsort(group, kind="stable")
    return [one for one in np.split(order, np.cumsum(np.bincount(group))[:-1]) if len(one) > 1]


def _border_inside(original: Facade, source: Ints, facade: Facade, node: Ints) -> float:
    worst = 0.0
    for along in (X, Y):
        low = original.position[source, along] - original.position[0, along]
        high, whole = low + original.size[source, along], float(original.size[0, along])
        slack = TOLERANCE * whole
        at_edge = ((low <= slack) | (high >= whole - slack)) & (high - low < 0.5 * whole)
        new_low = facade.position[node, along] - facade.position[0, along]
        new_high, new_whole = new_low + facade.size[node, along], float(facade.size[0, along])
        slack = TOLERANCE * new_whole
        inside = at_edge & (new_low > slack) & (new_high < new_whole - slack)
        worst = max(worst, float(facade.size[node[inside], 1 - along].sum() / facade.size[0, 1 - along]))
    return worst
