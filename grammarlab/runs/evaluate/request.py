"""Request of an evaluation."""

from __future__ import annotations

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
"""That a person gives."""


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
    """Experiments to draw besides."""
    grids: bool = False
    """Whether to draw samples before and after."""
    density: bool = False
    """Whether to measure the ways to make a density of a known preference: for the scenarios that the paper measures
    it for, or for all where there is none of these."""
    persons: tuple[Respondent, ...] = (EXACT,)
    """Error models of persons, at least one; each has all seeds."""
    grammar_labels: Mapping[str, int] = field(default_factory=dict)
    """By name of a scenario, after how many labels of each person to measure the grammar that comes out; under the
    empty name for all others. Where there is none, it is not measured."""

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
            methods: names with commas between; empty for those that each scenario names.
            batch: models a round, for all methods; None for what each prefers.
            seeds: >= 1.
            max_labels: scores that each person gives; 0 for as many as each scenario's target asks for, and where it
                does not say, for its labels and `ENOUGH_LABELS` at least.
            figures: ``all``, or names with commas between, of the experiments beside the scenarios; empty for none.
            grids: whether to draw samples before and after.
            density: whether to measure the ways to make a density of a known preference.
            persons: names of `RESPONDENTS` with commas between. Experiments are drawn for exact persons.
            grammar_labels: after how many labels to make a grammar too: ``128``, ``F1=288``, or several of these with
                commas between.

        Raises:
            UsageError: a number out of range, an unknown method, figure or person, a file that is no scenario, two
                scenarios of one name.
        """
        for what, number, least in (("seeds", seeds, 1), ("max_labels", max_labels, 0)):
            if number < least:
                raise UsageError(f"{what} is a number from {least}, not {number}.")
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
        """After how many labels the grammar of a scenario is measured; None for not at all."""
        return self.grammar_labels.get(scenario, self.grammar_labels.get(""))

    def methods_of(self, scenario: Path) -> tuple[Method, ...]:
        """The methods to compare on a scenario."""
        return methods_of(self.methods or ",".join(load_source(scenario).scenario.methods), self.batch)

    def labels_of(self, scenario: Path) -> int:
        """How many scores each person gives on a scenario."""
        target = load_source(scenario).scenario.target
        return self.max_labels or target.ask or max(target.labels or 0, ENOUGH_LABELS)


def _label_numbers(text: str) -> dict[str, int]:
    """Numbers by the name of what they are for: ``128,F1=288``."""
    found: dict[str, int] = {}
    for word in filter(None, (word.strip() for word in text.split(","))):
        name, _, number = word.rpartition("=")
        if not (number.strip().isdecimal() and 0 < int(number) <= MOST_LABELS):
            raise UsageError(
                f"expected numbers of labels from 1 to {MOST_LABELS:,}, such as 128,F1=288; found {word!r}."
            )
        found[name.strip()] = int(number)
    return found


def _check_names(scenarios: Sequence[Path]) -> None:
    """Check that scenario names are unique, since they name tables and pictures."""
    seen: dict[str, Path] = {}
    for path in scenarios:
        name = load_source(path).scenario.name
        if name in seen:
            raise UsageError(f"{seen[name]} and {path} are both called {name!r}; give each scenario its own name.")
        seen[name] = path
