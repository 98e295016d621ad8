"""Scores of buildings, in a session file per grammar beside the plan; `grammarlab score` opens the same files."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

from grammarlab.city.plan import ZonePlan
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.settings import POOL_SIZE
from grammarlab.pages.record.events import Record
from grammarlab.pages.record.judgements import Judgement, Scores
from grammarlab.pages.record.store import SUFFIX, About, Store
from grammarlab.runs.sample.shipped import find_rules

LEARNED = "-learned"
_NUMBERED = re.compile(rf"(.*{LEARNED})(?:-([0-9]{{1,6}}))?")


@dataclass
class ZoneSessions:
    """Sessions of zones that were opened so far. Every score is on disk before it counts. For one thread."""

    folder: Path
    """Folder of the plan."""
    seed: int
    """Seed of the city."""
    _stores: dict[Path, Store] = field(default_factory=dict)

    def score(self, zone: ZonePlan, model: Address, score: float | None, kind: str, key: str) -> None:
        """Score a building; None takes a score away.

        Args:
            zone: zone of the building.
            model: its address.
            score: 0 to 100.
            kind: scale of the score; see `Judgement`.
            key: unique name of the request; a repeated one has no effect. Empty for none.

        Raises:
            UsageError: If there is no such score.
            AssetError: If it cannot be saved.
        """
        store = self._store(zone, make=True)
        if store is None or (key and key in store.record.keys):
            return

        def body(record: Record) -> dict[str, object]:
            named = {"key": key} if key else {}
            return {"factor": record.active, "models": [str(model)], "score": score, "kind": kind, **named}

        store.append("score", body)

    def judgement(self, zone: ZonePlan, model: Address) -> Judgement | None:
        """The score of a building; None for none."""
        return self.scores(zone).get(str(model))

    def scores(self, zone: ZonePlan) -> Scores:
        """All scores of a zone with its present grammar, in the factor in use."""
        store = self._store(zone, make=False)
        return {} if store is None else store.record.factors[store.record.active]

    def factors(self, zone: ZonePlan) -> dict[str, Scores]:
        """Scores by factor."""
        store = self._store(zone, make=False)
        return {} if store is None else store.record.factors

    def path(self, zone: ZonePlan) -> Path:
        """Session file of a zone with its present grammar: a learned grammar has scores of its own."""
        stem = Path(zone.grammar).stem
        return self.folder / f"{stem if stem.startswith(f'{zone.name}{LEARNED}') else zone.name}{SUFFIX}"

    def learned_file(self, zone: ZonePlan) -> Path:
        """Unused file for a grammar learned from the scores of a zone: NAME-learned.cga, NAME-learned-2.cga."""
        source = find_rules(zone.grammar)
        match = _NUMBERED.fullmatch(source.name) if source.name.startswith(f"{zone.name}{LEARNED}") else None
        number = int(match[2] or 1) + 1 if match else 1
        while True:
            end = f"-{number}" if number > 1 else ""
            path = self.folder / f"{zone.name}{LEARNED}{end}{source.suffix}"
            if not path.exists():
                return path
            number += 1

    def poll(self) -> bool:
        """Read scores that were given elsewhere; returns whether there were any."""
        changed = [store.poll() for store in self._stores.values()]
        return any(changed)

    def close(self) -> None:
        """Close all files."""
        for store in self._stores.values():
            store.close()
        self._stores.clear()

    def _store(self, zone: ZonePlan, *, make: bool) -> Store | None:
        """The session of a zone; None if there is no file and none is made."""
        path = self.path(zone)
        if path not in self._stores:
            if not path.exists() and not make:
                return None
            source = find_rules(zone.grammar)
            title = re.sub(r"[^\w ().-]", "_", source.name)[:200]
            text = source.text().removeprefix("\ufeff")
            self._stores[path] = Store.open(path, About(title, text, self.seed, POOL_SIZE, source.suffix))
        return self._stores[path]
