"""State of the page of a city: its parcels, what a person decides about them, and scores of buildings."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from grammarlab.city.parcel_addresses import EXCLUDED, Pins, excluded, pinned, released, rerolled
from grammarlab.city.plan import Plan, ZonePlan, parse_plan
from grammarlab.city.tree_map_plan import is_tree_file
from grammarlab.errors import UsageError
from grammarlab.language.grammar import hash_of
from grammarlab.learning.designs.addresses import Address
from grammarlab.pages.city.builder import BuildAgain, LearnedZone, LearnZone, TellRules
from grammarlab.pages.city.decisions import (
    Choices,
    changed_parcels,
    changed_zones,
    read_choices,
    save_choices,
    state_of,
    with_grammar,
)
from grammarlab.pages.city.ground_plan import GroundPlan, ground_placement, ground_plan
from grammarlab.pages.city.parcel_facts import ParcelFacts
from grammarlab.pages.city.site_labels import liked, site_labels
from grammarlab.pages.city.zone_sessions import ZoneSessions
from grammarlab.pages.desk import AbstractDocumentDesk
from grammarlab.pages.windows import PROTOCOL, Answer, Message
from grammarlab.pages.workers.worker_pool import TaskOutcome, WorkerPool
from grammarlab.runs.sample.shipped import SUFFIX, find_rules

NO_PLAN = (
    "The plan of this city is not known, so nothing can be built again. "
    "Build it from a plan: grammarlab city build PLAN.toml -o DIR"
)


MOST_SURVEYED = 20_000
"""Largest number of parcels of a city whose rules are told: the whole map is read for them once."""


class CityDesk(AbstractDocumentDesk[Choices]):
    """A city that is changed parcel by parcel. Each step is saved before it is answered."""

    def __init__(self, folder: Path, plan: Path | None, builders: WorkerPool, readers: WorkerPool) -> None:
        """Open a built city.

        Args:
            folder: folder of the city.
            plan: file of its plan; None if it is unknown.
            builders: pool of one process that builds and learns.
            readers: pool of one process that derives buildings again.

        Raises:
            AssetError: If the folder is not that of a city.
            UsageError: If the plan cannot be read.
            LanguageError: If the plan has mistakes.
        """
        self.folder = folder
        self.facts = ParcelFacts.read(folder)
        choices, self.plan = (Choices(Pins(), ""), None) if plan is None else read_choices(plan)
        self._placement = ground_placement(self.facts, folder, self.plan)
        super().__init__(folder if self.plan is None else self.plan.pins, choices, saved=choices)
        self.sessions = None if self.plan is None else ZoneSessions(self.plan.folder, self.plan.seed)
        self.tiles = 0
        self.failed = ""
        self._builders, self._readers = builders, readers
        self._waiting: set[str] = set()
        """Parcels that are to be built again."""
        self._task = ""
        """What the builder does, in words."""
        self._learned: dict[str, str] = {}

    @cached_property
    def ground(self) -> GroundPlan | None:
        """The ground; made when a window asks for it, while it loads the first tiles."""
        return ground_plan(self.facts, self._placement)

    def accept(self, document: Choices) -> None:
        """Save choices before they become the current ones.

        Raises:
            UsageError: If there is no plan, or it was changed elsewhere.
        """
        plan = self._plan()
        save_choices(plan.path, plan.pins, self.document, document)
        self.saved = document

    def follow(self, previous: Choices) -> None:
        """Build again what has changed."""
        before = self._plan()
        self._waiting |= changed_parcels(previous, self.document)
        if previous.plan != self.document.plan:
            self.plan = parse_plan(self.document.plan, before.path)
            zones = changed_zones(before, self.plan)
            self._waiting |= {
                parcel for parcel, zone in zip(self.facts.rows.id, self.facts.rows.zone, strict=True) if zone in zones
            }
        self._build()

    def write(self, path: Path, document: Choices, *, is_new: bool) -> None:
        """Every step has saved its document, so there is nothing to write."""

    def reroll(self, parcel: str) -> None:
        """Let a parcel have another building."""
        self._built(parcel)
        self._decide(f"reroll {parcel}", rerolled(self.document.pins, parcel))

    def pin(self, parcel: str) -> None:
        """Keep the building of a parcel, or release it if it is kept."""
        pins = self.document.pins
        if state_of(pins.get(parcel)) == "pinned":
            self._decide(f"unpin {parcel}", released(pins, parcel))
            return
        self._built(parcel)
        (seed, model), zone = self.facts.address_of(parcel), self.facts.zone_of(parcel)
        self._decide(f"pin {parcel}", pinned(pins, parcel, seed=seed, model=model, zone=zone))

    def exclude(self, parcel: str) -> None:
        """Leave a parcel empty, or build on it again."""
        self.facts.row(parcel)
        pins = self.document.pins
        if pins.get(parcel).zone == EXCLUDED:
            self._decide(f"include {parcel}", released(pins, parcel))
        else:
            self._decide(f"exclude {parcel}", excluded(pins, parcel))

    def score(self, parcel: str, score: float | None, kind: str, key: str) -> None:
        """Score the building of a parcel; on disk when this returns.

        Raises:
            UsageError: If there is no building, or no such score.
        """
        self._built(parcel)
        sessions = self._sessions()
        if not self._is_scorable(self.facts.zone_of(parcel)):
            raise UsageError(f"{parcel} has trees; buildings are scored.")
        sessions.score(self._zone(parcel), self._address(parcel), score, kind, key)
        self.notify()

    def learn(self, name: str) -> None:
        """Learn the grammar of a zone from its scores, and build the zone with it; returns at once.

        Raises:
            UsageError: If nothing is liked, or the builder is busy.
        """
        sessions, zone = self._sessions(), self._zone_named(name)
        if self._task:
            raise UsageError("buildings are being built; learn when they are ready.")
        if not liked(sessions.scores(zone)):
            raise UsageError(f"nothing of {name} is liked yet: score at least one of its buildings above 0.")
        source = find_rules(zone.grammar)
        file = sessions.learned_file(zone)
        labels = site_labels(self.facts, zone, sessions.factors(zone), hash_of(source.text()))
        plan = self._plan()
        task = LearnZone(
            zone=name,
            grammar=zone.grammar,
            labels=labels,
            plan=plan.path,
            session=sessions.path(zone).name,
            file=file,
            seed=plan.seed,
        )
        self._submit(f"learning {name}…", task, partial(self._take_learned, name, file))

    def state(self) -> dict[str, Any]:
        """The whole state of the page."""
        facts = self.facts
        return {
            "protocol": PROTOCOL,
            **self.summary(),
            "title": self.folder.resolve().name,
            "tiles": self.tiles,
            "busy": self._task,
            "failed": self.failed,
            "editable": self.plan is not None,
            "built": int(facts.is_built.sum()),
            "empty": facts.numbers_of_empty(),
            "zones": [self._zone_state(name) for name in facts.zones],
            "num_pins": len(self.document.pins),
        }

    def parcel(self, parcel: str) -> Message:
        """What is known of a parcel.

        Raises:
            UsageError: If there is no parcel with this id.
        """
        zone, is_built = self.facts.zone_of(parcel), bool(self.facts.is_built[self.facts.row(parcel)])
        said = None
        if self.sessions is not None and is_built:
            said = self.sessions.judgement(self._zone(parcel), self._address(parcel))
        return {
            "id": parcel,
            "zone": zone,
            "status": "built" if is_built else "empty",
            "facts": [("zone", zone or "none"), *self._rules_fact(parcel), *self.facts.of(parcel)],
            "pin": state_of(self.document.pins.get(parcel)),
            "said": {"score": said and said.score, "kind": said and said.kind},
            "scorable": said is not None or self._is_scorable(zone),
        }

    def tell_rules(self, parcel: str, answer: Answer) -> None:
        """Answer with lines about how the building of a parcel was derived, when a process has derived it."""
        self.facts.row(parcel)
        if self.plan is None or len(self.facts) > MOST_SURVEYED:
            answer({"rules": []}, ())
            return
        task = TellRules(self.plan.path, parcel)
        # A building that cannot be derived again, such as one of a map that has moved, has no rules to tell.
        self._readers.submit(task, lambda outcome: answer({"rules": outcome.value or []}, ()), first=True)

    def poll(self) -> None:
        """Look for scores that were given elsewhere."""
        if self.sessions is not None and self.sessions.poll():
            self.notify()

    def close(self) -> None:
        """End the builder, and close all files."""
        self._builders.close()
        self._readers.close()
        if self.sessions is not None:
            self.sessions.close()

    # Building

    def _decide(self, words: str, pins: Pins) -> None:
        self._plan()
        self.do(words, replace(self.document, pins=pins))

    def _build(self) -> None:
        """Build what waits, unless the builder is busy."""
        if self._task or not self._waiting:
            return
        parcels = tuple(sorted(self._waiting))
        self._waiting.clear()
        words = f"building {parcels[0]}…" if len(parcels) == 1 else f"building {len(parcels):,} parcels…"
        task = BuildAgain(self.folder, parcels)
        self._submit(words, task, partial(self._take_tiles, parcels))

    def _submit(self, words: str, task: BuildAgain | LearnZone, then: Any) -> None:
        self._task, self.failed = words, ""
        self._builders.submit(task, then)
        self.notify()

    def _take_tiles(self, parcels: tuple[str, ...], outcome: TaskOutcome) -> None:
        self._task = ""
        if outcome.value is None:
            self.failed = outcome.error
            self._waiting |= {*parcels}
            self.notify()
            return
        self.facts = ParcelFacts.read(self.folder)
        self.tiles += 1
        self._build()
        self.notify()

    def _take_learned(self, zone: str, file: Path, outcome: TaskOutcome) -> None:
        self._task = ""
        if not isinstance(outcome.value, LearnedZone):
            self.failed = outcome.error
            self._build()
            self.notify()
            return
        self._learned[zone] = outcome.value.words
        plan = with_grammar(self.document.plan, zone, file.name)
        try:
            self.do(f"learn {zone}", replace(self.document, plan=plan))
        except (UsageError, OSError) as error:
            self.failed = str(error)
            self.notify()

    # Parts of the state

    def _plan(self) -> Plan:
        if self.plan is None:
            raise UsageError(NO_PLAN)
        return self.plan

    def _sessions(self) -> ZoneSessions:
        if self.sessions is None:
            raise UsageError(NO_PLAN)
        return self.sessions

    def _built(self, parcel: str) -> None:
        if not self.facts.is_built[self.facts.row(parcel)]:
            raise UsageError(f"{parcel} has no building.")

    def _zone(self, parcel: str) -> ZonePlan:
        return self._zone_named(self.facts.zone_of(parcel))

    def _zone_named(self, name: str) -> ZonePlan:
        for zone in self._plan().zones:
            if zone.name == name:
                return zone
        raise UsageError(f"the plan has no zone {name!r}; build the city again.")

    def _address(self, parcel: str) -> Address:
        return Address(False, *self.facts.address_of(parcel))

    def _is_scorable(self, zone: str) -> bool:
        """Whether a zone has buildings, and not trees."""
        grammars = [each.grammar for each in self.plan.zones if each.name == zone] if self.plan else []
        return bool(grammars) and not is_tree_file(grammars[0]) and find_rules(grammars[0]).suffix == SUFFIX

    def _rules_fact(self, parcel: str) -> list[tuple[str, str]]:
        """Name of the rules, and the beginning of the hash of their text."""
        zone = self.facts.zone_of(parcel)
        names = [Path(each.grammar).name for each in self.plan.zones if each.name == zone] if self.plan else []
        text = self.facts.rows.grammar[self.facts.row(parcel)]
        words = " ".join([*names, *([f"({text[:12]})"] if text else [])])
        return [("rules", words)] if words else []

    def _zone_state(self, name: str) -> dict[str, Any]:
        zones = [] if self.plan is None else [zone for zone in self.plan.zones if zone.name == name]
        scores = self.sessions.scores(zones[0]) if zones and self.sessions else {}
        return {
            "name": name,
            "grammar": Path(zones[0].grammar).name if zones else "",
            "parcels": int((self.facts.is_built & (self.facts.rows.zone == name)).sum()),
            "scored": len(scores),
            "learnable": liked(scores),
            "learned": self._learned.get(name, ""),
        }
