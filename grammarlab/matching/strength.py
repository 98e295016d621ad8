"""Kinds with the most likely strength of the prior of rows and columns, and an averaged posterior.

The posterior of the best kinds alone is overconfident: it ignores that two kinds may be one, or one may be two. Each
solution at a distance of one step, optimised again, has the weight exp(-difference of description lengths); its kinds
are identified with those of the best solution with which they share most elements.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product

import numpy as np
from scipy.optimize import linear_sum_assignment

from grammarlab.arrays import Floats, Ints
from grammarlab.matching.evidence_maps import Maps
from grammarlab.matching.shared_kinds import VALUE_COST, Groups, Solution, find_kinds, nearby

_LENGTH_FACTOR = 0.5
"""Factor on the difference in nats, since solutions two steps away are not included."""
_STRENGTHS = (0.25, 1.0, 4.0, 16.0)
"""Values of kappa to try, in addition to no prior."""
_NUM_BIASES = 3
"""Number of deviations of sizes by the bias of a scan to try, from the step of the maps, by equal factors."""
_LARGEST_BIAS_M = 0.04
"""Largest of them, metres, unless the step of the maps is larger."""
_MIN_GROUPS = 2
"""Least number of groups with several elements for a prior."""


def with_bias(maps: Maps, corrected: Callable[[Maps], Maps]) -> Maps:
    """Corrected maps that allow for the bias of a scan, if the kinds have a shorter description then.

    Shadows, reveals and the angle of a scanner move all points of a side together, which the noise of points does not
    include: equal windows of a real wall would be several kinds. The bias costs as much as a shared width or
    height. Elements that differ in truth are described better without it, since their kinds are sharp. All deviations
    are tried, since one that is too small may be the longer description while a larger one is the shorter.

    Args:
        maps: evidence maps of N elements, without a bias.
        corrected: the corrections of a person, applied to maps.
    """
    best = corrected(maps)
    length = find_kinds(best).length
    cost = VALUE_COST * np.log(max(len(maps.evidence), 2))
    step = min(maps.widths[1] - maps.widths[0], maps.heights[1] - maps.heights[0])
    # A deviation of less than the step would change nothing.
    for bias in np.geomspace(step, max(step, _LARGEST_BIAS_M), _NUM_BIASES).tolist():
        blurred = corrected(maps.blurred(bias))
        other = find_kinds(blurred).length + cost
        if other < length:
            best, length = blurred, other
    return best


def find_kinds_with(maps: Maps, row: Ints, column: Ints) -> tuple[Solution, int]:
    """The kinds of shortest description, with the prior of rows or columns if it helps; and the number of trials.

    Args:
        maps: evidence maps of N elements.
        row: [N] row of the facade, -1 for none.
        column: [N] column of the facade, -1 for none.
    """
    best = plain = find_kinds(maps)
    sides = [index for index in (row, column) if _grouped(index)]
    priors: list[tuple[Groups, ...]] = [(Groups(index, kappa),) for index, kappa in product(sides, _STRENGTHS)]
    if len(sides) > 1:
        priors.append(tuple(Groups(index, _STRENGTHS[2]) for index in sides))
    chosen: tuple[Groups, ...] = ()
    for groups in priors:
        solution = find_kinds(maps, groups, plain.kinds)
        if solution.length < best.length:
            best, chosen = solution, groups
    return _averaged(maps, chosen, best), 1 + len(priors)


def _grouped(index: Ints) -> bool:
    values = index[index >= 0].tolist()
    return sum(values.count(value) > 1 for value in set(values)) >= _MIN_GROUPS


def _averaged(maps: Maps, groups: tuple[Groups, ...], best: Solution) -> Solution:
    """The best solution, with a posterior averaged over similar solutions."""
    total, weight = best.posterior.copy(), 1.0
    for other in nearby(maps, groups, best):
        chance = float(np.exp(-_LENGTH_FACTOR * max(other.length - best.length, 0.0)))
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
