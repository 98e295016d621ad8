"""Intensities of trees learned from trees on a map.

An intensity is the mode of a log-Gaussian Cox process (J. Møller, A. Syversveen, R. Waagepetersen, "Log Gaussian Cox
processes", 1998) on cells of 20 m. The scale and the length of the kernel of each species are learned by the Laplace
evidence.

Counts of different cells are independent given the intensity, so any cells chosen without regard to their trees give
the same answer on average: of a large area, `_MAX_CELLS` are looked at, chosen by hashes of their addresses.
"""

from __future__ import annotations

from dataclasses import dataclass
from hashlib import sha256
from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from threadpoolctl import threadpool_limits

from grammarlab.arrays import Floats, Ints
from grammarlab.city.fields import METRES_PER_KM
from grammarlab.city.tree_intensity import CELL, TreeIntensity
from grammarlab.city.tree_names import MAX_SPECIES
from grammarlab.city.zone_design import kernel_root, rounded, spread_order, whitened_kernels
from grammarlab.errors import UsageError
from grammarlab.geometry.footprints.frame import Frame
from grammarlab.randomness import Keys, fold, root_keys
from grammarlab.trees.planting import HECTARE

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

_PLACES = 64
"""Most inducing places."""
_MAX_CELLS = 40_000
"""Most cells to learn from: a budget of seconds per species."""
_MOST_CANDIDATES = 4_000_000
"""Most cells of the box around an area: 1,600 km²."""
_LANE = 577215664
"""Place below the seed 0 for the choice of cells."""
_SCALES = (0.0, 0.3, 0.6, 1.0, 1.7, 3.0)
"""Candidate standard deviations of g, in logarithms of intensities; with the first one, trees stand evenly."""
_LENGTHS = (0.25, 0.5, 1.0, 2.0)
"""Candidate lengths of the kernel, by the spread of the cells."""
_STEPS, _TOLERANCE = 60, 1e-9
_PSEUDO_TREES = 0.5
"""Trees added to a species without any, so that its logarithm is finite."""


@dataclass(frozen=True, eq=False)
class _Cells:
    """Cells of an area."""

    index: Ints
    """[c, 2] column and row, from the frame's origin."""
    share: Floats
    """[c] share of each that is in the area, > 0."""


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
        UsageError: If the area is empty or too large, or there are no trees in it or too many species.
    """
    inside = shapely.contains_xy(area, *east_north.T)
    east_north, species = east_north[inside], species[inside]
    names = tuple(sorted(set(species.tolist())))
    if not 1 <= len(names) <= MAX_SPECIES:
        raise UsageError(f"trees: expected 1 to {MAX_SPECIES} species in the area, found {len(names)}.")
    cells = _cells(area, frame)
    counts = _counts(cells, east_north, np.array([names.index(name) for name in species.tolist()]), len(names))
    u = np.asarray((cells.index + 0.5) * CELL / METRES_PER_KM, np.float64)
    places = rounded(u[spread_order(u, _PLACES)])
    with threadpool_limits(1, "blas"):
        fits = [_fit(u, cells.share * CELL**2 / HECTARE, column, places) for column in counts.T]
    return TreeIntensity(
        species=names,
        frame=frame,
        intercept=np.array([fit[0] for fit in fits]),
        places=places,
        weights=np.column_stack([fit[1] for fit in fits]),
        length=np.array([fit[2] for fit in fits]),
        trees=_hash(east_north + frame.origin, species),
    )


def _hash(points: Floats, species: NDArray[np.object_]) -> str:
    """SHA-256 of trees in any order, by places to the centimetre."""
    rows = zip(np.round(points, 2).tolist(), species.tolist(), strict=True)
    lines = sorted(f"{name}\0{east:.2f}\0{north:.2f}" for (east, north), name in rows)
    return sha256("\n".join(lines).encode("utf-8", "surrogatepass")).hexdigest()


def _counts(cells: _Cells, east_north: Floats, species: Ints, num: int) -> Floats:
    """[c, num] trees of each species in each cell; trees in other cells do not count."""
    row_of = {cell: row for row, cell in enumerate(zip(*cells.index.T.tolist(), strict=True))}
    counts = np.zeros((len(cells.index), num))
    for cell, number in zip(np.floor(east_north / CELL).astype(np.int64).tolist(), species.tolist(), strict=True):
        row = row_of.get(tuple(cell))
        if row is not None:
            counts[row, number] += 1.0
    return counts


def _cells(area: BaseGeometry, frame: Frame) -> _Cells:
    """Cells that meet an area; of many, those whose addresses have the smallest hashes."""
    if area.is_empty or area.area <= 0.0:
        raise UsageError("area: expected polygons of trees, found none.")
    west, south, east, north = np.floor(np.array(area.bounds) / CELL).astype(np.int64).tolist()
    num = (east - west + 1) * (north - south + 1)
    if num > _MOST_CANDIDATES:
        raise UsageError(f"area: expected at most {_MOST_CANDIDATES:,} cells of {CELL:g} m, found {num:,}.")
    index = np.stack(np.meshgrid(np.arange(west, east + 1), np.arange(south, north + 1)), axis=-1).reshape(-1, 2)
    if num > _MAX_CELLS:
        index = index[np.argsort(_words(index, frame), kind="stable")]  # ty: ignore[invalid-argument-type]
    shapely.prepare(area)
    parts, total = [], 0
    for start in range(0, num, _MAX_CELLS):
        part = _meeting(area, index[start : start + _MAX_CELLS])  # ty: ignore[invalid-argument-type]
        parts.append(part)
        total += len(part.index)
        if total >= _MAX_CELLS:
            break
    return _Cells(
        np.concatenate([part.index for part in parts])[:_MAX_CELLS],
        np.concatenate([part.share for part in parts])[:_MAX_CELLS],
    )


def _words(index: Ints, frame: Frame) -> Keys:
    """[n] hashes of cells [n, 2] by their places on the earth."""
    address = index + np.round(np.array(frame.origin) / CELL).astype(np.int64) + (1 << 40)
    return fold(fold(root_keys(0, np.array([_LANE], np.uint64)), address[:, 0]), address[:, 1])


def _meeting(area: BaseGeometry, index: Ints) -> _Cells:
    """Those of cells [n, 2] that are at least partly in a prepared area."""
    boxes = shapely.box(*(index * CELL).T, *((index + 1) * CELL).T)
    meets = shapely.intersects(area, boxes)
    share = np.asarray(shapely.area(shapely.intersection(boxes[meets], area))) / CELL**2
    return _Cells(index[meets][share > 0.0], share[share > 0.0])


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
