"""Grammars learned from the scores of simulated persons, compared with the persons' target densities."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from grammarlab.about import __version__
from grammarlab.evaluation.methods import METHODS
from grammarlab.evaluation.respondents import EXACT, Respondent
from grammarlab.evaluation.scenario import Scenario
from grammarlab.runs.evaluate.curve_store import digest, measurements_in
from grammarlab.runs.evaluate.curve_tasks import CurveTask
from grammarlab.runs.evaluate.simulated_labels import labels_of
from grammarlab.runs.learn.from_labels import learn_from_labels
from grammarlab.runs.learn.scenario_measures import LabelledSet
from grammarlab.runs.sample.shipped import find_rules
from grammarlab.runs.sample.sources import load_source
from grammarlab.runs.work.executors import SERIAL, AbstractExecutor
from grammarlab.runs.work.results import Progress, computed
from grammarlab.tables import markdown_table

STORE = "grammars"
METHOD = "default"
"""Method of the interviews."""


@dataclass(frozen=True, slots=True)
class Person:
    """Task: one person, and a number of scores."""

    path: Path
    """The scenario file."""
    seed: int
    labels: int
    cache: Path
    """Folder for cached features, shared by persons."""
    respondent: Respondent = EXACT
    """Error model of the person."""

    @property
    def key(self) -> str:
        """Key of the result: SHA-256 of all its inputs."""
        values = [__version__, load_source(self.path).key, METHODS[METHOD].as_json(), self.seed, self.labels]
        return digest([*values, asdict(self.respondent)])

    def __str__(self) -> str:
        return (
            f"the grammar of person {self.respondent.name} {self.seed} for {self.path.stem} after {self.labels} scores"
        )


@dataclass(frozen=True, slots=True)
class PersonRow:
    """A grammar made from the scores of one person."""

    scenario: str
    seed: int
    labels: int
    js: float
    """Divergence of its density from the person's target density, on the labelled set, in nats."""
    js_predicted: float
    """Divergence of the predicted scores, after the last round."""
    correlation: float
    rules_before: int
    rules_after: int
    method: str
    seconds: float
    person: str = EXACT.name
    """Error model of the person: a name of `RESPONDENTS`."""


def person_rows(
    persons: Sequence[Person],
    folder: Path,
    *,
    executor: AbstractExecutor = SERIAL,
    fresh: bool = False,
    on_progress: Progress = lambda _what, _done, _total: None,
) -> tuple[PersonRow, ...]:
    """Make a grammar for each person; stored ones are not made again.

    Args:
        persons: scenarios, seeds and numbers of labels.
        folder: storage of finished rows.
        executor: makes the grammars; only the seconds depend on it.
        fresh: remove stored rows first.
        on_progress: called with the number of finished grammars.

    Raises:
        GrammarlabError: If the scenarios or the folder cannot be used.
    """
    measurements = measurements_in(folder, STORE, fresh=fresh)
    results = computed(
        measurements, row_of, {person.key: person for person in persons}, executor, "grammars", on_progress
    )
    return tuple(PersonRow(**values) for values in results.values())


def row_of(person: Person) -> dict[str, Any]:
    """The row of a person."""
    scenario, method = load_source(person.path), METHODS[METHOD]
    source = scenario.for_person(person.seed)
    labels, curve = labels_of(
        CurveTask(
            scenario=person.path,
            source_key=scenario.key,
            method=method,
            seed=person.seed,
            max_labels=person.labels,
            cache=person.cache,
            person=person.respondent,
        )
    )
    with tempfile.TemporaryDirectory() as scratch:
        result = learn_from_labels(
            source.scenario.grammar,
            labels,
            Path(scratch, f"new{find_rules(source.scenario.grammar).suffix}"),
            labels_from=str(person),
            choices=source.scenario.choices,
            settings=method.settings(source.scenario.features),
            pool=source.pool,
        )
    measured = LabelledSet.of(source, person.respondent).measure(result.learned)
    row = PersonRow(
        scenario=source.scenario.name,
        seed=person.seed,
        labels=person.labels,
        js=measured.after.js,
        js_predicted=curve.points[-1].js,
        correlation=measured.after.correlation,
        rules_before=result.learned.rules_before,
        rules_after=result.learned.rules_after,
        method=result.learned.method,
        seconds=result.seconds,
        person=person.respondent.name,
    )
    return asdict(row)


def person_table(rows: Sequence[PersonRow], scenarios: Sequence[Scenario]) -> str:
    """The rows as a section of a Markdown page: medians over persons.

    Args:
        rows: rows of scenarios.
        scenarios: the scenarios, in the order of the page.
    """
    lines: list[tuple[str, ...]] = []
    for scenario in scenarios:
        by_person: dict[str, list[PersonRow]] = {}
        for row in rows:
            if row.scenario == scenario.name:
                by_person.setdefault(row.person, []).append(row)
        for person, group in by_person.items():
            js = sorted(row.js for row in group)
            lines.append(
                (
                    scenario.name,
                    person,
                    f"{group[0].labels}",
                    f"{np.median(js):.5f}",
                    f"{js[0]:.5f}–{js[-1]:.5f}",
                    f"{np.median([row.js_predicted for row in group]):.5f}",
                    f"{np.median([row.correlation for row in group]):.4f}",
                    f"{group[0].rules_before}",
                    f"{np.median([row.rules_after for row in group]):g}",
                    f"{sum(row.method == 'compile' for row in group)}/{len(group)}",
                )
            )
    head = ("scenario", "person", "labels", "JS", "lowest–highest", "JS of scores", "correlation")
    head += ("branches", "after", "exact")
    return (
        "## From scores to a grammar\n\n"
        "A simulated person gives scores, a preference is learned from them, and a grammar is made of it. *JS* is the "
        "divergence of the grammar from what the person wanted, *JS of scores* that of the predicted scores, both in "
        "nats on the labelled set; *exact* says how many of the grammars follow the learned preference exactly. "
        "Medians over persons.\n\n" + markdown_table(head, lines)
    )
