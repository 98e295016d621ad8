"""Labels of buildings on parcels: their addresses with the ground that they are built on."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import shapely

from grammarlab.city.parcel_addresses import model_indices
from grammarlab.city.plan import FieldFormula, ZonePlan
from grammarlab.learning.designs.addresses import Address, hashes_of
from grammarlab.pages.city.parcel_facts import ParcelFacts
from grammarlab.pages.record.judgements import Scores
from grammarlab.preference.labels import MAX_TEXT, Label, Labels


@dataclass(frozen=True, slots=True)
class SiteLabels:
    """Labels of a zone."""

    labels: Labels
    """[n] labels."""
    parcels: tuple[str, ...]
    """[n] id of the parcel of each; empty for models of the pool."""


def site_labels(facts: ParcelFacts, zone: ZonePlan, factors: Mapping[str, Scores], grammar: str) -> SiteLabels:
    """Labels of all scores of single models in a session of a zone.

    A building that stands on a parcel now, or stood there before it was rerolled, is labelled with its footprint and
    with the attributes that the plan gives to all buildings of the zone; `grammarlab.pages.city.site_values` adds those
    of its parcel. All other models are those of the pool.

    Args:
        facts: the parcels.
        zone: their zone.
        factors: scores of the session by factor.
        grammar: SHA-256 of the text of its grammar.
    """
    hashes = hashes_of(grammar)
    parcels = _parcels_of_models(facts)
    attributes = json.dumps(
        {name: value for name, value in zone.attributes.items() if not isinstance(value, FieldFormula)}
    )
    labels, ids = list[Label](), list[str]()
    for factor, scores in factors.items():
        for subject, judgement in scores.items():
            if " " in subject:
                continue
            address = Address.parse(subject)
            label = replace(address.label(factor, judgement.score, hashes), kind=judgement.kind)
            row = None if address.flat else parcels.get((address.seed, address.model))
            placed = None if row is None else _on_parcel(label, facts, row, zone.start, attributes)
            labels.append(placed or label)
            ids.append("" if row is None or placed is None else facts.rows.id[row])
    return SiteLabels(Labels(tuple(labels)), tuple(ids))


def _parcels_of_models(facts: ParcelFacts) -> dict[tuple[int, int], int]:
    """Rows of parcels by the address of their present and former buildings."""
    seeds, models = facts.rows.seed.tolist(), facts.rows.model.tolist()
    rows: dict[tuple[int, int], int] = {}
    for row in np.flatnonzero(facts.rows.reroll > 0).tolist():
        former = np.arange(facts.rows.reroll[row])
        for model in model_indices([facts.rows.id[row]] * len(former), former).tolist():
            rows[seeds[row], model] = row
    return rows | {address: row for row, address in enumerate(zip(seeds, models, strict=True))}


def _on_parcel(label: Label, facts: ParcelFacts, row: int, start: str, attributes: str) -> Label | None:
    """The label with the footprint of a parcel; None if that is unknown or has too many corners."""
    outline = facts.rows.lot[row]
    if outline is None:
        return None
    corner = np.floor(np.array(outline.bounds[:2]))
    text = shapely.to_wkt(shapely.transform(outline, lambda points: points - corner), 3)
    if len(text) > MAX_TEXT:
        return None
    return replace(label, footprint=text, start_rule=start, attributes=attributes)


def liked(scores: Scores) -> bool:
    """Whether a score can be learned from: one building at least is liked."""
    return any(judgement.is_positive for judgement in scores.values())
