"""Models drawn from the density before learning and from the learned one, stored like the curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grammarlab.evaluation import protocol
from grammarlab.evaluation.preparation import Material
from grammarlab.randomness import derived_seed
from grammarlab.runs.evaluate.curve_store import measurements_in
from grammarlab.runs.evaluate.curve_tasks import CurveTask, run_protocol
from grammarlab.runs.work.executors import SERIAL, AbstractExecutor
from grammarlab.runs.work.results import Progress, computed

STORE = "samples"
NUM_MODELS = 100
"""Number of models of a sample; a smaller sample is its beginning."""
LANE = 3
"""Lane of the seed for the choice of models, below a curve's seed."""


@dataclass(frozen=True, slots=True)
class CurveSample:
    """Models drawn independently from a density."""

    js: float
    """Divergence of the density from the target density, in nats."""
    models: tuple[int, ...]
    """[NUM_MODELS] indices in the labelled set, with repeats."""
    scores: tuple[float, ...]
    """[NUM_MODELS] their true scores, 0 to 100."""


@dataclass(frozen=True, slots=True)
class BeforeAfter:
    """Samples of a person's densities."""

    seed: int
    """Seed of the person."""
    labels: int
    """Number of labels of the person."""
    before: CurveSample
    """Sample of the original grammar."""
    after: CurveSample
    """Sample of the density learned from all labels."""


def draw_models(
    tasks: Sequence[CurveTask],
    folder: Path,
    *,
    executor: AbstractExecutor = SERIAL,
    fresh: bool = False,
    on_progress: Progress = lambda _what, _done, _total: None,
) -> tuple[BeforeAfter, ...]:
    """Samples before and after the curves of tasks; stored ones are not made again.

    Args:
        tasks: curves; each is made again for its learned density.
        folder: storage of finished pairs of samples.
        executor: makes the samples, which do not depend on it.
        fresh: remove stored samples first.
        on_progress: called with the number of finished tasks.

    Raises:
        GrammarlabError: If the scenarios or the folder cannot be used.
    """
    measurements = measurements_in(folder, STORE, fresh=fresh)
    results = computed(
        measurements, _samples_of, {task.curve_name: task for task in tasks}, executor, "samples", on_progress
    )
    return tuple(_parsed(results[task.curve_name]) for task in tasks)


def choose(weights: NDArray[np.float64], num_models: int, seed: int) -> list[int]:
    """Indices of models, drawn independently with probabilities proportional to weights.

    Args:
        weights: [n] >= 0, not all 0.
        num_models: number of models; a smaller sample is the beginning of a larger one.
        seed: 0 <= seed < 2**64.
    """
    random = np.random.default_rng(derived_seed(seed, LANE))
    return random.choice(len(weights), num_models, p=weights / weights.sum()).tolist()


def _samples_of(task: CurveTask) -> dict[str, Any]:
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
