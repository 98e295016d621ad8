"""Request of an evaluation, and the scenario files that it names: shipped ones, files and folders."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path

from grammarlab.about import PACKAGE
from grammarlab.errors import UsageError
from grammarlab.evaluation.methods import Method, methods_of
from grammarlab.evaluation.respondents import EXACT, RESPONDENTS, Respondent
from grammarlab.evaluation.scenario import SUFFIX
from grammarlab.evaluation.scenario_values import chosen
from grammarlab.files import existing
from grammarlab.runs.evaluate.figures import PlannedFigure, load_figures
from grammarlab.runs.sample.sources import load_source

FIGURES = "figures"
"""The folder of named experiments in the folder of scenarios (`evaluate_figures`)."""
TASTES = "tastes"
"""The folder in that of scenarios with further scenarios of many kinds, for tuning and testing a learner."""
MIN_LABELS = 128
"""Default smallest number of scores."""
MAX_LABELS = 100_000
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
                its labels and at least `MIN_LABELS`.
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
        return self.max_labels or target.ask or max(target.labels or 0, MIN_LABELS)


def find_scenario(argument: str) -> Path:
    """Scenario file of a SCENARIO argument: a file, or a shipped name.

    Raises:
        UsageError: If there is no scenario with that name, or there are several.
    """
    paths = find_scenarios(argument)
    if len(paths) != 1:
        raise UsageError(f"expected one scenario, found {len(paths)} in {argument!r}.")
    return paths[0]


def find_scenarios(argument: str) -> tuple[Path, ...]:
    """Scenario files of a SCENARIOS argument: a file, all files of a folder, a shipped name, or several.

    Args:
        argument: text of the argument; several are separated by commas.

    Raises:
        UsageError: If there is nothing with that name; the message has the nearest names.
    """
    if (path := existing(argument)) is not None:
        if path.is_file():
            return (path,)
        files = tuple(sorted(path.glob(f"*{SUFFIX}")))
        if not files:
            raise UsageError(f"the folder {argument!r} has no scenario: expected files with the suffix {SUFFIX}.")
        return files
    shipped = named_scenarios()
    if argument in shipped:
        return (shipped[argument],)
    if "," in argument:
        return tuple(path for part in argument.split(",") for path in find_scenarios(part))
    names, target = {name.lower(): name for name in shipped}, Path(argument)
    near = [names[name] for name in get_close_matches(target.stem.lower(), names, n=1, cutoff=0.5)]
    folder = existing(str(target.parent))
    neighbours = [file.name for file in folder.glob(f"*{SUFFIX}")] if folder is not None else []
    near += get_close_matches(target.name, neighbours, n=1, cutoff=0.6)
    hint = f" Did you mean {' or '.join(repr(name) for name in near)}?" if near else ""
    raise UsageError(
        f"no scenario file or folder {argument!r}, and no shipped scenario with that name.{hint} "
        f"Shipped: {', '.join(shipped)}."
    )


def named_scenarios() -> dict[str, Path]:
    """All shipped scenario files with unique names, including the tastes."""
    tastes = sorted((scenarios_folder() / TASTES).glob(f"*/*{SUFFIX}"))
    return shipped_scenarios() | {file.stem: file for file in tastes}


def scenarios_folder() -> Path:
    """Folder of the shipped scenarios: inside an installed package, or next to it in a checkout."""
    inside = PACKAGE / "scenarios"
    return inside if inside.is_dir() else PACKAGE.parent / "scenarios"


def shipped_scenarios() -> dict[str, Path]:
    """The shipped scenario files by name, without those of the tastes."""
    return {file.stem: file for file in sorted(scenarios_folder().glob(f"*{SUFFIX}"))}


def _label_numbers(text: str) -> dict[str, int]:
    """Numbers by name of the scenario: ``128,F1=288``."""
    numbers: dict[str, int] = {}
    for word in filter(None, (word.strip() for word in text.split(","))):
        name, _, number = word.rpartition("=")
        if not (re.fullmatch(r"\s*[0-9]{1,9}\s*", number) and 0 < int(number) <= MAX_LABELS):
            raise UsageError(
                f"expected numbers of labels from 1 to {MAX_LABELS:,}, such as 128,F1=288; found {word[:60]!r}."
            )
        numbers[name.strip()] = int(number)
    return numbers


def _check_names(scenarios: Sequence[Path]) -> None:
    """Check that scenario names are unique, since they name tables and pictures."""
    path_of: dict[str, Path] = {}
    for path in scenarios:
        name = load_source(path).scenario.name
        if name in path_of:
            raise UsageError(
                f"{path_of[name]} and {path} both have the name {name!r}; give each scenario a unique name."
            )
        path_of[name] = path
