"""Request of an evaluation."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from grammarlab.errors import UsageError
from grammarlab.evaluation.methods import Method, methods_of
from grammarlab.evaluation.names import chosen
from grammarlab.evaluation.respondents import EXACT, RESPONDENTS, Respondent
from grammarlab.runs.evaluate.figures import PlannedFigure, load_figures
from grammarlab.runs.evaluate.find import FIGURES
from grammarlab.runs.sampling.sources import load_source

ENOUGH_LABELS = 128
"""Default smallest number of scores."""


MOST_LABELS = 100_000
"""Largest number of scores of a person."""


@dataclass(frozen=True, slots=True)
class EvaluationRequest:
    """A request of an evaluation."""

    scenarios: tuple[Path, ...]
    """Scenario files, at least one, of different names."""
    methods: str
    """Method names separated by commas; empty for those of each scenario."""
    batch: int | None
    """Models per round; None for the default of each method."""
    seeds: int
    """Number of simulated persons for each method: seeds 0 to seeds - 1."""
    max_labels: int
    """Number of scores of each person; 0 for that of the scenario's target."""
    figures: tuple[PlannedFigure, ...] = ()
    """Additional experiments to draw."""
    grids: bool = False
    """Whether to draw samples before and after."""
    density: bool = False
    """Whether to measure methods that make a density of a known preference: for the scenarios for which the paper has
    results, or for all if there is none of these."""
    persons: tuple[Respondent, ...] = (EXACT,)
    """Error models of persons, at least one; each has all seeds."""
    grammar_labels: Mapping[str, int] = field(default_factory=dict)
    """Number of labels of each person after which to measure the resulting grammar, by scenario name; the empty name is
    for all others. Scenarios without an entry are not measured."""

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
        density: bool = False,
        persons: str = EXACT.name,
        grammar_labels: str = "",
    ) -> EvaluationRequest:
        """A checked request.

        Args:
            scenarios: scenario files.
            methods: names separated by commas; empty for those of each scenario.
            batch: models per round, for all methods; None for the default of each.
            seeds: number of seeds, >= 1.
            max_labels: number of scores of each person; 0 for that of each scenario's target, or, if it has none, for
                its labels and at least `ENOUGH_LABELS`.
            figures: ``all``, or comma-separated names of experiments in the folder of scenarios; empty for none.
            grids: whether to draw samples before and after.
            density: whether to measure methods that make a density of a known preference.
            persons: comma-separated names of `RESPONDENTS`. Experiments are drawn for exact persons.
            grammar_labels: numbers of labels after which to make a grammar too: ``128``, ``F1=288``, or several of
                these separated by commas.

        Raises:
            UsageError: If a number is out of range, a method, figure or person is unknown, a file is not a scenario, or
                two scenarios have the same name.
        """
        for what, number, least in (("seeds", seeds, 1), ("max_labels", max_labels, 0)):
            if number < least:
                raise UsageError(f"{what}: expected a number of at least {least}, found {number}.")
        planned = load_figures(scenarios[0].parent / FIGURES, figures) if figures else ()
        request = cls(
            scenarios=scenarios,
            methods=methods,
            batch=batch,
            seeds=seeds,
            max_labels=max_labels,
            figures=planned,
            grids=grids,
            density=density,
            persons=chosen(persons, RESPONDENTS, "person"),
            grammar_labels=_label_numbers(grammar_labels),
        )
        _check_names(scenarios)
        for path in scenarios:
            request.methods_of(path)
        return request

    def grammar_labels_of(self, scenario: str) -> int | None:
        """Number of labels after which the grammar of a scenario is measured; None for no measurement."""
        return self.grammar_labels.get(scenario, self.grammar_labels.get(""))

    def methods_of(self, scenario: Path) -> tuple[Method, ...]:
        """The methods to compare on a scenario."""
        return methods_of(self.methods or ",".join(load_source(scenario).scenario.methods), self.batch)

    def labels_of(self, scenario: Path) -> int:
        """Number of scores of each person on a scenario."""
        target = load_source(scenario).scenario.target
        return self.max_labels or target.ask or max(target.labels or 0, ENOUGH_LABELS)


def _label_numbers(text: str) -> dict[str, int]:
    """Numbers by name of the scenario: ``128,F1=288``."""
    found: dict[str, int] = {}
    for word in filter(None, (word.strip() for word in text.split(","))):
        name, _, number = word.rpartition("=")
        if not (re.fullmatch(r"\s*[0-9]{1,9}\s*", number) and 0 < int(number) <= MOST_LABELS):
            raise UsageError(
                f"expected numbers of labels from 1 to {MOST_LABELS:,}, such as 128,F1=288; found {word[:60]!r}."
            )
        found[name.strip()] = int(number)
    return found


def _check_names(scenarios: Sequence[Path]) -> None:
    """Check that scenario names are unique, since they name tables and pictures."""
    seen: dict[str, Path] = {}
    for path in scenarios:
        name = load_source(path).scenario.name
        if name in seen:
            raise UsageError(f"{seen[name]} and {path} both have the name {name!r}; give each scenario a unique name.")
        seen[name] = path
