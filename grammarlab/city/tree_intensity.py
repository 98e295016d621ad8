"""Intensities of trees: how many of each species stand where, and trees drawn from them.

The intensity has the form of a zone density: ln(trees per hectare) = b + g(u) for each species, g a sum of Matérn 3/2
kernels (`grammarlab.city.tree_learning`).

Candidates are those of `grammarlab.trees.arrivals`: a Poisson process in space and time with addresses, in cells of
20 m. A candidate is a tree if its time is below the intensity at its place, and no earlier candidate is within the
crown (the second hard-core process of B. Matérn, *Spatial Variation*, 1960). So a tree depends on what is near it and
not on the outline of the area, and a denser forest has the candidates of a sparser one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import KDTree

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.city.fields import METRES_PER_KM
from grammarlab.city.zone_density import matern, text_words
from grammarlab.city.zone_draws import zone_noise
from grammarlab.geometry.footprints.equal_area import Plane
from grammarlab.geometry.footprints.frame import Frame
from grammarlab.randomness import Keys, derived_seed
from grammarlab.trees.arrivals import FULL, candidates_in
from grammarlab.trees.planting import HECTARE

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

CELL = 20.0
"""Side of the cells in metres. It divides the grid of the origins of frames, so cells are the same in all frames."""
MAX_INTENSITY = FULL * HECTARE / CELL**2
"""Largest intensity in trees per hectare before thinning: 200; larger ones count as this one."""
_BLOCK = 1 << 16
"""Points whose kernels are in memory at once: 34 MB for 64 places."""


@dataclass(frozen=True, eq=False, kw_only=True)
class TreeIntensity:
    """Trees per hectare of S species at any place."""

    species: tuple[str, ...]
    """[S] different names."""
    frame: Frame
    intercept: Floats
    """[S] logarithm of the trees per hectare far from all inducing places."""
    places: Floats
    """[M, 2] inducing places in km from the frame's origin."""
    weights: Floats
    """[M, S] weights of the kernel around each place."""
    length: Floats
    """[S] length of the kernel in km, > 0."""
    trees: str
    """SHA-256 of the trees that it was learned from, 64 hexadecimal digits."""

    def at(self, east_north: Floats) -> Floats:
        """[n, S] trees per hectare at points [n, 2] in metres from the frame's origin."""
        return np.exp(np.minimum(self._logarithms(east_north), np.log(MAX_INTENSITY)))

    def species_at(self, east_north: Floats, ids: NDArray[np.object_], seed: int) -> Ints:
        """[n] number of the species drawn for trees that stand anyhow, in proportion to the intensities.

        Args:
            east_north: [n, 2] trees in metres from the frame's origin.
            ids: [n] names of their places; a place has the same species whatever the others are.
            seed: 0 <= seed < 2**64.
        """
        return (self._logarithms(east_north) + zone_noise(ids, self.species, seed)).argmax(axis=1)

    def _logarithms(self, east_north: Floats) -> Floats:
        """[n, S] logarithms of trees per hectare."""
        u = east_north / METRES_PER_KM
        values = np.empty((len(u), len(self.species)))
        for start in range(0, len(u), _BLOCK):
            block = slice(start, start + _BLOCK)
            for column, length in enumerate(self.length.tolist()):
                kernels = matern(u[block], self.places, length)
                values[block, column] = self.intercept[column] + kernels @ self.weights[:, column]
        return values


@dataclass(frozen=True, eq=False)
class Trees:
    """n trees, ordered by their addresses."""

    model: Keys
    """[n] addresses, below 2**63."""
    species: Ints
    """[n] number of the species."""
    east_north: Floats
    """[n, 2] metres from the frame's origin."""

    def __len__(self) -> int:
        return len(self.model)


def trees_in(area: BaseGeometry, intensity: TreeIntensity, radii: Sequence[float], seed: int) -> Trees:
    """Trees drawn from an intensity.

    Args:
        area: polygons in metres from the frame's origin.
        intensity: the intensity.
        radii: [S] > 0, radius of the crown of each species in metres; no tree stands within the crown of another one.
        seed: seed of the city.

    Raises:
        UsageError: If the area has too many cells.
    """
    if area.is_empty:
        return Trees(np.zeros(0, np.uint64), np.zeros(0, np.int64), np.zeros((0, 2)))
    reach, origin = max(radii), np.array(intensity.frame.origin)
    boxes = (shapely.bounds(shapely.get_parts(area)) + np.tile(origin, 2)).reshape(-1, 2, 2)
    boxes += np.array([[-reach], [reach]])
    parts = list[tuple[Keys, Floats, Floats, Ints]]()
    for number, name in enumerate(intensity.species):
        word = int(text_words(np.array([name], object))[0])
        for block in candidates_in(Plane(), boxes, CELL, derived_seed(seed, word)):
            points = block.coordinates - origin
            early = block.time < _rate(intensity.at(points), radii, number) * CELL**2
            parts.append((block.model[early], block.time[early], points[early], np.full(early.sum(), number)))
    model, time, points, species = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    stands = ~_shaded(points, time, model, np.array(radii)[species]) & shapely.contains_xy(area, *points.T)
    order = np.flatnonzero(stands)
    order = order[np.argsort(model[order])]
    return Trees(model[order], species[order], points[order])


def _rate(intensities: Floats, radii: Sequence[float], number: int) -> Floats:
    """[n] candidates of a species per square metre, of which as many stand as its intensity says.

    Of candidates with the rate r for all species and crowns of area a, (1 - exp(-r a)) / a stand per square metre.
    """
    per_metre = intensities / HECTARE
    total = per_metre.sum(axis=1)
    crown = np.pi * (per_metre @ np.square(radii)) / np.maximum(total, 1e-12)
    covered = np.minimum(total * crown, 1.0 - np.exp(-1.0) * 0.1)
    factor = np.where(covered > 1e-9, -np.log1p(-covered) / np.maximum(covered, 1e-9), 1.0)
    return per_metre[:, number] * factor


def _shaded(points: Floats, time: Floats, model: Keys, radius: Floats) -> Flags:
    """[n] whether an earlier candidate is within the crown: nearer than the mean of both radii [n]."""
    shaded = np.zeros(len(points), np.bool_)
    if len(points) < 2:
        return shaded
    one, other = KDTree(points).query_pairs(float(radius.max()), output_type="ndarray").T
    near = np.hypot(*(points[one] - points[other]).T) < (radius[one] + radius[other]) / 2
    one, other = one[near], other[near]
    swap = (time[one] > time[other]) | ((time[one] == time[other]) & (model[one] > model[other]))
    shaded[np.where(swap, one, other)] = True
    return shaded
