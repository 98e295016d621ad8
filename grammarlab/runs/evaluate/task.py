"""Task of one learning curve, which runs in any process."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path

from grammarlab.about import __version__
from grammarlab.evaluation import protocol
from grammarlab.evaluation.curves import Curve
from grammarlab.evaluation.material import Material
from grammarlab.evaluation.methods import Method
from grammarlab.evaluation.preparation import prepare
from grammarlab.evaluation.respondents import EXACT, Respondent
from grammarlab.learning.round import State
from grammarlab.learning.settings import Settings
from grammarlab.runs.evaluate.disk.measurements import digest
from grammarlab.runs.evaluate.disk.store import CurveRecord
from grammarlab.runs.sampling.sources import load_source


@dataclass(frozen=True, slots=True)
class CurveTask:
    """One curve to make."""

    scenario: Path
    """The scenario file."""
    source_key: str
    """`Source.key` of the scenario and its grammar."""
    method: Method
    seed: int
    """0 <= seed < 2**64."""
    max_labels: int
    """>= 1."""
    cache: Path
    """Folder for compiled code, shared with other curves and runs."""
    person: Respondent = EXACT
    """Error model of the scores."""

    @property
    def settings(self) -> Settings:
        """Settings of the method for the scenario."""
        return self.method.settings(load_source(self.scenario).scenario.features)

    @property
    def key(self) -> str:
        """Key of the curve: SHA-256 of all its inputs except `max_labels`."""
        return digest([__version__, self.source_key, self.method.as_json(), self.seed, asdict(self.person)])

    @property
    def place(self) -> str:
        """Name of the curve among all curves."""
        return f"{self.key}-{self.max_labels}"

    def __str__(self) -> str:
        return (
            f"the curve of {self.scenario.stem}, method {self.method.name}, person {self.person.name}, seed {self.seed}"
        )


@lru_cache(maxsize=2)
def load_material(scenario: Path, _source_key: str, settings: Settings, seed: int) -> Material:
    """Material of the curves of a scenario and a seed; their tasks are consecutive, so few are cached.

    The key makes changed files be read again.
    """
    return prepare(load_source(scenario).for_person(seed), settings)


def run_protocol(
    task: CurveTask, on_round: Callable[[Material, State], None] = lambda _material, _state: None
) -> tuple[Material, State, Curve]:
    """The simulated person of a task, after all rounds.

    Args:
        task: the task.
        on_round: called with the material and the state after every round.
    """
    material = load_material(task.scenario, task.source_key, task.settings, task.seed)
    material = material if task.method.factored else material.as_one_factor()
    material = material.answered_by(task.person, task.seed)
    state, curve = protocol.run(
        material, task.method.batch, task.seed, task.max_labels, lambda state: on_round(material, state)
    )
    return material, state, curve


def make_curve(task: CurveTask) -> CurveRecord:
    """The curve of a task."""
    material, _, curve = run_protocol(task)
    name = load_source(task.scenario).scenario.name
    return CurveRecord(
        key=task.key,
        scenario=name,
        method=task.method.name,
        seed=task.seed,
        max_labels=task.max_labels,
        js_original=material.js_original,
        curve=curve,
        person=task.person.name,
    )
