"""How to learn: the choices that methods differ in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # these load JAX, which sampling need not wait for
    from grammarlab.preference.fitting import Method as Fit
    from grammarlab.preference.questions.queries import Way


FAMILIES = ("paths", "symbols", "draws", "thresholds", "skips", "siblings", "subtrees")
"""Kinds of features."""
MAX_PATH_LENGTH = 4
POOL_SIZE = 5000
"""Designs to ask about, before rare ones ask for more."""


@dataclass(frozen=True, slots=True)
class FeatureOptions:
    """What a learner looks at."""

    path_length: int = 2
    """Edges of the longest paths to begin with, 1 to `MAX_PATH_LENGTH`."""
    families: tuple[str, ...] = ("paths",)
    """Kinds of features, of `FAMILIES`."""


@dataclass(frozen=True, slots=True)
class Settings:
    """What a step of learning does with answers. The default is what a person gets."""

    features: FeatureOptions = FeatureOptions(2, ("paths", "symbols", "draws", "thresholds"))
    fit: Fit = "blended"
    options: tuple[tuple[str, float], ...] = ()
    """Parameters of the fit by name; only the paper's baseline has any."""
    query: Way = "default"
    """How designs to ask about are chosen."""
    grows: bool = True
    """Whether longer paths are taken in where designs with equal rows got different scores."""
    widens: bool = True
    """Whether the pool is widened where liked designs are rare (`grammarlab.learning.designs.pool`)."""
    warm: bool = False
    """Whether a fit starts from that of the round before: what is learned then depends on the rounds as well as on the
    scores, as it does for the paper's process."""
    seed: int = 0
    """Of the random starts of fits."""
