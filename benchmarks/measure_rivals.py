"""The learner beside other regressions on equal label files and columns: ``python benchmarks/measure_rivals.py``.

A label file has the scores of random designs (`benchmarks.bench_tastes.label_file`). Each rival gets the same scores
and the columns that the learner ended with, those that it composed included, and once more without these. Predictions
of the labelled set are compared with the person's density as in `grammarlab.evaluation.protocol`; a negative prediction
is 0. ``--json FILE`` writes all divergences.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from zlib import crc32

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.bench_tastes import label_file
from grammarlab.arrays import Floats
from grammarlab.evaluation.methods import METHODS
from grammarlab.evaluation.preparation import Material, prepare
from grammarlab.evaluation.protocol import learned
from grammarlab.evaluation.respondents import RESPONDENTS
from grammarlab.learning.designs.design_tables import DesignTable
from grammarlab.learning.fitting import Method, fit
from grammarlab.learning.round import State, init, step, table_rows
from grammarlab.learning.targets.divergence import agreement
from grammarlab.preference.base import MAX_SCORE
from grammarlab.randomness import derived_seed
from grammarlab.runs.evaluate.request import find_scenarios
from grammarlab.runs.sample.sources import load_source

RIVALS: tuple[Method, ...] = ("lightgbm", "paper", "sklearn", "kde")
LEARNER = "grammarlab"


@dataclass(frozen=True, kw_only=True, slots=True)
class Result:
    """A method on one label file."""

    scenario: str
    scores: int
    person: str
    method: str
    composed: bool
    """Whether columns that the learner composed were among those of the method."""
    original: float
    """Divergence of the original grammar from the target, nats."""
    js: float
    """Divergence of the density by the method from the target, nats."""
    seconds: float
    """CPU seconds; those of the learner include the search for columns."""


def measure(path: Path, person: str, numbers: Sequence[int], models: int, rivals: Sequence[Method]) -> Iterator[Result]:
    """All methods on the label files of a scenario with one factor."""
    source = load_source(path)
    source = replace(source, scenario=replace(source.scenario, num_models=models))
    name = source.scenario.name
    material = prepare(source, METHODS["default"].settings(source.scenario.features))
    if len(material.factors) > 1:
        return
    seed = derived_seed(0, crc32(name.encode()))
    answered = material.answered_by(RESPONDENTS[person], seed)
    _ = answered.study.table(init(answered.study))
    for number in numbers:
        start = time.process_time()
        state = step(answered.study, init(answered.study), label_file(answered, number, seed))
        seconds = time.process_time() - start
        of = {"scenario": name, "scores": number, "person": person, "original": answered.js_original}
        composed = bool(state.columns.extra)
        js = _divergence(answered, learned(answered, state))
        yield Result(**of, method=LEARNER, composed=composed, js=js, seconds=seconds)
        for rival in rivals:
            for with_composed in (True, False) if composed else (False,):
                start = time.process_time()
                predicted = _by(rival, answered, state, with_composed)
                seconds = time.process_time() - start
                js = _divergence(answered, predicted)
                yield Result(**of, method=rival, composed=with_composed, js=js, seconds=seconds)


def _divergence(material: Material, predicted: Floats) -> float:
    return agreement(material.target, predicted, material.weights).js


def _by(method: Method, material: Material, state: State, with_composed: bool) -> Floats:
    """[n] values of the labelled set by a method that learns from the answers of a state, 0 to 1."""
    table = material.study.table(state)
    answers = state.answers[material.factors[0]]
    rows = table_rows(material.study.tables(state.wide), state.columns, answers)
    num = table.rows.shape[1] - (0 if with_composed else len(state.columns.extra))
    preference = _fitted(method, table, num, rows.tolist(), answers.scores)
    return np.clip(preference.predict(table.others[:, :num]).mean, 0.0, MAX_SCORE) / MAX_SCORE


def _fitted(method: Method, table: DesignTable, num: int, rows: list[int], scores: Floats):
    return fit(
        table.rows[rows, :num], scores, groups=table.groups[:num], continuous=table.continuous[:num], method=method
    )


def summary(results: Sequence[Result]) -> Iterator[str]:
    """Medians by method, and how often each is the best of all, or nearly."""
    yield "person     scores  method      composed  files  median JS  worst ratio  best  median CPU s"
    for person, scores in dict.fromkeys((result.person, result.scores) for result in results):
        group = [result for result in results if (result.person, result.scores) == (person, scores)]
        best = {
            name: min(result.js for result in group if result.scenario == name)
            for name in {result.scenario for result in group}
        }
        for method in dict.fromkeys(result.method for result in group):
            for composed in (False, True) if method != LEARNER else (None,):
                some = _of(group, method, composed)
                if not some:
                    continue
                ratios = [result.js / result.original for result in some]
                wins = sum(result.js <= 1.2 * best[result.scenario] + 1e-4 for result in some)
                js, seconds = ([getattr(result, what) for result in some] for what in ("js", "seconds"))
                told = {None: "own", True: "with", False: "without"}[composed]
                yield (
                    f"{person:10} {scores:6}  {method:11} {told:8} {len(some):6} {np.median(js):10.4f} "
                    f"{max(ratios):12.2f} {wins:5} {np.median(seconds):13.2f}"
                )


def _of(group: Sequence[Result], method: str, composed: bool | None) -> list[Result]:
    """Results of a method; where nothing was composed, its columns are the same with and without."""
    own = [result for result in group if result.method == method]
    if composed is None:
        return own
    both = {result.scenario for result in own if result.composed}
    return [result for result in own if result.composed == composed or result.scenario not in both]


def main() -> None:
    parser = argparse.ArgumentParser(description="The learner beside other regressions on equal scores and columns.")
    parser.add_argument("--scenarios", default="scenarios/tastes/kinds", help="names, files or folders, with commas")
    parser.add_argument("--persons", default="exact,sd10", help="default: exact,sd10")
    parser.add_argument("--scores", default="32,64,128", help="default: 32,64,128")
    parser.add_argument("--models", type=int, default=2000, help="size of pool and labelled set (2000)")
    parser.add_argument("--json", type=Path, help="file for all results")
    options = parser.parse_args()
    results = list[Result]()
    numbers = [int(number) for number in options.scores.split(",")]
    with threadpool_limits(1):
        for path in (path for part in options.scenarios.split(",") for path in find_scenarios(part)):
            for person in options.persons.split(","):
                for result in measure(path, person, numbers, options.models, RIVALS):
                    results.append(result)
                    print(
                        f"{result.scenario:24} {result.scores:4} {result.person:8} {result.method:11} "
                        f"{'with' if result.composed else '-':5} {result.original:.3f} -> {result.js:.4f} "
                        f"{result.seconds:6.2f} s",
                        flush=True,
                    )
                if options.json:
                    options.json.write_text(json.dumps([asdict(result) for result in results], indent=1))
    print("\n" + "\n".join(summary(results)))


if __name__ == "__main__":
    main()
