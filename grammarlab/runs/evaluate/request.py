"""What an evaluation measures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from grammarlab.errors import UsageError
from grammarlab.evaluation.methods import Method, methods_of
from grammarlab.runs.evaluate.figures import PlannedFigure, load_figures
from grammarlab.runs.evaluate.find import FIGURES
from grammarlab.runs.evaluate.task import load_source

ENOUGH_LABELS = 128
"""Scores after which most of what is asked of a learner has been seen."""


@dataclass(frozen=True, slots=True)
class EvaluationRequest:
    """What to measure."""

    scenarios: tuple[Path, ...]
    """Scenario files, at least one, of different names."""
    methods: str
    """Names with commas between; empty for those that each scenario names."""
    batch: int | None
    """Models a round; None for what each method prefers."""
    seeds: int
    """Simulated persons for each method: seeds 0 to seeds - 1."""
    max_labels: int
    """Scores each of them gives; 0 for as many as the scenario's target, and `ENOUGH_LABELS` at least."""
    figures: tuple[PlannedFigure, ...] = ()
    """Experiments to draw besides."""
    grids: bool = False
    """Whether to draw samples before and after."""

    @classmethod
    def of(
        cls,
        scenarios: tuple[Path, ...],
        *,
        methods: str = "",
        batch: int | None = None,
        seeds: int = 10,
        max_labels: int = 256,
        figures: str = "",
        grids: bool = False,
    ) -> EvaluationRequest:
        """A request, checked.

        Args:
            scenarios: scenario files.
            methods: names with commas between; empty for those that each scenario names.
            batch: models a round, for all methods; None for what each prefers.
            seeds: >= 1.
            max_labels: scores that each person gives; 0 for as many as each scenario's target, and `ENOUGH_LABELS`
                at least.
            figures: ``all``, or names with commas between, of the experiments beside the scenarios; empty for none.
            grids: whether to draw samples before and after.

        Raises:
            UsageError: a number out of range, an unknown method or figure, a file that is no scenario, two scenarios of
                one name.
        """
        for what, number, least in (("seeds", seeds, 1), ("max_labels", max_labels, 0)):
            if number < least:
                raise UsageError(f"{what} is a number from {least}, not {number}.")
        planned = load_figures(scenarios[0].parent / FIGURES, figures) if figures else ()
        request = cls(scenarios, methods, batch, seeds, max_labels, planned, grids)
        _check_names(scenarios)
        for path in scenarios:
            request.methods_of(path)
        return request

    def methods_of(self, scenario: Path) -> tuple[Method, ...]:
        """The methods to compare on a scenario."""
        return methods_of(self.methods or ",".join(load_source(scenario).scenario.methods), self.batch)

    def labels_of(self, scenario: Path) -> int:
        """How many scores each person gives on a scenario."""
        return self.max_labels or max(load_source(scenario).scenario.target.labels or 0, ENOUGH_LABELS)


def _check_names(scenarios: Sequence[Path]) -> None:
    """Make sure that no two scenarios would share tables and pictures."""
    seen: dict[str, Path] = {}
    for path in scenarios:
        name = load_source(path).scenario.name
        if name in seen:
            raise UsageError(f"{seen[name]} and {path} are both called {name!r}; give each scenario its own name.")
        seen[name] = path
