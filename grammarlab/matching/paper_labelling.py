"""Labels of elements by a Markov random field with label costs (paper 001, Equation 5.3).

sum_i D_i(l_i) + sum_{i<k} w_ik V(l_i, l_k) + sum over used templates of their cost is minimised by alpha expansion:
each move changes any elements to one label, and the best such move is a minimum cut (Boykov, Veksler and Zabih 2001;
label costs: Delong, Osokin, Isack and Boykov 2012). V has to be a metric.

The objective of labelling: Equation 5.3 of paper 001.

Labels of few elements with the least energy, proven by CP-SAT: expansions end in a local optimum.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from grammarlab.matching.elements import Floats, Ints


@dataclass(frozen=True, eq=False)
class Field:
    """N elements, L labels."""

    data: Floats
    """[N, L] data costs, >= 0."""
    weight: Floats
    """[N, N] weights, >= 0, symmetric, 0 on the diagonal."""
    distance: Floats
    """[L, L] distances of labels, a metric."""
    owner: Ints
    """[L] template of each label."""
    cost: Floats
    """[T] cost of each used template, >= 0."""


def energy(field: Field, labels: Ints) -> float:
    """Equation 5.3 for labels [N]."""
    data = field.data[np.arange(len(labels)), labels].sum()
    smooth = (field.weight * field.distance[np.ix_(labels, labels)]).sum() / 2.0
    return float(data + smooth + field.cost[np.unique(field.owner[labels])].sum())


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


FEW = 12
"""Largest number of elements for which the least energy is proven."""
_SCALE = 1 << 40
"""Integer scale of capacities; the sum of all costs of a cut stays far below 2^63."""


def label(field: Field) -> tuple[Ints, list[float]]:
    """Labels [N] of low energy, the least one for few elements, and the energies after each move, which never rise."""
    labels, energies = expanded(field, field.data.argmin(axis=1))
    if len(field.data) > FEW:
        return labels, energies
    better, more = expanded(field, least(field, labels))
    return (better, [*energies, more[-1]]) if more[-1] < energies[-1] else (labels, energies)


def expanded(field: Field, start: Ints) -> tuple[Ints, list[float]]:
    """Labels after expansions to every label, until none lowers the energy."""
    labels, energies = start.copy(), [energy(field, start)]
    since = 0
    while since < field.data.shape[1]:
        for alpha in range(field.data.shape[1]):
            moved = _expand(field, labels, alpha)
            found = energies[-1] if moved is None else energy(field, moved)
            if moved is not None and found < energies[-1] - 1e-12:
                labels, since = moved, 0
                energies.append(found)
            else:
                since += 1
            if since >= field.data.shape[1]:
                break
    return labels, energies


def _expand(field: Field, labels: Ints, alpha: int) -> Ints | None:
    """Labels after the best move to one label; None if no element changes."""
    free = _undecided(field, labels, alpha)
    if not len(free):
        return None
    taken = _cut(field, labels, alpha, free)
    if not taken.any():
        return None
    moved = labels.copy()
    moved[free[taken]] = alpha
    return moved


def _undecided(field: Field, labels: Ints, alpha: int) -> Ints:
    """Elements that may change to a label in the best move; others would not gain even if all of these changed."""
    every = np.arange(len(labels))
    own, other = field.data[every, labels], field.data[:, alpha]
    saved = np.where(field.owner[labels] != field.owner[alpha], field.cost[field.owner[labels]], 0.0)
    apart = field.distance[labels, alpha]
    free = labels != alpha
    away = field.weight * field.distance[np.ix_(labels, labels)]
    while free.any():
        # With the free elements at alpha: the costs of keeping a label, and of changing it.
        keep = own + (field.weight[:, free].sum(axis=1)) * apart + away[:, ~free].sum(axis=1)
        take = other + field.weight[:, ~free] @ apart[~free]
        still = free & (take < keep + saved)
        if (still == free).all():
            break
        free = still
    return np.flatnonzero(free)


def _cut(field: Field, labels: Ints, alpha: int, free: Ints) -> np.ndarray:
    """[F] whether each free element changes to the label in the best move: those beyond the minimum cut."""
    from ortools.graph.python import max_flow  # noqa: PLC0415 an extra

    number = len(free)
    fixed = np.setdiff1d(np.arange(len(labels)), free)
    keep = field.data[free, labels[free]] + (
        field.weight[np.ix_(free, fixed)] * field.distance[np.ix_(labels[free], labels[fixed])]
    ).sum(axis=1)
    take = field.data[free, alpha] + field.weight[np.ix_(free, fixed)] @ field.distance[alpha, labels[fixed]]
    first, second = np.triu_indices(number, 1)
    weight = field.weight[free[first], free[second]]
    linked = weight > 0.0
    first, second, weight = first[linked], second[linked], weight[linked]
    own = field.distance[labels[free], alpha]
    both = weight * field.distance[labels[free[first]], labels[free[second]]]
    # A pair costs `both` if none changes, `one` if only the second does, `two` if only the first does.
    one, two = weight * own[first], weight * own[second]
    np.add.at(keep, first, both - two)
    np.add.at(keep, second, two)
    between = np.maximum(one + two - both, 0.0)
    tails, heads, sizes = [first], [second], [between]
    source, sink, nodes = number, number + 1, number + 2
    base = np.minimum(keep, take)
    tails += [np.full(number, source), np.arange(number)]
    heads += [np.arange(number), np.full(number, sink)]
    sizes += [take - base, keep - base]
    infinite = 2.0 * float(sum(each.sum() for each in sizes) + field.cost.sum() + 1.0)
    for template in np.unique(field.owner[labels]):
        members = np.flatnonzero(field.owner[labels[free]] == template)
        stays = (field.owner[labels[fixed]] == template).any()
        if template == field.owner[alpha] or stays or not len(members):
            continue
        # The cost applies as long as one of its elements keeps its label.
        tails += [members, np.array([nodes])]
        heads += [np.full(len(members), nodes), np.array([sink])]
        sizes += [np.full(len(members), infinite), field.cost[template : template + 1]]
        nodes += 1
    if not (field.owner[labels] == field.owner[alpha]).any():
        tails += [np.array([source]), np.full(number, nodes)]
        heads += [np.array([nodes]), np.arange(number)]
        sizes += [field.cost[field.owner[alpha]][None], np.full(number, infinite)]
        nodes += 1
    flow: Any = max_flow.SimpleMaxFlow()  # its stubs do not match the shapes of arrays
    scale = _SCALE / infinite
    capacity = np.rint(np.concatenate(sizes) * scale).astype(np.int64)
    first_ends, last_ends = (np.concatenate(each).astype(np.int32) for each in (tails, heads))
    flow.add_arcs_with_capacity(first_ends, last_ends, capacity)
    flow.solve(source, sink)
    stay = np.zeros(nodes, dtype=bool)
    stay[flow.get_source_side_min_cut()] = True
    return ~stay[:number]
