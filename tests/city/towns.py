"""Towns with a known density of zones, and answers drawn from it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pyarrow as pa
import shapely
from scipy.special import expit

from grammarlab.arrays import Floats, Ints
from grammarlab.city.fields import ParcelFields, parcel_fields
from grammarlab.city.packed_outlines import PackedOutlines
from grammarlab.city.parcels import Parcels
from grammarlab.geometry.footprints.frame import Frame

ZONES = ("core", "middle", "rim")
RADIUS = 1000.0
Truth = Callable[[ParcelFields], Floats]


def town(num: int, seed: int = 0) -> ParcelFields:
    """Fields of parcels spread over a disk of 1 km, about a point that is not the origin."""
    rng = np.random.default_rng(seed)
    radius, angle = RADIUS * np.sqrt(rng.uniform(0, 1, num)), rng.uniform(0, 2 * np.pi, num)
    west, south = radius * np.cos(angle) + 2300.0, radius * np.sin(angle) - 700.0
    sides = np.exp(rng.normal(np.log([18.0, 30.0]), [0.45, 0.3], (num, 2)))
    parcels = Parcels(
        frame=Frame("EPSG:32631", (448000.0, 5412000.0)),
        id=np.array([f"{index:06d}" for index in range(num)], object),
        outlines=PackedOutlines.of(shapely.box(west, south, west + sides[:, 0], south + sides[:, 1])),
        elevation=np.full(num, np.nan),
        attributes=pa.table({"floors": rng.integers(1, 9, num)}),
        first_edge=np.ones(num, np.int32),
        reason=np.full(num, "", object),
    )
    return parcel_fields(parcels, frontage=sides[:, 0], attributes=["floors"])


def ordered(position: Floats) -> Floats:
    """[N, 3] three zones one after the other along a position [N], a third of a disk each, with soft borders."""
    first, last = expit((0.45 - position) / 0.07), expit((position - 0.75) / 0.07)
    chance = np.column_stack([first, (1 - first) * (1 - last), last * (1 - first)])
    return chance / chance.sum(axis=1, keepdims=True)


def three_rings(fields: ParcelFields) -> Floats:
    """Three zones in rings around a centre."""
    return ordered(np.hypot(*(fields.east_north - [2300.0, -700.0]).T) / RADIUS)


def by_area(fields: ParcelFields) -> Floats:
    """Three zones by the area of the parcel, wherever it is."""
    return ordered(0.6 + 0.4 * (np.log(fields.columns(["area"])[:, 0]) - np.log(540.0)))


def patches(fields: ParcelFields) -> Floats:
    """Three zones in patches of some 400 m: a smooth random field for each."""
    rng = np.random.default_rng(5)
    waves = rng.normal(size=(200, 2)) / 0.2
    phase, size = rng.uniform(0, 2 * np.pi, 200), 3.0 * np.sqrt(2 / 200) * rng.normal(size=(200, 3))
    chance = np.exp(np.cos(fields.east_north / 1000.0 @ waves.T + phase) @ size)
    return chance / chance.sum(axis=1, keepdims=True)


def everywhere_alike(fields: ParcelFields) -> Floats:
    """Zones that depend on nothing."""
    return np.tile([0.5, 0.3, 0.2], (len(fields), 1))


def counts(chance: Floats, seed: int, wrong: float = 0.0) -> Floats:
    """[N, 3] one answer per parcel, of which a share is any other zone."""
    rng = np.random.default_rng([seed, 1])  # other numbers than those of a town of this seed
    zone = (rng.uniform(size=(len(chance), 1)) > chance.cumsum(axis=1)).sum(axis=1)
    shift = rng.integers(1, 3, len(zone)) * (rng.uniform(size=len(zone)) < wrong)
    return np.eye(3)[(zone + shift) % 3]


def sampled(num: int, most: int, seed: int) -> Ints:
    """Rows of parcels to ask about, at random."""
    return np.random.default_rng([seed, 2]).permutation(num)[:most]


def divergence(one: Floats, other: Floats) -> float:
    """Jensen-Shannon divergence of the zones of a parcel, averaged over the parcels, in nats."""
    middle = (one + other) / 2
    parts = [(part * np.log(np.maximum(part, 1e-300) / middle)).sum(axis=1).mean() for part in (one, other)]
    return float(np.mean(parts))
