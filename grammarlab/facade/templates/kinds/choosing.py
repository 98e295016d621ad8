"""Which templates the elements are made of: as few as explain them, each at a cost."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grammarlab.facade.templates.clouds import Clouds
from grammarlab.facade.templates.elements import Floats, Ints
from grammarlab.facade.templates.fitting.fit import Fits, background_cost
from grammarlab.facade.templates.template import Template

_HIDING = 4.0
"""Nats for saying that a part is hidden."""
_FITTING = 6.0
"""Nats by which a template has to beat points that are spread evenly over the box."""
_LEAST_INSIDE = 0.5
"""Part of the points that belong to what fits."""
_TEMPLATE = 4.0
"""Parts of the logarithm of the number of elements that a template costs."""


def description(clouds: Clouds, templates: Sequence[Template], fits: Fits) -> Floats:
    """[N, T + 1] nats to describe each element by each template, and last by none."""
    points = clouds.weight.sum(axis=1)
    number = np.array([len(template.parameters) for template in templates])
    cost = fits.cost + 0.5 * number * np.log(np.maximum(points, 2.0))[:, None] + _HIDING * (fits.hidden > 0.0)
    cost = np.where(fits.inside < _LEAST_INSIDE, 1e6, cost)
    return np.concatenate([cost, background_cost(clouds)[:, None] - _FITTING], axis=1)


def used_templates(costs: Floats) -> Ints:
    """Numbers of the templates that describe all elements in the shortest way, ascending; empty where none fits.

    One after the other is added that helps most, and taken away or exchanged where that helps.
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
