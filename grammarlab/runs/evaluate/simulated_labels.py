"""Labels of a simulated person, in a label file."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from grammarlab.evaluation.curves import Curve
from grammarlab.evaluation.methods import METHODS
from grammarlab.evaluation.preparation import Material
from grammarlab.evaluation.respondents import EXACT, RESPONDENTS
from grammarlab.evaluation.scenario_values import chosen_one
from grammarlab.learning.round import State
from grammarlab.preference.label_files import save_labels
from grammarlab.preference.labels import OVERALL, Labels
from grammarlab.runs.evaluate.curve_tasks import CurveTask, run_protocol
from grammarlab.runs.sample.sources import load_source
from grammarlab.runs.work.executors import AbstractExecutor
from grammarlab.runs.work.results import Progress
from grammarlab.runs.work.workers import one_thread


@dataclass(frozen=True, slots=True)
class LabelResult:
    """Labels on disk."""

    file: Path
    labels: Labels
    curve: Curve
    """Learning curve of the labels."""


def label_models_of(
    scenario: Path,
    file: Path,
    num_labels: int,
    *,
    seed: int = 0,
    method: str = "default",
    person: str = EXACT.name,
    cache: Path | None = None,
    executor: AbstractExecutor | None = None,
    on_progress: Progress = lambda _what, _done, _total: None,
) -> LabelResult:
    """Let a simulated person score models, which are chosen round after round as for a real person.

    A new file is written after every round, so what was scored before an interruption is not lost. An existing one is
    replaced at the end.

    Args:
        scenario: a scenario file.
        file: the label file to write: .csv, .jsonl or .parquet.
        num_labels: number of scores, all factors together.
        seed: seed of the person, 0 <= seed < 2**64; the pool follows from it.
        method: method of choosing models, of `grammarlab.evaluation.methods.METHODS`.
        person: error model of scores, of `grammarlab.evaluation.respondents.RESPONDENTS`.
        cache: folder for counted features, reused by later calls.
        executor: does all rounds as one task, on a machine that has the scenario by the same path; the file is then
            written at the end. None does them in this process.
        on_progress: called after every round, or at the end if there is an executor.

    Raises:
        UsageError: If the method, the person or the suffix of the file is unknown.
    """
    way, respondent = chosen_one(method, METHODS, "method"), chosen_one(person, RESPONDENTS, "person")
    key = load_source(scenario).key
    file.parent.mkdir(parents=True, exist_ok=True)

    is_new = not file.exists()

    def on_labels(labels: Labels) -> None:
        if is_new:
            save_labels(labels, file)
        on_progress("scores", len(labels), num_labels)

    with tempfile.TemporaryDirectory() as scratch:
        save_labels(Labels(), Path(scratch, file.name))  # report a wrong suffix before the work
        task = CurveTask(
            scenario=scenario.absolute(),
            source_key=key,
            method=way,
            seed=seed,
            max_labels=num_labels,
            cache=cache or Path(scratch),
            person=respondent,
        )
        if executor is None:
            labels, curve = labels_of(task, on_labels)
        else:
            ((labels, curve),) = executor.results(labels_of, [task])
            on_progress("scores", len(labels), num_labels)
    save_labels(labels, file)
    return LabelResult(file, labels, curve)


def labels_of(task: CurveTask, on_labels: Callable[[Labels], None] = lambda _labels: None) -> tuple[Labels, Curve]:
    """Labels of the simulated person of a task, and their learning curve.

    Args:
        task: the task.
        on_labels: called with the labels after every round.
    """
    with one_thread():
        material, state, curve = run_protocol(task, lambda material, state: on_labels(_labels(material, state)))
    return _labels(material, state), curve


def _labels(material: Material, state: State) -> Labels:
    single, hashes = len(material.factors) == 1, material.study.space.hashes
    rows = [
        address.label(OVERALL if single else name, score, hashes)
        for name, answers in state.answers.items()
        for address, score in zip(answers.designs, answers.scores.tolist(), strict=True)
    ]
    return Labels(tuple(rows))
