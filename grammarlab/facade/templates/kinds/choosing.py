"""Choice of templates: as few as explain the elements, each at a cost."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grammarlab.facade.templates.clouds import Clouds
from grammarlab.facade.templates.elements import Floats, Ints
from grammarlab.facade.templates.fitting.fit import Fits, background_cost
from grammarlab.facade.templates.template import Template

_HIDING = 4.0
"""Cost of an occluding half-plane, nats."""
_FITTING = 6.0
"""Least gain of a template over points that are uniform in the box, nats."""
_LEAST_INSIDE = 0.5
"""Least fraction of inliers of a fit."""
_TEMPLATE = 4.0
"""Cost of a template, as a multiple of the logarithm of the number of elements."""


def description(clouds: Clouds, templates: Sequence[Template], fits: Fits) -> Floats:
    """[N, T + 1] description length of each element by each template, and by none last, nats."""
    points = clouds.weight.sum(axis=1)
    number = np.array([len(template.parameters) for template in templates])
    cost = fits.cost + 0.5 * number * np.log(np.maximum(points, 2.0))[:, None] + _HIDING * (fits.hidden > 0.0)
    cost = np.where(fits.inside < _LEAST_INSIDE, 1e6, cost)
    return np.concatenate([cost, background_cost(clouds)[:, None] - _FITTING], axis=1)


def used_templates(costs: Floats) -> Ints:
    """Indices of the templates with the shortest description of all elements, ascending; empty if none fits.

    Greedy: the best one is added, removed or exchanged as long as that shortens the description.
    """
    price = _TEMPLATE * np.log(len(costs) + 1.0)
    number = costs.shape[1] - 1
    used: frozenset[int] = frozenset()
    best = _total(costs, used, price)
    while True:
        steps = [used ^ {each} for each in range(number)]
        steps += [(used - {old}) | {new} for old in used for new in range(number) if new not in used]
        totals = [_total(costs, each, price) for each in steps]
        place = int(np.argmin(totals))
        if totals[place] >= best - 1e-9:
            return np.array(sorted(used), dtype=np.int64)
        used, best = steps[place], totals[place]


def _total(costs: Floats, used: frozenset[int], price: float) -> float:
    return float(costs[:, [*sorted(used), -1]].min(axis=1).sum() + price * len(used))
