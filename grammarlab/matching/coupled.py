"""The default method: kinds that share parameters, from the evidence of every element for every size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from grammarlab.matching.corrections import (
    Corrections,
    check_corrections,
    given_sizes,
    left_out,
    united,
    with_sizes,
    with_templates,
)
from grammarlab.matching.elements import Clouds, Elements, Floats, Ints, clouds_of, too_poor
from grammarlab.matching.evidence_maps import Maps, maps_of
from grammarlab.matching.fit import fit_all
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
from grammarlab.matching.strength import find_kinds_with
from grammarlab.matching.template import Template, stack

PARTICLES = 512
_LARGER, _SMALLER = 1.5, 0.6
"""Largest and least candidate sizes, as multiples of the visible ones."""
_NOISE = np.array([0.4, 2.5])
"""Range of the noise of an element, as multiples of the median of all."""
_TOGETHER = 8
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
    reasons = too_poor(elements) | left_out(corrections)
    which = np.array([each for each in range(len(elements)) if each not in reasons], dtype=np.int64)
    if not len(which):
        return assemble(elements, [], reasons, clock.seconds)
    clouds = clouds_of(elements, which)
    fits = fit_all(clouds, stack(templates))
    costs = with_templates(description(clouds, templates, fits), which, templates, corrections)
    used = used_templates(costs)
    odds = _odds(costs[:, [*used.tolist(), -1]])
    clock.lap("fitting")
    best = odds.argmax(axis=1)
    reasons |= unfit(clouds, templates, best == len(used))
    taken = []
    for number, place in enumerate(used.tolist()):
        members = np.flatnonzero(best == number)
        size = fits.parameters[members, place, : len(templates[place].parameters)]
        samples = _samples(clouds, templates[place], members, size, fits.noise[members, place], seed)
        maps = _maps(clouds, members, samples, given_sizes(corrections, which[members]))
        taken.append((place, members, samples, with_sizes(maps, which[members], corrections) if corrections else maps))
    clock.lap("evidence")
    parts = []
    for number, (place, members, samples, maps) in enumerate(taken):
        inside = which[members]
        solution, rounds = find_kinds_with(maps, elements.row[inside], elements.column[inside])
        solution = replace(solution, posterior=united(solution.posterior, inside, corrections))
        sure = odds[members, number]
        hidden = fits.hidden[members, place]
        middle = clouds.middle[members]
        parts.append(
            TemplateGroup(
                template=templates[place],
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


def _odds(costs: Floats) -> Floats:
    odds = np.exp(costs.min(axis=1, keepdims=True) - costs)
    return odds / odds.sum(axis=1, keepdims=True)


def _samples(
    clouds: Clouds, template: Template, members: Ints, sizes: Floats, noise: Floats, seed: int
) -> ParticleSamples:
    """Posterior samples of the parameters of some elements, within a range from the largest and smallest sizes."""
    low = np.maximum(template.low, 0.1 * template.low)
    high = template.high.copy()
    low[:2] = np.maximum(_SMALLER * sizes[:, :2].min(axis=0), 1e-3)
    high[:2] = np.maximum(_LARGER * sizes[:, :2].max(axis=0), 1.2 * low[:2])
    limits = template.limits if len(template.limits) else np.zeros((1, 1 + len(template.parameters)))
    numbers = (low, high, limits, np.median(noise) * _NOISE)
    bounds = Bounds(*(jnp.asarray(each, jnp.float32) for each in numbers))
    columns = (clouds.points, clouds.weight, clouds.area, clouds.reach)
    pieces = jnp.asarray(template.pieces, jnp.float32)
    found = []
    for first in range(0, len(members), _TOGETHER):
        which = slice(first, first + _TOGETHER)
        task = CenteredElement(*(jnp.asarray(_filled(each[members[which]]), jnp.float32) for each in columns))
        drawn = sample(_draws(_filled(clouds.element[members[which]]), len(low), seed), task, bounds, pieces)
        found.append([np.asarray(each, dtype=np.float64) for each in drawn])
    return ParticleSamples(*(np.concatenate(each)[: len(members)] for each in zip(*found, strict=True)))


def _filled(rows: NDArray[Any]) -> NDArray[Any]:
    """Rows repeated up to a whole batch."""
    return rows[np.arange(_TOGETHER) % len(rows)]


def _draws(element: Ints, size: int, seed: int) -> ParticleDraws:
    """Random numbers by seed and element, so that they do not depend on other elements of the scan."""
    begin, moves = num_draws(size)
    shapes = ((PARTICLES, begin), (STEPS,), (STEPS, PARTICLES, moves))
    drawn = []
    for each in element.tolist():
        random = np.random.Generator(np.random.Philox(key=np.array([seed, each], dtype=np.uint64)))
        drawn.append([random.random(shape, dtype=np.float32) for shape in shapes])
    return ParticleDraws(*(jnp.asarray(np.stack(each)) for each in zip(*drawn, strict=True)))


def _maps(clouds: Clouds, members: Ints, samples: ParticleSamples, given: Sequence[tuple[int, float]]) -> Maps:
    """Evidence maps within the range of the samples and of given sizes: axis and metres."""
    sizes = np.asarray(samples.parameters)[:, :, :2]
    points = clouds.weight[members].sum(axis=1)
    error = np.asarray(samples.noise).mean(axis=1) * np.sqrt(8.0 / np.maximum(points, 8.0))
    low, high = sizes.min(axis=(0, 1)), sizes.max(axis=(0, 1)) + 1e-6
    for axis, value in given:
        low[axis], high[axis] = min(low[axis], value), max(high[axis], value)
    return maps_of(sizes, error, low, high)
