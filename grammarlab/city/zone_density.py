"""Zone densities: the probability of each zone at each parcel, learned from answers.

P(k | x, u) = softmax_k(b_k · x + g_k(u)), where x are standardised fields of the parcel and u is its place. g_k is a
sum of functions of the Matérn 3/2 kernel around inducing places (`grammarlab.city.zone_learning`).
"""

from __future__ import annotations

from dataclasses import dataclass
from hashlib import sha256

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist
from scipy.special import softmax

from grammarlab.arrays import Floats
from grammarlab.city.fields import METRES_PER_KM, ParcelFields
from grammarlab.errors import UsageError
from grammarlab.geometry.footprints.frame import Frame
from grammarlab.randomness import Keys

MAX_STANDARD = 4.0
"""Largest standardised value: parcels beyond are treated alike, as answers about such parcels are rare."""
MAX_WEIGHTS = 3072
"""Most inducing places times zones: a file of at most 100 kB."""
_SQRT_3 = np.sqrt(3.0)
_BLOCK = 8192
"""Parcels whose kernels are in memory at once: 17 MB for 256 places."""


@dataclass(frozen=True, slots=True)
class Feature:
    """A field with the numbers that standardise it: (value - mean) / scale; for some, ln(1 + value) is the value."""

    name: str
    unit: str
    mean: float
    scale: float
    """> 0."""
    is_log: bool = False
    """Whether ln(1 + value) is standardised; values below 0 count as 0."""
    centre: tuple[float, float] | None = None
    """Point in km from the origin of the density's frame, if the field is the distance to it in km: a learned centre.
    None for a field of `ParcelFields`."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ZoneDensity:
    """Probabilities of K zones at parcels."""

    zones: tuple[str, ...]
    """[K] different names."""
    frame: Frame
    """Frame of the inducing places."""
    features: tuple[Feature, ...]
    """[F] fields of the parcels that the probabilities depend on."""
    intercept: Floats
    """[K] log-odds of each zone in a typical parcel far from all inducing places."""
    slope: Floats
    """[F, K] change of the log-odds per standard deviation of a field: b."""
    places: Floats
    """[M, 2] inducing places in km from the frame's origin."""
    weights: Floats
    """[M, K] weights of the kernel around each place."""
    length: float
    """Length of the kernel in km, > 0."""
    scale: float
    """Standard deviation of g before any answer, in log-odds, >= 0."""
    counts: Floats
    """[M, K] answers for each zone, of those nearest to each place, >= 0."""
    offsets: Floats
    """[M, K] mean log-odds of these answers without g; 0 where there are none."""
    answers: str
    """SHA-256 of the answers, 64 hexadecimal digits."""

    def log_odds(self, fields: ParcelFields) -> Floats:
        """[N, K] logarithms of the probabilities, but for a constant per parcel.

        Raises:
            UsageError: If a field is missing, or the parcels are in another coordinate system.
        """
        u = places_km(fields, self.frame)
        x = standardised(fields, u, self.features)
        odds = self.intercept + x @ self.slope
        for start in range(0, len(u), _BLOCK):
            block = slice(start, start + _BLOCK)
            odds[block] += matern(u[block], self.places, self.length) @ self.weights
        return odds

    def probabilities(self, fields: ParcelFields) -> Floats:
        """[N, K] P(k | x) >= 0; each row has the sum 1. See `log_odds` for errors."""
        return softmax(self.log_odds(fields), axis=1)


def text_words(texts: NDArray[np.object_]) -> Keys:
    """[n] 64-bit words of texts: the first 8 bytes of their SHA-256."""
    digests = b"".join(sha256(text.encode("utf-8", "surrogatepass")).digest()[:8] for text in texts)
    return np.frombuffer(digests, ">u8").astype(np.uint64)


def standardised(fields: ParcelFields, u: Floats, features: tuple[Feature, ...]) -> Floats:
    """[N, F] standardised fields between -`MAX_STANDARD` and `MAX_STANDARD`; unknown values are typical ones, 0.

    Args:
        fields: fields of N parcels.
        u: [N, 2] their places in km, as `places_km`.
        features: F fields.
    """
    x = np.empty((len(fields), len(features)))
    for column, feature in zip(x.T, features, strict=True):
        centre = feature.centre
        values = fields.columns([feature.name])[:, 0] if centre is None else np.hypot(*(u - centre).T)
        if feature.is_log:
            values = np.log1p(np.maximum(values, 0.0))
        column[:] = (values - feature.mean) / feature.scale
    return np.nan_to_num(np.clip(x, -MAX_STANDARD, MAX_STANDARD))


def places_km(fields: ParcelFields, frame: Frame) -> Floats:
    """[N, 2] places of parcels in km from the origin of a frame.

    Raises:
        UsageError: If the fields are in another coordinate system.
    """
    if fields.frame.crs != frame.crs:
        raise UsageError(
            f"the zones were learned in {frame.crs or 'local metres'}, and the parcels are in "
            f"{fields.frame.crs or 'local metres'}: give the map the same `crs`, or learn the zones again."
        )
    return (fields.east_north + np.subtract(fields.frame.origin, frame.origin)) / METRES_PER_KM


def matern(one: Floats, other: Floats, length: float) -> Floats:
    """[n, m] Matérn 3/2 kernel of points [n, 2] and [m, 2]: (1 + r) exp(-r), r = sqrt(3) distance / length."""
    r = _SQRT_3 / length * cdist(one, other)
    return (1.0 + r) * np.exp(-r)
