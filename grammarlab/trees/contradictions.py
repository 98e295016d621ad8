"""Warnings about parameters of a species that contradict each other."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.errors import Finding
from grammarlab.trees.budget import MAX_LEAVES, MAX_STEMS
from grammarlab.trees.parameters import COLUMN, LOW, NUM_LEVELS, PARAMETERS, SPREAD
from grammarlab.trees.species import Species
from grammarlab.trees.species_places import Path, Places

_PRUNED = ("prune_width", "prune_width_peak", "prune_power_low", "prune_power_high")
_NEEDS = {
    "base_size": ("branches_1",),
    "lobe_depth": ("lobes",),
    "lobes": ("lobe_depth",),
    "wind_direction": ("wind_speed",),
    **dict.fromkeys(_PRUNED, ("prune_ratio",)),
    "split_angle_0": ("seg_splits_0", "base_splits"),
    **{f"split_angle_{level}": (f"seg_splits_{level}",) for level in range(1, NUM_LEVELS)},
    **{f"curve_back_{level}": (f"curve_{level}",) for level in range(NUM_LEVELS)},
    **{name: ("leaves",) for name in PARAMETERS if name.startswith("leaf_")},
    "leaves": ("leaf_scale",),
    "blossom_rate": ("leaves",),
    "blossom_scale": ("blossom_rate",),
    "blossom_shape": ("blossom_rate",),
}
"""Parameters that mean little without one of others."""
_ENVELOPE = 8
"""Shape that uses the envelope without pruning."""
_LONGEST = 2.0
"""A child that is longer than this many parents is more likely a slip than a habit."""

_BEARING = (1.0, 1.0, 0.6, 0.75)
"""Mean number of stems of each level by the largest number on one parent, for parents of the usual lengths."""
_LEAFY = 0.75
"""Mean number of leaves by the largest number on one stem."""


class _Ranges:
    """The smallest and the largest value of each column among the trees of a species."""

    def __init__(self, species: Species) -> None:
        self._low: Floats = np.min([kind.low for kind in species.kinds], axis=0)
        self._high: Floats = np.max([kind.high for kind in species.kinds], axis=0)

    def low(self, column: str) -> float:
        """The smallest value."""
        return float(self._low[COLUMN[column]])

    def high(self, column: str) -> float:
        """The largest value."""
        return float(self._high[COLUMN[column]])

    def is_zero(self, parameter: str) -> bool:
        """Whether a parameter is 0 in all trees."""
        return self.low(parameter) == self.high(parameter) == 0.0


def contradictions(species: Species, places: Places, paths: Mapping[str, Path]) -> tuple[Finding, ...]:
    """Warnings about a species, in the order of its file.

    Args:
        species: the species of a file.
        places: places of the values of the file.
        paths: path of each parameter that the file names.
    """
    ranges = _Ranges(species)
    unused = dict(_unused_levels(ranges, paths))
    warnings = {**dict(_needless(ranges, paths)), **unused}
    for name, text in (*_sizes(ranges, paths), *_mixed_signs(ranges, paths), *_too_many(ranges, paths)):
        warnings.setdefault(name, text)
    findings = [
        Finding("warning", "contradiction", message, places.of_key(paths[name]), hint)
        for name, (message, hint) in warnings.items()
    ]
    return tuple(sorted(findings, key=lambda finding: finding.location))


_Warning = tuple[str, tuple[str, str]]
"""Name of a parameter, what is wrong with it, and what to try."""


def _unused_levels(ranges: _Ranges, paths: Mapping[str, Path]) -> Iterator[_Warning]:
    """Parameters of levels that no tree has."""
    most = int(ranges.high("levels"))
    for level in range(most, NUM_LEVELS):
        names = [name for name in paths if name.endswith(f"_{level}")]
        if level == most and not ranges.is_zero("leaves"):
            # The leaves of the last level take their angles from the level after.
            names = [name for name in names if not name.startswith(("down_angle_", "rotate_"))]
        if names:
            others = f" and {len(names) - 1} more of its parameters have" if len(names) > 1 else " has"
            message = f"no tree has stems of level {level}, so {names[0]}{others} no effect"
            yield names[0], (message, f"give levels the value {level + 1}, or delete the line{'s' * (len(names) > 1)}")
    if most < 3 and "attraction_up" in paths and not ranges.is_zero("attraction_up"):
        yield (
            "attraction_up",
            ("attraction_up has no effect: it bends stems of level 2 and 3", "give levels the value 3"),
        )


def _needless(ranges: _Ranges, paths: Mapping[str, Path]) -> Iterator[_Warning]:
    """Parameters without an effect, because another one is 0."""
    for name, others in _NEEDS.items():
        if name not in paths or ranges.is_zero(name) or not all(ranges.is_zero(other) for other in others):
            continue
        if name in _PRUNED and ranges.high("shape") == _ENVELOPE:
            continue
        effect = "bends the upper half of stems only" if name.startswith("curve_back") else "has no effect"
        yield name, (f"{name} {effect}: {others[0]} is 0", f"give {' or '.join(others)} a value, or delete the line")
    for level in range(2, NUM_LEVELS):
        name = f"branches_{level - 1}"
        if name in paths and ranges.is_zero(name) and ranges.high("levels") > level:
            yield name, (f"there are no stems of level {level}: {name} is 0", f"give levels the value {level - 1}")


def _sizes(ranges: _Ranges, paths: Mapping[str, Path]) -> Iterator[_Warning]:
    """Sizes that are negative for some trees, and children that are longer than plausible."""
    for name in paths:
        spread = name + SPREAD
        is_size = spread in COLUMN and LOW[COLUMN[name]] >= 0.0 and not name.startswith("split_angle")
        if is_size and ranges.high(spread) > ranges.low(name):
            message = f"the spread of {name}, {ranges.high(spread):g}, is larger than its value, {ranges.low(name):g}"
            yield name, (message, "a smaller spread, so that no size is below 0")
        if name.startswith("length_") and name[-1] != "0" and ranges.high(name) > _LONGEST:
            message = f"stems of level {name[-1]} are up to {ranges.high(name):g} times as long as their parent"
            yield name, (message, f"{name} is a share of the length of the parent, such as 0.3")


def _mixed_signs(ranges: _Ranges, paths: Mapping[str, Path]) -> Iterator[_Warning]:
    """Spreads that are negative for some trees only."""
    for name in paths:
        spread = name + SPREAD
        if PARAMETERS[name].signed and ranges.low(spread) < 0.0 < ranges.high(spread):
            message = f"the spread of {name} is negative for some trees, which has another meaning, but not for all"
            yield name, (message, "use a range on one side of 0, or two [[kinds]]")


def _too_many(ranges: _Ranges, paths: Mapping[str, Path]) -> Iterator[_Warning]:
    """Parameters that multiply stems or leaves beyond what is possible, for trees with the largest of all values."""
    shoots = 1.0 + ranges.high("base_splits")
    for level in range(int(ranges.high("levels"))):
        factors = {f"branches_{level}": ranges.high(f"branches_{level}") * _BEARING[level]} if level else {}
        splits = 1.0 + ranges.high(f"seg_splits_{level}")
        clones = splits ** np.arange(ranges.high(f"curve_res_{level}"))
        shoots *= float(np.prod(list(factors.values())))
        factors[f"seg_splits_{level}"] = float(clones[-1])
        name = max(factors, key=lambda name: factors[name])
        if shoots * clones[-1] > MAX_STEMS and name in paths:
            message = f"trees may have some {shoots * clones[-1]:.2g} stems of level {level}, of {MAX_STEMS:,} possible"
            yield name, (message, f"a smaller {name}, or fewer levels")
            return
        # Clones bear children only above the place where they split off.
        shoots *= float(clones.mean())
    most = max(abs(ranges.low("leaves")), abs(ranges.high("leaves")))
    leaves = shoots * most * _LEAFY * ranges.high("leaf_quality")
    if leaves > MAX_LEAVES and "leaves" in paths:
        message = f"trees may have some {leaves:.2g} leaves, of {MAX_LEAVES:,} possible"
        yield "leaves", (message, "fewer leaves, or a smaller leaf_quality, which draws fewer and larger leaves")
