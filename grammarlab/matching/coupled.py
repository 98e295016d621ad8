"""The default method: kinds that share parameters, from the evidence of every element for every size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any

import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.matching.corrections import (
    Corrections,
    check_corrections,
    fixed_sizes,
    ignored_elements,
    united,
    with_sizes,
    with_templates,
)
from grammarlab.matching.elements import Clouds, Elements, clouds_of, too_poor
from grammarlab.matching.evidence_maps import Maps, maps_of
from grammarlab.matching.fit import Fits, fit_all
from grammarlab.matching.match import Clock, Match
from grammarlab.matching.match_assembly import TemplateGroup, assemble
from grammarlab.matching.particles import (
    STEPS,
    Bounds,
    CenteredElement,
    ParticleDraws,
    ParticleSamples,
    num_draws,
    sample,
)
from grammarlab.matching.plain import description, unfit, used_templates
from grammarlab.matching.strength import find_kinds_with, with_bias
from grammarlab.matching.template import Template, stack

PARTICLES = 512
_MAX_SIZE_RATIO, _MIN_SIZE_RATIO = 1.5, 0.6
"""Largest and least candidate sizes, as multiples of the visible ones."""
_NOISE_RANGE = np.array([0.4, 2.5])
"""Range of the noise of an element, as multiples of the median of all."""
_BATCH_SIZE = 8
"""Number of elements of a batch; all batches have this size, so that only one is compiled."""


def couple(elements: Elements, templates: Sequence[Template], seed: int, corrections: Corrections = ()) -> Match:
    """Kinds of elements, from the joint evidence of all elements.

    Args:
        elements: the elements.
        templates: the possible templates.
        seed: seed of the samples.
        corrections: corrections of the elements.

    Raises:
        FacadeError: If corrections have unknown elements or templates, or contradict each other.
    """
    clock = Clock()
    check_corrections(corrections, len(elements), templates)
    reasons = too_poor(elements) | ignored_elements(corrections)
    indices = np.array([element for element in range(len(elements)) if element not in reasons], dtype=np.int64)
    if not len(indices):
        return assemble(elements, [], reasons, clock.seconds)
    clouds = clouds_of(elements, indices)
    fits = _fits(elements, clouds, templates)
    costs = with_templates(description(clouds, templates, fits), indices, templates, corrections)
    used = used_templates(costs)
    odds = _odds(costs[:, [*used.tolist(), -1]])
    clock.lap("fitting")
    best = odds.argmax(axis=1)
    reasons |= unfit(clouds, templates, best == len(used))
    evidence = []
    for number, template_index in enumerate(used.tolist()):
        members = np.flatnonzero(best == number)
        size = fits.parameters[members, template_index, : len(templates[template_index].parameters)]
        samples = _samples(clouds, templates[template_index], members, size, fits.noise[members, template_index], seed)
        maps = _maps(clouds, members, samples, fixed_sizes(corrections, indices[members]))
        evidence.append((template_index, members, samples, maps))
    clock.lap("evidence")
    parts = []
    for number, (template_index, members, samples, raw) in enumerate(evidence):
        inside = indices[members]
        maps = with_bias(raw, lambda maps, inside=inside: _corrected(maps, inside, corrections))
        solution, rounds = find_kinds_with(maps, elements.row[inside], elements.column[inside])
        solution = replace(solution, posterior=united(solution.posterior, inside, corrections))
        sure = odds[members, number]
        hidden = fits.hidden[members, template_index]
        middle = clouds.middle[members]
        parts.append(
            TemplateGroup(
                template=templates[template_index],
                element=inside,
                middle=middle,
                sure=sure,
                hidden=hidden,
                samples=samples,
                maps=maps,
                solution=solution,
                rounds=rounds,
            )
        )
    clock.lap("kinds")
    return assemble(elements, parts, reasons, clock.seconds)


def _fits(elements: Elements, clouds: Clouds, templates: Sequence[Template]) -> Fits:
    """Fits of single elements; those unlike their row are fitted again, from the parameters of the others.

    A fit from usual proportions may stop at a nearby optimum, such as a transom at the upper side, and an element that
    is partly hidden does so more often.
    """
    stacked = stack(templates)
    fits = fit_all(clouds, stacked)
    best = description(clouds, templates, fits)[:, :-1].argmin(axis=1)
    unlike = unlike_row(elements.row[clouds.element], best)
    # Only templates of other elements, since fits of the others would start as they did.
    known = np.unique(np.delete(best, unlike))
    if stacked.usual.shape[1] == 2 or not len(unlike) or not len(known):
        return fits
    usual = stacked.usual.copy()
    for template in known.tolist():
        members = np.setdiff1d(np.flatnonzero(best == template), unlike)
        usual[template] = np.median(fits.parameters[members, template], axis=0)
    stacked = replace(stacked, usual=usual).subset(known)
    some, chosen = clouds_of(elements, clouds.element[unlike]), [templates[index] for index in known.tolist()]
    block = np.ix_(unlike, known)
    best_fits = Fits(**{field.name: getattr(fits, field.name)[block] for field in fields(Fits)})
    for corner in (0.0, -1.0):
        again = fit_all(some, replace(stacked, guess=np.full(len(known), corner)))
        best_fits = _better(some, chosen, best_fits, again)
    for field in fields(Fits):
        getattr(fits, field.name)[block] = getattr(best_fits, field.name)
    return fits


def _better(clouds: Clouds, templates: Sequence[Template], first: Fits, second: Fits) -> Fits:
    """Of two fits of each template to each element, those of the shorter description."""
    lengths = [description(clouds, templates, fits)[:, :-1] for fits in (first, second)]
    better = lengths[1] < lengths[0]
    columns = {}
    for field in fields(Fits):
        before, after = getattr(first, field.name), getattr(second, field.name)
        columns[field.name] = np.where(better.reshape(*better.shape, *(1,) * (before.ndim - 2)), after, before)
    return Fits(**columns)


def unlike_row(row: Ints, template: Ints) -> Ints:
    """Indices of the elements of rows whose template [N] is not the most frequent one of their row."""
    usual = template.copy()
    for each in np.unique(row[row >= 0]).tolist():
        usual[row == each] = np.bincount(template[row == each]).argmax()
    return np.flatnonzero(template != usual)


def _corrected(maps: Maps, indices: Ints, corrections: Corrections) -> Maps:
    return with_sizes(maps, indices, corrections) if corrections else maps


def _odds(costs: Floats) -> Floats:
    odds = np.exp(costs.min(axis=1, keepdims=True) - costs)
    return odds / odds.sum(axis=1, keepdims=True)


def _samples(
    clouds: Clouds, template: Template, members: Ints, sizes: Floats, noise: Floats, seed: int
) -> ParticleSamples:
    """Posterior samples of the parameters of some elements, within a range from the largest and smallest sizes."""
    low = np.maximum(template.low, 0.1 * template.low)
    high = template.high.copy()
    low[:2] = np.maximum(_MIN_SIZE_RATIO * sizes[:, :2].min(axis=0), 1e-3)
    high[:2] = np.maximum(_MAX_SIZE_RATIO * sizes[:, :2].max(axis=0), 1.2 * low[:2])
    limits = template.limits if len(template.limits) else np.zeros((1, 1 + len(template.parameters)))
    numbers = (low, high, limits, np.median(noise) * _NOISE_RANGE)
    bounds = Bounds(*(jnp.asarray(values, jnp.float32) for values in numbers))
    columns = (clouds.points, clouds.weight, clouds.area, clouds.reach)
    pieces = jnp.asarray(template.pieces, jnp.float32)
    batches = []
    for first in range(0, len(members), _BATCH_SIZE):
        batch = slice(first, first + _BATCH_SIZE)
        task = CenteredElement(*(jnp.asarray(_filled(column[members[batch]]), jnp.float32) for column in columns))
        drawn = sample(_draws(_filled(clouds.element[members[batch]]), len(low), seed), task, bounds, pieces)
        batches.append([np.asarray(column, dtype=np.float64) for column in drawn])
    return ParticleSamples(*(np.concatenate(column)[: len(members)] for column in zip(*batches, strict=True)))


def _filled(rows: NDArray[Any]) -> NDArray[Any]:
    """Rows repeated up to a whole batch."""
    return rows[np.arange(_BATCH_SIZE) % len(rows)]


def _draws(element: Ints, size: int, seed: int) -> ParticleDraws:
    """Random numbers by seed and element, so that they do not depend on other elements of the scan."""
    begin, moves = num_draws(size)
    shapes = ((PARTICLES, begin), (STEPS,), (STEPS, PARTICLES, moves))
    drawn = []
    for index in element.tolist():
        random = np.random.Generator(np.random.Philox(key=np.array([seed, index], dtype=np.uint64)))
        drawn.append([random.random(shape, dtype=np.float32) for shape in shapes])
    return ParticleDraws(*(jnp.asarray(np.stack(column)) for column in zip(*drawn, strict=True)))


def _maps(clouds: Clouds, members: Ints, samples: ParticleSamples, fixed: Sequence[tuple[int, float]]) -> Maps:
    """Evidence maps within the range of the samples and of given sizes: axis and metres."""
    sizes = np.asarray(samples.parameters)[:, :, :2]
    points = clouds.weight[members].sum(axis=1)
    error = np.asarray(samples.noise).mean(axis=1) * np.sqrt(8.0 / np.maximum(points, 8.0))
    low, high = sizes.min(axis=(0, 1)), sizes.max(axis=(0, 1)) + 1e-6
    for axis, value in fixed:
        low[axis], high[axis] = min(low[axis], value), max(high[axis], value)
    return maps_of(sizes, error, low, high)
