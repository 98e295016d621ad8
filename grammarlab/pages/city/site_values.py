"""What the rules of a building were given beside its outline: attributes of its parcel, and widths of its streets."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.city.sites import Sites
from grammarlab.derivation.state.width_attribute import STREET_WIDTH
from grammarlab.learning.designs.grammar_space import polygon_of_label
from grammarlab.pages.city.rule_words import survey_of
from grammarlab.pages.city.site_labels import SiteLabels
from grammarlab.preference.labels import MAX_TEXT, Label, Labels
from grammarlab.runs.city.zone_rules import ZoneRules

_NEAR = 0.01
"""Metres between the middles of an edge of a label, which is rounded, and of the same edge of its site."""


def with_site_values(site_labels: SiteLabels, plan: Path) -> Labels:
    """Labels with the values that the rules had for the building, so that it is derived as it was shown.

    Args:
        site_labels: labels of one zone, with their footprints.
        plan: file of the plan of the city.

    Raises:
        GrammarlabError: If a file of the plan cannot be used.
    """
    if not any(site_labels.parcels):
        return site_labels.labels
    survey = survey_of(plan)
    row_of = {parcel: row for row, parcel in enumerate(survey.parcels.id[survey.sites.parcel].tolist())}
    rules: dict[int, ZoneRules] = {}
    labels = list[Label]()
    for label, parcel in zip(site_labels.labels, site_labels.parcels, strict=True):
        row = row_of.get(parcel) if parcel else None
        if row is None:
            labels.append(label)
            continue
        zone = int(survey.sites.zone[row])
        if zone not in rules:
            rules[zone] = ZoneRules.of(survey.plan.zones[zone])
        labels.append(_with_values(label, survey.sites, row, rules[zone]))
    return Labels(tuple(labels))


def _with_values(label: Label, sites: Sites, row: int, rules: ZoneRules) -> Label:
    """The label with the values of a site; as it is if they are too long for a label."""
    known = {} if rules.is_park else rules.source.grammar.attributes
    values: dict[str, Any] = {
        name: column.values[row].item()
        for name, column in sites.attributes.items()
        if column.is_given[row] and name in known and not known[name].constant
    }
    widths = sites.footprints.widths(row)
    if widths is not None:
        of_edges = _of_edges(label.footprint, sites.footprints.polygon(row), widths)
        values[STREET_WIDTH] = ";".join(f"{width:g}" for width in of_edges.tolist())
    text = json.dumps(values)
    return replace(label, attributes=text) if len(text) <= MAX_TEXT else label


def _of_edges(footprint: str, corners: Floats, widths: Floats) -> Floats:
    """[m] widths along the edges of the footprint of a label.

    Its corners may begin elsewhere and join its courts in another way than those of the site, and its origin differs.

    Args:
        footprint: footprint of the label.
        corners: [n, 3] corners of the site.
        widths: [n] widths along the edges that leave them.
    """
    ours, theirs = _middles(np.asarray(polygon_of_label(footprint), np.float64)), _middles(corners)
    distance = np.linalg.norm(ours[:, None] - theirs, axis=2)
    return np.where(distance.min(axis=1) < _NEAR, widths[distance.argmin(axis=1)], 0.0)


def _middles(corners: Floats) -> Floats:
    """[n, 2] middles of the edges that leave corners [n, 3], from the lowest coordinates of the corners."""
    plan = corners[:, [0, 2]]
    return (plan + np.roll(plan, -1, axis=0)) / 2 - plan.min(axis=0)
