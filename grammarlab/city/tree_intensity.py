"""Intensities of trees: how many of each species stand where, learned from trees on a map, and trees drawn from them.

The intensity has the form of a zone density: ln(trees per hectare) = b + g(u) for each species, g a sum of Matérn 3/2
kernels. It is the mode of a log-Gaussian Cox process (J. Møller, A. Syversveen, R. Waagepetersen, "Log Gaussian Cox
processes", 1998) on cells of 20 m, whose scale and length are learned by the Laplace evidence.

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
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.spatial import KDTree
from threadpoolctl import threadpool_limits

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.city.fields import METRES_PER_KM
from grammarlab.city.zone_density import matern, text_words
from grammarlab.city.zone_design import kernel_root, rounded, spread_order, whitened_kernels
from grammarlab.errors import UsageError
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
_PLACES = 64
"""Most inducing places."""
_MAX_CELLS = 40_000
"""Most cells to learn from."""
_SCALES = (0.0, 0.3, 0.6, 1.0, 1.7, 3.0)
"""Candidate standard deviations of g, in logarithms of intensities; with the first one, trees stand evenly."""
_LENGTHS = (0.25, 0.5, 1.0, 2.0)
"""Candidate lengths of the kernel, by the spread of the cells."""
_STEPS, _TOLERANCE = 60, 1e-9
_PSEUDO_TREES = 0.5
"""Trees added to a species without any, so that its logarithm is finite."""


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
    """[S] length of the kernel in km."""

    def at(self, east_north: Floats) -> Floats:
        """[n, S] trees per hectare at points [n, 2] in metres from the frame's origin."""
        u = east_north / METRES_PER_KM
        parts = [
            matern(u, self.places, length) @ weights
            for length, weights in zip(self.length, self.weights.T, strict=True)
        ]
        return np.exp(np.minimum(self.intercept + np.column_stack(parts), np.log(MAX_INTENSITY)))


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


def learned_intensity(
    east_north: Floats, species: NDArray[np.object_], area: BaseGeometry, frame: Frame
) -> TreeIntensity:
    """The intensity of trees on a map.

    Args:
        east_north: [n, 2] trees in metres from the frame's origin; those outside the area are left out.
        species: [n] names of their species.
        area: where all trees are on the map, in metres.
        frame: the frame.

    Raises:
        UsageError: If the area is empty or too large, or there are no species.
    """
    names = tuple(sorted(set(species.tolist())))
    if not names:
        raise UsageError("trees: expected at least one.")
    centres, share = _cells(area)
    inside = shapely.contains_xy(area, *east_north.T)
    cell_of = {tuple(cell): row for row, cell in enumerate(np.floor(centres / CELL).astype(np.int64).tolist())}
    counts = np.zeros((len(centres), len(names)))
    cells = np.floor(east_north[inside] / CELL).astype(np.int64).tolist()
    for cell, name in zip(cells, species[inside].tolist(), strict=True):
        counts[cell_of[tuple(cell)], names.index(name)] += 1.0
    u = centres / METRES_PER_KM
    places = rounded(u[spread_order(u, _PLACES)])
    with threadpool_limits(1, "blas"):
        fits = [_fit(u, share * CELL**2 / HECTARE, column, places) for column in counts.T]
    return TreeIntensity(
        species=names,
        frame=frame,
        intercept=np.array([fit[0] for fit in fits]),
        places=places,
        weights=np.column_stack([fit[1] for fit in fits]),
        length=np.array([fit[2] for fit in fits]),
    )


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


def _cells(area: BaseGeometry) -> tuple[Floats, Floats]:
    """[c, 2] centres of the cells that meet an area, and [c] the share of each that is inside."""
    if area.is_empty or area.area <= 0.0:
        raise UsageError("area: expected polygons of trees, found none.")
    west, south, east, north = np.floor(np.array(area.bounds) / CELL).astype(np.int64).tolist()
    num = (east - west + 1) * (north - south + 1)
    if num > 100 * _MAX_CELLS:
        raise UsageError(f"area: expected at most {_MAX_CELLS:,} cells of {CELL:g} m, found {num:,}.")
    index = np.stack(np.meshgrid(np.arange(west, east + 1), np.arange(south, north + 1)), axis=-1).reshape(-1, 2)
    boxes = shapely.box(*(index * CELL).T, *((index + 1) * CELL).T)
    shapely.prepare(area)
    meets = shapely.intersects(area, boxes)
    share = np.asarray(shapely.area(shapely.intersection(boxes[meets], area))) / CELL**2
    used = share > 0.0
    if used.sum() > _MAX_CELLS:
        raise UsageError(f"area: expected at most {_MAX_CELLS:,} cells of {CELL:g} m, found {used.sum():,}.")
    return (index[meets][used] + 0.5) * CELL, share[used]


def _fit(u: Floats, hectares: Floats, counts: Floats, places: Floats) -> tuple[float, Floats, float]:
    """Intercept, weights [M] and length of the best scale and length, by the Laplace evidence.

    Args:
        u: [c, 2] cells in km.
        hectares: [c] area of each cell.
        counts: [c] trees.
        places: [M, 2] inducing places in km.
    """
    spread = max(float(np.sqrt(u.var(axis=0).sum())), CELL / METRES_PER_KM)
    mean = np.log(max(counts.sum(), _PSEUDO_TREES) / hectares.sum())
    best = (-np.inf, mean, np.zeros(len(places)), spread)
    for share in _LENGTHS:
        length = float(rounded(np.array(share * spread)))
        kernels = whitened_kernels(u, places, length)
        for scale in _SCALES:
            rows = np.column_stack([np.ones(len(u)), scale * kernels])
            value, weights = _poisson_mode(rows, hectares * np.exp(mean), counts)
            if value > best[0] + 1e-6:
                on_kernels = solve_triangular(kernel_root(places, length).T, scale * weights[1:], lower=False)
                best = (value, float(mean + weights[0]), rounded(on_kernels), length)
    return float(rounded(np.array(best[1]))), best[2], best[3]


def _poisson_mode(rows: Floats, expected: Floats, counts: Floats) -> tuple[float, Floats]:
    """Logarithm of the evidence, but for a constant, and the most probable weights [D] with the prior N(0, 1).

    Args:
        rows: [c, D] design.
        expected: [c] mean counts if all weights are 0.
        counts: [c] counts.
    """
    weights = np.zeros(rows.shape[1])

    def value_at(w: Floats) -> float:
        odds = rows @ w
        return float(counts @ odds - expected @ np.exp(np.minimum(odds, 30.0)) - 0.5 * w @ w)

    value = value_at(weights)
    for _ in range(_STEPS):
        rate = expected * np.exp(np.minimum(rows @ weights, 30.0))
        factor = cho_factor(rows.T @ (rate[:, None] * rows) + np.eye(len(weights)), lower=True)
        step = cho_solve(factor, rows.T @ (counts - rate) - weights)
        length = 1.0
        while value_at(weights + length * step) < value and length > 1e-6:
            length /= 2
        weights = weights + length * step
        gain, value = value_at(weights) - value, value_at(weights)
        if gain < _TOLERANCE:
            break
    rate = expected * np.exp(np.minimum(rows @ weights, 30.0))
    factor = np.linalg.cholesky(rows.T @ (rate[:, None] * rows) + np.eye(len(weights)))
    return value - float(np.log(np.diag(factor)).sum()), weights
