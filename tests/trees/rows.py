"""Rows of parameters for tests."""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.randomness import Keys, root_keys
from grammarlab.trees.parameters import COLUMN, DEFAULTS, NUM_LEVELS

ASPEN = {
    "scale": 13.0,
    "scale_v": 3.0,
    "base_size": 0.4,
    "curve_0_v": 20.0,
    "branches_1": 50,
    "down_angle_1": 60,
    "down_angle_1_v": -50.0,
    "curve_res_1": 5,
    "curve_1": -40.0,
    "curve_1_v": 50.0,
    "branches_2": 30,
    "length_2": 0.6,
    "down_angle_2": 45.0,
    "down_angle_2_v": 10.0,
    "curve_2": -40.0,
    "curve_2_v": 75.0,
    "leaves": 25,
    "leaf_scale": 0.17,
    "leaf_scale_x": 1.0,
}
"""A tree with all that is usual: the quaking aspen of Weber and Penn."""


def row(**named: float) -> Floats:
    """[P] the defaults, with other values for some columns."""
    values = DEFAULTS.copy()
    for name, value in named.items():
        values[COLUMN[name]] = value
    return values


def tree_keys(num: int, seed: int = 1) -> Keys:
    return root_keys(seed, np.arange(num))


def random_row(seed: int) -> Floats:
    """[P] any tree of a few hundred stems: every parameter is used, negative ones too."""
    rng = np.random.default_rng(seed)

    def some(low: float, high: float, zero: float = 0.3) -> float:
        return 0.0 if rng.random() < zero else float(rng.uniform(low, high))

    def whole(low: int, high: int) -> float:
        return float(rng.integers(low, high + 1))

    named: dict[str, float] = {
        "shape": whole(0, 8),
        "base_size": some(0.0, 0.7),
        "scale": rng.uniform(0.5, 30.0),
        "scale_v": some(0.0, 10.0),
        "z_scale": rng.uniform(0.5, 2.0),
        "z_scale_v": some(0.0, 0.5),
        "levels": float(rng.choice([1, 2, 3, 3, 4, 4])),
        "ratio": rng.uniform(0.002, 0.1),
        "ratio_power": some(0.0, 3.0),
        "scale_0": rng.uniform(0.5, 2.0),
        "scale_0_v": some(0.0, 0.5),
        "attraction_up": some(-10.0, 10.0),
        "prune_ratio": some(0.0, 1.0, 0.6),
        "prune_width": rng.uniform(0.1, 1.0),
        "prune_width_peak": some(0.0, 1.0),
        "prune_power_low": some(0.0, 2.0),
        "prune_power_high": some(0.0, 2.0),
        "wind_speed": some(0.0, 40.0, 0.6),
        "wind_direction": rng.uniform(-360.0, 360.0),
        "base_splits": whole(0, 3) * (rng.random() < 0.3),
        "leaves": whole(-8, 11),
        "leaf_bend": some(0.0, 1.0),
        "leaf_quality": rng.uniform(0.05, 1.0),
        "blossom_rate": some(0.0, 1.0),
    }
    for level in range(NUM_LEVELS):
        named |= {
            f"length_{level}": rng.uniform(0.3, 1.2),
            f"length_{level}_v": some(0.0, 0.4),
            f"taper_{level}": rng.uniform(0.0, 3.0),
            f"seg_splits_{level}": some(0.0, 0.7 / (1 + level), 0.5),
            f"split_angle_{level}": rng.uniform(0.0, 90.0),
            f"split_angle_{level}_v": some(0.0, 30.0),
            f"curve_res_{level}": whole(1, 5),
            f"curve_{level}": some(-180.0, 180.0),
            f"curve_{level}_v": some(-60.0, 180.0),
            f"curve_back_{level}": some(-180.0, 180.0, 0.6),
        }
        if level > 0:
            named |= {
                f"down_angle_{level}": rng.uniform(-180.0, 180.0),
                f"down_angle_{level}_v": some(-90.0, 90.0),
                f"rotate_{level}": rng.uniform(-360.0, 360.0),
                f"rotate_{level}_v": some(0.0, 90.0),
                f"branches_{level}": whole(0, (16, 9, 6)[level - 1]),
            }
    return row(**named)
