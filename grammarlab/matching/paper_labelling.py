"""Labels of elements by a Markov random field with label costs (paper 001, Equation 5.3).

sum_i D_i(l_i) + sum_{i<k} w_ik V(l_i, l_k) + sum over used templates of their cost is minimised by alpha expansion:
each move changes any elements to one label, and the best such move is a minimum cut (Boykov, Veksler and Zabih 2001;
label costs: Delong, Osokin, Isack and Boykov 2012). V has to be a metric. Expansions end in a local optimum; the least
energy of few elements is proven by CP-SAT.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from grammarlab.arrays import Floats, Ints

_MAX_EXACT_ELEMENTS = 12
"""Largest number of elements for which the least energy is proven."""
_MAX_INTEGER_ENERGY = 1e6
"""Integer energy of the largest energy of one element, for the solver."""
_TIME_LIMIT = 10.0
"""Deterministic time limit of the solver, about a second per unit; equal on any machine."""
_CAPACITY_SCALE = 1 << 40
"""Integer scale of capacities; the sum of all costs of a cut stays far below 2^63."""


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


def label(field: Field) -> tuple[Ints, list[float]]:
    """Labels [N] of low energy, the least one for few elements, and the energies after each move, which never rise."""
    labels, energies = _expanded(field, field.data.argmin(axis=1))
    if len(field.data) > _MAX_EXACT_ELEMENTS:
        return labels, energies
    better, more = _expanded(field, _least_energy_labels(field, labels))
    return (better, [*energies, more[-1]]) if more[-1] < energies[-1] else (labels, energies)


def energy(field: Field, labels: Ints) -> float:
    """Equation 5.3 for labels [N]."""
    data = field.data[np.arange(len(labels)), labels].sum()
    smooth = (field.weight * field.distance[np.ix_(labels, labels)]).sum() / 2.0
    return float(data + smooth + field.cost[np.unique(field.owner[labels])].sum())


def _expanded(field: Field, start: Ints) -> tuple[Ints, list[float]]:
    """Labels after expansions to every label, until none lowers the energy."""
    labels, energies = start.copy(), [energy(field, start)]
    idle = 0
    while idle < field.data.shape[1]:
        for alpha in range(field.data.shape[1]):
            moved = _expand(field, labels, alpha)
            moved_energy = energies[-1] if moved is None else energy(field, moved)
            if moved is not None and moved_energy < energies[-1] - 1e-12:
                labels, idle = moved, 0
                energies.append(moved_energy)
            else:
                idle += 1
            if idle >= field.data.shape[1]:
                break
    return labels, energies


def _expand(field: Field, labels: Ints, alpha: int) -> Ints | None:
    """Labels after the best move to one label; None if no element changes."""
    free = _undecided(field, labels, alpha)
    if not len(free):
        return None
    is_moved = _cut(field, labels, alpha, free)
    if not is_moved.any():
        return None
    moved = labels.copy()
    moved[free[is_moved]] = alpha
    return moved


def _undecided(field: Field, labels: Ints, alpha: int) -> Ints:
    """Elements that may change to a label in the best move; others would not gain even if all of these changed."""
    indices = np.arange(len(labels))
    current_cost, alpha_cost = field.data[indices, labels], field.data[:, alpha]
    saved = np.where(field.owner[labels] != field.owner[alpha], field.cost[field.owner[labels]], 0.0)
    alpha_distance = field.distance[labels, alpha]
    free = labels != alpha
    away = field.weight * field.distance[np.ix_(labels, labels)]
    while free.any():
        # With the free elements at alpha: the costs of keeping a label, and of changing it.
        keep = current_cost + (field.weight[:, free].sum(axis=1)) * alpha_distance + away[:, ~free].sum(axis=1)
        take = alpha_cost + field.weight[:, ~free] @ alpha_distance[~free]
        is_gaining = free & (take < keep + saved)
        if (is_gaining == free).all():
            break
        free = is_gaining
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
    alpha_distance = field.distance[labels[free], alpha]
    both = weight * field.distance[labels[free[first]], labels[free[second]]]
    # A pair costs `both` if none changes, `second_only` if only the second does, `first_only` if only the first does.
    second_only, first_only = weight * alpha_distance[first], weight * alpha_distance[second]
    np.add.at(keep, first, both - first_only)
    np.add.at(keep, second, first_only)
    between = np.maximum(second_only + first_only - both, 0.0)
    tails, heads, sizes = [first], [second], [between]
    source, sink, nodes = number, number + 1, number + 2
    base = np.minimum(keep, take)
    tails += [np.full(number, source), np.arange(number)]
    heads += [np.arange(number), np.full(number, sink)]
    sizes += [take - base, keep - base]
    infinite = 2.0 * float(sum(size.sum() for size in sizes) + field.cost.sum() + 1.0)
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
    scale = _CAPACITY_SCALE / infinite
    capacity = np.rint(np.concatenate(sizes) * scale).astype(np.int64)
    first_ends, last_ends = (np.concatenate(ends).astype(np.int32) for ends in (tails, heads))
    flow.add_arcs_with_capacity(first_ends, last_ends, capacity)
    flow.solve(source, sink)
    stay = np.zeros(nodes, dtype=bool)
    stay[flow.get_source_side_min_cut()] = True
    return ~stay[:number]


def _least_energy_labels(field: Field, start: Ints) -> Ints:
    """Labels [N] of the least energy, or of the lowest one found within the time limit.

    Args:
        field: the field, of few elements.
        start: [N] initial labels.
    """
    from ortools.sat.python import cp_model  # noqa: PLC0415 an extra

    model, (elements, labels) = cp_model.CpModel(), field.data.shape
    highest = max(float(field.data.max()), float(field.distance.max() * field.weight.max()), 1e-300)
    scale = _MAX_INTEGER_ENERGY / highest

    def integers(costs: Floats) -> list[Any]:
        return np.rint(np.minimum(costs, elements * highest) * scale).astype(np.int64).tolist()

    takes = [[model.new_bool_var("") for _ in range(labels)] for _ in range(elements)]
    used = [model.new_bool_var("") for _ in field.cost]
    terms, factors = list(used), integers(field.cost)
    for element in range(elements):
        model.add_exactly_one(takes[element])
        terms += takes[element]
        factors += integers(field.data[element])
        for label in range(labels):
            model.add_implication(takes[element][label], used[field.owner[label]])
            model.add_hint(takes[element][label], label == start[element])
        for other in range(element):
            costs = integers(field.weight[element, other] * field.distance)
            between = model.new_int_var(0, max(max(row) for row in costs), "")
            for label in range(labels):
                distance = cp_model.LinearExpr.weighted_sum(takes[other], costs[label])
                model.add(between >= distance).only_enforce_if(takes[element][label])
            terms.append(between)
            factors.append(1)
    model.minimize(cp_model.LinearExpr.weighted_sum(terms, factors))
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    solver.parameters.max_deterministic_time = _TIME_LIMIT
    if solver.solve(model) not in {cp_model.OPTIMAL, cp_model.FEASIBLE}:
        return start
    return np.array([[solver.value(take) for take in row] for row in takes]).argmax(axis=1)
