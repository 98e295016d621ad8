"""Table 4.3 of the paper, reproduced: divergence and size of rules of methods that make a density."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from time import perf_counter
from typing import Any

from grammarlab.about import __version__
from grammarlab.density.samples.examples import learn_from_examples
from grammarlab.density.targets.rejection import reject
from grammarlab.density.targets.target import Target
from grammarlab.errors import GrammarlabError, UsageError
from grammarlab.evaluation.preparation import Source
from grammarlab.evaluation.scenario import Scenario
from grammarlab.features.patterns.tree_index import without_geometry
from grammarlab.learning.targets.grammar_target import LearnedSampler
from grammarlab.runs.evaluate.curve_store import digest, measurements_in
from grammarlab.runs.learn.from_scenario import learned_of
from grammarlab.runs.learn.scenario_measures import LabelledSet
from grammarlab.runs.sample.sources import load_source
from grammarlab.runs.work.executors import SERIAL, AbstractExecutor
from grammarlab.runs.work.results import Progress, computed
from grammarlab.tables import markdown_table

NUM_SAMPLES = 5_000
"""Number of models from which all methods except the exact one learn, as in the paper."""
METHODS = ("parameters", "structure", "tied", "examples", "compile")
"""The columns. *examples* is S tied without given features: the samples must determine them."""
STORE = "density"


@dataclass(frozen=True, slots=True)
class DensityRow:
    """One method for the density of one scenario."""

    scenario: str
    method: str
    js: float
    """Divergence from the target density on the scenario's labelled set, in nats."""
    js_original: float
    correlation: float
    """Correlation of the weights of the two densities."""
    correlation_original: float
    rules_before: int
    rules_after: int
    seconds: float
    findings: tuple[str, ...] = ()


def density_rows(
    scenarios: Sequence[Path],
    folder: Path,
    *,
    executor: AbstractExecutor = SERIAL,
    fresh: bool = False,
    on_progress: Progress = lambda _what, _done, _total: None,
) -> tuple[DensityRow, ...]:
    """Measure all methods on scenarios; stored rows are not measured again.

    Args:
        scenarios: scenario files.
        folder: storage of finished rows.
        executor: measures the rows; only the seconds depend on it.
        fresh: remove stored rows first.
        on_progress: called with the number of finished rows.

    Raises:
        GrammarlabError: If the scenarios or the folder cannot be used. A method that makes no density of a scenario
            has no row.
    """
    tasks = {
        task.key: task for path in scenarios for task in (_CurveRow(path, method, NUM_SAMPLES) for method in METHODS)
    }
    results = computed(
        measurements_in(folder, STORE, fresh=fresh), _measured, tasks, executor, "densities", on_progress
    )
    return tuple(_row(values) for values in results.values() if values)


def _row(stored: Mapping[str, Any]) -> DensityRow:
    values: dict[str, Any] = {**stored, "findings": tuple(stored["findings"])}
    return DensityRow(**values)


@dataclass(frozen=True, slots=True)
class _CurveRow:
    """One row to measure."""

    scenario: Path
    """The scenario file."""
    method: str
    num_samples: int

    @property
    def key(self) -> str:
        """Key of the row: SHA-256 of all its inputs."""
        return digest([__version__, load_source(self.scenario).key, self.method, self.num_samples])

    def __str__(self) -> str:
        return f"the density of {self.scenario.stem} by {self.method}"


@lru_cache(maxsize=1)
def _labelled_set(scenario: Path, _source_key: str) -> LabelledSet:
    """The labelled set of a scenario, derived once for its tasks; a changed file has another key."""
    return LabelledSet.of(load_source(scenario))


def _measured(task: _CurveRow) -> dict[str, object]:
    """A row; None if the method makes no density."""
    source, method = load_source(task.scenario), task.method
    labelled = _labelled_set(task.scenario, source.key)
    try:
        learned, seconds = (
            _from_examples(source, task.num_samples)
            if method == "examples"
            else learned_of(source, method, task.num_samples)
        )
    except UsageError:
        raise
    except GrammarlabError:
        return {}
    comparison = labelled.measure(learned)
    return asdict(
        DensityRow(
            scenario=source.scenario.name,
            method=method,
            js=comparison.after.js,
            js_original=comparison.before.js,
            correlation=comparison.after.correlation,
            correlation_original=comparison.before.correlation,
            rules_before=learned.rules_before,
            rules_after=learned.rules_after,
            seconds=seconds,
            findings=learned.findings,
        )
    )


def _from_examples(source: Source, num_samples: int) -> tuple[LearnedSampler, float]:
    """S tied from samples of the target density, with all possible dependences."""
    scenario = source.scenario
    grammar, assets = source.grammar_space.grammar, source.grammar_space.assets
    target = Target.of_score(grammar, scenario.score, scenario.base, assets)
    sampler = reject(target, num_pilot=num_samples, seed=(scenario.seed + 1) % 2**64)
    forest = without_geometry(sampler.sample(num_samples, (scenario.seed + 2) % 2**64))
    begun = perf_counter()
    learned = learn_from_examples(grammar, forest, assets=assets)
    return learned, perf_counter() - begun


def density_tables(rows: Sequence[DensityRow], scenarios: Sequence[Scenario]) -> str:
    """The rows as a section of a Markdown page, with the paper's results.

    Args:
        rows: rows of some scenarios.
        scenarios: scenarios of the rows, in the order of the page.
    """
    by_place = {(row.scenario, row.method): row for row in rows}
    listed = [scenario for scenario in scenarios if any(row.scenario == scenario.name for row in rows)]
    original = {row.scenario: row for row in rows}
    head = (
        "## From a preference to a density (Table 4.3)\n\n"
        "Divergence in nats from the target density on the labelled set. The preference is known. *compile* computes "
        f"the grammar from it; the other methods learn from {NUM_SAMPLES:,} samples of the density. *tied* is "
        "structure learning of only those choices that the relevant features name; *examples* is the same, but finds "
        "these choices from the samples. In brackets: the paper.\n\n"
    )
    divergences = [
        (
            scenario.name,
            _with_paper(original[scenario.name].js_original, scenario.paper.original),
            *(
                _with_paper(_js(by_place, scenario, method), getattr(scenario.paper, _PAPER.get(method, ""), None))
                for method in METHODS
            ),
        )
        for scenario in listed
    ]
    correlations = [
        (
            scenario.name,
            _correlation(original[scenario.name].correlation_original),
            *(_cell(by_place, scenario, method, lambda row: _correlation(row.correlation)) for method in METHODS),
        )
        for scenario in listed
    ]
    rules = [
        (
            scenario.name,
            f"{original[scenario.name].rules_before}",
            *(_cell(by_place, scenario, method, lambda row: f"{row.rules_after}") for method in METHODS),
        )
        for scenario in listed
    ]
    names = ("scenario", "original", *METHODS)
    notes = [f"- {row.scenario}, {row.method}: {row.findings[0]}" for row in rows if _is_inexact(row)]
    return "\n".join(
        [
            head + markdown_table(names, divergences),
            "Correlation of the weights.\n\n" + markdown_table(names, correlations),
            "Branches of the rules of all symbols.\n\n" + markdown_table(names, rules),
            *(["Preferences without an exact grammar:\n\n" + "\n".join(notes) + "\n"] if notes else []),
        ]
    )


_PAPER = {"parameters": "p_learning", "structure": "s_learning"}
"""Keys of the paper's results in a scenario."""


def _is_inexact(row: DensityRow) -> bool:
    return row.method == "compile" and any("no exact grammar" in finding for finding in row.findings[:1])


def _js(rows: Mapping[tuple[str, str], DensityRow], scenario: Scenario, method: str) -> float | None:
    row = rows.get((scenario.name, method))
    return None if row is None else row.js


def _cell(
    rows: Mapping[tuple[str, str], DensityRow], scenario: Scenario, method: str, text: Callable[[DensityRow], str]
) -> str:
    row = rows.get((scenario.name, method))
    return "–" if row is None else text(row)


def _correlation(value: float) -> str:
    """Three digits; no sign before a zero from rounding."""
    return f"{round(value, 3) + 0.0:.3f}"


def _with_paper(value: float | None, paper: float | None) -> str:
    text = "–" if value is None else "0" if value < 1e-12 else f"{value:.4f}" if value >= 5e-5 else f"{value:.1g}"
    return text if paper is None else f"{text} ({paper:.3f})"
