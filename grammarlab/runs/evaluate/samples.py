"""Models drawn from the density before learning and from the learned one, remembered like the curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grammarlab.evaluation import protocol
from grammarlab.evaluation.material import Material
from grammarlab.randomness import derived_seed
from grammarlab.runs.disk.results import Progress, made
from grammarlab.runs.evaluate.disk.measurements import measurements_in
from grammarlab.runs.evaluate.task import CurveTask, run_protocol
from grammarlab.runs.work.executors import SERIAL, AbstractExecutor

STORE = "samples"
NUM_MODELS = 100
"""Models of a sample; fewer are its beginning."""
LANE = 3
"""Place below a curve's seed that the choice of models has its seed from."""


@dataclass(frozen=True, slots=True)
class CurveSample:
    """Models drawn from a density, each on its own."""

    js: float
    """Divergence of the density from the wanted one, in nats."""
    models: tuple[int, ...]
    """[NUM_MODELS] places in the labelled set; they may repeat."""
    scores: tuple[float, ...]
    """[NUM_MODELS] their true scores, 0 to 100."""


@dataclass(frozen=True, slots=True)
class BeforeAfter:
    """Samples of a person's densities."""

    seed: int
    """Of the person."""
    labels: int
    """That the person gave."""
    before: CurveSample
    """Of the grammar as it is."""
    after: CurveSample
    """Of what was learned from all labels."""


def draw_models(
    tasks: Sequence[CurveTask],
    folder: Path,
    *,
    executor: AbstractExecutor = SERIAL,
    fresh: bool = False,
    on_progress: Progress = lambda _what, _done, _total: None,
) -> tuple[BeforeAfter, ...]:
    """Samples before and after the curves of some tasks; those that the folder holds already are not made again.

    Args:
        tasks: curves; each is made again to learn what it learned.
        folder: keeps each pair of samples as soon as it is there.
        executor: who makes them; no number depends on it.
        fresh: forget what the folder holds.
        on_progress: told about finished tasks.

    Raises:
        GrammarlabError: as the scenarios and the folder give reason to.
    """
    kept = measurements_in(folder, STORE, fresh=fresh)
    found = made(kept, _made, {task.place: task for task in tasks}, executor, "samples", on_progress)
    return tuple(_parsed(found[task.place]) for task in tasks)


def choose(weights: NDArray[np.float64], num_models: int, seed: int) -> list[int]:
    """Indices of models, each drawn on its own with a probability proportional to its weight.

    Args:
        weights: [n] >= 0, not all 0.
        num_models: how many to draw; fewer are the beginning of more.
        seed: 0 <= seed < 2**64.
    """
    random = np.random.default_rng(derived_seed(seed, LANE))
    return random.choice(len(weights), num_models, p=weights / weights.sum()).tolist()


def _made(task: CurveTask) -> dict[str, Any]:
    """The samples of a task."""
    material, state, curve = run_protocol(task)
    learned = material.weights * protocol.learned(material, state)
    before = _sample(material, material.weights, material.js_original, task.seed)
    after = _sample(material, learned if learned.any() else material.weights, curve.points[-1].js, task.seed)
    return asdict(BeforeAfter(task.seed, state.num_answers, before, after))


def _sample(material: Material, weights: NDArray[np.float64], js: float, seed: int) -> CurveSample:
    models = choose(weights, NUM_MODELS, seed)
    return CurveSample(js, tuple(models), tuple(100 * float(material.target[model]) for model in models))


def _parsed(values: Mapping[str, Any]) -> BeforeAfter:
    before, after = (
        CurveSample(part["js"], tuple(part["models"]), tuple(part["scores"]))
        for part in (values["before"], values["after"])
    )
    return BeforeAfter(values["seed"], values["labels"], before, after)
