"""A match from the kinds of each template: parameters of elements and kinds, with standard deviations.

Elements have common parameters by the threshold of the paper (section 5.4.4).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from grammarlab.arrays import Floats, Ints
from grammarlab.matching.elements import Elements
from grammarlab.matching.evidence_maps import Maps
from grammarlab.matching.match import UNKNOWN, Match
from grammarlab.matching.particles import ParticleSamples
from grammarlab.matching.shared_kinds import Solution
from grammarlab.matching.template import Template

_THRESHOLD_RATIO = 0.005
"""Similarity threshold of the paper, as a fraction of the largest diagonal of a box."""
_MIN_SPREAD_M = 5e-4
"""Least standard deviation, metres, due to the grid and the samples."""


@dataclass(frozen=True, eq=False, kw_only=True)
class TemplateGroup:
    """The M elements of one template, and their kinds."""

    template: Template
    element: Ints
    """[M] index of each element among all."""
    middle: Floats
    """[M, 2] centres of the boxes."""
    sure: Floats
    """[M] probability of the template."""
    hidden: Floats
    """[M] hidden fraction of the outline."""
    samples: ParticleSamples
    maps: Maps
    solution: Solution
    rounds: int


def similarity_threshold(elements: Elements) -> float:
    """Difference of parameters below which two elements are similar, metres."""
    return _THRESHOLD_RATIO * float(np.linalg.norm(elements.high - elements.low, axis=1).max())


def couplings(owner: Ints, values: Floats, used: Floats, threshold: float) -> Floats:
    """[T, D, N, N] couplings of Equation 5.4: for elements of one template, and for replicas in all templates.

    Args:
        owner: [N] template of each element.
        values: [N, D] parameters of its label.
        used: [T, D] 1 for the parameters of a template.
        threshold: largest difference, metres.
    """
    number = len(owner)
    near = _close(values, threshold)
    same = (owner[:, None] == owner[None]) & ~np.eye(number, dtype=bool)
    replica = near.all(axis=0) & same
    coupled = np.zeros((len(used), values.shape[1], number, number))
    for template in range(len(used)):
        members = same & (owner == template)[:, None]
        coupled[template] = (near & members) | replica
        coupled[template] *= used[template][:, None, None]
    return coupled


def replicas(owner: Ints, values: Floats, threshold: float) -> Ints:
    """[N] kind of each element, from 0: connected components of replicas."""
    near = _close(values, threshold).all(axis=0) & (owner[:, None] == owner[None])
    return connected_components(csr_matrix(near), directed=False)[1].astype(np.int64)


def assemble(
    elements: Elements, parts: Sequence[TemplateGroup], reasons: Mapping[int, str], seconds: Mapping[str, float]
) -> Match:
    """The match from the kinds of all templates; for each template, the kinds with most elements come first."""
    number = len(elements)
    kind = np.full(number, UNKNOWN, dtype=np.int64)
    parameters: list[Floats] = [np.zeros(0)] * number
    deviations: list[Floats] = [np.zeros(0)] * number
    corner, hidden = elements.low.copy(), np.zeros(number)
    total = sum(len(part.solution.kinds) for part in parts)
    posterior = np.zeros((number, total + 1))
    posterior[:, -1] = 1.0
    values: list[Floats] = []
    spreads: list[Floats] = []
    template: list[int] = []
    all_reasons = dict(reasons)
    for index, part in enumerate(parts):
        first = len(values)
        part_values, part_spreads = _kind_values(part)
        part_spreads = [np.hypot(spread, elements.common_error) for spread in part_spreads]
        values += part_values
        spreads += part_spreads
        template += [index] * len(part_values)
        chance = part.solution.posterior * part.sure[:, None]
        posterior[part.element] = 0.0
        posterior[part.element, first : first + len(part_values)] = chance[:, :-1]
        posterior[part.element, -1] = 1.0 - chance[:, :-1].sum(axis=1)
        hidden[part.element] = part.hidden
        for row, element in enumerate(part.element.tolist()):
            best = int(part.solution.posterior[row].argmax())
            if best == len(part_values):
                all_reasons[element] = "its size matches no kind, and is too uncertain for a kind of its own"
                continue
            kind[element] = first + best
            parameters[element] = part_values[best]
            deviations[element] = _deviation(part.solution.posterior[row, :-1], best, part_values, part_spreads)
            corner[element] = part.middle[row] + _corner(part.samples, row, part_values[best])
    return Match(
        elements=elements,
        templates=tuple(part.template for part in parts),
        kind=kind,
        kind_template=np.array(template, dtype=np.int64),
        values=tuple(values),
        spread=tuple(spreads),
        posterior=posterior,
        parameters=tuple(parameters),
        deviations=tuple(deviations),
        corner=corner,
        hidden=hidden,
        reasons=all_reasons,
        iterations=sum(part.rounds for part in parts),
        seconds=dict(seconds),
    )


def _close(values: Floats, threshold: float) -> np.ndarray:
    """[D, N, N] c: whether parameters [N, D] of two elements differ by less than a threshold."""
    moved = values.T
    return np.abs(moved[:, :, None] - moved[:, None, :]) < threshold


def _kind_values(part: TemplateGroup) -> tuple[list[Floats], list[Floats]]:
    """Parameters [K] [D] of each kind and their standard deviations, from all elements that share them."""
    kinds = part.solution.kinds
    weight = part.solution.posterior[:, :-1]
    size = np.asarray(part.samples.parameters).shape[2]
    values = np.zeros((len(kinds), size))
    spreads = np.zeros((len(kinds), size))
    for axis, (index, sizes) in enumerate(((kinds.width, part.maps.widths), (kinds.height, part.maps.heights))):
        for value in np.unique(index):
            members = np.flatnonzero(index == value)
            if axis == 0:
                score = sum(weight[:, k] @ part.maps.logs_by_height[kinds.height[k]] for k in members)
            else:
                score = sum(weight[:, k] @ part.maps.logs_by_width[kinds.width[k]] for k in members)
            values[members, axis], spreads[members, axis] = _peak(np.asarray(score), sizes, int(value))
    for k in range(len(kinds)):
        values[k, 2:], spreads[k, 2:] = _further(part.samples, weight[:, k], values[k])
    return list(values), list(spreads)


def _peak(score: Floats, sizes: Floats, value: int) -> tuple[float, float]:
    """Mean and standard deviation of a value near its index, of an unnormalised log-density on its axis."""
    near = np.abs(np.arange(len(sizes)) - value) <= 8
    chance = np.where(near, np.exp(np.minimum(score - score[value], 50.0)), 0.0)
    chance /= chance.sum()
    mean = float(chance @ sizes)
    step = sizes[1] - sizes[0]
    return mean, float(np.sqrt(chance @ (sizes - mean) ** 2 + step**2 / 12.0 + _MIN_SPREAD_M**2))


def _further(samples: ParticleSamples, weight: Floats, value: Floats) -> tuple[Floats, Floats]:
    """Means [D - 2] and standard deviations of further parameters of a kind; precise elements have more weight."""
    drawn = np.asarray(samples.parameters)[:, :, 2:]
    if not drawn.shape[2]:
        return np.zeros(0), np.zeros(0)
    near = _nearness(samples, value)
    mean = (near[:, :, None] * drawn).sum(axis=1)
    variance = (near[:, :, None] * (drawn - mean[:, None]) ** 2).sum(axis=1) + _MIN_SPREAD_M**2
    precision = weight[:, None] / variance
    total = np.maximum(precision.sum(axis=0), 1e-9)
    return (precision * mean).sum(axis=0) / total, np.sqrt(1.0 / total)


def _nearness(samples: ParticleSamples, value: Floats) -> Floats:
    """[M, Q] normalised weights of samples, by the distance of their width and height from those of a kind."""
    away = np.asarray(samples.parameters)[:, :, :2] - value[:2]
    scale = np.maximum(np.asarray(samples.noise).mean(axis=1), 1e-3)[:, None]
    square = 0.5 * ((away / scale[:, :, None]) ** 2).sum(axis=2)
    near = np.exp(square.min(axis=1, keepdims=True) - square)
    return near / near.sum(axis=1, keepdims=True)


def _deviation(chance: Floats, best: int, values: Sequence[Floats], spreads: Sequence[Floats]) -> Floats:
    """Standard deviations [D] of an element's parameters around its kind, over all possible kinds."""
    chance = chance / max(float(chance.sum()), 1e-12)
    away = np.array(values) - values[best]
    return np.sqrt(chance @ (away**2 + np.array(spreads) ** 2))


def _corner(samples: ParticleSamples, row: int, value: Floats) -> Floats:
    """[2] lower left corner of an element with the size of a kind, relative to the centre of its box."""
    single = ParticleSamples(*(np.asarray(column)[row : row + 1] for column in samples))
    return _nearness(single, value)[0] @ np.asarray(samples.corner)[row]
