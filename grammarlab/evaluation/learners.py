"""Methods put to work: from what a method says to a learner of the protocol."""

from __future__ import annotations

from functools import partial

from grammarlab.evaluation.methods import Method
from grammarlab.evaluation.protocol import Floats, Ints, Learner
from grammarlab.preference.base import AbstractPreference
from grammarlab.preference.fitting import fit
from grammarlab.preference.queries import propose


def learner_of(method: Method, path_length: int) -> Learner:
    """How a method fits and asks.

    Args:
        method: what to put to work.
        path_length: edges of the longest paths to begin with.
    """
    return Learner(partial(_fit, method), partial(propose, method.query), method.batch, path_length, method.grows)


def _fit(
    method: Method, rows: Floats, scores: Floats, groups: Ints, seed: int, warm: AbstractPreference | None
) -> AbstractPreference:
    if method.options:
        # Only this baseline has parameters, and only experiments change them.
        from grammarlab.preference import gaussian_process  # noqa: PLC0415 - loads JAX

        return gaussian_process.fit(rows, scores, groups=groups, seed=seed, warm=warm, **dict(method.options))
    return fit(rows, scores, groups=groups, method=method.fit, seed=seed, warm=warm)
