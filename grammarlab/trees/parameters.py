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
    yield Parameter("shape", "", 0, 8, 7, "outline of the crown: 0 conical to 7 tend flame, 8 envelope", integer=True)
    yield Parameter("base_size", "", 0.0, 0.95, 0.3, "share of the height without branches")
    yield Parameter("scale", "m", 0.05, 120.0, 12.0, "height of the tree", spread=60.0, log=True)
    yield Parameter("z_scale", "", 0.1, 10.0, 1.0, "stretch along the height", spread=5.0, log=True)
    yield Parameter("levels", "", 1, NUM_LEVELS, 3, "levels of stems, the trunk included", integer=True)
    yield Parameter("ratio", "", 0.001, 0.3, 0.015, "radius of the trunk by its length", log=True)
    yield Parameter("ratio_power", "", 0.0, 8.0, 1.2, "how much thinner shorter stems are")
    yield Parameter("lobes", "", 0, 40, 0, "number of lobes around the trunk", integer=True)
    yield Parameter("lobe_depth", "", 0.0, 0.9, 0.0, "depth of the lobes by the radius")
    yield Parameter("flare", "", -0.9, 10.0, 0.5, "how much wider the trunk is at the ground")
    yield Parameter("attraction_up", "", -20.0, 20.0, 0.0, "bending of branches of level 2 and 3 to the sky")
    yield Parameter("prune_ratio", "", 0.0, 1.0, 0.0, "how much the envelope shortens stems that leave it")
    yield Parameter("prune_width", "", 0.0, 4.0, 0.5, "radius of the envelope by the height of the tree")
    yield Parameter("prune_width_peak", "", 0.0, 1.0, 0.5, "height of the widest part of the envelope, from its base")
    yield Parameter("prune_power_low", "", 0.0, 16.0, 0.5, "curvature of the envelope below its widest part")
    yield Parameter("prune_power_high", "", 0.0, 16.0, 0.5, "curvature of the envelope above its widest part")
    yield Parameter("wind_speed", "m/s", 0.0, 60.0, 0.0, "wind that bends the stems, as a still pose")
    yield Parameter("wind_direction", "deg", -360.0, 360.0, 0.0, "where the wind blows to, about the vertical from +x")


def _level(level: int) -> Iterator[Parameter]:
    below = "the trunk" if level == 0 else f"stems of level {level}"
    if level == 0:
        yield Parameter("scale_0", "", 0.05, 10.0, 1.0, "factor of the trunk's radius", spread=5.0, log=True)
        yield Parameter("base_splits", "", 0, 20, 0, "stems more that the trunk splits into at once", integer=True)
    else:
        yield Parameter(
            f"down_angle_{level}", "deg", -180.0, 180.0, 60.0, f"angle of {below} from their parent", 180.0, signed=True
        )
        yield Parameter(
            f"rotate_{level}", "deg", -360.0, 360.0, 140.0, f"turn of {below} around their parent since the last", 360.0
        )
        yield Parameter(f"branches_{level}", "", 0, 2000, 20, f"most {below} on one parent", integer=True, log=True)
    yield Parameter(
        f"length_{level}", "", 0.0, 25.0, 1.0 if level == 0 else 0.3, f"length of {below} by their parent", 25.0
    )
    yield Parameter(f"taper_{level}", "", 0.0, 3.0, 1.0, f"0 cylinder, 1 cone, 2 rounded end, 3 beads: {below}")
    yield Parameter(f"seg_splits_{level}", "", 0.0, 4.0, 0.0, f"splits of {below} at each segment")
    yield Parameter(f"split_angle_{level}", "deg", 0.0, 180.0, 0.0, f"angle between {below} that split", spread=180.0)
    yield Parameter(f"curve_res_{level}", "", 1, 60, 3, f"segments of {below}", integer=True, log=True)
    yield Parameter(f"curve_{level}", "deg", -720.0, 720.0, 0.0, f"bend of {below} from end to end", 720.0, signed=True)
    yield Parameter(f"curve_back_{level}", "deg", -720.0, 720.0, 0.0, f"bend of the upper half of {below}")


def _leaves() -> Iterator[Parameter]:
    yield Parameter("leaves", "", -500, 500, 0, "leaves on a last stem; negative: a fan at its tip", integer=True)
    shapes = "0 oval, 1 pointed, 2 lance, 3 lobed, 4 palmate, 5 heart, 6 needle, 7 twig of needles, 8 frond, 9 feather"
    yield Parameter("leaf_shape", "", 0, 9, 0, f"outline of a leaf: {shapes}", integer=True)
    yield Parameter("leaf_scale", "m", 0.0, 8.0, 0.2, "length of a leaf", log=True)
    yield Parameter("leaf_scale_x", "", 0.01, 4.0, 0.7, "width of a leaf by its length", log=True)
    yield Parameter("leaf_bend", "", 0.0, 1.0, 0.3, "turn of leaves to the light")
    yield Parameter("leaf_stem_len", "", -20.0, 20.0, 0.5, "length of the stalk by that of the leaf")
    yield Parameter("leaf_quality", "", 0.01, 1.0, 1.0, "share of the leaves, each larger in return", log=True)
    yield Parameter("blossom_rate", "", 0.0, 1.0, 0.0, "blossoms by leaves")
    yield Parameter("blossom_shape", "", 1, 3, 1, "petals: 1 round, 2 pointed, 3 bell", integer=True)
    yield Parameter("blossom_scale", "m", 0.0, 2.0, 0.04, "length of a petal", log=True)


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
