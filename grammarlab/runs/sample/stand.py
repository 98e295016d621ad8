"""Stands of trees: the trees of a run on an area, with their places."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.errors import AssetError
from grammarlab.randomness import Keys
from grammarlab.runs.work.json_members import member, numbers, of_kind

HECTARE = 10_000.0
"""Square metres."""
MAX_TREES = 100_000
"""Most trees of a stand."""
_MAX_COORDINATE = 1e8
"""Largest coordinate in metres: those of maps on Earth are smaller."""
_MAX_WORD = 2**63
_MAX_CORNERS = 1_000_000
"""Most corners of the outlines of an area."""


@dataclass(frozen=True, slots=True, eq=False)
class Stand:
    """n trees on an area, the earliest first: model k of a run is tree k."""

    model: Keys
    """[n] index under the seed of the run, which is the address of its place: the same in every area."""
    position: Floats
    """[n, 3] of the bases of the trunks, in world metres."""
    radius: Floats
    """[n] metres of room for the crown around the trunk."""
    outlines: tuple[tuple[Floats, ...], ...]
    """The polygons of the area, each with the rings [k, 2] of its outline and of its holes: world x and z in metres."""
    size: float
    """Square metres of the area."""
    density: float
    """Trees per hectare of a large area; the same density and gap place the same trees."""
    gap: float
    """Metres between crowns."""
    is_full: bool
    """Whether hardly another tree fits."""

    def __len__(self) -> int:
        return len(self.model)

    def __str__(self) -> str:
        more = "; hardly another one fits" if self.is_full else ""
        gap = f" --gap {self.gap:g}" if self.gap else ""
        density = repr(self.density).removesuffix(".0")
        return (
            f"{len(self):,} trees on {self.size / HECTARE:.3g} hectares{more}. On a larger area, "
            f"--density {density}{gap} plants them again with others around them"
        )

    def as_json(self) -> dict[str, Any]:
        """All fields as plain values."""
        columns = zip(self.model.tolist(), self.position.tolist(), self.radius.tolist(), strict=True)
        return {
            "size": self.size,
            "density": self.density,
            "gap": self.gap,
            "is_full": self.is_full,
            "outlines": [[ring.tolist() for ring in rings] for rings in self.outlines],
            # Programs in other languages round large numbers.
            "trees": [{"model": str(model), "x": x, "z": z, "radius": radius} for model, (x, _, z), radius in columns],
        }

    @classmethod
    def from_json(cls, values: Mapping[str, Any], where: str) -> Stand:
        """The stand of `as_json`.

        Raises:
            AssetError: If the values are not those of a stand.
        """
        size, density, gap = numbers([values.get(name) for name in ("size", "density", "gap")], 3, f"{where}.size")
        trees = member(values, "trees", list, where)
        if len(trees) > MAX_TREES:
            raise AssetError(f"{where}.trees: expected at most {MAX_TREES:,}, found {len(trees):,}.")
        table = np.array([_numbers_of(tree, f"{where}.trees[{k}]") for k, tree in enumerate(trees)]).reshape(-1, 3)
        if np.abs(table).max(initial=0.0) > _MAX_COORDINATE or (table[:, 2] < 0).any():
            raise AssetError(f"{where}.trees: expected places on a map and radii of at least 0 m.")
        outlines = member(values, "outlines", list, where)
        return cls(
            model=np.array([_word(tree, f"{where}.trees") for tree in trees], dtype=np.uint64),
            position=np.column_stack([table[:, 0], np.zeros(len(table)), table[:, 1]]),
            radius=table[:, 2],
            outlines=tuple(
                tuple(_ring(ring, f"{where}.outlines") for ring in of_kind(rings, list, f"{where}.outlines"))
                for rings in outlines
            ),
            size=size,
            density=density,
            gap=gap,
            is_full=member(values, "is_full", bool, where),
        )


def _numbers_of(tree: Any, where: str) -> list[float]:
    entries = of_kind(tree, dict, where)
    return numbers([entries.get(name) for name in ("x", "z", "radius")], 3, where)


def _word(tree: Mapping[str, Any], where: str) -> int:
    text = member(tree, "model", str, where)
    if not (text.isascii() and text.isdigit() and len(text) < 20 and int(text) < _MAX_WORD):
        raise AssetError(f"{where}: expected a model from 0 to {_MAX_WORD - 1}, found {text[:40]!r}.")
    return int(text)


def _ring(values: Any, where: str) -> Floats:
    corners = of_kind(values, list, where)
    if not 3 <= len(corners) <= _MAX_CORNERS:
        raise AssetError(f"{where}: expected rings of at least 3 corners, found {len(corners):,}.")
    ring = np.array([numbers(corner, 2, where) for corner in corners])
    if np.abs(ring).max() > _MAX_COORDINATE:
        raise AssetError(f"{where}: expected corners within {_MAX_COORDINATE:,.0f} m of the origin.")
    return ring
