"""Sequences of edits without duplicates, ranked so that good and different results come first."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from grammarlab.arrays import Ints
from grammarlab.facade.editing.grids import kinds
from grammarlab.facade.editing.variations import Variation, unedited, vary
from grammarlab.facade.tree import LEAF, Facade, X

_POINTS_PER_SIDE = 48
"""Number of points along each side of a facade at which two of them are compared."""


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
        also: names of grids that are edited in the same places, see `vary`; a grid is left out while a
            previous step left it with another number of columns (rows).
        most: largest number of intermediate variations to continue from.
        start: variations of the facade to start from; by default the facade itself.
    """
    kind, variations = kinds(facade), (*start,) or (unedited(facade),)
    for _ in range(abs(steps)):
        further = [
            variation
            for before in variations[:most]
            if any(other.name == grid for other in before.facade.grids)
            for variation in vary(
                before,
                grid,
                axis,
                also=also if also is None else _in_step(before.facade, grid, axis, also),
                insertions=steps > 0,
                removals=steps < 0,
            ).variations
        ]
        variations = distinct(further, kind)
    return variations


def distinct(variations: Sequence[Variation], kind: Ints) -> tuple[Variation, ...]:
    """The variations without those that look like an earlier one.

    Args:
        variations: variations of one facade.
        kind: [N] from `grids.kinds` of the original facade.
    """
    first: dict[bytes, Variation] = {}
    for variation in variations:
        first.setdefault(canonical(variation, kind), variation)
    return tuple(first.values())


def canonical(variation: Variation, kind: Ints) -> bytes:
    """A canonical form: equal for variations of one facade that look the same, pictures aside.

    Args:
        variation: a variation of that facade.
        kind: [N] from `grids.kinds` of the original facade.
    """
    facade = variation.facade
    leaf_kind = np.where(facade.axis == LEAF, kind[np.maximum(variation.source, 0)], -1)
    visible_size = np.round(variation.visible[:, 2:] - variation.visible[:, :2], 3)
    return b"".join(column.tobytes() for column in (facade.parent, facade.axis, leaf_kind, visible_size))


def ranked(
    variations: Sequence[Variation],
    kind: Ints,
    energy: Callable[[Variation], float] | None = None,
    different: int = 10,
) -> tuple[Variation, ...]:
    """Variations without duplicates in look, with good and different ones first.

    The first one has the least energy. Then, among the better half, the next one is always the one farthest from all
    previous ones (`appearance`), so that each group of similar ones is represented. After `different` of them the rest
    follows by energy.

    Args:
        variations: variations of one facade.
        kind: [N] from `grids.kinds` of the original facade.
        energy: energy of a variation; `strain` by default.
        different: number of different ones at the start.
    """
    unique = distinct(variations, kind)
    energies = np.array([(energy or strain)(variation) for variation in unique])
    order = np.argsort(energies, kind="stable")
    better = order[: max(different, (len(order) + 1) // 2)]
    looks = np.array([appearance(unique[index], kind) for index in better], dtype=np.int64)
    first = better[_farthest_first(looks, different)]
    rest = order[~np.isin(order, first)]
    return tuple(unique[index] for index in [*first.tolist(), *rest.tolist()])


def strain(variation: Variation) -> float:
    """Deviation of the sizes of leaves from their targets: root mean square of the logarithm of the ratio."""
    leaves = variation.facade.leaves
    return float(np.sqrt(np.square(np.log(variation.facade.size[leaves] / variation.target[leaves])).mean()))


def appearance(variation: Variation, kind: Ints) -> Ints:
    """[K] kind of the leaf at each of K points spread over the facade; its size is ignored.

    The distance of two variations is the fraction of these points at which they differ.
    """
    facade: Facade = variation.facade
    leaves = facade.leaves
    low = facade.position[leaves] / facade.size[0]
    high = low + facade.size[leaves] / facade.size[0]
    # Point i lies at (i + 1/2) / _POINTS_PER_SIDE; a leaf shows at the points from begin to end - 1.
    begin, end = (np.rint(corner * _POINTS_PER_SIDE).astype(np.int64).tolist() for corner in (low, high))
    raster = np.full((_POINTS_PER_SIDE, _POINTS_PER_SIDE), -1, dtype=np.int64)
    leaf_kinds = kind[np.maximum(variation.source[leaves], 0)].tolist()
    for (left, bottom), (right, top), leaf_kind in zip(begin, end, leaf_kinds, strict=True):
        raster[bottom:top, left:right] = leaf_kind
    return raster.ravel()


def _in_step(facade: Facade, grid: str, axis: int, others: Sequence[str]) -> tuple[str, ...]:
    """Those of some grids with as many columns (rows) as another one."""
    count = {other.name: other.num_columns if axis == X else other.num_rows for other in facade.grids}
    return tuple(name for name in others if count.get(name) == count[grid])


def _farthest_first(rows: Ints, count: int) -> Ints:
    """Indices of rows: the first, then always the one with most differences from its nearest chosen one."""
    chosen: list[int] = [0][: len(rows)]
    distance = np.full(len(rows), np.inf)
    while len(chosen) < min(count, len(rows)):
        distance = np.minimum(distance, (rows != rows[chosen[-1]]).mean(axis=1))
        distance[chosen] = -1.0
        chosen.append(int(np.argmax(distance)))
    return np.array(chosen, dtype=np.int64)
