"""Zones drawn from a density: patches where nothing is known, and noise of each parcel.

A zone is drawn as argmax_k(log P(k) + Gumbel noise of (seed, id, zone)), so that a parcel keeps its zone whatever
the other parcels are, and a small change of P changes few zones (C. Maddison, D. Tarlow, T. Minka, "A* sampling", NIPS
2014): at most a share 2 t / (1 + t) of the parcels, t being the total variation distance of old and new P.

P is not that of the most probable g, but of one draw of g by the seed: what the answers leave open is decided in
patches as large as the length of the kernel, and not parcel by parcel. Its values at the inducing places Z are drawn
given the answers (`grammarlab.city.elliptical_slice`). A prior draw f, moved to them, is g everywhere else (Matheron's
rule; J. Wilson et al., "Efficiently sampling functions from Gaussian process posteriors", 2020):

    g(u) = f(u) + k(u, Z) k(Z, Z)^-1 (g(Z) - f(Z)).

f is a sum of waves (A. Rahimi, B. Recht, "Random features for large-scale kernel machines", 2007). So g is a function
of the seed, the names of the zones and the place, and parcels do not depend on each other.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve
from scipy.special import ndtri
from threadpoolctl import threadpool_limits

from grammarlab.arrays import Floats, Ints
from grammarlab.city.elliptical_slice import MAX_TRIES, drawn_values
from grammarlab.city.fields import METRES_PER_KM, ParcelFields
from grammarlab.city.zone_density import ZoneDensity, matern, places_km, text_words
from grammarlab.geometry.footprints.frame import Frame
from grammarlab.randomness import Keys, fold, root_keys, uniforms

_NOISE, _WAVES, _AMPLITUDES, _PRIORS, _ANGLES = 3141592651, 2718281828, 2718281829, 1618033988, 1618033989
"""Places below a seed for the noise of parcels, the waves of f, their sizes, and steps at the inducing places."""
_NUM_WAVES = 512
"""Waves of a prior draw: its covariance has an error of some 1 / sqrt(waves) of the variance, 4 %."""
_PHASE = 5
"""Draw of a wave for its phase; those before are for its frequency."""
_STEPS = 1000
"""Steps from the mode to a draw: a budget of half a second."""
_STEPS_AT_ONCE = 50
"""Steps whose prior draws are made together."""
_NUGGET = 1e-4
"""Added to the diagonal of the kernel, of size 1, as in learning."""
_BLOCK = 8192
"""Parcels whose waves are in memory at once: 34 MB."""


@dataclass(frozen=True, eq=False)
class Waves:
    """One draw of K independent Gaussian processes, as sums of L waves."""

    frequency: Floats
    """[L, 2] radians per km of each wave."""
    phase: Floats
    """[L] radians."""
    amplitude: Floats
    """[L, K]."""

    def at(self, u: Floats) -> Floats:
        """[N, K] values at places [N, 2] in km, wherever the origin of a frame is."""
        parts = [u[start : start + _BLOCK] for start in range(0, len(u), _BLOCK)]
        values = [np.cos(part @ self.frequency.T + self.phase) @ self.amplitude for part in parts]
        return np.concatenate([np.zeros((0, self.amplitude.shape[1])), *values])


@dataclass(frozen=True, eq=False)
class DrawnDensity:
    """A density with one draw of g by a seed."""

    density: ZoneDensity
    """The learned density; with a draw, its weights move the waves to the values of g at the inducing places."""
    waves: Waves | None
    """The prior draw; None if zones do not depend on the place."""

    def log_odds(self, fields: ParcelFields) -> Floats:
        """[N, K] logarithms of the probabilities, but for a constant per parcel; see `ZoneDensity.log_odds`."""
        odds, frame = self.density.log_odds(fields), self.density.frame
        return odds if self.waves is None else odds + self.waves.at(_earth_km(places_km(fields, frame), frame))


def drawn_zones(density: ZoneDensity, fields: ParcelFields, seed: int) -> Ints:
    """[N] number of the zone drawn for each parcel; a function of seed, id, names of zones, fields and place.

    Args:
        density: the density.
        fields: fields of N parcels.
        seed: 0 <= seed < 2**64.

    Raises:
        UsageError: If a field is missing, or the parcels are in another coordinate system.
    """
    odds = drawn_density(density, seed).log_odds(fields)
    return (odds + zone_noise(fields.id, density.zones, seed)).argmax(axis=1)


def drawn_density(density: ZoneDensity, seed: int) -> DrawnDensity:
    """One posterior draw of a density by a seed."""
    if not len(density.places) or not density.scale:
        return DrawnDensity(density, None)
    zones = text_words(np.array(density.zones, object))
    waves = _prior(zones, density.length, density.scale, seed)
    with threadpool_limits(1, "blas"):
        root = density.scale * _kernel_root(density)
        values = _drawn_at_places(density, root, seed)
        on_kernels = density.scale**2 * cho_solve(
            (root, True), values - waves.at(_earth_km(density.places, density.frame))
        )
    return DrawnDensity(replace(density, weights=on_kernels), waves)


def zone_noise(ids: NDArray[np.object_], zones: tuple[str, ...], seed: int) -> Floats:
    """[N, K] independent draws of the standard Gumbel distribution, one per parcel and zone."""
    keys = fold(root_keys(seed, np.array([_NOISE], np.uint64)), text_words(ids))
    draws = np.column_stack([uniforms(keys, word) for word in text_words(np.array(zones, object))[:, None]])
    return -np.log(-np.log(np.maximum(draws, np.finfo(float).tiny)))


def _prior(zones: Keys, length: float, scale: float, seed: int) -> Waves:
    """A draw of the Matérn 3/2 process for each zone.

    Its spectral density in the plane is that of Student's t with 3 degrees of freedom, divided by the length.
    """
    wave = np.arange(_NUM_WAVES, dtype=np.uint64)
    keys = fold(root_keys(seed, np.array([_WAVES], np.uint64)), wave)
    normals = _normals(keys, np.arange(_PHASE, dtype=np.uint64))
    chi_squared = np.square(normals[:, 2:]).sum(axis=1)
    amplitudes = _normals(fold(root_keys(seed, np.array([_AMPLITUDES], np.uint64)), wave), zones)
    return Waves(
        frequency=normals[:, :2] * np.sqrt(3.0 / chi_squared)[:, None] / length,
        phase=2.0 * np.pi * uniforms(keys, _PHASE),
        amplitude=scale * np.sqrt(2.0 / _NUM_WAVES) * amplitudes,
    )


def _kernel_root(density: ZoneDensity) -> Floats:
    """[M, M] lower triangle whose product is the kernel of the inducing places."""
    kernel = matern(density.places, density.places, density.length)
    return np.asarray(np.linalg.cholesky(kernel + _NUGGET * np.eye(len(kernel))), np.float64)


def _drawn_at_places(density: ZoneDensity, root: Floats, seed: int) -> Floats:
    """[M, K] draw of g at the inducing places given the answers there.

    Args:
        density: the density.
        root: [M, M] root of the covariance of g of each zone.
        seed: seed of the draw.
    """
    # Zones are in the order of their words, for sums that do not depend on their order in the file.
    words = text_words(np.array(density.zones, object))
    order = np.argsort(words)
    counts, offsets, words = density.counts[:, order], density.offsets[:, order], words[order]

    num = counts.sum(axis=1)

    def log_likelihood(values: Floats) -> float:
        odds = offsets + values
        odds -= odds.max(axis=1, keepdims=True)  # in place of a function of scipy, which takes longer for few places
        return float(np.vdot(counts, odds) - num @ np.log(np.exp(odds).sum(axis=1)))

    mode = matern(density.places, density.places, density.length) @ density.weights[:, order]
    values = np.empty_like(mode)
    values[:, order] = drawn_values(mode, _steps(density, root, words, seed), log_likelihood)
    return values


def _steps(density: ZoneDensity, root: Floats, words: Keys, seed: int) -> Iterator[tuple[Floats, Floats]]:
    """Prior draws [M, K] at the inducing places, and draws for the angles of each step.

    Args:
        density: the density.
        root: [M, M] root of the covariance of g of each zone.
        words: [K] words of the zones.
        seed: seed of the draw.
    """
    places = _place_words(density)
    (prior,), (angle,) = (root_keys(seed, np.array([lane], np.uint64)) for lane in (_PRIORS, _ANGLES))
    tries = np.arange(2 + MAX_TRIES)
    for start in range(0, _STEPS, _STEPS_AT_ONCE):
        step = np.arange(start, min(start + _STEPS_AT_ONCE, _STEPS))
        keys = fold(np.repeat(fold(np.full(len(step), prior), step), len(places)), np.tile(places, len(step)))
        normals = _normals(keys, words).reshape(len(step), len(places), -1)
        angles = uniforms(np.repeat(fold(np.full(len(step), angle), step), len(tries)), np.tile(tries, len(step)))
        yield from zip(root @ normals, angles.reshape(len(step), -1), strict=True)


def _earth_km(u: Floats, frame: Frame) -> Floats:
    """[N, 2] places [N, 2] in km from the origin of a frame, from that of its coordinate system."""
    return u + np.array(frame.origin) / METRES_PER_KM


def _place_words(density: ZoneDensity) -> Keys:
    """[M] words of the inducing places on the earth, to the millimetre of a file."""
    metres = np.round(METRES_PER_KM * _earth_km(density.places, density.frame), 3)
    return text_words(np.array([f"{east:.3f}\0{north:.3f}" for east, north in metres.tolist()], object))


def _normals(keys: Keys, words: Keys) -> Floats:
    """[R, C] standard normal draws, one per key [R] and word [C]."""
    draws = uniforms(np.repeat(keys, len(words)), np.tile(words, len(keys))).reshape(len(keys), -1)
    return ndtri(np.clip(draws, 1e-15, 1.0 - 1e-15))
