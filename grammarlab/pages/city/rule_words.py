"""How the building of a parcel was derived, in a few lines: what chance decided, from the lot down."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from grammarlab.city.plan import read_plan
from grammarlab.derivation.forest import Forest
from grammarlab.runs.city.survey import Survey, surveyed
from grammarlab.runs.city.zone_rules import ZoneRules

MOST_LINES = 16
"""Largest number of decisions that are told: the first ones, which decide most."""
_MOST_SYMBOLS = 4
"""Largest number of successors that are named."""


def rules_of(plan: Path, parcel: str) -> list[str]:
    """Decisions about the building of a parcel, those about the whole building first.

    Args:
        plan: file of the plan of the city.
        parcel: id of the parcel.

    Returns:
        Lines such as ``Walls → OldWalls (line 44)``; none for a parcel without a building.

    Raises:
        GrammarlabError: If a file of the plan cannot be used, or the building cannot be derived.
    """
    read = read_plan(plan)
    forest = _forest(plan, _time(plan), _time(read.pins), parcel)
    return [] if forest is None else decisions(forest)


def decisions(forest: Forest) -> list[str]:
    """What chance decided in the first model of a forest: branches of rules, then values of attributes."""
    nodes, draws = forest.nodes, forest.draws
    kinds = np.array([site.kind for site in forest.sites], object)[draws.site]
    choosing = np.unique(draws.node[kinds == "choice"])
    counts: dict[str, int] = {}
    for node in choosing[(nodes.rule[choosing] >= 0) & (nodes.model[choosing] == 0)].tolist():
        children = [forest.symbols[symbol] for symbol in nodes.symbol[nodes.parent == node].tolist()]
        names = list(dict.fromkeys(children))
        shown = ", ".join([*names[:_MOST_SYMBOLS], *(["…"] if len(names) > _MOST_SYMBOLS else [])])
        rule = forest.rules[nodes.rule[node]]
        line = f"{rule.symbol} → {shown or 'nothing'} (line {rule.line})"
        counts[line] = counts.get(line, 0) + 1
    lines = [f"{line}{f' × {number}' if number > 1 else ''}" for line, number in counts.items()]
    return [*lines[: MOST_LINES - len(_values(forest))], *_values(forest)]


def _values(forest: Forest) -> list[str]:
    """Values of the attributes of the file that were drawn for the whole building; those of imports are many."""
    draws = forest.draws
    values = {
        site.name: value
        for site, value in zip((forest.sites[each] for each in draws.site.tolist()), draws.value.tolist(), strict=True)
        if site.kind == "uniform" and site.name == site.definition and not {*"#."} & {*site.name}
    }
    return [f"{name} = {value:.2f}" for name, value in list(values.items())[: MOST_LINES // 2]]


def _time(path: Path) -> int:
    """When a file was changed; 0 if there is none."""
    return path.stat().st_mtime_ns if path.is_file() else 0


def _forest(plan: Path, plan_time: int, pins_time: int, parcel: str) -> Forest | None:
    """The derivation of the building of a parcel; None if it has none."""
    survey = _survey(plan, plan_time, pins_time)
    rows = np.flatnonzero(survey.parcels.id[survey.sites.parcel] == parcel)
    if not len(rows):
        return None
    rules = ZoneRules.of(survey.plan.zones[int(survey.sites.zone[rows[0]])])
    if rules.is_park:
        return None
    known = rules.source.grammar.attributes
    site = survey.sites.take(rows[:1])
    values = {name: column for name, column in site.attributes.items() if name in known and not known[name].constant}
    return rules.source.derive(replace(site, attributes=values).lots()).forest


def survey_of(plan: Path) -> Survey:
    """The survey of a plan; made again when the file or its pins have changed.

    Raises:
        GrammarlabError: If a file of the plan cannot be used.
    """
    return _survey(plan, _time(plan), _time(read_plan(plan).pins))


@lru_cache(maxsize=2)
def _survey(plan: Path, _plan_time: int, _pins_time: int) -> Survey:
    """The survey of a plan; made again when the file or its pins have changed."""
    read = read_plan(plan)
    return surveyed(read, tuple(ZoneRules.of(zone) for zone in read.zones))
