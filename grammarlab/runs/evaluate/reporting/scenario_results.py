"""The curves of one scenario and one person."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from grammarlab.evaluation.curves import Curve
from grammarlab.evaluation.respondents import EXACT
from grammarlab.evaluation.scenario import Scenario
from grammarlab.runs.evaluate.disk.store import CurveRecord


@dataclass(frozen=True, slots=True)
class ScenarioResults:
    """The curves of one scenario and one error model."""

    scenario: Scenario
    records: tuple[CurveRecord, ...]
    """At least one; grouped by method, in the order of the request."""
    path: Path
    """The scenario file."""

    @property
    def js_original(self) -> float:
        """Divergence before learning, in nats: the median over seeds."""
        return float(np.median([record.js_original for record in self.records]))

    @property
    def person(self) -> str:
        """Error model of the scores: a name of `RESPONDENTS`."""
        return self.records[0].person

    @property
    def name(self) -> str:
        """Name of the results among all: that of the scenario for exact persons, otherwise such as ``F1.sd10``."""
        return self.scenario.name if self.person == EXACT.name else f"{self.scenario.name}.{self.person}"

    def by_method(self) -> dict[str, tuple[CurveRecord, ...]]:
        """The curves of each method, one per seed."""
        names = dict.fromkeys(record.method for record in self.records)
        return {name: tuple(record for record in self.records if record.method == name) for name in names}

    def counted(self, records: Sequence[CurveRecord]) -> list[Curve]:
        """Curves of the scenario, with labels counted from the start that its target defines."""
        later = self.scenario.target.since == "first liked"
        return [record.curve.since_first_liked() if later else record.curve for record in records]
