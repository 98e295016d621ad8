"""Settings of learning, in which methods differ."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # these load JAX, which sampling does not need
    from grammarlab.learning.fitting import Method as Fit
    from grammarlab.preference.queries import Way


FAMILIES = ("paths", "symbols", "draws", "skips", "siblings", "counts")
"""Kinds of features."""
MAX_PATH_LENGTH = 4
"""Largest number of edges of a path."""
POOL_SIZE = 5000
"""Default size of the pool, before it is widened for rare designs."""
LEAST_POOL = 500
"""Smallest size of a pool of designs that take long to make, unless another is asked for."""


@dataclass(frozen=True, slots=True)
class FeatureOptions:
    """Features of a learner."""

    path_length: int = 2
    """Initial number of edges of the longest paths, 1 to `MAX_PATH_LENGTH`."""
    families: tuple[str, ...] = ("paths",)
    """Kinds of features, of `FAMILIES`."""


@dataclass(frozen=True, slots=True)
class Settings:
    """Settings of a step of learning. The default is for persons."""

    features: FeatureOptions = FeatureOptions(2, ("paths", "symbols", "draws"))
    fit: Fit = "blended"
    options: tuple[tuple[str, float], ...] = ()
    """Parameters of the fit by name; only the paper's baseline has any."""
    query: Way = "default"
    """Query strategy, which selects the designs to ask about."""
    grows: bool = True
    """Whether longer paths are added if designs with equal rows got different scores, and the default method adds
    composed columns that scores need."""
    widens: bool = True
    """Whether the pool is widened if liked designs are rare (`grammarlab.learning.designs.pool`)."""
    warm: bool = False
    """Whether a fit starts from that of the previous round: the result then depends on the rounds and the scores, as
    for the paper's process."""
    seed: int = 0
    """Seed of the random starts of fits."""
