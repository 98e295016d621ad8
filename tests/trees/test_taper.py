"""Radii along stems."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.trees.growth import grow
from grammarlab.trees.taper import radii, tapered
from tests.cases import some
from tests.trees.oracle import taper_radius
from tests.trees.rows import random_row, row, tree_keys


@pytest.mark.parametrize(
    ("taper", "along", "radius"),
    [
        (0.0, 0.7, 1.0),
        (0.5, 0.5, 0.75),
        (1.0, 0.25, 0.75),
        (1.0, 1.0, 0.0),
        (1.5, 0.5, 0.75),
        # A ball ends the stem: at .97, t = .515 and the tip is .3 away, .215 from the centre: √(.515² - .215²).
        (1.5, 0.97, np.sqrt(0.219)),
        (2.0, 0.5, 1.0),
        (2.0, 0.95, np.sqrt(0.75)),
        # Beads of diameter 2 meet at 2, 4, … metres from the tip, and are widest between.
        (3.0, 0.8, 0.0),
        (3.0, 0.7, 1.0),
        (2.5, 0.8, 0.5),
        (2.5, 1.0, 0.0),
    ],
)
def test_radii_worked_by_hand(taper: float, along: float, radius: float):
    """A stem of 10 m with a radius of 1 m."""
    value = tapered(np.array([1.0]), np.array([10.0]), np.array([taper]), np.array([along]))
    np.testing.assert_allclose(value, [radius], atol=1e-7)


def test_radii_are_those_of_the_oracle():
    rng = np.random.default_rng(1)
    radius, length, taper, along = rng.uniform(0, [2, 5, 3, 1], (400, 4)).T
    expected = [taper_radius(*numbers) for numbers in zip(radius, length, taper, along, strict=True)]
    np.testing.assert_allclose(tapered(radius, length, taper, along), expected, atol=1e-9)


@pytest.mark.parametrize("seed", some(range(50)))
def test_radii_never_grow_along_a_stem_but_for_beads_and_flare(seed: int):
    values = row(
        **{f"taper_{level}": taper for level, taper in enumerate(np.random.default_rng(seed).uniform(0, 2, 4))}
    )
    values = np.where(values == row(), random_row(seed), values)
    skeleton = grow(values[None], tree_keys(1))
    for level, stems in enumerate(skeleton.levels):
        along = np.linspace(0.0, 1.0, 60)
        stem = np.repeat(np.arange(len(stems)), len(along))
        radius = radii(skeleton, level, stem, np.tile(along, len(stems))).reshape(len(stems), -1)
        assert (np.diff(radius, axis=1) <= 1e-12).all()
        assert (radius >= 0).all()


def test_the_trunk_flares_by_its_factor_at_the_ground_and_not_above_an_eighth():
    skeleton = grow(row(flare=0.8, ratio=0.02, scale=10.0, taper_0=0.0)[None], tree_keys(1))
    radius = radii(skeleton, 0, np.zeros(4, int), np.array([0.0, 1 / 16, 1 / 8, 1.0]))
    np.testing.assert_allclose(radius, 0.2 * np.array([1 + 0.8 * 0.99, 1 + 0.8 * 0.09, 1.0, 1.0]))
