"""Posterior of elements, averaged over other sets of kinds that explain the scene nearly as well.

The posterior of the best kinds alone is overconfident: it ignores that two kinds may be one, or one may be two. Each
solution at a distance of one step, optimised again, has the weight exp(-difference of description lengths); its kinds
are identified with those of the best solution with which they share most elements.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from grammarlab.facade.templates.elements import Floats
from grammarlab.facade.templates.evidence.kinds import Solution, nearby
from grammarlab.facade.templates.evidence.maps import Maps
from grammarlab.facade.templates.evidence.neighbours import Groups

TEMPER = 0.5
"""Factor on the difference in nats, since solutions two steps away are not included."""


def averaged(maps: Maps, groups: tuple[Groups, ...], best: Solution) -> Solution:
    """The best solution, with a posterior averaged over similar solutions."""
    total, weight = best.posterior.copy(), 1.0
    for other in nearby(maps, groups, best):
        chance = float(np.exp(-TEMPER * max(other.length - best.length, 0.0)))
        if chance > 1e-4:
            total += chance * _renamed(other.posterior, best.posterior)
            weight += chance
    return replace(best, posterior=total / weight)


def _renamed(other: Floats, best: Floats) -> Floats:
    """[N, K + 1] a posterior [N, J + 1] in the kinds of another one; kinds without a partner count as unknown."""
    overlap = best[:, :-1].T @ other[:, :-1]
    rows, columns = linear_sum_assignment(-overlap)
    named = np.zeros_like(best)
    named[:, rows] = other[:, columns]
    named[:, -1] = 1.0 - named[:, :-1].sum(axis=1)
    return named
