"""The parameters of the model of Weber and Penn (SIGGRAPH 1995), with units, limits and their meaning.

A species gives each of them a value or a range. ``curve_1`` is the paper's 1Curve, ``curve_1_v`` its spread 1CurveV:
a draw is uniform on value - spread to value + spread.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from grammarlab.arrays import Flags, Floats

Unit = Literal["", "m", "deg", "m/s"]

NUM_LEVELS = 4
"""Largest number of levels of stems: the trunk and three levels of branches."""
SPREAD = "_v"
"""End of the name of a spread."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A number that describes trees."""

    name: str
    unit: Unit
    low: float
    """Smallest possible value."""
    high: float
    """Largest possible value."""
    default: float
    """Value in files that do not name it."""
    why: str
    """Meaning, in one line."""
    spread: float | None = None
    """Largest absolute value of its spread; None if it has none."""
    signed: bool = False
    """Whether a negative spread has its own meaning."""
    integer: bool = False
    """Whether it is a count or a choice."""
    log: bool = False
    """Whether ranges are drawn evenly in the logarithm: sizes and counts."""


def _tree() -> Iterator[Parameter]:
    yield Parameter(
        name="shape",
        unit="",
        low=0,
        high=8,
        default=7,
        why="outline of the crown: 0 conical to 7 tend flame, 8 envelope",
        integer=True,
    )
    yield Parameter(
        name="base_size", unit="", low=0.0, high=0.95, default=0.3, why="share of the height without branches"
    )
    yield Parameter(
        name="scale", unit="m", low=0.05, high=120.0, default=12.0, why="height of the tree", spread=60.0, log=True
    )
    yield Parameter(
        name="z_scale", unit="", low=0.1, high=10.0, default=1.0, why="stretch along the height", spread=5.0, log=True
    )
    yield Parameter(
        name="levels",
        unit="",
        low=1,
        high=NUM_LEVELS,
        default=3,
        why="levels of stems, the trunk included",
        integer=True,
    )
    yield Parameter(
        name="ratio", unit="", low=0.001, high=0.3, default=0.015, why="radius of the trunk by its length", log=True
    )
    yield Parameter(
        name="ratio_power", unit="", low=0.0, high=8.0, default=1.2, why="how much thinner shorter stems are"
    )
    yield Parameter(
        name="lobes", unit="", low=0, high=40, default=0, why="number of lobes around the trunk", integer=True
    )
    yield Parameter(name="lobe_depth", unit="", low=0.0, high=0.9, default=0.0, why="depth of the lobes by the radius")
    yield Parameter(
        name="flare", unit="", low=-0.9, high=10.0, default=0.5, why="how much wider the trunk is at the ground"
    )
    yield Parameter(
        name="attraction_up",
        unit="",
        low=-20.0,
        high=20.0,
        default=0.0,
        why="bending of branches of level 2 and 3 to the sky",
    )
    yield Parameter(
        name="prune_ratio",
        unit="",
        low=0.0,
        high=1.0,
        default=0.0,
        why="how much the envelope shortens stems that leave it",
    )
    yield Parameter(
        name="prune_width",
        unit="",
        low=0.0,
        high=4.0,
        default=0.5,
        why="radius of the envelope by the height of the tree",
    )
    yield Parameter(
        name="prune_width_peak",
        unit="",
        low=0.0,
        high=1.0,
        default=0.5,
        why="height of the widest part of the envelope, from its base",
    )
    yield Parameter(
        name="prune_power_low",
        unit="",
        low=0.0,
        high=16.0,
        default=0.5,
        why="curvature of the envelope below its widest part",
    )
    yield Parameter(
        name="prune_power_high",
        unit="",
        low=0.0,
        high=16.0,
        default=0.5,
        why="curvature of the envelope above its widest part",
    )
    yield Parameter(
        name="wind_speed", unit="m/s", low=0.0, high=60.0, default=0.0, why="wind that bends the stems, as a still pose"
    )
    yield Parameter(
        name="wind_direction",
        unit="deg",
        low=-360.0,
        high=360.0,
        default=0.0,
        why="where the wind blows to, about the vertical from +x",
    )


def _level(level: int) -> Iterator[Parameter]:
    below = "the trunk" if level == 0 else f"stems of level {level}"
    if level == 0:
        yield Parameter(
            name="scale_0",
            unit="",
            low=0.05,
            high=10.0,
            default=1.0,
            why="factor of the trunk's radius",
            spread=5.0,
            log=True,
        )
        yield Parameter(
            name="base_splits",
            unit="",
            low=0,
            high=20,
            default=0,
            why="stems more that the trunk splits into at once",
            integer=True,
        )
    else:
        yield Parameter(
            name=f"down_angle_{level}",
            unit="deg",
            low=-180.0,
            high=180.0,
            default=60.0,
            why=f"angle of {below} from their parent",
            spread=180.0,
            signed=True,
        )
        yield Parameter(
            name=f"rotate_{level}",
            unit="deg",
            low=-360.0,
            high=360.0,
            default=140.0,
            why=f"turn of {below} around their parent since the last",
            spread=360.0,
        )
        yield Parameter(
            name=f"branches_{level}",
            unit="",
            low=0,
            high=2000,
            default=20,
            why=f"most {below} on one parent",
            integer=True,
            log=True,
        )
    yield Parameter(
        name=f"length_{level}",
        unit="",
        low=0.0,
        high=25.0,
        default=1.0 if level == 0 else 0.3,
        why=f"length of {below} by their parent",
        spread=25.0,
    )
    yield Parameter(
        name=f"taper_{level}",
        unit="",
        low=0.0,
        high=3.0,
        default=1.0,
        why=f"0 cylinder, 1 cone, 2 rounded end, 3 beads: {below}",
    )
    yield Parameter(
        name=f"seg_splits_{level}", unit="", low=0.0, high=4.0, default=0.0, why=f"splits of {below} at each segment"
    )
    yield Parameter(
        name=f"split_angle_{level}",
        unit="deg",
        low=0.0,
        high=180.0,
        default=0.0,
        why=f"angle between {below} that split",
        spread=180.0,
    )
    yield Parameter(
        name=f"curve_res_{level}",
        unit="",
        low=1,
        high=60,
        default=3,
        why=f"segments of {below}",
        integer=True,
        log=True,
    )
    yield Parameter(
        name=f"curve_{level}",
        unit="deg",
        low=-720.0,
        high=720.0,
        default=0.0,
        why=f"bend of {below} from end to end",
        spread=720.0,
        signed=True,
    )
    yield Parameter(
        name=f"curve_back_{level}",
        unit="deg",
        low=-720.0,
        high=720.0,
        default=0.0,
        why=f"bend of the upper half of {below}",
    )


def _leaves() -> Iterator[Parameter]:
    yield Parameter(
        name="leaves",
        unit="",
        low=-500,
        high=500,
        default=0,
        why="leaves on a last stem; negative: a fan at its tip",
        integer=True,
    )
    shapes = "0 oval, 1 pointed, 2 lance, 3 lobed, 4 palmate, 5 heart, 6 needle, 7 twig of needles, 8 frond, 9 feather"
    yield Parameter(
        name="leaf_shape", unit="", low=0, high=9, default=0, why=f"outline of a leaf: {shapes}", integer=True
    )
    yield Parameter(name="leaf_scale", unit="m", low=0.0, high=8.0, default=0.2, why="length of a leaf", log=True)
    yield Parameter(
        name="leaf_scale_x", unit="", low=0.01, high=4.0, default=0.7, why="width of a leaf by its length", log=True
    )
    yield Parameter(name="leaf_bend", unit="", low=0.0, high=1.0, default=0.3, why="turn of leaves to the light")
    yield Parameter(
        name="leaf_stem_len", unit="", low=-20.0, high=20.0, default=0.5, why="length of the stalk by that of the leaf"
    )
    yield Parameter(
        name="leaf_quality",
        unit="",
        low=0.01,
        high=1.0,
        default=1.0,
        why="share of the leaves, each larger in return",
        log=True,
    )
    yield Parameter(name="blossom_rate", unit="", low=0.0, high=1.0, default=0.0, why="blossoms by leaves")
    yield Parameter(
        name="blossom_shape", unit="", low=1, high=3, default=1, why="petals: 1 round, 2 pointed, 3 bell", integer=True
    )
    yield Parameter(name="blossom_scale", unit="m", low=0.0, high=2.0, default=0.04, why="length of a petal", log=True)


PARAMETERS = {
    parameter.name: parameter for part in (_tree(), *map(_level, range(NUM_LEVELS)), _leaves()) for parameter in part
}
"""All parameters by name, the trunk's before those of the branches."""


def _columns() -> Iterator[tuple[str, Parameter]]:
    for parameter in PARAMETERS.values():
        yield parameter.name, parameter
        if parameter.spread is not None:
            yield f"{parameter.name}{SPREAD}", parameter


COLUMNS = tuple(name for name, _ in _columns())
"""[P] names of the columns of `grammarlab.trees.species`: the parameters, each followed by its spread if it has one."""
COLUMN = {name: index for index, name in enumerate(COLUMNS)}


def _limits() -> tuple[Floats, Floats]:
    low, high = [], []
    for name, parameter in _columns():
        is_spread = name != parameter.name
        spread = parameter.spread or 0.0
        low.append((-spread if parameter.signed else 0.0) if is_spread else parameter.low)
        high.append(spread if is_spread else parameter.high)
    return np.array(low, dtype=np.float64), np.array(high, dtype=np.float64)


LOW, HIGH = _limits()
"""[P] smallest and largest possible values of the columns."""
DEFAULTS: Floats = np.array([parameter.default if name == parameter.name else 0.0 for name, parameter in _columns()])
"""[P] values in files that do not name them."""
IS_INTEGER: Flags = np.array([name == parameter.name and parameter.integer for name, parameter in _columns()])
"""[P] whether a column has whole numbers only."""
IS_LOG: Flags = np.array([name == parameter.name and parameter.log for name, parameter in _columns()])
"""[P] whether a range is drawn evenly in the logarithm."""
