"""Designs of zone densities: parcels as rows of numbers on which log-odds depend linearly.

A row has a constant, the standardised fields, and the whitened kernels around the inducing places, each with its
scale: the standard deviation of its part of the log-odds before any answer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular
from scipy.spatial import KDTree

from grammarlab.arrays import Floats, Ints
from grammarlab.city.fields import ParcelFields
from grammarlab.city.softmax_process import Mode, contrasts
from grammarlab.city.zone_density import Feature, ZoneDensity, matern, places_km, standardised
from grammarlab.geometry.footprints.frame import Frame

_NUGGET = 1e-4
"""Added to the diagonal of the kernel, of size 1: parcels at one place, such as flats, may differ a little."""
_DECIMALS = 6
"""Decimals of the numbers of a density, so that its file is small and has the same numbers."""

_DECIMALS_OF_ANSWERS = 3
"""Decimals of numbers of answers and of their log-odds."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ZoneDesign:
    """What turns a parcel into a row of D = 1 + F + M numbers."""

    frame: Frame
    features: tuple[Feature, ...]
    """[F] fields."""
    places: Floats
    """[M, 2] inducing places in km from the frame's origin."""
    length: float
    """Length of the kernel in km."""
    scales: Floats
    """[2 + F] standard deviations: of the constant, of each field's slope, and of the kernel."""

    @property
    def column_scales(self) -> Floats:
        """[D] scale of each column."""
        return np.concatenate([self.scales[:-1], np.full(len(self.places), self.scales[-1])])

    def rows(self, fields: ParcelFields) -> Floats:
        """[N, D] rows of parcels."""
        u = places_km(fields, self.frame)
        kernels = whitened_kernels(u, self.places, self.length)
        return np.column_stack([np.ones(len(u)), standardised(fields, u, self.features), kernels]) * self.column_scales

    def density(
        self, mode: Mode, fields: ParcelFields, counts: Floats, zones: tuple[str, ...], answers: str
    ) -> ZoneDensity:
        """The density with the weights of a mode.

        Args:
            mode: the weights.
            fields: fields of n parcels with answers.
            counts: [n, K] answers for each zone.
            zones: [K] names.
            answers: hash of the answers.
        """
        num = 1 + len(self.features)
        weights = (mode.weights * self.column_scales[:, None]) @ contrasts(len(zones)).T
        on_kernels = solve_triangular(kernel_root(self.places, self.length).T, weights[num:], lower=False)
        at_places, offsets = self._answers(weights[:num], fields, counts)
        return ZoneDensity(
            zones=zones,
            frame=self.frame,
            features=self.features,
            intercept=rounded(weights[0]),
            slope=rounded(weights[1:num]),
            places=self.places,
            weights=rounded(on_kernels),
            length=self.length,
            scale=float(rounded(self.scales[-1])),
            counts=np.round(at_places, _DECIMALS_OF_ANSWERS),
            offsets=np.round(offsets, _DECIMALS_OF_ANSWERS) + 0.0,
            answers=answers,
        )

    def _answers(self, weights: Floats, fields: ParcelFields, counts: Floats) -> tuple[Floats, Floats]:
        """[M, K] answers for each zone, of those nearest to each place, and [M, K] their mean log-odds without g.

        Args:
            weights: [1 + F, K] weights of the constant and of the fields.
            fields: fields of n parcels with answers.
            counts: [n, K] answers.
        """
        at_places, offsets = np.zeros((2, len(self.places), counts.shape[1]))
        if len(self.places):
            u = places_km(fields, self.frame)
            odds = weights[0] + standardised(fields, u, self.features) @ weights[1:]
            num = counts.sum(axis=1)[:, None]
            _, nearest = KDTree(self.places).query(u)
            np.add.at(at_places, nearest, counts)
            np.add.at(offsets, nearest, num * odds)
            offsets /= np.maximum(at_places.sum(axis=1), 1e-12)[:, None]
        return at_places, offsets


def rounded(values: Floats) -> Floats:
    """Numbers with the decimals of a file, in km, standard deviations or log-odds; without negative zeros."""
    return np.round(values, _DECIMALS) + 0.0


def whitened_kernels(u: Floats, places: Floats, length: float) -> Floats:
    """[n, M] columns whose products are the kernel of points [n, 2], projected on the inducing places [M, 2]."""
    return solve_triangular(kernel_root(places, length), matern(places, u, length), lower=True).T


def kernel_root(places: Floats, length: float) -> Floats:
    """[M, M] lower triangle whose product is the kernel of places [M, 2]."""
    return np.asarray(np.linalg.cholesky(matern(places, places, length) + _NUGGET * np.eye(len(places))), np.float64)


def spread_order(points: Floats, most: int) -> Ints:
    """Indices of at most `most` points [n, 2], each the farthest from those before it; the first is near the middle."""
    first = int(((points - points.mean(axis=0)) ** 2).sum(axis=1).argmin())
    order, distance = [first], np.full(len(points), np.inf)
    while len(order) < min(most, len(points)):
        distance = np.minimum(distance, ((points - points[order[-1]]) ** 2).sum(axis=1))
        distance[order[-1]] = -1.0  # a point is taken once, even if others are at its place
        order.append(int(distance.argmax()))
    return np.array(order)
