"""Sites: parcels with all that decides about their buildings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.derivation.lots import AttributeColumn, Footprints, Lots


@dataclass(frozen=True, eq=False, kw_only=True)
class Sites:
    """S places to build on, in the order of their parcels; at most one per parcel."""

    parcel: Ints
    """[S] row of the parcel."""
    zone: Ints
    """[S] number of the zone in the plan."""
    seed: NDArray[np.uint64]
    """[S] seed: the city's, or that of a pin."""
    model: NDArray[np.uint64]
    """[S] index of the model under the seed (`grammarlab.city.parcel_addresses`)."""
    reroll: Ints
    """[S] how often the parcel was rerolled, >= 0."""
    corner: Floats
    """[S, 3] origin of the footprint in the world: x and z in whole metres from the frame's origin, y the height of
    the ground at the front."""
    plinth: Floats
    """[S] metres from the corner down to the lowest ground below the outline of the footprint; 0 without a terrain."""
    footprints: Footprints
    """S footprints in metres from their corners: one per site, edge 0 along the widest street; with the widths of the
    streets along their edges."""
    attributes: Mapping[str, AttributeColumn]
    """[S] values of attributes by name: those of the zones in the plan, and what is known of the parcels. Which of them
    a grammar has is not checked."""
    start_rule: NDArray[np.object_]
    """[S] names of start rules; empty for the one that the grammar marks."""

    def __len__(self) -> int:
        return len(self.parcel)

    def take(self, rows: NDArray[np.integer]) -> Sites:
        """The sites at these rows, in this order."""
        return Sites(
            parcel=self.parcel[rows],
            zone=self.zone[rows],
            seed=self.seed[rows],
            model=self.model[rows],
            reroll=self.reroll[rows],
            corner=self.corner[rows],
            plinth=self.plinth[rows],
            footprints=self.footprints.take(rows),
            attributes={name: column.take(rows) for name, column in self.attributes.items()},
            start_rule=self.start_rule[rows],
        )

    def lots(self) -> Lots:
        """The sites as lots to derive; all attributes must be those of the grammar."""
        names, start_rule = np.unique(self.start_rule.astype(np.str_), return_inverse=True)
        return Lots(
            seed=self.seed,
            model=self.model,
            footprints=self.footprints,
            footprint=np.arange(len(self), dtype=np.int32),
            attributes={name: column for name, column in self.attributes.items() if column.is_given.any()},
            start_rules=tuple(names.tolist()),
            start_rule=start_rule.astype(np.int32),
        )
