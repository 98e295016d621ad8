"""Labelling by alpha expansion: against brute force and CP-SAT."""

from itertools import product

import numpy as np
import pytest
from ortools.sat.python import cp_model

from grammarlab.matching.paper_labelling import Field, energy, label
from tests.cases import some


def _field(elements: int, labels: int, seed: int, cost: float) -> Field:
    random = np.random.default_rng(seed)
    place, owner = random.normal(size=(labels, 2)), random.integers(3, size=labels)
    away = np.minimum(np.linalg.norm(place[:, None] - place[None], axis=2), 1.6)
    distance = np.where(owner[:, None] == owner[None], away, 0.8)
    weight = np.triu(random.uniform(0.0, 0.1, size=(elements, elements)), 1)
    data = random.uniform(size=(elements, labels))
    return Field(data, weight + weight.T, distance, owner, np.full(3, cost))


def _optimum(field: Field) -> float:
    """The least energy, by CP-SAT in millionths."""
    model, scale = cp_model.CpModel(), 10**6
    elements, labels = field.data.shape
    takes = [[model.new_bool_var("") for _ in range(labels)] for _ in range(elements)]
    used = [model.new_bool_var("") for _ in field.cost]
    total = sum(round(scale * cost) * each for cost, each in zip(field.cost.tolist(), used, strict=True))
    for i in range(elements):
        model.add_exactly_one(takes[i])
        total += sum(round(scale * field.data[i, own]) * takes[i][own] for own in range(labels))
        for own in range(labels):
            model.add_implication(takes[i][own], used[field.owner[own]])
        for k in range(i):
            between = model.new_int_var(0, scale, "")
            for own in range(labels):
                row = field.weight[i, k] * field.distance[own]
                cost = sum(round(scale * each) * takes[k][other] for other, each in enumerate(row.tolist()))
                model.add(between >= cost).only_enforce_if(takes[i][own])
            total += between
    model.minimize(total)
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    assert solver.solve(model) == cp_model.OPTIMAL
    return solver.objective_value / scale


@pytest.mark.parametrize(("elements", "seed"), some([(8, 0), (10, 1), (12, 2)]))
def test_labels_of_few_elements_have_the_least_energy(elements, seed):
    field = _field(elements, 6, seed, cost=0.3)
    assert label(field)[1][-1] == pytest.approx(_optimum(field), abs=1e-4)


@pytest.mark.parametrize("seed", range(25))
def test_labels_are_those_of_least_energy(seed):
    field = _field(4, 6, seed, cost=0.02 * seed)
    labels, energies = label(field)
    best = min(energy(field, np.array(each)) for each in product(range(6), repeat=4))
    assert energies[-1] == pytest.approx(best, abs=1e-9)
    assert energy(field, labels) == pytest.approx(energies[-1])
    assert (np.diff(energies) <= 0.0).all()


def test_a_cost_of_templates_makes_them_fewer_and_energies_never_rise():
    used = []
    for cost in (0.0, 0.3, 100.0):
        field = _field(30, 40, 5, cost)
        labels, energies = label(field)
        assert (np.diff(energies) <= 0.0).all()
        used.append(len(np.unique(field.owner[labels])))
    assert used[0] >= used[1] >= used[2] == 1
