"""Labels of a simulated person, as a file that a real one could have made."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

from grammarlab.errors import UsageError
from grammarlab.evaluation.curves import Curve
from grammarlab.evaluation.flattening import flattened_hash
from grammarlab.evaluation.methods import METHODS
from grammarlab.evaluation.preparation import pool_address
from grammarlab.preference.label_files import save_labels
from grammarlab.preference.labels import OVERALL, Label, Labels
from grammarlab.runs.evaluate.task import Task, load_source, run_protocol
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
    single = len(material.factors) == 1
    hashes = (source.grammar.hash, flattened_hash(source.grammar))
    rows: list[Label] = []
    for name, factor in zip(material.factors, state.factors, strict=True):
        for index, score in zip(factor.asked.tolist(), factor.scores.tolist(), strict=True):
            flat, pool_seed, model = pool_address(source, index)
            rows.append(Label(pool_seed, model, OVERALL if single else name, score, hashes[flat]))
    labels = Labels(tuple(rows))
    save_labels(labels, file)
    return LabelResult(file, labels, curve)
