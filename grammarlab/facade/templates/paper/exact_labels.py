"""Labels of few elements with the least energy, proven by CP-SAT: expansions end in a local optimum."""

from __future__ import annotations

from typing import Any

import numpy as np

from grammarlab.facade.templates.elements import Floats, Ints
from grammarlab.facade.templates.paper.field import Field

_WHOLE = 1e6
"""Integer energy of the largest energy of one element, for the solver."""
_EFFORT = 10.0
"""Deterministic time limit of the solver, about a second per unit; equal on any machine."""


def least(field: Field, start: Ints) -> Ints:
    """Labels [N] of the least energy, or of the lowest one found within the time limit.

    Args:
        field: the field, of few elements.
        start: [N] initial labels.
    """
    from ortools.sat.python import cp_model  # noqa: PLC0415 an extra

    model, (elements, labels) = cp_model.CpModel(), field.data.shape
    highest = max(float(field.data.max()), float(field.distance.max() * field.weight.max()), 1e-300)
    scale = _WHOLE / highest

    def whole(costs: Floats) -> list[Any]:
        return np.rint(np.minimum(costs, elements * highest) * scale).astype(np.int64).tolist()

    takes = [[model.new_bool_var("") for _ in range(labels)] for _ in range(elements)]
    used = [model.new_bool_var("") for _ in field.cost]
    terms, factors = list(used), whole(field.cost)
    for element in range(elements):
        model.add_exactly_one(takes[element])
        terms += takes[element]
        factors += whole(field.data[element])
        for own in range(labels):
            model.add_implication(takes[element][own], used[field.owner[own]])
            model.add_hint(takes[element][own], own == start[element])
        for other in range(element):
            costs = whole(field.weight[element, other] * field.distance)
            between = model.new_int_var(0, max(max(row) for row in costs), "")
            for own in range(labels):
                apart = cp_model.LinearExpr.weighted_sum(takes[other], costs[own])
                model.add(between >= apart).only_enforce_if(takes[element][own])
            terms.append(between)
            factors.append(1)
    model.minimize(cp_model.LinearExpr.weighted_sum(terms, factors))
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    solver.parameters.max_deterministic_time = _EFFORT
    if solver.solve(model) not in {cp_model.OPTIMAL, cp_model.FEASIBLE}:
        return start
    return np.array([[solver.value(take) for take in row] for row in takes]).argmax(axis=1)
