"""Labels of buildings describe them as they were built: with the attributes of their parcels, and their streets."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from grammarlab.city.plan import read_plan
from grammarlab.errors import UsageError
from grammarlab.learning.designs.addresses import Address, hashes_of
from grammarlab.learning.designs.grammar_space import GrammarSpace, widths_of_label
from grammarlab.pages.city.parcel_facts import ParcelFacts
from grammarlab.pages.city.site_labels import site_labels
from grammarlab.pages.city.site_values import with_site_values
from grammarlab.pages.record.judgements import Judgement
from grammarlab.runs.city.build import build_city
from grammarlab.runs.city.survey import surveyed
from grammarlab.runs.city.zone_rules import ZoneRules

RULES = """
attr floors = 2.0
attr streetWidth = 0
@StartRule
Lot --> extrude(3 * floors + rand(0, 0.5)) comp(f) { street.front : Front. | side : Wall. | top : Roof. }
        report("width", streetWidth)
"""
PLAN = """
[layout]
size = "160x120"
[layout.parcels]
area = 1500
[ring]
depth = 10
[[zones]]
name = "{zone}"
grammar = "rules.cga"
footprint = "{footprint}"
attributes = {{ floors = "= 1 + area / 300" }}
"""


@pytest.mark.parametrize("footprint", ["setback", "ring"])
def test_a_labelled_building_is_derived_as_it_was_built(tmp_path: Path, footprint: str):
    (tmp_path / "rules.cga").write_text(RULES)
    plan = tmp_path / "plan.toml"
    plan.write_text(PLAN.format(zone="all", footprint=footprint))
    build_city(plan, tmp_path / "city")
    facts = ParcelFacts.read(tmp_path / "city")
    read = read_plan(plan)
    rules = ZoneRules.of(read.zones[0])
    models = {
        str(Address(False, *facts.address_of(parcel))): parcel for parcel in facts.rows.id[facts.is_built].tolist()
    }
    scores = dict.fromkeys(models, Judgement(80.0))
    made = site_labels(facts, read.zones[0], {"overall": scores}, rules.hash)
    labels = with_site_values(made, plan)
    space = GrammarSpace(rules.source.grammar)
    survey = surveyed(read, (rules,))
    assert footprint != "ring" or any("), (" in label.footprint for label in labels)
    for label, parcel in zip(labels, made.parcels, strict=True):
        row = int(np.flatnonzero(survey.parcels.id[survey.sites.parcel] == parcel)[0])
        values = json.loads(label.attributes)
        assert values["floors"] == pytest.approx(1 + survey.parcels.area[survey.sites.parcel[row]] / 300)
        again = space.derive([Address.of(label, hashes_of(rules.hash))])
        built = rules.source.derive(survey.sites.take(np.array([row])).lots()).forest
        names = [[forest.symbols[symbol] for symbol in forest.nodes.symbol.tolist()] for forest in (again, built)]
        assert sorted(names[0]) == sorted(names[1])
        assert "Front" in " ".join(names[0])
        reports = [forest.reports.value.tolist() for forest in (again, built)]
        assert reports[0] == pytest.approx(reports[1])
        assert reports[0][0] > 0.0


def test_widths_of_a_label_are_numbers():
    with pytest.raises(UsageError, match='expected a width for each edge such as "8;0;0;6", found'):
        widths_of_label("wide")
