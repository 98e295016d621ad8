"""A species: a random distribution of the parameters of trees."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from difflib import get_close_matches

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.asset_roots import AssetRoot
from grammarlab.errors import UsageError, shown
from grammarlab.randomness import Keys, fold, uniforms
from grammarlab.trees.parameters import COLUMN, COLUMNS, HIGH, IS_INTEGER, IS_LOG, LOW

_PARAMETERS = 1
"""Lane below the key of a tree for the draws of its parameters; its stems have others (`grammarlab.trees.skeleton`)."""
_KIND = 0
"""Site of the draw of a kind; column c has site c + 1."""


@dataclass(frozen=True, slots=True, eq=False)
class Kind:
    """A part of a species, such as its slender trees: a range for every column."""

    weight: float
    """> 0; the weights of the kinds of a species sum to 1."""
    low: Floats
    """[P] start of the range of each column of `grammarlab.trees.parameters.COLUMNS`."""
    high: Floats
    """[P] end of the range; equal to `low` for a constant. Ranges of whole numbers include both ends."""
    means: str = ""
    """The kind in words."""


@dataclass(frozen=True, slots=True)
class Look:
    """Colours and pictures of bark, leaves and blossoms."""

    bark: str = ""
    """Picture of the bark, relative to the asset folder; empty for none."""
    leaf: str = ""
    """Picture of a leaf or a twig of leaves with transparent ground; empty for none."""
    blossom: str = ""
    bark_color: tuple[float, float, float] = (0.36, 0.28, 0.21)
    """sRGB, 0 to 1; it multiplies the picture."""
    leaf_color: tuple[float, float, float] = (0.27, 0.42, 0.16)
    blossom_color: tuple[float, float, float] = (0.96, 0.86, 0.9)


@dataclass(frozen=True, slots=True, eq=False)
class Species:
    """A distribution of trees.

    >>> import grammarlab as gl
    >>> palm = gl.load("palm")
    >>> isinstance(palm, gl.Species), len(palm.kinds)
    (True, 1)
    """

    name: str
    kinds: tuple[Kind, ...]
    """At least one; a tree is of one of them, drawn by weight, its columns drawn evenly within the ranges of the kind
    (evenly in the logarithm for those of `IS_LOG`), independent of each other."""
    typical: Floats
    """[P] the value of each column in the file: what a person would name as typical."""
    look: Look = Look()
    about: str = ""
    """The species in one sentence."""
    why: Mapping[str, str] = field(default_factory=dict)
    """Reasons of values by the name of the parameter."""
    acceptance: str = ""
    """An expression (`grammarlab.features.expression`) with the probability, 0 to 1, of keeping a candidate; empty
    to keep all."""
    assets: AssetRoot | None = None
    """Folder of the pictures of its look; None if it is unknown."""


def drawn(species: Species, keys: Keys) -> tuple[Floats, Ints]:
    """The columns [n, P] of the trees of some keys [n], and the kind [n] of each.

    A column depends on its own draw and on the kind only, so that another range of one column changes no other.
    """
    below = fold(keys, _PARAMETERS)
    ends = np.cumsum([kind.weight for kind in species.kinds])
    kind = np.minimum(np.searchsorted(ends, uniforms(below, _KIND) * ends[-1], side="right"), len(ends) - 1)
    units = np.column_stack([uniforms(below, site) for site in range(1, len(IS_LOG) + 1)])
    low, high = (np.stack([getattr(kind, end) for kind in species.kinds])[kind] for end in ("low", "high"))
    return within(low, high, units), kind


def within(low: Floats, high: Floats, units: Floats) -> Floats:
    """[n, P] values at shares [n, P], 0 <= share < 1, of ranges [n, P]."""
    end = np.where(IS_INTEGER, high + 1.0, high)
    # A range of counts from 0 has no logarithm, and is drawn evenly.
    log = IS_LOG & (low > 0.0)
    safe = np.where(log, low, 1.0)
    values = np.where(log, safe * (np.where(log, end, 1.0) / safe) ** units, low + (end - low) * units)
    return np.where(low == high, low, np.where(IS_INTEGER, np.minimum(np.floor(values), high), values))


def constrained(species: Species, values: Mapping[str, object]) -> Species:
    """The species with constant values of some columns; all others are drawn as before.

    Args:
        species: the species.
        values: value of each column.

    Raises:
        UsageError: If there is no such column, or it cannot have the value.
    """
    if not values:
        return species
    low, high = (np.array([getattr(kind, end) for kind in species.kinds]) for end in ("low", "high"))
    typical = species.typical.copy()
    for name, value in values.items():
        if name not in COLUMN:
            near = get_close_matches(name, COLUMNS, n=3, cutoff=0.5)
            hint = f"did you mean {' or '.join(near)}?" if near else "such as scale or branches_1."
            raise UsageError(f"{shown(name)} is not a parameter of trees; {hint}")
        column = COLUMN[name]
        least, most, is_count = float(LOW[column]), float(HIGH[column]), bool(IS_INTEGER[column])
        number = float(value) if isinstance(value, int | float) and not isinstance(value, bool) else np.nan
        if not least <= number <= most or (is_count and number % 1.0):
            kind = "a whole number" if is_count else "a number"
            raise UsageError(f"{name}: expected {kind} from {least:g} to {most:g}, found {shown(value)}.")
        low[:, column] = high[:, column] = typical[column] = number
    kinds = (replace(kind, low=low[index], high=high[index]) for index, kind in enumerate(species.kinds))
    return replace(species, kinds=tuple(kinds), typical=typical)
