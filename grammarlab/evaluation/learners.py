"""Methods put to work: from what a method says to a learner of the protocol."""

from __future__ import annotations

from functools import partial

import numpy as np

from grammarlab.derivation.forest import Forest
from grammarlab.evaluation.methods import Method
from grammarlab.evaluation.protocol import Floats, Ints, Learner
from grammarlab.evaluation.scenario import FeatureOptions
from grammarlab.features.growth import search_patterns
from grammarlab.features.pattern import Feature
from grammarlab.features.thresholds import find_half_space, find_thresholds
from grammarlab.preference.base import AbstractPreference
from grammarlab.preference.fitting import fit
from grammarlab.preference.queries import propose

SEARCHED = ("thresholds", "subtrees")
"""Families of features that are searched for in the labelled models; all others are counted beforehand."""
FEWEST_LIKED = 3
"""Models with a score above 0 that a search for subtrees begins with."""


def learner_of(method: Method, features: FeatureOptions) -> Learner:
    """How a method fits and asks.

    Args:
        method: what to put to work.
        features: what it looks at.
    """
    searched = [family for family in features.families if family in SEARCHED]
    return Learner(
        partial(_fit, method),
        partial(propose, method.query),
        method.batch,
        method.path_length or features.path_length,
        method.grows,
        partial(_search, searched) if searched else None,
        method.query == "default",
    )


def _fit(
    method: Method, rows: Floats, scores: Floats, groups: Ints, seed: int, warm: AbstractPreference | None
) -> AbstractPreference:
    if method.options:
        # Only this baseline has parameters, and only experiments change them.
        from grammarlab.preference import gaussian_process  # noqa: PLC0415 - loads JAX

        return gaussian_process.fit(rows, scores, groups=groups, seed=seed, warm=warm, **dict(method.options))
    return fit(rows, scores, groups=groups, method=method.fit, seed=seed, warm=warm)


def _search(families: list[str], forests: tuple[Forest, ...], scores: Floats) -> tuple[Feature, ...]:
    """Features that explain scores, of the families that are searched for."""
    found: tuple[Feature, ...] = ()
    if "thresholds" in families:
        found += _bounds(forests, scores)
    # A pattern that fits a single liked model by chance is found for any model.
    if "subtrees" in families and (scores > 0).sum() >= FEWEST_LIKED:
        found += search_patterns(forests, scores)
    return found


def _bounds(forests: tuple[Forest, ...], scores: Floats) -> tuple[Feature, ...]:
    """Bounds on continuous draws: of several at once where they belong together, else of each alone."""
    names = list(dict.fromkeys(site.name for site in forests[0].sites if site.kind == "uniform"))
    liked = scores > (scores.min() + scores.max()) / 2
    together = find_half_space(forests, np.asarray(liked), names) if names else None
    if together is not None and len(together.sites) > 1:
        return (together,)
    return find_thresholds(forests, scores, names)
