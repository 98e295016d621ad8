"""One step of learning on equal label files: ``python benchmarks/bench_tastes.py --scenarios scenarios/tastes/kinds``.

Each cell is a scenario, a number of scores, a person and a seed. Its label file has random designs of the scenario's
pool in a random order; a file of fewer scores is the beginning of a file of more, and persons score the same designs.
Another learner is measured on the same files by running this script with ``PYTHONPATH`` set to its checkout, and
``--compare A.json B.json`` compares the two. CPU seconds include what a study makes only once, such as a wider pool.
"""

from __future__ import annotations

import argparse
import json
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from zlib import crc32

import numpy as np
from threadpoolctl import threadpool_limits

from grammarlab.arrays import Floats
from grammarlab.evaluation.methods import METHODS
from grammarlab.evaluation.preparation import Material, prepare
from grammarlab.evaluation.protocol import learned
from grammarlab.evaluation.respondents import RESPONDENTS
from grammarlab.learning.answers import Answers
from grammarlab.learning.round import init, step
from grammarlab.learning.targets.divergence import agreement
from grammarlab.randomness import derived_seed, root_keys, uniforms
from grammarlab.runs.evaluate.request import find_scenarios
from grammarlab.runs.sample.sources import load_source

PERSONS = "exact,sd10,stars,blunders10,sd20"
SCORES = "24,64,128"
DESIGNS, ORDER = 11, 12
"""Lanes below the seed of a person at a scenario: which designs are scored, and the order of shuffled scores."""
MARGIN = 0.1
"""Relative difference within which two divergences are equal."""
LEAST = 5e-4
"""Difference in nats within which two divergences are equal."""
WORSE = 1.05
"""Ratio to the divergence of the original grammar above which learning did harm."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Cell:
    """One step on one label file."""

    scenario: str
    scores: int
    """Number of scores of the label file."""
    person: str
    seed: int
    original: float
    """Divergence of the original grammar from the target, nats."""
    js: float
    """Divergence of the learned density from the target, nats."""
    moved: float
    """Divergence of the learned density from the original grammar, nats."""
    seconds: float
    """CPU seconds of the step."""
    columns: tuple[str, ...]
    """Columns that the search added."""
    voices: str = ""
    """What is said about two voices in the scores; empty for one."""

    @property
    def key(self) -> tuple[str, int, str, int]:
        """Identity of the label file."""
        return self.scenario, self.scores, self.person, self.seed

    def __str__(self) -> str:
        columns = " | ".join(self.columns) or "-"
        return (
            f"{self.scenario:28} {self.scores:4} {self.person:10} {self.seed:2}  {self.original:.3f} -> {self.js:.4f}"
            f"  moved {self.moved:.4f}  {self.seconds:5.2f} s  {columns}  {self.voices}"
        )


@dataclass(frozen=True, kw_only=True, slots=True)
class Plan:
    """The cells of each scenario."""

    persons: tuple[str, ...]
    scores: tuple[int, ...]
    seeds: int
    models: int | None
    """Size of the pool and of the labelled set; None for that of each scenario."""
    shuffled: bool
    """Whether scores are given to random designs of the label file, so that they have no pattern."""


def measure(plan: Plan, path: Path) -> list[Cell]:
    """All cells of a scenario; its pool and its labelled set are made once."""
    source = load_source(path)
    if plan.models is not None:
        source = replace(source, scenario=replace(source.scenario, num_models=plan.models))
    cells = list[Cell]()
    with threadpool_limits(1):
        material = prepare(source, METHODS["default"].settings(source.scenario.features))
        _ = material.study.table(init(material.study))
        for seed in range(plan.seeds):
            for person in plan.persons:
                for scores in plan.scores:
                    cells.append(_cell(source.scenario.name, material, scores, person, seed, plan.shuffled))
                    print(cells[-1], flush=True)
    return cells


def _cell(name: str, material: Material, num_scores: int, person: str, seed: int, shuffled: bool) -> Cell:
    person_seed = derived_seed(seed, crc32(name.encode()))
    answered = material.answered_by(RESPONDENTS[person], person_seed)
    answers = label_file(answered, num_scores, person_seed, shuffled)
    start = time.process_time()
    state = step(answered.study, init(answered.study), answers)
    seconds = time.process_time() - start
    preference = learned(answered, state)
    return Cell(
        scenario=name,
        scores=num_scores,
        person=person,
        seed=seed,
        original=answered.js_original,
        js=agreement(answered.target, preference, answered.weights).js,
        moved=agreement(np.ones(len(preference)), preference, answered.weights).js,
        seconds=seconds,
        columns=tuple(str(feature) for feature in state.columns.extra),
        voices=" ".join(filter(None, map(str, state.heard.values()))),
    )


def label_file(material: Material, num_scores: int, seed: int, shuffled: bool = False) -> tuple[Answers, ...]:
    """Scores of random designs of the pool; several factors take turns.

    Args:
        material: the pool, and the person.
        num_scores: number of scores, all factors together, 1 to the size of the pool.
        seed: seed of the person at a scenario.
        shuffled: whether scores are given to random designs of the file.
    """
    pool = list(material.study.pool)
    addresses = [pool[index] for index in _permutation(seed, DESIGNS, len(pool))[:num_scores]]
    ascending = np.array(sorted(range(num_scores), key=addresses.__getitem__), dtype=np.int64)
    scores = np.empty((num_scores, len(material.factors)))
    scores[ascending] = material.person([addresses[index] for index in ascending.tolist()], ascending)
    if shuffled:
        scores = scores[_permutation(seed, ORDER, num_scores)]
    num_factors = len(material.factors)
    return tuple(
        Answers(factor, tuple(addresses[index::num_factors]), scores[index::num_factors, index])
        for index, factor in enumerate(material.factors)
        if num_scores > index
    )


def _permutation(seed: int, lane: int, num: int) -> list[int]:
    """Random order of ``num`` things."""
    return np.argsort(uniforms(root_keys(derived_seed(seed, lane), np.arange(num)), 0), kind="stable").tolist()


# Summaries -----------------------------------------------------------------------------------------------------------


def summary(cells: Sequence[Cell]) -> Iterator[str]:
    """Medians by person and number of scores, and how often learning did harm or found columns."""
    yield "person     scores  files  median JS  median ratio  worst ratio  worse  with columns  told of two  CPU s"
    for person, scores in dict.fromkeys((cell.person, cell.scores) for cell in cells):
        group = [cell for cell in cells if (cell.person, cell.scores) == (person, scores)]
        ratios = np.array([cell.js / cell.original for cell in group])
        js, seconds = ([getattr(cell, name) for cell in group] for name in ("js", "seconds"))
        yield (
            f"{person:10} {scores:6} {len(group):6} {np.median(js):10.4f} {np.median(ratios):13.3f} "
            f"{ratios.max():12.2f} {(ratios > WORSE).sum():6} {sum(bool(cell.columns) for cell in group):13} "
            f"{sum(bool(cell.voices) for cell in group):11} "
            f"{np.median(seconds):13.2f}"
        )


def compare(before: Sequence[Cell], after: Sequence[Cell]) -> Iterator[str]:
    """Cells of two learners beside each other, and counts of better, equal and worse ones.

    Raises:
        SystemExit: If they have no label file in common, or a target differs.
    """
    others = {cell.key: cell for cell in after}
    pairs = [(cell, others[cell.key]) for cell in before if cell.key in others]
    if not pairs:
        raise SystemExit("the two files have no scenario, number of scores, person and seed in common.")
    yield f"{'scenario':28} scores person   seed  original    first -> second   ratio         CPU s"
    for first, second in pairs:
        if not np.isclose(first.original, second.original, rtol=1e-9):
            raise SystemExit(f"{first.key}: the targets differ; measure both with the same scenarios and --models.")
        yield (
            f"{first.scenario:28} {first.scores:6} {first.person:10} {first.seed:2} {first.original:9.3f} "
            f"{first.js:8.4f} -> {second.js:.4f} {_ratio(first, second):7.2f}  {first.seconds:5.2f} -> "
            f"{second.seconds:5.2f}  {verdict(first, second)}"
        )
    yield "\nperson     scores  files  median JS first -> second  median ratio  better  equal  worse  CPU s"
    for person, scores in dict.fromkeys((first.person, first.scores) for first, _ in pairs):
        group = [pair for pair in pairs if (pair[0].person, pair[0].scores) == (person, scores)]
        yield _line(f"{person:10} {scores:6}", group)
    yield _line(f"{'all':17}", pairs)


def _line(name: str, pairs: Sequence[tuple[Cell, Cell]]) -> str:
    counts = Counter(verdict(*pair) for pair in pairs)
    js: Floats = np.median([(first.js, second.js) for first, second in pairs], axis=0)
    seconds: Floats = np.median([(first.seconds, second.seconds) for first, second in pairs], axis=0)
    ratio = np.median([_ratio(*pair) for pair in pairs])
    return (
        f"{name} {len(pairs):6} {js[0]:16.4f} -> {js[1]:.4f} {ratio:13.2f} "
        f"{counts['better']:7} {counts['equal']:6} {counts['worse']:6}  {seconds[0]:.2f} -> {seconds[1]:.2f}"
    )


def _ratio(first: Cell, second: Cell) -> float:
    """The second divergence as a multiple of the first; differences below `LEAST` are not counted."""
    return max(second.js, LEAST) / max(first.js, LEAST)


def verdict(first: Cell, second: Cell) -> str:
    """Whether the second learner is better, equal or worse."""
    if abs(second.js - first.js) <= max(LEAST, MARGIN * max(first.js, second.js)):
        return "equal"
    return "better" if second.js < first.js else "worse"


def read(path: Path) -> list[Cell]:
    """Cells that ``--json`` wrote."""
    records = json.loads(path.read_text())
    return [Cell(**(record | {"columns": tuple(record["columns"])})) for record in records]


def main() -> None:
    parser = argparse.ArgumentParser(description="One step of learning on each of many label files.")
    parser.add_argument("--scenarios", default="scenarios/tastes/kinds", help="names, files or folders, with commas")
    parser.add_argument("--persons", default=PERSONS, help=f"default: {PERSONS}")
    parser.add_argument("--scores", default=SCORES, help=f"default: {SCORES}")
    parser.add_argument("--seeds", type=int, default=1, help="seeds per scenario and person")
    parser.add_argument("--models", type=int, help="size of pool and labelled set instead of the scenario's: 2000")
    parser.add_argument("--shuffled", action="store_true", help="scores without a pattern")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--json", type=Path, help="file for all cells")
    parser.add_argument("--compare", type=Path, nargs=2, metavar="JSON", help="compare two files of cells instead")
    options = parser.parse_args()
    if options.compare:
        print("\n".join(compare(*(read(path) for path in options.compare))))
        return
    plan = Plan(
        persons=tuple(options.persons.split(",")),
        scores=tuple(int(number) for number in options.scores.split(",")),
        seeds=options.seeds,
        models=options.models,
        shuffled=options.shuffled,
    )
    paths = [path for part in options.scenarios.split(",") for path in find_scenarios(part)]
    cells = list[Cell]()
    for group in _measured(plan, paths, options.jobs):
        cells += group
        # After every scenario, so that a run that is stopped leaves what it has.
        if options.json:
            options.json.write_text(json.dumps([asdict(cell) for cell in cells], indent=1))
    print("\n".join(("", *summary(cells))))


def _measured(plan: Plan, paths: Sequence[Path], jobs: int) -> Iterator[list[Cell]]:
    """The cells of each scenario, in order."""
    if jobs == 1:
        yield from (measure(plan, path) for path in paths)
        return
    with ProcessPoolExecutor(jobs) as executor:
        yield from executor.map(partial(measure, plan), paths)


if __name__ == "__main__":
    main()
