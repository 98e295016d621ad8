"""`fit`: a preference from labelled rows, by a chosen method."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from grammarlab.errors import UsageError
from grammarlab.extras import named_extras
from grammarlab.preference.base import AbstractPreference, Rows
from grammarlab.preference.labels import COMPARISONS, Kind

Method = Literal["blended", "partition", "grouped", "paper", "kde", "sklearn", "lightgbm"]

_MODULES: dict[Method, str] = {
    "blended": "grammarlab.preference.blended",
    "partition": "grammarlab.preference.cells.partition",
    "grouped": "grammarlab.preference.processes.grouped",
    "paper": "grammarlab.baselines.gaussian_process",
    "kde": "grammarlab.baselines.kde",
    "sklearn": "grammarlab.baselines.sklearn_process",
    "lightgbm": "grammarlab.baselines.boosted_trees",
}
"""Module of each method; JAX, scikit-learn and LightGBM are imported only if needed."""

_WITH_CONTINUOUS = ("blended", "partition", "grouped")
"""Methods that distinguish counts from continuous columns."""
_WITH_PRIORS = ("blended", "partition")
"""Methods to which some columns may be more likely to matter than others."""


def fit(
    rows: Rows,
    scores: ArrayLike,
    *,
    groups: ArrayLike | None = None,
    continuous: ArrayLike | None = None,
    priors: ArrayLike | None = None,
    method: Method = "blended",
    seed: int = 0,
    warm: AbstractPreference | None = None,
    kinds: Sequence[Kind] = (),
    others: Rows | None = None,
    designs: tuple[Rows, ArrayLike] | None = None,
) -> AbstractPreference:
    """A preference that explains the scores of some models and predicts those of all others.

    It is defined for every set of at least one label. Rows may repeat, and repeated rows may have different scores:
    the prediction is then near their mean. If all scores are zero, all predictions are zero. As far as scores have no
    pattern yet, the method ``blended`` predicts the same score for all models (`BlendedPreference.unexplained`).

    Args:
        rows: [n, F] finite numbers that describe the labelled models.
        scores: [n] scores of the person, 0 (disliked) to 100.
        groups: [F] a number >= 0 for each column; columns of one group belong to one choice.
        continuous: [F] whether columns are continuous instead of counts; the baselines ignore it.
        priors: [F] how likely columns are to matter, relative to each other; by default all are equally likely. Only
            the methods ``blended`` and ``partition`` use it, for conditions on many continuous columns.
        method: ``blended`` (the next two, with weights from held-out scores), ``partition`` (cells that average their
            scores), ``grouped`` (a weight for each group, averaged by evidence), ``paper`` (a weight for each column,
            Equations 4.4-4.8), ``kde`` (score-weighted density, the paper's baseline), ``sklearn`` or ``lightgbm``
            (boosted trees).
        seed: seed of random draws; the same seed gives the same preference.
        warm: the preference of the round before, found by the same method on the same columns.
        kinds: [n] kind of each label; by default all are scores.
        others: [n, F] rows of the other models of comparisons; only the method ``blended`` supports them.
        designs: [m, F] rows of models and [m] >= 0, their density: equal weights for a sample of a grammar. The method
            ``blended`` then predicts what `learn` learns, a density: each explanation has its share of these models.
            Other methods ignore them.

    Raises:
        UsageError: If an argument is wrong or a library is missing; the message says where and what to do.

    >>> import grammarlab as gl
    >>> rows, scores = [[0.0, 1.0], [1.0, 0.0], [0.0, 0.0], [1.0, 1.0]], [100.0, 0.0, 0.0, 100.0]
    >>> likes_the_second = gl.fit(rows, scores, method="kde")
    >>> likes_the_second.predict([[0.0, 1.0], [0.0, 0.0]]).mean.round().tolist()
    [100.0, 0.0]
    """
    if method not in _MODULES:
        raise UsageError(f"method: expected one of {', '.join(get_args(Method))}, found {method!r}.")
    unknown = set(kinds) - set(get_args(Kind))
    if unknown:
        raise UsageError(f"kinds: expected {', '.join(get_args(Kind))}, found {', '.join(map(repr, sorted(unknown)))}.")
    if set(kinds) & set(COMPARISONS) and method != "blended":
        raise UsageError(f"kinds: the method {method!r} learns only from scores; use 'blended' with comparisons.")
    is_mixed = method == "blended" and bool(set(kinds) - {"score"})
    with named_extras():
        module = import_module("grammarlab.preference.mixed" if is_mixed else _MODULES[method])
    if is_mixed:
        options: dict[str, Any] = {"kinds": kinds, "others": rows if others is None else others}
    else:
        options = {"warm": warm} | ({"priors": priors} if method in _WITH_PRIORS else {})
    options |= {"continuous": continuous} if method in _WITH_CONTINUOUS else {}
    preference = module.fit(rows, scores, groups=groups, seed=seed, **options)
    if method == "blended" and designs is not None:
        return preference.for_density(designs[0], np.asarray(designs[1], dtype=np.float64))
    return preference
