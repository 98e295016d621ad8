"""Learning the zones of a plan from answers about some of its parcels, and the parcels to ask about next."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.city.fields import ParcelFields, numeric_attributes, parcel_fields
from grammarlab.city.lot_survey import surveyed_lots
from grammarlab.city.parcel_ids import canonical_id
from grammarlab.city.plan import Plan, read_plan
from grammarlab.city.site_making import lot_fields
from grammarlab.city.zone_answers import ZoneAnswers, canonical_text, read_zone_answers
from grammarlab.city.zone_density import text_words
from grammarlab.city.zone_file import SUFFIX, save_zones
from grammarlab.city.zone_learning import LearnedZones, held_out_chances, learned_zones, shares_of_log_odds
from grammarlab.city.zone_questions import first_questions, next_questions
from grammarlab.city.zone_scores import ScoredZones, counts_of_scores
from grammarlab.errors import AssetError, UsageError, shown
from grammarlab.files import check_overwrites
from grammarlab.runs.city.survey import ground_of, site_sources

NUM_QUESTIONS = 16
"""Parcels to ask about next, unless another number is wanted."""
_FOLDS = 5
"""Parts of the answers, each held out once."""
_MIN_HELD_OUT = 20
"""Fewest answered parcels for held-out measures."""


@dataclass(frozen=True, slots=True)
class HeldOut:
    """How well zones are predicted from the other answers. Scales and centre were chosen with all answers."""

    accuracy: float
    """Share of answers that name the most probable zone."""
    log_loss: float
    """Mean of -ln P of the answers, in nats."""
    log_loss_of_shares: float
    """The same if every parcel had the shares of the other answers."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ZonesResult:
    """Learned zones with what is known about them."""

    file: Path
    learned: LearnedZones
    num_answers: int
    num_blank: int
    """Rows of the table without an answer."""
    unknown: tuple[str, ...]
    """Ids of answers that are not those of parcels to build on; these answers are left out."""
    zones: dict[str, int]
    """Answers per zone, or scores per zone."""
    decides: dict[str, float]
    """Share of each field, and of the ``place``, in what is learned, largest first; empty if nothing decides."""
    held_out: HeldOut | None
    """None with few answers, or if the answers are scores."""
    questions: tuple[str, ...]
    """Ids of parcels to ask about next, the most informative first."""
    seconds: float

    def as_json(self) -> dict[str, Any]:
        """The result as plain values, for ``--json``."""
        held_out = self.held_out
        return {
            "file": str(self.file),
            "answers": self.num_answers,
            "blank": self.num_blank,
            "unknown": list(self.unknown),
            "zones": self.zones,
            "decides": {name: round(share, 4) for name, share in self.decides.items()},
            "held_out": None
            if held_out is None
            else {name: round(getattr(held_out, name), 4) for name in HeldOut.__dataclass_fields__},
            "questions": list(self.questions),
            "seconds": round(self.seconds, 3),
        }


def learn_zones(
    plan: Path, answers: Path, output: Path | None = None, *, num_questions: int = NUM_QUESTIONS
) -> ZonesResult:
    """Learn the zones of a plan and write their file.

    Args:
        plan: file of the plan.
        answers: table of answers, see `grammarlab.city.zone_answers`.
        output: file to write; None for the one that the plan names as density, or else the plan's name with `SUFFIX`.
        num_questions: number of parcels to ask about next.

    Raises:
        GrammarlabError: If the plan, one of its files or the answers cannot be used.
    """
    start = perf_counter()
    read = read_plan(plan)
    output = _output(read) if output is None else output
    check_overwrites([output], [plan, answers, *([read.parcels] if read.parcels else [])])
    table = read_zone_answers(answers)
    zones = _zones(read, table, answers)
    fields = plan_fields(read)
    learned, unknown = _learned(fields, table, zones, answers)
    save_zones(learned.density, output)
    shares = shares_of_log_odds(learned)
    return ZonesResult(
        file=output,
        learned=learned,
        num_answers=len(table),
        num_blank=table.num_blank,
        unknown=unknown,
        zones=dict(Counter(table.zone.tolist()).most_common()),
        decides={name: share for name, share in shares.items() if share > 0.0},
        held_out=_held_out(learned) if table.score is None else None,
        questions=tuple(next_questions(learned, fields, num_questions).tolist()),
        seconds=perf_counter() - start,
    )


def questions(plan: Path, num: int = NUM_QUESTIONS) -> tuple[str, ...]:
    """Ids of parcels to ask about first, before there are answers.

    Raises:
        GrammarlabError: If the plan or one of its files cannot be used.
    """
    return tuple(first_questions(plan_fields(read_plan(plan)), num).tolist())


def plan_fields(plan: Plan) -> ParcelFields:
    """All numbers that the zones of a plan may depend on, for the parcels that can be built on.

    Columns of whole numbers that are all different are left out: they are ids.

    Raises:
        GrammarlabError: If one of its files cannot be used.
    """
    without = replace(plan, zones=tuple(replace(zone, density=None) for zone in plan.zones))
    ground = ground_of(plan)
    lots = surveyed_lots(plan, ground.parcels, ground.streets)
    sources = site_sources(without, (), ground.parcels.frame)
    fields = lot_fields(without, ground.parcels, lots, ground.terrain, sources).learned
    chosen = ground.parcels.take(lots.parcel)
    attributes = parcel_fields(chosen, attributes=numeric_attributes(chosen))
    for name in attributes.name:
        values = attributes.columns([name])[:, 0]
        if name not in fields.name and not _is_id(values):
            fields = fields.with_field(name, "", values)
    return fields


def _is_id(values: Floats) -> bool:
    present = values[np.isfinite(values)]
    return bool(len(present) > 1 and (present == np.round(present)).all() and len(np.unique(present)) == len(present))


def _output(plan: Plan) -> Path:
    named = {zone.density for zone in plan.zones if zone.density is not None}
    if len(named) > 1:
        names = ", ".join(sorted(path.name for path in named))
        raise UsageError(
            f"{plan.path}: its zones have several learned files ({names}): give `output=`, the one to learn."
        )
    return named.pop() if named else plan.path.with_name(plan.path.stem + SUFFIX)


def _zones(plan: Plan, answers: ZoneAnswers, path: Path) -> tuple[str, ...]:
    """Zones to learn, in the order of the plan: those with answers or with a density."""
    names = {canonical_text(zone.name): zone.name for zone in plan.zones}
    for zone, line in zip(answers.zone.tolist(), answers.line.tolist(), strict=True):
        if zone not in names:
            listing = ", ".join(names.values())[:200]
            raise AssetError(
                f"{path}: line {line}: expected a zone of the plan, one of {listing}; found {shown(zone)}."
            )
    answered = set(answers.zone.tolist())
    zones = tuple(zone.name for zone in plan.zones if canonical_text(zone.name) in answered or zone.density is not None)
    if len(zones) < 2:
        raise AssetError(
            f"{path}: expected answers with at least two zones, found {', '.join(zones)} only. "
            "Zones of the plan with a learned file count even without answers."
        )
    return zones


def _learned(
    fields: ParcelFields, answers: ZoneAnswers, zones: tuple[str, ...], path: Path
) -> tuple[LearnedZones, tuple[str, ...]]:
    """The zones, and the ids of answers that were left out."""
    row_of = {name: row for row, name in enumerate(fields.id.tolist())}
    ids = [canonical_id(name) for name in answers.id.tolist()]
    rows = np.array([row_of.get(name, -1) for name in ids])
    unknown = tuple(dict.fromkeys(name for name, row in zip(ids, rows.tolist(), strict=True) if row < 0))
    if (rows < 0).all():
        raise AssetError(
            f"{path}: line {answers.line[0]}: no parcel {shown(answers.id[0])} can be built on, nor any other of the "
            f"{len(unknown):,} ids. The map has ids such as {', '.join(fields.id[:3].tolist())[:100]}."
        )
    known = np.flatnonzero(rows >= 0)
    different, parcel = np.unique(rows[known], return_inverse=True)
    number_of = {canonical_text(name): number for number, name in enumerate(zones)}
    zone = np.array([number_of[name] for name in answers.zone[known].tolist()])
    chosen = fields.take(different)
    if answers.score is None:
        counts = np.zeros((len(different), len(zones)))
        np.add.at(counts, (parcel, zone), 1.0)
    else:
        scored = ScoredZones(chosen, parcel.astype(np.int64), zone, answers.score[known])
        counts = counts_of_scores(scored, np.ones(len(zones)))
    return learned_zones(chosen, counts, zones, answers.hash), unknown


def _held_out(learned: LearnedZones) -> HeldOut | None:
    counts = learned.counts
    if len(counts) < _MIN_HELD_OUT:
        return None
    folds = _folds(learned.fields.id)
    chances = held_out_chances(learned, folds)
    shares = np.empty_like(counts)
    for fold in range(_FOLDS):
        others = counts[folds != fold].sum(axis=0) + 1.0
        shares[folds == fold] = others / others.sum()
    total = counts.sum()
    return HeldOut(
        accuracy=float(counts[np.arange(len(counts)), chances.argmax(axis=1)].sum() / total),
        log_loss=float(-(counts * np.log(chances)).sum() / total),
        log_loss_of_shares=float(-(counts * np.log(shares)).sum() / total),
    )


def _folds(ids: NDArray[np.object_]) -> Ints:
    """[n] folds of equal size, by ids."""
    folds = np.empty(len(ids), np.int64)
    folds[np.argsort(text_words(ids), kind="stable")] = np.arange(len(ids)) % _FOLDS
    return folds
