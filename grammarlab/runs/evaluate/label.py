"""Labels of a simulated person, as a file that a real one could have made."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

from grammarlab.errors import UsageError
from grammarlab.evaluation.curves import Curve
from grammarlab.evaluation.methods import METHODS
from grammarlab.preference.label_files import save_labels
from grammarlab.preference.labels import OVERALL, Labels
from grammarlab.runs.evaluate.task import Task, run_protocol
from grammarlab.runs.sources import load_source
from grammarlab.runs.workers import one_thread


@dataclass(frozen=True, slots=True)
class LabelResult:
    """Labels on disk."""

    file: Path
    labels: Labels
    curve: Curve
    """How well each round of them was learned from."""


def label_models_of(
    scenario: Path, file: Path, num_labels: int, *, seed: int = 0, method: str = "default", cache: Path | None = None
) -> LabelResult:
    """Lets a simulated person score models, chosen round after round as they would be for a real person.

    Args:
        scenario: a scenario file.
        file: the label file to write: .csv, .jsonl or .parquet.
        num_labels: how many scores, all factors together.
        seed: of the person, 0 <= seed < 2**64.
        method: of `grammarlab.evaluation.methods.METHODS`: how models are chosen.
        cache: folder for counted features that later calls use again.

    Raises:
        UsageError: for an unknown method or kind of file.
    """
    if method not in METHODS:
        raise UsageError(f"no method is called {method!r}; those there are: {', '.join(METHODS)}")
    source = load_source(scenario)
    file.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        save_labels(Labels(), Path(scratch, file.name))  # a wrong suffix is better told before the work than after it
        task = Task(scenario, source.key, METHODS[method], seed, num_labels, cache or Path(scratch))
        with one_thread():
            material, state, curve = run_protocol(task)
    single, hashes = len(material.factors) == 1, material.study.space.hashes
    rows = [
        address.label(OVERALL if single else name, score, hashes)
        for name, answers in state.answers.items()
        for address, score in zip(answers.designs, answers.scores.tolist(), strict=True)
    ]
    labels = Labels(tuple(rows))
    save_labels(labels, file)
    return LabelResult(file, labels, curve)
