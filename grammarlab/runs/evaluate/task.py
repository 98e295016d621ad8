"""One learning curve: what to make, and making it. Runs in any process."""

from __future__ import annotations

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
    """`Source.key`: what the scenario and its grammar say."""
    method: Method
    seed: int
    """0 <= seed < 2**64."""
    max_labels: int
    """>= 1."""
    cache: Path
    """Folder for compiled code that other curves and other runs use again."""
    person: Respondent = EXACT
    """How the models are scored."""

    @property
    def settings(self) -> Settings:
        """How the method learns what the scenario is about."""
        return self.method.settings(load_source(self.scenario).scenario.features)

    @property
    def key(self) -> str:
        """Names the curve: SHA-256 of everything that decides it but `max_labels`."""
        return digest([__version__, self.source_key, self.method.as_json(), self.seed, asdict(self.person)])

    @property
    def place(self) -> str:
        """Names the curve among all that are made."""
        return f"{self.key}-{self.max_labels}"

    def __str__(self) -> str:
        return (
            f"the curve of {self.scenario.stem}, method {self.method.name}, person {self.person.name}, seed {self.seed}"
        )


@lru_cache(maxsize=2)
def load_material(scenario: Path, _source_key: str, settings: Settings, seed: int) -> Material:
    """What the curves of a scenario and a seed are made from; their tasks stand together, so few are kept.

    The key is there so that a file that has changed is read again.
    """
    return prepare(load_source(scenario).for_person(seed), settings)


def run_protocol(task: CurveTask) -> tuple[Material, State, Curve]:
    """The simulated person of a task, after all rounds."""
    material = load_material(task.scenario, task.source_key, task.settings, task.seed)
    material = material if task.method.factored else material.as_one_factor()
    material = material.answered_by(task.person, task.seed)
    state, curve = protocol.run(material, task.method.batch, task.seed, task.max_labels)
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
