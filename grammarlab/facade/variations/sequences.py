"""Several edits one after the other, and which variations look the same."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from grammarlab.facade.grids.kinds import kinds
from grammarlab.facade.tree import LEAF, Facade, X
from grammarlab.facade.variations.single import Variation, unedited, vary

Ints = NDArray[np.int64]


def canonical(variation: Variation, kind: Ints) -> bytes:
    """A form that two variations of one facade share when they look the same, pictures aside.

    Args:
        variation: Of that facade.
        kind: [N] from `kinds.kinds` of the facade that was edited first.
    """
    facade = variation.facade
    what = np.where(facade.axis == LEAF, kind[np.maximum(variation.source, 0)], -1)
    part = np.round(variation.shown[:, 2:] - variation.shown[:, :2], 3)
    return b"".join(column.tobytes() for column in (facade.parent, facade.axis, what, part))


def distinct(variations: Sequence[Variation], kind: Ints) -> tuple[Variation, ...]:
    """The variations less those that look like an earlier one; `kind` as for `canonical`."""
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
        facade: What is edited.
        grid: Name of the active grid.
        axis: X for columns, Y for rows.
        steps: How many columns or rows come or go.
        also: As for `vary`; a grid that a step left with fewer or more columns (rows) than the active one rests then.
        most: How many of the variations on the way are gone on from.
        start: Variations of the facade to go on from; by default the facade itself.
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
    """Those of some grids that have as many columns (rows) as another one."""
    count = {each.name: each.num_columns if axis == X else each.num_rows for each in facade.grids}
    return tuple(name for name in others if count.get(name) == count[grid])
