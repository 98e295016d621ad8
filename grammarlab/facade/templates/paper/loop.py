"""The loop of the paper: deform, find a common space, label, find similarities; until labels are stable."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grammarlab.extras import require
from grammarlab.facade.templates.clock import Clock
from grammarlab.facade.templates.clouds import Clouds, clouds_of
from grammarlab.facade.templates.elements import Elements, Floats, Ints, too_poor
from grammarlab.facade.templates.fitting.fit import Fits, fit_all
from grammarlab.facade.templates.kinds.choosing import description
from grammarlab.facade.templates.kinds.match import Match
from grammarlab.facade.templates.kinds.plain import fitting, from_labels, unfit
from grammarlab.facade.templates.kinds.relations import THRESHOLD, couplings, replicas
from grammarlab.facade.templates.paper.deforming import deform
from grammarlab.facade.templates.paper.field import Field
from grammarlab.facade.templates.paper.labelling import label
from grammarlab.facade.templates.paper.placing import place_labels
from grammarlab.facade.templates.paper.subspace import dimensions_of, merged, similarity, weights_of
from grammarlab.facade.templates.template import Stack, Template, stack

MOST_ITERATIONS = 12
BEST = 3
"""Number of best templates whose deformations become labels, for each element."""
W_S = 0.1
_LABEL_COST = 0.2
"""Cost of a template, as a fraction of the mean data cost."""
_SPACE = 4.0
"""Unit of Equation 5.2, which the paper does not give, as a multiple of the similarity threshold."""


def match_as_paper(elements: Elements, templates: Sequence[Template]) -> Match:
    """Kinds of elements by the paper's loop, with its weights."""
    require("ortools")
    clock = Clock()
    reasons = too_poor(elements)
    which = np.array([each for each in range(len(elements)) if each not in reasons], dtype=np.int64)
    stacked = stack(templates)
    clouds = clouds_of(elements, which)
    fits = fit_all(clouds, stacked)
    fine = fitting(clouds, templates, fits)
    reasons |= unfit(clouds, templates, ~fine)
    which = which[fine]
    clouds = clouds_of(elements, which)
    fits = fits.of(fine)
    clock.lap("fitting")
    threshold = THRESHOLD * float(np.linalg.norm(elements.high - elements.low, axis=1).max())
    state = np.concatenate([fits.corner, fits.parameters], axis=2)
    owner, values, corner = np.zeros(len(which), dtype=np.int64), state[:, 0, 2:], state[:, 0, :2]
    before: tuple[Ints, Ints] | None = None
    iterations = 0
    while len(which) and iterations < MOST_ITERATIONS:
        iterations += 1
        field, label_values, label_corner = _field(clouds, templates, stacked, fits, state, threshold)
        clock.lap("subspace")
        labels, _ = label(field)
        clock.lap("labelling")
        owner, values = field.owner[labels], label_values[labels]
        corner = label_corner[labels, np.arange(len(which))]
        found = replicas(owner, values, threshold)
        if before is not None and (before[0] == owner).all() and (before[1] == found).all():
            break
        before = owner, found
        coupled = couplings(owner, values, stacked.used, threshold)
        clock.lap("similarity")
        state = deform(clouds, stacked, state, coupled, 10.0 * threshold)
        clock.lap("deformation")
    kind = replicas(owner, values, threshold)
    return from_labels(
        elements, templates, which, kind, owner, values, corner, fits, reasons, iterations=iterations, clock=clock
    )


def _field(
    clouds: Clouds, templates: Sequence[Template], stacked: Stack, fits: Fits, state: Floats, threshold: float
) -> tuple[Field, Floats, Floats]:
    """The field of Equation 5.3, the parameters [L, D] of its labels and their corners [L, N, 2] on each element."""
    against = fits.noise.min(axis=1, keepdims=True) * _against(clouds, templates, fits)
    best = np.argsort(against, axis=1)[:, :BEST]
    element = np.repeat(np.arange(len(best)), best.shape[1])
    owner = best.reshape(-1).astype(np.int64)
    values = state[element, owner, 2:]
    data, corner = place_labels(clouds, stacked, state, owner, values, 10.0 * threshold)
    data += np.minimum(against, 10.0 * threshold)[:, owner]
    away = np.linalg.norm(values[:, None] - values[None], axis=2)
    other = max(float(away.max(initial=0.0)) / 2.0, 1e-3)
    same = owner[:, None] == owner[None]
    # A metric: the distance of labels of different templates is half of the largest distance within one.
    distance = np.where(same, np.minimum(away, 2.0 * other), other)
    weights = weights_of(state[:, np.unique(owner), 2:], _SPACE * threshold)
    near = similarity(merged(weights, min(dimensions_of(weights), len(best))))
    cost = np.full(len(stacked.usual), _LABEL_COST * float(data.min(axis=1).mean()))
    return Field(data, W_S * near, distance, owner, cost), values, corner


def _against(clouds: Clouds, templates: Sequence[Template], fits: Fits) -> Floats:
    """[N, T] nats per point that each template describes an element worse by than the best one."""
    costs = description(clouds, templates, fits)[:, :-1]
    return (costs - costs.min(axis=1, keepdims=True)) / clouds.weight.sum(axis=1, keepdims=True)
