"""Sequences of edits, and duplicates among variations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from grammarlab.facade.grids.kinds import kinds
from grammarlab.facade.tree import LEAF, Facade, X
from grammarlab.facade.variations.single import Variation, unedited, vary

Ints = NDArray[np.int64]


def canonical(variation: Variation, kind: Ints) -> bytes:
    """A canonical form: equal for variations of one facade that look the same, pictures aside.

    Args:
        variation: a variation of that facade.
        kind: [N] from `kinds.kinds` of the original facade.
    """
    facade = variation.facade
    what = np.where(facade.axis == LEAF, kind[np.maximum(variation.source, 0)], -1)
    part = np.round(variation.shown[:, 2:] - variation.shown[:, :2], 3)
    return b"".join(column.tobytes() for column in (facade.parent, facade.axis, what, part))


def distinct(variations: Sequence[Variation], kind: Ints) -> tuple[Variation, ...]:
    """The variations without those that look like an earlier one; `kind` as for `canonical`."""
    first: dict[bytes, Variation] = {}
    for variation in variations:
        first.setdefault(canonical(variation, kind), variation)
    return tuple(first.values())


def sequences(
    facade: Facade,
    grid: str,
    axis: int,
    steps: int,
    *,
    also: Sequence[str] | None = None,
    most: int = 1000,
    start: Sequence[Variation] = (),
) -> tuple[Variation, ...]:
    """Different variations after a number of insertions, or of removals for a negative number.

    Args:
        facade: the facade to edit.
        grid: name of the active grid.
        axis: X for columns, Y for rows.
        steps: number of columns or rows to add, or to remove if negative.
        also: as for `vary`; a grid is left out while a previous step left it with another number of columns (rows).
        most: largest number of intermediate variations to continue from.
        start: variations of the facade to start from; by default the facade itself.
    """
    kind, found = kinds(facade), (*start,) or (unedited(facade),)
    for _ in range(abs(steps)):
        further = [
            variation
            for before in found[:most]
            if any(each.name == grid for each in before.facade.grids)
            for variation in vary(
                before,
                grid,
                axis,
                also=also if also is None else _in_step(before.facade, grid, axis, also),
                insertions=steps > 0,
                removals=steps < 0,
            ).found
        ]
        found = distinct(further, kind)
    return found


def _in_step(facade: Facade, grid: str, axis: int, others: Sequence[str]) -> tuple[str, ...]:
    """Those of some grids with as many columns (rows) as another one."""
    count = {each.name: each.num_columns if axis == X else each.num_rows for each in facade.grids}
    return tuple(name for name in others if count.get(name) == count[grid])
