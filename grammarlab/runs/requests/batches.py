"""Batches of a run, each of which is made, recorded and resumed separately."""

from __future__ import annotations

from dataclasses import dataclass

from grammarlab.derivation.lots import Lots
from grammarlab.geometry.outlines.footprints import Footprint, Remark
from grammarlab.language.attribute_values import usable_properties
from grammarlab.language.grammar import Grammar
from grammarlab.runs.requests.request import BATCH_MODELS, SampleRequest


@dataclass(frozen=True, slots=True)
class Batch:
    """Consecutive models of a run, on one or several footprints."""

    index: int
    first_model: int
    num_models: int

    def __str__(self) -> str:
        return f"models {self.first_model} to {self.first_model + self.num_models - 1}"


def cut_batches(request: SampleRequest) -> tuple[Batch, ...]:
    """The batches of a run: model k on footprint f has the index ``f * num_models + k`` under the run's seed."""
    total = request.total_models
    starts = range(0, total, BATCH_MODELS)
    return tuple(Batch(index, first, min(BATCH_MODELS, total - first)) for index, first in enumerate(starts))


def lots_of(request: SampleRequest, batch: Batch, grammar: Grammar) -> Lots:
    """Lots of a batch.

    Properties of a footprint replace attributes, options of the request replace both. Unusable properties have no
    effect (`property_remarks`).
    """
    first, end = batch.first_model, batch.first_model + batch.num_models
    start_rule = request.start_rule or None
    if not request.footprints:
        return Lots.of(
            end - first, request.seed, first_model=first, attributes=request.attributes, start_rule=start_rule
        )
    parts = []
    for number in range(first // request.num_models, (end - 1) // request.num_models + 1):
        footprint = request.footprints[number]
        low, high = max(first, number * request.num_models), min(end, (number + 1) * request.num_models)
        attributes = {**usable_properties(footprint.properties, grammar).values, **request.attributes}
        parts.append(
            Lots.of(
                high - low,
                request.seed,
                first_model=low,
                footprint=footprint.polygon,
                attributes=attributes,
                start_rule=start_rule,
            )
        )
    return Lots.concatenate(parts)


def property_remarks(footprint: Footprint, grammar: Grammar) -> tuple[Remark, ...]:
    """Remarks about properties of a footprint that have the names of attributes, and values that these cannot take."""
    problems = dict(usable_properties(footprint.properties, grammar).problems)
    for name in footprint.unread:
        if name in grammar.attributes and not grammar.attributes[name].constant:
            problems[name] = f"attribute {name!r}: expected a finite number, a text, true or false"
    return tuple(Remark(footprint.name, "property", problem) for problem in problems.values())
