"""Labels of a simulated person, as a file that a real one could have made."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

from grammarlab.evaluation.curves import Curve
from grammarlab.evaluation.methods import METHODS
from grammarlab.evaluation.names import chosen_one
from grammarlab.evaluation.respondents import EXACT, RESPONDENTS
from grammarlab.preference.labels.files import save_labels
from grammarlab.preference.labels.table import OVERALL, Labels
from grammarlab.runs.evaluate.task import CurveTask, run_protocol
from grammarlab.runs.sampling.sources import load_source
from grammarlab.runs.work.workers import one_thread


@dataclass(frozen=True, slots=True)
class LabelResult:
    """Labels on disk."""

    file: Path
    labels: Labels
    curve: Curve
    """How well each round of them was learned from."""


def label_models_of(
    scenario: Path,
    file: Path,
    num_labels: int,
    *,
    seed: int = 0,
    method: str = "default",
    person: str = EXACT.name,
    cache: Path | None = None,
) -> LabelResult:
    """Lets a simulated person score models, chosen round after round as they would be for a real person.

    Args:
        scenario: a scenario file.
        file: the label file to write: .csv, .jsonl or .parquet.
        num_labels: how many scores, all factors together.
        seed: of the person, 0 <= seed < 2**64; the models there are to ask about follow from it.
        method: of `grammarlab.evaluation.methods.METHODS`: how models are chosen.
        person: of `grammarlab.evaluation.respondents.RESPONDENTS`: how they are scored.
        cache: folder for counted features that later calls use again.

    Raises:
        UsageError: for an unknown method, person or kind of file.
    """
    way, respondent = chosen_one(method, METHODS, "method"), chosen_one(person, RESPONDENTS, "person")
    key = load_source(scenario).key
    file.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        save_labels(Labels(), Path(scratch, file.name))  # a wrong suffix is better told before the work than after it
        labels, curve = labels_of(
            CurveTask(
                scenario=scenario,
                source_key=key,
                method=way,
                seed=seed,
                max_labels=num_labels,
                cache=cache or Path(scratch),
                person=respondent,
            )
        )
    save_labels(labels, file)
    return LabelResult(file, labels, curve)


def labels_of(task: CurveTask) -> tuple[Labels, Curve]:
    """What the simulated person of a task says, and how well each round of it was learned from."""
    with one_thread():
        material, state, curve = run_protocol(task)
    single, hashes = len(material.factors) == 1, material.study.space.hashes
    rows = [
        address.label(OVERALL if single else name, score, hashes)
        for name, answers in state.answers.items()
        for address, score in zip(answers.designs, answers.scores.tolist(), strict=True)
    ]
    return Labels(tuple(rows)), curve
